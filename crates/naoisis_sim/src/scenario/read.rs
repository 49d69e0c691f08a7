//! Parses text to a tree of values.

use core::ops::Range;
use ron::extensions::Extensions;
use serde::Deserialize;
use serde_json::Value;

use super::format::Format;
use super::scanner::outline_of;
use super::spans::{Content, Node};
use super::wording::quoted;

/// A syntax error.
#[derive(Clone, PartialEq, Debug)]
pub struct SyntaxFault {
    /// The faulty bytes.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// What was expected.
    pub expected: String,
}

/// Parses a text to values.
pub fn read(text: &str, format: Format) -> Result<Value, SyntaxFault> {
    let first = text.len() - text.trim_start().len();
    if first == text.len() {
        return Err(SyntaxFault {
            span: 0..0,
            message: "the file is empty".to_owned(),
            expected: format!("a scenario, such as {}", format.smallest_scenario()),
        });
    }
    let mut value = match format {
        Format::Json => serde_json::from_str(text).map_err(|error| json_fault(text, &error))?,
        Format::Ron => read_ron(text)?,
    };
    let outline = outline_of(text).ok_or_else(|| SyntaxFault {
        span: first..first,
        message: "the structure of the file is not clear".to_owned(),
        expected: format!("plain {format}"),
    })?;
    if let Some(entry) = outline.duplicate_key() {
        return Err(SyntaxFault {
            span: entry.key_span.clone(),
            message: format!("the field {} is there twice", quoted(&entry.key)),
            expected: "each field once".to_owned(),
        });
    }
    if let Some(node) = outline.find_scalar(text, &|scalar| is_not_finite(scalar)) {
        return Err(not_finite(text, node.span.clone()));
    }
    if format == Format::Ron {
        mend_ron(&mut value, &outline, text);
    }
    Ok(value)
}

/// Parses RON to the values of JSON. Words become strings, `(a: 1)` an object, `(1, 2)` a list and `variant(1)` an object with one field.
fn read_ron(text: &str) -> Result<Value, SyntaxFault> {
    /// ron distinguishes words and variants only for serde's internal buffer, which an untagged enum uses.
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Buffered {
        Value(Value),
    }

    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    match options.from_str(text) {
        Ok(Buffered::Value(value)) => Ok(value),
        Err(error) => Err(ron_fault(text, &error)),
    }
}

/// Corrects what RON parses differently: `()` is an object without fields, `Name(...)` is the contents of the parentheses, and the word
/// `null` is JSON's null.
fn mend_ron(value: &mut Value, node: &Node, text: &str) {
    if node.is_named_struct
        && let Value::Object(fields) = value
        && fields.len() == 1
        && let Some((_, inner)) = core::mem::take(fields).into_iter().next()
    {
        *value = inner;
    }
    match &node.content {
        Content::Map(entries) if entries.is_empty() => *value = Value::Object(serde_json::Map::new()),
        Content::Scalar if text.get(node.span.clone()) == Some("null") => *value = Value::Null,
        Content::Scalar => {}
        Content::Map(entries) => {
            for entry in entries {
                if let Some(value) = value.get_mut(&entry.key) {
                    mend_ron(value, &entry.value, text);
                }
            }
        }
        Content::List(nodes) => {
            for (index, node) in nodes.iter().enumerate() {
                if let Some(value) = value.get_mut(index) {
                    mend_ron(value, node, text);
                }
            }
        }
    }
}

/// Returns whether a scalar is a number that is not finite, such as `NaN`, `-inf` or `1e999`.
fn is_not_finite(scalar: &str) -> bool {
    let number: String = scalar.chars().take(400).filter(|&character| character != '_').collect();
    let number = number.trim_end_matches("f32").trim_end_matches("f64").to_ascii_lowercase();
    number.parse::<f64>().is_ok_and(|number| !number.is_finite())
}

fn not_finite(text: &str, span: Range<usize>) -> SyntaxFault {
    let word = text.get(span.clone()).unwrap_or_default();
    SyntaxFault {
        span,
        message: format!("{} is not a finite number", quoted(word)),
        expected: "a finite number".into(),
    }
}

/// Returns the bytes of the word or number at `position`.
fn word_at(text: &str, position: usize) -> Range<usize> {
    let is_part = |character: char| character.is_alphanumeric() || "+-._".contains(character);
    let before = text.get(..position).unwrap_or_default();
    let start = before.trim_end_matches(is_part).len();
    let after = &text[before.len()..];
    let end = before.len() + (after.len() - after.trim_start_matches(is_part).len());
    start..end
}

/// Returns the byte position of a line (from 1). `column_bytes` returns the offset in that line.
fn position_of(text: &str, line: usize, column_bytes: impl Fn(&str) -> usize) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let line_text = text[line_start..].lines().next().unwrap_or_default();
    line_start + column_bytes(line_text).min(line_text.len())
}

fn json_fault(text: &str, error: &serde_json::Error) -> SyntaxFault {
    // serde_json counts bytes, and the faulty byte is the last that it read.
    let mut position = position_of(text, error.line(), |_| error.column().saturating_sub(1));
    if error.is_eof() {
        position = text.len();
    }
    while !text.is_char_boundary(position) {
        position -= 1;
    }
    let word = word_at(text, position);
    if is_not_finite(&text[word.clone()]) {
        return not_finite(text, word);
    }
    let whole = error.to_string();
    let what = whole.split(" at line ").next().unwrap_or_default();
    let (message, expected) = match what {
        "expected value" | "expected ident" => (
            "this is no JSON value".to_owned(),
            "a number, a text in double quotes, `true`, `false`, `null`, a list or an object",
        ),
        "trailing comma" => ("nothing follows the comma".to_owned(), "another element, or no comma"),
        "trailing characters" => ("something follows after the scenario's end".to_owned(), "the end of the file"),
        "key must be a string" => ("this is no field's name".to_owned(), "a field's name in double quotes"),
        "recursion limit exceeded" => ("the nesting is too deep".to_owned(), "at most 128 levels of lists and objects"),
        "number out of range" => ("the number is too large".to_owned(), "a finite number"),
        "invalid number" => ("this is no JSON number".to_owned(), "a number such as 0.5, -2 or 1e-3"),
        _ if what.starts_with("EOF while parsing") => {
            let inside = match what {
                "EOF while parsing a list" => "a list",
                "EOF while parsing an object" => "an object",
                "EOF while parsing a string" => "a text",
                _ => "a value",
            };
            (format!("the file ends in the middle of {inside}"), "the rest of it, and every bracket closed")
        }
        _ => match what.strip_prefix("expected ") {
            Some(expected) => {
                let expected = expected.to_owned();
                return SyntaxFault { span: position..word.end, message: "this is not JSON".to_owned(), expected };
            }
            None => (format!("this is not JSON ({what})"), "JSON as of RFC 8259"),
        },
    };
    SyntaxFault { span: position..word.end, message, expected: expected.to_owned() }
}

fn ron_fault(text: &str, error: &ron::error::SpannedError) -> SyntaxFault {
    use ron::Error;

    let at = |position: ron::error::Position| {
        position_of(text, position.line, |line| {
            line.char_indices().nth(position.col.saturating_sub(1)).map_or(line.len(), |(byte, _)| byte)
        })
    };
    let position = at(error.span.end);
    let span = position..word_at(text, position).end;
    let fault = |message: &str, expected: &str| SyntaxFault {
        span: span.clone(),
        message: message.to_owned(),
        expected: expected.to_owned(),
    };
    let the_end = || SyntaxFault {
        span: text.len()..text.len(),
        message: "the file ends in the middle of a value or a comment".to_owned(),
        expected: "the rest of it, and every bracket closed".to_owned(),
    };
    let is_at_end = text.get(position..).is_none_or(|rest| rest.trim().is_empty());
    match &error.code {
        Error::Eof | Error::ExpectedStringEnd | Error::UnclosedBlockComment => the_end(),
        Error::ExpectedComma | Error::ExpectedMapColon | Error::ExpectedArrayEnd if is_at_end => the_end(),
        Error::ExceededRecursionLimit => fault("the nesting is too deep", "at most 128 levels of lists and objects"),
        Error::TrailingCharacters => fault("something follows after the scenario's end", "the end of the file"),
        Error::ExpectedComma => {
            fault("there is no comma", "a comma, the end of the list or object, or a colon after a field's name")
        }
        Error::ExpectedMapColon => fault("there is no colon", "a colon and a value after a field's name"),
        Error::ExpectedArrayEnd => fault("the list does not go on like this", "a comma or a closing `]`"),
        Error::ExpectedMapEnd => fault("the object does not go on like this", "a comma or a closing `}`"),
        Error::ExpectedStructLikeEnd | Error::ExpectedOptionEnd => {
            fault("the object does not go on like this", "a comma or a closing `)`")
        }
        Error::ExpectedIdentifier | Error::InvalidIdentifier(_) => fault("this is no field's name", "a field's name"),
        Error::UnexpectedChar(character) => {
            fault(&format!("the character {} has no place here", quoted(&character.to_string())), "RON")
        }
        Error::Message(_) => odd_ron(text).unwrap_or_else(|| fault("this is no value of a scenario", "plain RON")),
        other => {
            let words = other.to_string();
            match words.strip_prefix("Expected ") {
                Some(expected) => fault("this is not RON", expected),
                None => fault(&format!("this is not RON ({words})"), "RON"),
            }
        }
    }
}

/// Returns the first construct of RON that scenarios do not have: a byte string, or a key that is no word.
fn odd_ron(text: &str) -> Option<SyntaxFault> {
    let outline = outline_of(text)?;
    if let Some(entry) = outline.find_odd_key() {
        return Some(SyntaxFault {
            span: entry.key_span.clone(),
            message: format!("{} is no field's name", quoted(&entry.key)),
            expected: "a field's name".to_owned(),
        });
    }
    let is_bytes = |scalar: &str| ["b\"", "br\"", "br#", "b'"].iter().any(|start| scalar.starts_with(start));
    outline.find_scalar(text, &is_bytes).map(|node| SyntaxFault {
        span: node.span.clone(),
        message: "this is a byte string".to_owned(),
        expected: "a text in quotes".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn ron(text: &str) -> Value {
        read(text, Format::Ron).unwrap()
    }

    #[test]
    fn natural_and_json_shaped_ron_are_the_same_values() {
        let expected = json!({
            "team": "blue", "pose": [0.1, 0.0, -1e-3], "behaviour": { "script": [{ "from_s": 1, "walk": [1, 2, 3] }] },
            "noise": { "gaussian": { "sd_m": 0.1 } }, "rolling": { "exponential_per_s": 0.5 }, "ball": null, "motion": {},
        });
        let natural = "Scenario(team: blue, pose: (0.1, 0.0, -1e-3), behaviour: script([(from_s: 1, walk: (1, 2, 3))]),
            noise: gaussian(sd_m: 0.1), rolling: exponential_per_s(0.5), ball: None, motion: ())";
        let with_some =
            "(team: \"blue\", pose: Some([0.1, 0.0, -1e-3]), behaviour: (script: [(from_s: 1, walk: Some((1, 2, 3)))]),
            noise: gaussian((sd_m: 0.1)), rolling: (exponential_per_s: 0.5), ball: null, motion: Motion())";
        assert_eq!(ron(natural), expected);
        assert_eq!(ron(with_some), expected);
        assert_eq!(ron(&expected.to_string()), expected);
    }

    #[test]
    fn numbers_of_ron_keep_all_their_digits() {
        for number in
            ["0.1", "0.03333333333333333", "1e-40", "123456789.123456", "16777217.0", "-0.25", "18446744073709551615"]
        {
            assert_eq!(ron(number), number.parse::<Value>().unwrap(), "{number}");
        }
    }

    #[test]
    fn numbers_that_are_not_finite_are_found() {
        for (text, start) in [("(a: NaN)", 4), ("(a: [1, -inf])", 8), ("(a: 1e999)", 4), ("(a: inff32)", 4)] {
            let fault = read(text, Format::Ron).unwrap_err();
            assert_eq!((fault.span.start, fault.expected.as_str()), (start, "a finite number"), "{text}");
        }
        for text in ["{\"a\": NaN}", "{\"a\": -Infinity}", "{\"a\": Infinity}", "{\"a\": 1e999}"] {
            let fault = read(text, Format::Json).unwrap_err();
            assert_eq!((fault.span.start, fault.expected.as_str()), (6, "a finite number"), "{text}: {fault:?}");
        }
        // A quoted text is not a number.
        assert!(read("(a: \"NaN\")", Format::Ron).is_ok());
    }
}
