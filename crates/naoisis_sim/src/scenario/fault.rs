//! What can be wrong with the values of a scenario, field by field.

use super::field_path::FieldPath;
use super::outline::FieldPart;
use super::shape::ShapeFault;
use super::wording::{did_you_mean, in_words, one_of, quoted};
use naoisis_sensing::sensing::camera::RenderingUnavailable;

/// A value of a scenario that cannot be. Its `Debug` form is the sentence too, as `main` and tests that return it print that.
#[derive(Clone, PartialEq, thiserror::Error)]
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

naoisis_core::debug_as_displayed!(ScenarioFault);

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

    /// What is wrong with the shape of settings that scenarios have at `root`.
    pub(super) fn of_shape(fault: &ShapeFault, root: &FieldPath) -> Self {
        let (path, error) = (fault.path().within(root), fault.error());
        let (message, expected) = error.words(path.last_part().as_deref());
        let fault = ScenarioFault::new(path, message, expected);
        if error.is_about_key() { fault.at_key() } else { fault }
    }

    /// The fault of a field's name, rather than of its value.
    #[must_use]
    pub fn at_key(self) -> Self {
        Self { part: FieldPart::Key, ..self }
    }

    /// What is wrong and what was expected, without the field.
    pub fn in_words(&self) -> String {
        in_words(&self.message, &self.expected)
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
