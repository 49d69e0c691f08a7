//! The outline of a scenario file's text, for finding a path such as `robots[1].pose` in it.
//!
//! The files are parsed by `serde_json` and `ron`, whose results have no positions.

use core::ops::Range;

use super::field_path::{FieldPath, Segment};

/// A value in the text.
#[derive(Clone, PartialEq, Debug)]
pub struct Node {
    /// The bytes of the value.
    pub span: Range<usize>,
    /// The contents of the value.
    pub content: Content,
    /// Whether the name of a type precedes it, as in RON's `Scenario(...)`.
    pub is_named_struct: bool,
}

/// The contents of a value.
#[derive(Clone, PartialEq, Debug)]
pub enum Content {
    /// A number, a string or a word.
    Scalar,
    /// `[...]`, or RON's `(1, 2)`.
    List(Vec<Node>),
    /// `{...}`, or RON's `(key: value)` and `variant(...)`.
    Map(Vec<Entry>),
}

/// A field of an object in the text.
#[derive(Clone, PartialEq, Debug)]
pub struct Entry {
    /// The key, without quotes.
    pub key: String,
    /// The bytes of the key.
    pub key_span: Range<usize>,
    /// Its value.
    pub value: Node,
}

/// The part of a field that an error is about.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FieldPart {
    /// Its key.
    Key,
    /// Its value.
    Value,
}

/// Returns the field with this name: the last of several, like the parsers.
fn field<'a>(entries: &'a [Entry], name: &str) -> Option<&'a Entry> {
    entries.iter().rev().find(|entry| entry.key == name)
}

impl Node {
    /// Returns the bytes of the value at `path`, and how many of its steps were found. If the path leads beyond the text (into a preset, or
    /// to a default), returns the bytes of the last key that was found.
    pub fn locate(&self, path: &FieldPath, part: FieldPart) -> (Range<usize>, usize) {
        let mut node = self;
        let mut key_span = self.span.start..self.span.start;
        for (found, segment) in path.segments().iter().enumerate() {
            let next = match (segment, &node.content) {
                (Segment::Field(name), Content::Map(entries)) => {
                    // A value that is not beside the model may be in it.
                    let in_model = || match &field(entries, "model")?.value.content {
                        Content::Map(of_model) => field(of_model, name),
                        _ => None,
                    };
                    field(entries, name).or_else(in_model).map(|entry| {
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
        let span = if part == FieldPart::Key { key_span } else { node.span.clone() };
        (span, path.segments().len())
    }

    /// Returns the first key that occurs twice in its object, at its second occurrence.
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

    /// Returns the first scalar whose text `is_wanted`.
    pub fn find_scalar<'a>(&'a self, text: &str, is_wanted: &impl Fn(&str) -> bool) -> Option<&'a Node> {
        match self.content {
            Content::Scalar => text.get(self.span.clone()).is_some_and(is_wanted).then_some(self),
            Content::List(_) | Content::Map(_) => self.children().find_map(|node| node.find_scalar(text, is_wanted)),
        }
    }

    /// Returns the first key that is neither a word nor a string.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::scanner::outline_of;

    fn found<'a>(text: &'a str, path: &str, part: FieldPart) -> &'a str {
        let (span, _) = outline_of(text).unwrap().locate(&FieldPath::from(path), part);
        &text[span]
    }

    #[test]
    fn paths_are_found_in_json() {
        let text = r#"{ "a\"b": [1, {"pose": [0.5, -1e3, 180]}], "walk": { "x": "}", "x": 2 } }"#;
        assert_eq!(found(text, "walk.x", FieldPart::Value), "2");
        let path = FieldPath::default().field("a\"b").index(1).field("pose").index(1);
        assert_eq!(&text[outline_of(text).unwrap().locate(&path, FieldPart::Value).0], "-1e3");
        assert_eq!(outline_of(text).unwrap().duplicate_key().unwrap().key_span.start, text.rfind("\"x\"").unwrap());
    }

    #[test]
    fn paths_are_found_in_ron() {
        let text = "#![enable(implicit_some)]\n// a comment, with ( and \"\nScenario(\n  /* { /* nested */ */ ball: Some((position_m: (0.1, -.5))),\n  noise: gaussian(sd_m: 0.1), rolling: exponential_per_s(0.5),\n  robots: [(team: blue, r#type: r#\"a \" b\"#, behaviour: script([(walk: (1, 2, 3)),]),)],\n)";
        assert_eq!(found(text, "ball.position_m[1]", FieldPart::Value), "-.5");
        assert_eq!(found(text, "noise.gaussian.sd_m", FieldPart::Value), "0.1");
        assert_eq!(found(text, "noise.gaussian.sd_m", FieldPart::Key), "sd_m");
        assert_eq!(found(text, "rolling.exponential_per_s", FieldPart::Value), "0.5");
        assert_eq!(found(text, "robots[0].type", FieldPart::Value), "r#\"a \" b\"#");
        assert_eq!(found(text, "robots[0].behaviour.script[0].walk[2]", FieldPart::Value), "3");
        assert!(outline_of(text).unwrap().is_named_struct);
    }

    #[test]
    fn what_is_not_in_the_text_is_placed_at_the_last_key_that_is() {
        let text = r#"{ "field": "spl2025", "robots": [ {}, {} ] }"#;
        assert_eq!(found(text, "field.goal.width_m", FieldPart::Value), "\"field\"");
        assert_eq!(found(text, "robots[1].pose", FieldPart::Value), "{}");
        assert_eq!(found(text, "ball", FieldPart::Value), "");
    }

    #[test]
    fn broken_and_deep_texts_have_no_outline() {
        for text in ["", "{", "(a", "[1, 2", "\"abc", "{1", "r#\"a", "[1}", "(a: 1", "}", ",", "a: b"] {
            assert_eq!(outline_of(text), None, "{text}");
        }
        assert_eq!(outline_of(&"[".repeat(1_000_000)), None);
        assert_eq!(outline_of(&"a(".repeat(1_000_000)), None);
        assert_eq!(outline_of(&format!("{}1{}", "[".repeat(500), "]".repeat(500))), None);
    }
}
