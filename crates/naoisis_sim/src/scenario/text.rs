//! The text that a scenario came from, for locating errors in it.

use core::ops::Range;
use std::sync::Arc;

use super::error::{Place, ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::{FieldPath, Segment};
use super::format::Format;
use super::read::SyntaxFault;
use super::scanner::outline_of;
use super::setting::Setting;
use super::spans::{Content, FieldPart, Node};
use super::types::Scenario;

/// The text that a scenario came from. Faults that are found later can be located in it.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioSource {
    /// The name of the file as given, or that of a built-in scenario.
    pub name: String,
    pub(super) text: Arc<str>,
    pub(super) format: Format,
    /// The settings laid over the text.
    pub(super) settings: Vec<Setting>,
}

/// A fault of a scenario, not located yet.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Finding {
    /// The kind of error.
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
    /// Creates the source of a file's text, without settings.
    pub(super) fn of_file(name: &str, format: Format, text: &str) -> Self {
        // Some editors begin a file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text).into();
        Self { name: name.to_owned(), format, text, settings: Vec::new() }
    }

    /// Returns the error for a syntax fault.
    pub(super) fn syntax_error(&self, fault: SyntaxFault) -> ScenarioError {
        let error = ScenarioError::of_file(ScenarioErrorKind::Syntax, &self.name, fault.message, fault.expected);
        error.at(Place::new(&self.text, fault.span))
    }

    /// Returns how many steps of a path are in the text.
    pub(super) fn steps_found(&self, path: &FieldPath) -> usize {
        self.outline().locate(path, FieldPart::Value).1
    }

    /// Returns the text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the error for a fault of the scenario that came from this text, such as an unregistered behaviour.
    pub fn error(&self, fault: &ScenarioFault) -> ScenarioError {
        self.placed(&self.outline(), &Finding::from(fault.clone()))
    }

    /// Returns the errors for all findings.
    pub(super) fn errors(&self, findings: &[Finding]) -> Vec<ScenarioError> {
        let outline = self.outline();
        findings.iter().map(|finding| self.placed(&outline, finding)).collect()
    }

    /// Returns the outline of the text. It is not kept, because only errors need it.
    fn outline(&self) -> Node {
        let nothing = || Node { span: 0..0, content: Content::Scalar, is_named_struct: false };
        outline_of(&self.text).unwrap_or_else(nothing)
    }

    /// Returns the setting that determines the value at `path`, and its index among the settings.
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

/// Returns the bytes of the value at `path`. If a robot does not have it, returns those of the common setting.
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

/// A scenario, together with the text that it came from.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioFile {
    /// The scenario, which is valid.
    pub scenario: Scenario,
    /// The text that it came from.
    pub source: ScenarioSource,
}
