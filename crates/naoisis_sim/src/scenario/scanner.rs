//! Scans the structure that JSON and RON texts share: brackets, keys, strings and comments.

use core::ops::Range;

use super::spans::{Content, Entry, Node};

/// Nesting depth limit of outlines. Both parsers have a lower limit, 128.
const DEEPEST: usize = 160;

/// Returns the outline of a whole text. Returns `None` if the text is not well-formed.
pub(super) fn outline_of(text: &str) -> Option<Node> {
    let mut scanner = Scanner { text, position: 0 };
    scanner.skip_attributes();
    let node = scanner.value(DEEPEST)?;
    scanner.skip_blanks();
    (scanner.position == text.len()).then_some(node)
}

/// Scans the text byte by byte, as all structural characters are ASCII.
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

    /// Skips `wanted` if it is next. Returns whether it was.
    fn eat(&mut self, wanted: &str) -> bool {
        let is_next = self.rest().starts_with(wanted);
        if is_next {
            self.position += wanted.len();
        }
        is_next
    }

    /// Skips all characters for which `is_wanted`, and returns them.
    fn eat_while(&mut self, is_wanted: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|character| !is_wanted(character)).unwrap_or(rest.len());
        self.position += length;
        &rest[..length]
    }

    /// Skips everything up to the end of `wanted`, or to the end of the text if there is none.
    fn skip_past(&mut self, wanted: &str) {
        self.position = self.rest().find(wanted).map_or(self.text.len(), |at| self.position + at + wanted.len());
    }

    /// Skips blanks and comments.
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

    /// Skips RON's `#![enable(...)]`.
    fn skip_attributes(&mut self) {
        self.skip_blanks();
        while self.eat("#!") {
            self.skip_past("]");
            self.skip_blanks();
        }
    }

    /// Scans the next value, without the blanks before and after it.
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

    /// Scans `(key: value, ...)` or `(value, ...)`. `()` is an object without fields.
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

    /// Skips the comma after an element, unless the end follows.
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
            // No key of a scenario, but it is kept for the error message.
            let key = self.eat_while(|next| !next.is_whitespace() && !",:[](){}\"".contains(next));
            return (!key.is_empty()).then(|| (key.to_owned(), start..self.position));
        }
        Some((self.text[span.clone()].to_owned(), span))
    }

    /// Scans a word. RON's raw identifiers (`r#type`) are returned without their prefix.
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

    /// Returns whether a raw, byte or raw byte string is next.
    fn is_raw_string(&self) -> bool {
        let rest = self.rest();
        let prefix = ["br", "b", "r"].into_iter().find(|prefix| rest.starts_with(prefix));
        prefix.is_some_and(|prefix| {
            let after = &rest[prefix.len()..];
            let hashes = if prefix.ends_with('r') { after.trim_start_matches('#') } else { after };
            hashes.starts_with('"') || (prefix == "b" && after.starts_with('\''))
        })
    }

    /// Skips a string of any kind, or a character.
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
