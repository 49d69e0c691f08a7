//! The text that a scenario came from: whatever is wrong with the scenario is placed in it.

use core::ops::Range;
use std::sync::Arc;

use super::error::{Place, ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::{FieldPath, Segment};
use super::format::Format;
use super::outline::{Content, FieldPart, Node};
use super::read::SyntaxFault;
use super::scanner::outline_of;
use super::setting::Setting;
use super::types::Scenario;

/// The text that a scenario came from: whatever turns out to be wrong with the scenario later can still be placed.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioSource {
    /// The file as it was named, or the name of a built-in scenario.
    pub name: String,
    pub(super) text: Arc<str>,
    pub(super) format: Format,
    /// What is laid over the text.
    pub(super) settings: Vec<Setting>,
}

/// Something wrong with a scenario, not placed yet.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Finding {
    /// What kind of thing.
    pub kind: ScenarioErrorKind,
    /// The field, what is wrong, and what was expected.
    pub fault: ScenarioFault,
}

impl From<ScenarioFault> for Finding {
    fn from(fault: ScenarioFault) -> Self {
        Self { kind: ScenarioErrorKind::Value, fault }
    }
}

impl ScenarioSource {
    /// A file's text, as it is.
    pub(super) fn of_file(name: &str, format: Format, text: &str) -> Self {
        // Some editors begin a file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).into();
        Self { name: name.to_owned(), format, text, settings: Vec::new() }
    }

    /// The error of a text that could not be read.
    pub(super) fn syntax_error(&self, fault: SyntaxFault) -> ScenarioError {
        let error = ScenarioError::of_file(ScenarioErrorKind::Syntax, &self.name, fault.message, fault.expected);
        error.at(Place::new(&self.text, fault.span))
    }

    /// How many of a path's steps the text has.
    pub(super) fn steps_found(&self, path: &FieldPath) -> usize {
        self.outline().locate(path, FieldPart::Value).1
    }

    /// The text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The error for something wrong with the scenario that this is the text of, such as a behaviour that nobody has
    /// registered.
    pub fn error(&self, fault: &ScenarioFault) -> ScenarioError {
        self.placed(&self.outline(), &Finding::from(fault.clone()))
    }

    /// The errors for all that was found.
    pub(super) fn errors(&self, findings: &[Finding]) -> Vec<ScenarioError> {
        let outline = self.outline();
        findings.iter().map(|finding| self.placed(&outline, finding)).collect()
    }

    /// Where the values stand. Only errors need it, so that it is not kept.
    fn outline(&self) -> Node {
        let nothing = || Node { span: 0..0, content: Content::Scalar, is_named_struct: false };
        outline_of(&self.text).unwrap_or_else(nothing)
    }

    /// The setting that the value at `path` comes of, and its place among the settings.
    pub(super) fn setting_of(&self, path: &FieldPath) -> Option<(usize, &Setting)> {
        self.settings.iter().enumerate().rev().find(|(_, setting)| setting.concerns(path))
    }

    fn placed(&self, outline: &Node, finding: &Finding) -> ScenarioError {
        let Finding { kind, fault } = finding;
        if let Some((_, setting)) = self.setting_of(&fault.path) {
            return setting.error(*kind, &fault.message, &fault.expected);
        }
        let place = Place::new(&self.text, find(outline, &fault.path, fault.related.as_ref(), fault.part));
        ScenarioError::of_file(*kind, &self.name, fault.message.clone(), fault.expected.clone())
            .at(place)
            .in_field(fault.path.clone())
    }
}

/// Where a text says what is at `path`. What a robot does not say itself, it has from the common settings.
fn find(outline: &Node, path: &FieldPath, related: Option<&FieldPath>, part: FieldPart) -> Range<usize> {
    let (own, found) = outline.locate(path, part);
    if found == path.segments().len() {
        return own;
    }
    let common = match path.segments() {
        [Segment::Field(robots), Segment::Index(_), ..] if robots == "robots" => Some(path.without_first(2)),
        _ => None,
    };
    if let Some(common) = common {
        let (place, found) = outline.locate(&common, part);
        if found > 0 && found == common.segments().len() {
            return place;
        }
    }
    match related {
        Some(related) if found == 0 => find(outline, related, None, part),
        _ => own,
    }
}

/// A scenario together with the text that it came from.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioFile {
    /// The scenario, valid.
    pub scenario: Scenario,
    /// The text that it came from.
    pub source: ScenarioSource,
}
