//! Faults of the values of a scenario, each with its field.

use super::deserialize::ShapeFault;
use super::field_path::FieldPath;
use super::spans::FieldPart;
use super::wording::{did_you_mean, in_words, one_of, quoted};
use naoisis_sensing::sensing::camera::RenderingUnavailable;

/// A fault of a value in a scenario. `Debug` shows the sentence as well, since `main` and tests that return the fault print that form.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("{path}: {}", in_words(.message, .expected))]
pub struct ScenarioFault {
    /// The faulty field.
    pub path: FieldPath,
    /// Another field that is involved. It is the place of the error if the file does not have `path`.
    pub related: Option<FieldPath>,
    /// What is wrong.
    pub message: String,
    /// What was expected.
    pub expected: String,
    /// The faulty part of the field.
    pub(super) part: FieldPart,
}

naoisis_core::debug_as_displayed!(ScenarioFault);

impl From<RenderingUnavailable> for ScenarioFault {
    fn from(error: RenderingUnavailable) -> Self {
        let path = FieldPath::from("cameras").field("render");
        let expected = "one (Mesa's lavapipe is one in software), or `software`, `off` or `auto`";
        ScenarioFault::new(path, error.to_string(), expected)
    }
}

impl ScenarioFault {
    /// Creates a fault of the value at `path`. Its text is `MESSAGE; expected EXPECTED`: `message` says what is wrong, `expected` what would
    /// be right.
    pub fn new(path: FieldPath, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { path, related: None, message: message.into(), expected: expected.into(), part: FieldPart::Value }
    }

    /// Returns the fault for settings of the wrong shape, which scenarios have at `root`.
    pub(super) fn of_shape(fault: &ShapeFault, root: &FieldPath) -> Self {
        let (path, error) = (fault.path().within(root), fault.error());
        let (message, expected) = error.words(path.last_part().as_deref());
        let fault = ScenarioFault::new(path, message, expected);
        if error.is_about_key() { fault.at_key() } else { fault }
    }

    /// Makes this a fault of the field's name instead of its value.
    #[must_use]
    pub fn at_key(self) -> Self {
        Self { part: FieldPart::Key, ..self }
    }

    /// Describes what is wrong and what was expected, without the field.
    pub fn in_words(&self) -> String {
        in_words(&self.message, &self.expected)
    }

    /// Sets another field that is involved.
    #[must_use]
    pub fn related_to(mut self, path: FieldPath) -> Self {
        self.related = Some(path);
        self
    }
}

/// Returns the fault of a name that the program does not have.
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
