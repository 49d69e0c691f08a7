//! What can be wrong with the values of a scenario, field by field.

use super::field_path::{FieldPath, Segment};
use super::outline::FieldPart;
use super::wording::{did_you_mean, in_words, one_of, quoted};
use crate::sensing::camera::RenderingUnavailable;

/// A value of a scenario that cannot be.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{path}: {}", in_words(.message, .expected))]
pub struct ScenarioFault {
    /// The field at fault.
    pub path: FieldPath,
    /// Another field that has to do with it: where to look if `path` was left to its default.
    pub related: Option<FieldPath>,
    /// What is wrong.
    pub message: String,
    /// What was expected instead.
    pub expected: String,
    /// Which part of the field is at fault.
    pub(super) part: FieldPart,
}

impl From<RenderingUnavailable> for ScenarioFault {
    fn from(error: RenderingUnavailable) -> Self {
        let path = FieldPath::from("cameras").field("render");
        let expected = "one (Mesa's lavapipe is one in software), or `software`, `off` or `auto`";
        ScenarioFault::new(path, error.to_string(), expected)
    }
}

impl ScenarioFault {
    /// Something wrong at `path`.
    pub fn new(path: FieldPath, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { path, related: None, message: message.into(), expected: expected.into(), part: FieldPart::Value }
    }

    /// The fault of a field's name, rather than of its value.
    #[must_use]
    pub(crate) fn at_key(self) -> Self {
        Self { part: FieldPart::Key, ..self }
    }

    /// What is wrong and what was expected, without the field.
    pub fn in_words(&self) -> String {
        in_words(&self.message, &self.expected)
    }

    /// Whether it may be there only because something else is wrong: in the same part of the scenario, in what its robot
    /// has from the common settings, or in the other field that it has to do with.
    pub(super) fn may_come_of(&self, wrong: &[FieldPath]) -> bool {
        let common = match self.path.segments() {
            [_, Segment::Index(_), Segment::Field(field), ..] => match field.as_str() {
                "head_deg" => "head",
                "behaviour" => "messages",
                field => field,
            },
            _ => "",
        };
        let common = FieldPath::from(common);
        let own = [Some(&self.path), self.related.as_ref(), Some(&common)];
        let mut parts = own.into_iter().flatten().map(FieldPath::part).filter(|part| !part.is_empty());
        parts.any(|part| wrong.iter().any(|other| other.part() == part))
    }

    /// The fault with another field that has to do with it.
    #[must_use]
    pub fn related_to(mut self, path: FieldPath) -> Self {
        self.related = Some(path);
        self
    }
}

/// The fault of a name in a file that names nothing which the program has.
pub fn unknown_name<'a>(
    path: &FieldPath,
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> ScenarioFault {
    let message = format!("there is no {what} {}{}", quoted(name), did_you_mean(name, known.clone()));
    let expected = if known.clone().next().is_none() {
        format!("none: this program has registered no {what}")
    } else {
        one_of(known)
    };
    ScenarioFault::new(path.clone(), message, expected)
}
