//! Where things stand in the text of a scenario file: a scanner for the structure that JSON and RON share.
//!
//! The parsers proper are `serde_json` and `ron`; what they return has no positions. This scanner knows brackets,
//! keys, strings and comments, and nothing else, so that a path such as `robots[1].pose` can be found in the text.

use core::ops::Range;

use super::field_path::{FieldPath, Segment};

/// Deeper nesting than this has no outline. Both parsers refuse it before, at 128.
const DEEPEST: usize = 160;

/// A value in the text.
#[derive(Clone, PartialEq, Debug)]
pub struct Node {
    /// Where it stands, in bytes.
    pub span: Range<usize>,
    /// What it is made of.
    pub content: Content,
    /// Whether a type's name stands before it, as in RON's `Scenario(...)`.
    pub is_named_struct: bool,
}

/// What a value is made of.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// A number, a string or a word.
    Scalar,
    /// `[...]`, or RON's `(1, 2)`.
    List(Vec<Node>),
    /// `{...}`, or RON's `(key: value)` and `variant(...)`.
    Map(Vec<Entry>),
}

/// A field in the text.
#[derive(Clone, PartialEq, Debug)]
pub struct Entry {
    /// The key, without quotes.
    pub key: String,
    /// Where the key stands, in bytes.
    pub key_span: Range<usize>,
    /// Its value.
    pub value: Node,
}

/// Which part of a field an error is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Aim {
    /// Its key.
    Key,
    /// Its value.
    Value,
}

impl Node {
    /// The outline of a whole text; none if the text is not well-formed.
    pub fn of_text(text: &str) -> Option<Node> {
        let mut scanner = Scanner { text, position: 0 };
        scanner.skip_attributes();
        let node = scanner.value(DEEPEST)?;
        scanner.skip_blanks();
        (scanner.position == text.len()).then_some(node)
    }

    /// Where `path` is in the text, and how many of its steps were found there. A path that leads on beyond the text
    /// (into a preset, or to a default) is placed at the last key that is there.
    pub fn locate(&self, path: &FieldPath, aim: Aim) -> (Range<usize>, usize) {
        let mut node = self;
        let mut key_span = self.span.start..self.span.start;
        for (found, segment) in path.segments().iter().enumerate() {
            let next = match (segment, &node.content) {
                (Segment::Field(name), Content::Map(entries)) => {
                    // The last of several: what the parsers keep.
                    entries.iter().rev().find(|entry| entry.key == *name).map(|entry| {
                        key_span = entry.key_span.clone();
                        &entry.value
                    })
                }
                (Segment::Index(index), Content::List(nodes)) => nodes.get(*index).inspect(|node| {
                    key_span = node.span.clone();
                }),
                _ => None,
            };
            let Some(next) = next else { return (key_span, found) };
            node = next;
        }
        let span = if aim == Aim::Key { key_span } else { node.span.clone() };
        (span, path.segments().len())
    }

    /// The first key that its object has twice: the second of the two.
    pub fn duplicate_key(&self) -> Option<&Entry> {
        let duplicate = match &self.content {
            Content::Map(entries) => {
                let mut keys: Vec<(&str, usize)> =
                    entries.iter().enumerate().map(|(order, entry)| (entry.key.as_str(), order)).collect();
                keys.sort_unstable();
                let second = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1).min();
                second.map(|order| &entries[order])
            }
            Content::Scalar | Content::List(_) => None,
        };
        duplicate.or_else(|| self.children().find_map(Node::duplicate_key))
    }

    /// The first scalar for which `is_wanted`, given its text.
    pub fn find_scalar<'a>(&'a self, text: &str, is_wanted: &impl Fn(&str) -> bool) -> Option<&'a Node> {
        match self.content {
            Content::Scalar => text.get(self.span.clone()).is_some_and(is_wanted).then_some(self),
            Content::List(_) | Content::Map(_) => self.children().find_map(|node| node.find_scalar(text, is_wanted)),
        }
    }

    /// The first key that is neither a word nor a string.
    pub fn find_odd_key(&self) -> Option<&Entry> {
        let entries: &[Entry] = if let Content::Map(entries) = &self.content { entries } else { &[] };
        let is_odd = |entry: &&Entry| entry.key.starts_with(|first: char| !(first.is_alphabetic() || first == '_'));
        entries.iter().find(is_odd).or_else(|| self.children().find_map(Node::find_odd_key))
    }

    fn children(&self) -> impl Iterator<Item = &Node> {
        let (nodes, entries): (&[Node], &[Entry]) = match &self.content {
            Content::Scalar => (&[], &[]),
            Content::List(nodes) => (nodes, &[]),
            Content::Map(entries) => (&[], entries),
        };
        nodes.iter().chain(entries.iter().map(|entry| &entry.value))
    }
}

/// Reads through the text, byte by byte: all structure is ASCII.
struct Scanner<'a> {
    text: &'a str,
    position: usize,
}

impl<'a> Scanner<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.position..).unwrap_or_default()
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Goes past `wanted` if it is next.
    fn eat(&mut self, wanted: &str) -> bool {
        let is_next = self.rest().starts_with(wanted);
        if is_next {
            self.position += wanted.len();
        }
        is_next
    }

    /// Goes past all characters for which `is_wanted`.
    fn eat_while(&mut self, is_wanted: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|character| !is_wanted(character)).unwrap_or(rest.len());
        self.position += length;
        &rest[..length]
    }

    /// Goes past `wanted` and everything before it; to the end if there is none.
    fn skip_past(&mut self, wanted: &str) {
        self.position = self.rest().find(wanted).map_or(self.text.len(), |at| self.position + at + wanted.len());
    }

    /// Goes past blanks and comments.
    fn skip_blanks(&mut self) {
        loop {
            self.eat_while(char::is_whitespace);
            if self.eat("//") {
                self.skip_past("\n");
            } else if self.eat("/*") {
                let mut depth = 1;
                while depth > 0 && !self.rest().is_empty() {
                    if self.eat("/*") {
                        depth += 1;
                    } else if self.eat("*/") {
                        depth -= 1;
                    } else {
                        self.position += self.peek().map_or(1, char::len_utf8);
                    }
                }
            } else {
                return;
            }
        }
    }

    /// Goes past RON's `#![enable(...)]`.
    fn skip_attributes(&mut self) {
        self.skip_blanks();
        while self.eat("#!") {
            self.skip_past("]");
            self.skip_blanks();
        }
    }

    /// The value that is next, without the blanks before and after it.
    fn value(&mut self, depth: usize) -> Option<Node> {
        let depth = depth.checked_sub(1)?;
        self.skip_blanks();
        let start = self.position;
        let mut is_named_struct = false;
        let content = match self.peek()? {
            '{' => {
                self.position += 1;
                self.entries('}', depth)?
            }
            '[' => {
                self.position += 1;
                self.elements(']', depth)?
            }
            '(' => self.parentheses(depth)?,
            '"' | '\'' => {
                self.string()?;
                Content::Scalar
            }
            _ if self.is_raw_string() => {
                self.string()?;
                Content::Scalar
            }
            first if is_word_start(first) => {
                let word_span = self.word();
                let word = &self.text[word_span.clone()];
                let after_word = self.position;
                self.skip_blanks();
                if self.peek() == Some('(') {
                    let start = self.position;
                    let content = self.parentheses(depth)?;
                    let mut inner = Node { span: start..self.position, content, is_named_struct: false };
                    // `variant(value)` is the value itself, not a list of one.
                    if let Content::List(nodes) = &mut inner.content
                        && nodes.len() == 1
                        && let Some(only) = nodes.pop()
                    {
                        inner = only;
                    }
                    is_named_struct = word != "Some" && word.starts_with(char::is_uppercase);
                    if word == "Some" || is_named_struct {
                        inner.content
                    } else {
                        Content::Map(vec![Entry { key: word.to_owned(), key_span: word_span, value: inner }])
                    }
                } else {
                    self.position = after_word;
                    Content::Scalar
                }
            }
            _ => {
                let scalar = self.eat_while(|next| !next.is_whitespace() && !",:[](){}\"/".contains(next));
                if scalar.is_empty() {
                    return None;
                }
                Content::Scalar
            }
        };
        Some(Node { span: start..self.position, content, is_named_struct })
    }

    /// `(key: value, ...)`, or `(value, ...)`. `()` is an object without fields.
    fn parentheses(&mut self, depth: usize) -> Option<Content> {
        self.position += 1;
        let start = self.position;
        self.skip_blanks();
        if self.eat(")") {
            return Some(Content::Map(Vec::new()));
        }
        let has_key = self.peek().is_some_and(is_word_start) && !self.is_raw_string() && {
            self.word();
            self.skip_blanks();
            self.peek() == Some(':')
        };
        self.position = start;
        if has_key { self.entries(')', depth) } else { self.elements(')', depth) }
    }

    fn elements(&mut self, end: char, depth: usize) -> Option<Content> {
        let mut nodes = Vec::new();
        loop {
            self.skip_blanks();
            if self.eat(end.encode_utf8(&mut [0; 4])) {
                return Some(Content::List(nodes));
            }
            nodes.push(self.value(depth)?);
            self.separator(end)?;
        }
    }

    fn entries(&mut self, end: char, depth: usize) -> Option<Content> {
        let mut entries = Vec::new();
        loop {
            self.skip_blanks();
            if self.eat(end.encode_utf8(&mut [0; 4])) {
                return Some(Content::Map(entries));
            }
            let (key, key_span) = self.key()?;
            self.skip_blanks();
            if !self.eat(":") {
                return None;
            }
            let value = self.value(depth)?;
            entries.push(Entry { key, key_span, value });
            self.separator(end)?;
        }
    }

    /// The comma after an element, unless the end follows.
    fn separator(&mut self, end: char) -> Option<()> {
        self.skip_blanks();
        (self.eat(",") || self.peek() == Some(end)).then_some(())
    }

    fn key(&mut self) -> Option<(String, Range<usize>)> {
        let start = self.position;
        if self.peek()? == '"' || self.is_raw_string() {
            self.string()?;
            let literal = &self.text[start..self.position];
            let key =
                serde_json::from_str(literal).unwrap_or_else(|_| literal.trim_matches(['r', '#', '"']).to_owned());
            return Some((key, start..self.position));
        }
        let span = self.word();
        if span.is_empty() {
            // Not a key that a scenario has; it is kept to be pointed at.
            let key = self.eat_while(|next| !next.is_whitespace() && !",:[](){}\"".contains(next));
            return (!key.is_empty()).then(|| (key.to_owned(), start..self.position));
        }
        Some((self.text[span.clone()].to_owned(), span))
    }

    /// A word; RON's raw identifiers (`r#type`) come without their mark.
    fn word(&mut self) -> Range<usize> {
        if self.rest().starts_with("r#") {
            self.position += 2;
        }
        let start = self.position;
        if self.peek().is_some_and(is_word_start) {
            self.eat_while(|next| next.is_alphanumeric() || next == '_');
        }
        start..self.position
    }

    /// Whether a raw, byte or raw byte string is next.
    fn is_raw_string(&self) -> bool {
        let rest = self.rest();
        let prefix = ["br", "b", "r"].into_iter().find(|prefix| rest.starts_with(prefix));
        prefix.is_some_and(|prefix| {
            let after = &rest[prefix.len()..];
            let hashes = if prefix.ends_with('r') { after.trim_start_matches('#') } else { after };
            hashes.starts_with('"') || (prefix == "b" && after.starts_with('\''))
        })
    }

    /// Any kind of string, or a character.
    fn string(&mut self) -> Option<()> {
        self.eat("b");
        if self.eat("r") {
            let hashes = self.eat_while(|next| next == '#');
            let end = format!("\"{hashes}");
            self.position += 1;
            return self.rest().find(&end).map(|at| self.position += at + end.len());
        }
        let quote = self.peek()?;
        self.position += quote.len_utf8();
        loop {
            let next = self.peek()?;
            self.position += next.len_utf8();
            match next {
                '\\' => self.position += self.peek()?.len_utf8(),
                _ if next == quote => return Some(()),
                _ => {}
            }
        }
    }
}

fn is_word_start(character: char) -> bool {
    character.is_alphabetic() || character == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found<'a>(text: &'a str, path: &str, aim: Aim) -> &'a str {
        let (span, _) = Node::of_text(text).unwrap().locate(&FieldPath::from(path), aim);
        &text[span]
    }

    #[test]
    fn paths_are_found_in_json() {
        let text = r#"{ "a\"b": [1, {"pose": [0.5, -1e3, 180]}], "walk": { "x": "}", "x": 2 } }"#;
        assert_eq!(found(text, "walk.x", Aim::Value), "2");
        let path = FieldPath::default().field("a\"b").index(1).field("pose").index(1);
        assert_eq!(&text[Node::of_text(text).unwrap().locate(&path, Aim::Value).0], "-1e3");
        assert_eq!(Node::of_text(text).unwrap().duplicate_key().unwrap().key_span.start, text.rfind("\"x\"").unwrap());
    }

    #[test]
    fn paths_are_found_in_ron() {
        let text = "#![enable(implicit_some)]\n// a comment, with ( and \"\nScenario(\n  /* { /* nested */ */ ball: Some((position_m: (0.1, -.5))),\n  noise: gaussian(sd_m: 0.1), rolling: exponential_per_s(0.5),\n  robots: [(team: blue, r#type: r#\"a \" b\"#, behaviour: script([(walk: (1, 2, 3)),]),)],\n)";
        assert_eq!(found(text, "ball.position_m[1]", Aim::Value), "-.5");
        assert_eq!(found(text, "noise.gaussian.sd_m", Aim::Value), "0.1");
        assert_eq!(found(text, "noise.gaussian.sd_m", Aim::Key), "sd_m");
        assert_eq!(found(text, "rolling.exponential_per_s", Aim::Value), "0.5");
        assert_eq!(found(text, "robots[0].type", Aim::Value), "r#\"a \" b\"#");
        assert_eq!(found(text, "robots[0].behaviour.script[0].walk[2]", Aim::Value), "3");
        assert!(Node::of_text(text).unwrap().is_named_struct);
    }

    #[test]
    fn what_is_not_in_the_text_is_placed_at_the_last_key_that_is() {
        let text = r#"{ "field": "spl2025", "robots": [ {}, {} ] }"#;
        assert_eq!(found(text, "field.goal.width_m", Aim::Value), "\"field\"");
        assert_eq!(found(text, "robots[1].pose", Aim::Value), "{}");
        assert_eq!(found(text, "ball", Aim::Value), "");
    }

    #[test]
    fn broken_and_deep_texts_have_no_outline() {
        for text in ["", "{", "(a", "[1, 2", "\"abc", "{1", "r#\"a", "[1}", "(a: 1", "}", ",", "a: b"] {
            assert_eq!(Node::of_text(text), None, "{text}");
        }
        assert_eq!(Node::of_text(&"[".repeat(1_000_000)), None);
        assert_eq!(Node::of_text(&"a(".repeat(1_000_000)), None);
        assert_eq!(Node::of_text(&format!("{}1{}", "[".repeat(500), "]".repeat(500))), None);
    }
}
