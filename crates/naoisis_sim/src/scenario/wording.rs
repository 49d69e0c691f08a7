//! Wording of error messages: quotes, lists of names, the nearest name.

use std::borrow::Cow;

/// Quotes a word from a file, on one line and cut to a maximum length.
pub fn quoted(word: &str) -> String {
    const LONGEST: usize = 60;
    let mut shown: String = word.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    format!("`{shown}`")
}

/// A message in which what is quoted has at most 100 letters, and a line at most 4000.
pub fn shortened(message: &str) -> Cow<'_, str> {
    const LONGEST_QUOTE: usize = 100;
    const LONGEST_LINE: usize = 4000;

    if message.len() <= LONGEST_QUOTE {
        return Cow::Borrowed(message);
    }
    let mut shown = String::new();
    // The quotation mark that the text is within, the letters since it, and those of the line.
    let (mut mark, mut of_quote, mut of_line) = (None, 0, 0);
    for letter in message.chars() {
        match (mark, letter) {
            (None, '`' | '"') => (mark, of_quote) = (Some(letter), 0),
            (Some(open), close) if open == close => mark = None,
            (Some(_), _) => of_quote += 1,
            (None, _) => {}
        }
        let is_long_quote = mark.is_some() && of_quote > LONGEST_QUOTE;
        if letter == '\n' && !is_long_quote {
            of_line = 0;
        }
        if is_long_quote || of_line > LONGEST_LINE {
            if !shown.ends_with('…') {
                shown.push('…');
            }
            continue;
        }
        of_line += 1;
        shown.push(letter);
    }
    Cow::Owned(shown)
}

/// Lists names as `a`, `b` or `c`.
pub fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    listed(names, "or")
}

/// Lists names as `a`, `b` and `c`.
pub fn all_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    listed(names, "and")
}

fn listed<'a>(names: impl IntoIterator<Item = &'a str>, word: &str) -> String {
    let names: Vec<String> = names.into_iter().map(quoted).collect();
    match names.as_slice() {
        [] => "nothing".to_owned(),
        [only] => only.clone(),
        [all_but_last @ .., last] => format!("{} {word} {last}", all_but_last.join(", ")),
    }
}

/// Combines what is wrong and what was expected to a sentence.
pub fn in_words(message: &str, expected: &str) -> String {
    // A suggestion ends with a question mark already.
    let separator = if message.ends_with('?') { "" } else { ";" };
    format!("{message}{separator} expected {expected}")
}

/// Returns the name that was probably meant by `word`: one that begins with it, or one that is a few typing errors away.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word: String = word.chars().take(100).collect::<String>().to_lowercase();
    let tolerance = (word.chars().count() / 3).max(1);
    names
        .into_iter()
        .filter_map(|name| {
            let lower = name.to_lowercase();
            let begins = word.len() >= 3 && lower.starts_with(word.as_str());
            let distance = if begins { 1 } else { strsim::damerau_levenshtein(&word, &lower) };
            (distance <= tolerance).then_some((distance, name))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// Returns `: did you mean ...?`, or an empty text.
pub fn did_you_mean<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, names).map(|name| format!(": did you mean `{name}`?")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_found_or_none() {
        let names = ["position_m", "velocity_mps", "radius_m"];
        assert_eq!(nearest("radius", names), Some("radius_m"));
        assert_eq!(nearest("Postion_m", names), Some("position_m"));
        assert_eq!(nearest("findball", ["FindBall"]), Some("FindBall"));
        assert_eq!(nearest("colour", names), None);
        assert_eq!(nearest("", names), None);
    }

    #[test]
    fn what_is_quoted_and_lines_have_a_longest_length() {
        let long = "x".repeat(1 << 20);
        for plain in ["", "`a` is \"b\"\nand `c`", &"word `name` ".repeat(100), &"a line\n".repeat(1000)] {
            assert_eq!(shortened(plain), plain);
        }
        let cut = format!("{}…", "x".repeat(100));
        assert_eq!(shortened(&format!("`{long}` is wrong")), format!("`{cut}` is wrong"));
        assert_eq!(shortened(&format!("no \"{long}\": `b`")), format!("no \"{cut}\": `b`"));
        for text in [long.clone(), format!("`{long}"), "`a".repeat(1 << 19), "…".repeat(1 << 20), format!("\"\n{long}")]
        {
            assert!(shortened(&text).chars().count() <= 4002, "{}", &text[..3]);
        }
    }

    #[test]
    fn words_are_quoted_on_one_line() {
        assert_eq!(quoted("a\nb"), "`a\\nb`");
        assert!(quoted(&"x".repeat(1000)).chars().count() < 70);
        assert_eq!(one_of(["a", "b", "c"]), "`a`, `b` or `c`");
    }
}
