//! What can be wrong with the values of a scenario, field by field.

use core::fmt;

use super::field_path::{FieldPath, Segment};
use super::outline::FieldPart;
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
    /// The values that it was judged by, itself among them; of none it is not known, and may be all of its part of the scenario.
    judged_by: Box<[FieldPath]>,
}

impl fmt::Debug for ScenarioFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// A place where something is wrong, so that the scenario has there what the file may not have meant.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct WrongPlace {
    pub path: FieldPath,
    /// Whether a name is wrong, of a field or of a preset: whatever stands beside it and is not given may have been meant.
    pub is_name: bool,
}

impl From<&ScenarioFault> for WrongPlace {
    fn from(fault: &ScenarioFault) -> Self {
        let is_name = fault.part == FieldPart::Key || fault.path.last_field() == Some("preset");
        WrongPlace { path: fault.path.clone(), is_name }
    }
}

impl WrongPlace {
    /// Whether the value at `path` may be another than the file meant. `is_given` tells whether a file gives a value.
    fn may_change(&self, path: &FieldPath, is_given: &impl Fn(&FieldPath) -> bool) -> bool {
        let beside = self.path.segments().len().saturating_sub(1);
        let is_beside = self.is_name && path.segments().len() > beside && path.starts_with(&self.path.first(beside));
        path.starts_with(&self.path) || self.path.starts_with(path) || (is_beside && !is_given(&path.first(beside + 1)))
    }
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
        Self {
            path,
            related: None,
            message: message.into(),
            expected: expected.into(),
            part: FieldPart::Value,
            judged_by: Box::default(),
        }
    }

    /// The fault of a value that is wrong whatever the others are.
    #[must_use]
    pub fn by_itself(self) -> Self {
        self.judged_with([])
    }

    /// The fault of a value together with these others.
    #[must_use]
    pub fn judged_with(mut self, others: impl IntoIterator<Item = FieldPath>) -> Self {
        let earlier = core::mem::take(&mut self.judged_by).into_iter();
        self.judged_by = earlier.chain([self.path.clone()]).chain(others).collect();
        self
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

    /// Whether it may be there only because something else is wrong: with a value that it was judged by, or, if these are not
    /// known, in the same part of the scenario, in what its robot has from the common settings, or in the other field that it
    /// has to do with.
    pub(super) fn may_come_of(&self, wrong: &[WrongPlace], is_given: &impl Fn(&FieldPath) -> bool) -> bool {
        if !self.judged_by.is_empty() {
            return self.judged_by.iter().any(|path| wrong.iter().any(|place| place.may_change(path, is_given)));
        }
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
        parts.any(|part| wrong.iter().any(|other| other.path.part() == part))
    }

    /// Whether one of the other values that it was judged by is wrong.
    pub(super) fn may_come_of_others(&self, wrong: &[WrongPlace]) -> bool {
        self.judged_by.iter().skip(1).any(|path| wrong.iter().any(|place| place.may_change(path, &|_| true)))
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
    ScenarioFault::new(path.clone(), message, expected).by_itself()
}
