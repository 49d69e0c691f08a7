//! Errors of scenario files, with their place and what was expected.

use core::fmt;
use core::ops::Range;
use std::sync::Arc;

use super::field_path::FieldPath;
use super::wording::in_words;

/// A kind of error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum ScenarioErrorKind {
    /// There is no such file or built-in scenario.
    NotFound,
    /// The file cannot be read, or its name does not tell its format.
    Unreadable,
    /// The text is not RON or not JSON.
    Syntax,
    /// There is no such field, or a value has the wrong type.
    Shape,
    /// A value is not possible.
    Value,
}

/// A place in a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The faulty bytes of the text, at most up to the end of the line.
    pub span: Range<usize>,
    text: Arc<str>,
}

impl Place {
    /// Returns the place of a span of bytes in a text.
    pub(super) fn new(text: &Arc<str>, span: Range<usize>) -> Place {
        let mut start = span.start.min(text.len());
        while !text.is_char_boundary(start) {
            start -= 1;
        }
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..].find(['\n', '\r']).map_or(text.len(), |newline| start + newline);
        let mut end = span.end.clamp(start, line_end);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        Place {
            line: text[..line_start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            span: start..end,
            text: Arc::clone(text),
        }
    }

    /// Returns the whole text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the line of the place, without its line end.
    pub fn source_line(&self) -> &str {
        self.text.lines().nth(self.line - 1).unwrap_or_default()
    }
}

/// An error in a scenario file. It is displayed as one paragraph: `PATH:LINE:COLUMN: `, then what is wrong and what was expected. `Debug`
/// shows the same, since `main` and tests that return the error print that form.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ScenarioError(Box<Details>);

naoisis_core::debug_as_displayed!(ScenarioError);

/// The contents of an error. They are boxed, since errors are large and rare.
#[derive(Clone, PartialEq, Eq)]
struct Details {
    kind: ScenarioErrorKind,
    file: String,
    place: Option<Place>,
    path: Option<FieldPath>,
    message: String,
    expected: String,
}

impl ScenarioError {
    /// Creates an error about a file as a whole.
    pub(super) fn of_file(kind: ScenarioErrorKind, file: &str, message: String, expected: String) -> Self {
        Self(Box::new(Details { kind, file: file.to_owned(), place: None, path: None, message, expected }))
    }

    /// Sets the place in the file.
    #[must_use]
    pub(super) fn at(mut self, place: Place) -> Self {
        self.0.place = Some(place);
        self
    }

    /// Sets the path in the scenario.
    #[must_use]
    pub(super) fn in_field(mut self, path: FieldPath) -> Self {
        self.0.path = Some(path);
        self
    }

    /// Returns the kind of error.
    pub fn kind(&self) -> ScenarioErrorKind {
        self.0.kind
    }

    /// Returns the file as it was named, or the name of a built-in scenario.
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// Returns the place in the file. Returns `None` if the file could not be read at all.
    pub fn place(&self) -> Option<&Place> {
        self.0.place.as_ref()
    }

    /// Returns the line, from 1.
    pub fn line(&self) -> Option<usize> {
        self.place().map(|place| place.line)
    }

    /// Returns the column in characters, from 1.
    pub fn column(&self) -> Option<usize> {
        self.place().map(|place| place.column)
    }

    /// Returns the faulty field, if the text is well-formed.
    pub fn path(&self) -> Option<&FieldPath> {
        self.0.path.as_ref()
    }

    /// Returns what is wrong.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns what was expected.
    pub fn expected(&self) -> &str {
        &self.0.expected
    }

    /// Returns `PATH:LINE:COLUMN: ` and what is wrong, without what was expected.
    pub fn headline(&self) -> String {
        match self.place() {
            Some(place) => format!("{}:{}:{}: {}", self.file(), place.line, place.column, self.message()),
            None => format!("{}: {}", self.file(), self.message()),
        }
    }
}

impl fmt::Display for Details {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:", self.file)?;
        if let Some(place) = &self.place {
            write!(formatter, "{}:{}:", place.line, place.column)?;
        }
        write!(formatter, " {}", in_words(&self.message, &self.expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let text: Arc<str> = Arc::from("ä\r\n  ö: \"über\",\r\n}");
        let place = Place::new(&text, text.find("\"über").unwrap()..text.len());
        assert_eq!((place.line, place.column), (2, 6));
        assert_eq!(&text[place.span.clone()], "\"über\",");
        assert_eq!(place.source_line(), "  ö: \"über\",");
        let end = Place::new(&text, 1000..2000);
        assert_eq!((end.line, end.column), (3, 2));
    }
}
