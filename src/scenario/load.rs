//! Loading scenarios: from files, from the embedded library, from text.

use core::fmt;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use super::error::{Place, ScenarioError, ScenarioErrorKind};
use super::field_path::{FieldPath, Segment};
use super::library::LIBRARY;
use super::outline::{Aim, Node};
use super::setting::Setting;
use super::shape::{self, ShapeFault};
use super::validate::{ScenarioFault, place_ball_beside_robots};
use super::wording::did_you_mean;
use super::{presets, read};
use crate::scenario::Scenario;

/// Larger files are no scenarios.
const LARGEST_FILE_BYTES: u64 = 16 << 20;

/// The two spellings of a scenario.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Format {
    /// Rusty Object Notation, `.ron`.
    Ron,
    /// JSON, `.json`.
    Json,
}

impl Format {
    /// The format that a file's name tells.
    pub fn of_path(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "ron" => Some(Format::Ron),
            "json" => Some(Format::Json),
            _ => None,
        }
    }

    pub(super) fn smallest_scenario(self) -> &'static str {
        match self {
            Format::Ron => "`(robots: [(team: blue, number: 1)])`",
            Format::Json => "`{ \"robots\": [{ \"team\": \"blue\", \"number\": 1 }] }`",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Format::Ron => "RON",
            Format::Json => "JSON",
        })
    }
}

/// The text that a scenario came from: whatever turns out to be wrong with the scenario later can still be placed.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioSource {
    /// The file as it was named, or the name of a built-in scenario.
    pub name: String,
    text: Arc<str>,
    value: Value,
    outline: Node,
    /// What is laid over the text.
    settings: Vec<Setting>,
}

impl ScenarioSource {
    /// The text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The error for something wrong with the scenario that this is the text of, such as a behaviour that nobody has
    /// registered.
    pub fn error(&self, fault: &ScenarioFault) -> ScenarioError {
        self.located(
            ScenarioErrorKind::Value,
            &fault.path,
            fault.related.as_ref(),
            fault.aim,
            &fault.message,
            &fault.expected,
        )
    }

    fn located(
        &self,
        kind: ScenarioErrorKind,
        path: &FieldPath,
        related: Option<&FieldPath>,
        aim: Aim,
        message: &str,
        expected: &str,
    ) -> ScenarioError {
        if let Some(setting) = self.settings.iter().rev().find(|setting| setting.concerns(path)) {
            return setting.error(kind, message, expected);
        }
        let place = Place::new(&self.text, self.find(path, related, aim));
        ScenarioError::of_file(kind, &self.name, message.to_owned(), expected.to_owned())
            .at(place)
            .in_field(path.clone())
    }

    /// Where the text says what is at `path`. What a robot does not say itself, it has from the common settings.
    fn find(&self, path: &FieldPath, related: Option<&FieldPath>, aim: Aim) -> core::ops::Range<usize> {
        let (own, found) = self.outline.locate(path, aim);
        if found == path.segments().len() {
            return own;
        }
        let common = match path.segments() {
            [Segment::Field(robots), Segment::Index(_), ..] if robots == "robots" => Some(path.without_first(2)),
            _ => None,
        };
        if let Some(common) = common {
            let (place, found) = self.outline.locate(&common, aim);
            if found > 0 && found == common.segments().len() {
                return place;
            }
        }
        match related {
            Some(related) if found == 0 => self.find(related, None, aim),
            _ => own,
        }
    }
}

/// A scenario together with the text that it came from.
#[derive(Clone, PartialEq, Debug)]
pub struct ScenarioFile {
    /// The scenario, valid.
    pub scenario: Scenario,
    /// Its text.
    pub source: ScenarioSource,
}

impl ScenarioFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// What is wrong with the file, and where.
    pub fn load(path: impl AsRef<Path>) -> Result<ScenarioFile, ScenarioError> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let error =
            |kind, message: String, expected: &str| ScenarioError::of_file(kind, &name, message, expected.to_owned());
        let bytes = match read_bytes(path) {
            Ok(bytes) => bytes,
            Err(problem) if problem.kind() == io::ErrorKind::NotFound => return Err(not_found(&name, path)),
            Err(problem) => {
                let message = format!("the file cannot be read: {problem}");
                return Err(error(ScenarioErrorKind::Unreadable, message, "a readable `.ron` or `.json` file"));
            }
        };
        let Some(format) = Format::of_path(path) else {
            let message = "the file's name does not tell its format".to_owned();
            return Err(error(ScenarioErrorKind::Unreadable, message, "a name that ends in `.ron` or `.json`"));
        };
        if bytes.len() as u64 > LARGEST_FILE_BYTES {
            let message = format!("the file has more than {} MiB", LARGEST_FILE_BYTES >> 20);
            return Err(error(ScenarioErrorKind::Unreadable, message, "a scenario"));
        }
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(problem) => {
                let valid = problem.utf8_error().valid_up_to();
                let text: Arc<str> = String::from_utf8_lossy(problem.as_bytes()).into();
                let message = "the file is not UTF-8 text".to_owned();
                let error = error(ScenarioErrorKind::Unreadable, message, "a text file in UTF-8");
                return Err(error.at(Place::new(&text, valid..valid)));
            }
        };
        ScenarioFile::from_text(&text, format, &name)
    }

    /// The built-in scenario of this name.
    ///
    /// # Errors
    /// When there is none.
    pub fn named(name: &str) -> Result<ScenarioFile, ScenarioError> {
        match LIBRARY.iter().find(|entry| entry.name == name) {
            Some(entry) => ScenarioFile::from_text(entry.text, entry.format, entry.name),
            None => {
                let meant = did_you_mean(name, LIBRARY.iter().map(|entry| entry.name));
                let message = format!("there is no built-in scenario of this name, and no such file{meant}");
                Err(ScenarioError::of_file(ScenarioErrorKind::NotFound, name, message, expected_name()))
            }
        }
    }

    /// What a command line means: the name of a built-in scenario, or the path of a file.
    ///
    /// # Errors
    /// When there is neither, or the file is wrong.
    pub fn find(path_or_name: &str) -> Result<ScenarioFile, ScenarioError> {
        let path = Path::new(path_or_name);
        let is_built_in = LIBRARY.iter().any(|entry| entry.name == path_or_name);
        let looks_like_path = path.extension().is_some() || path.components().count() > 1 || path.exists();
        if !is_built_in && looks_like_path { ScenarioFile::load(path) } else { ScenarioFile::named(path_or_name) }
    }

    /// Reads a text. `name` is what errors call it.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn from_text(text: &str, format: Format, name: &str) -> Result<ScenarioFile, ScenarioError> {
        // Some editors begin a file with a byte order mark.
        let text: Arc<str> = text.strip_prefix('\u{feff}').unwrap_or(text).into();
        let (value, outline) = read::read(&text, format).map_err(|fault| {
            ScenarioError::of_file(ScenarioErrorKind::Syntax, name, fault.message, fault.expected)
                .at(Place::new(&text, fault.span))
        })?;
        let source = ScenarioSource { name: name.to_owned(), text, value, outline, settings: Vec::new() };
        ScenarioFile::build(source)
    }

    /// The same scenario with some fields set otherwise; later settings win.
    ///
    /// # Errors
    /// What is wrong with a setting, or with the scenario that comes of it.
    pub fn with(&self, settings: &[Setting]) -> Result<ScenarioFile, ScenarioError> {
        if settings.is_empty() {
            return Ok(self.clone());
        }
        let mut source = self.source.clone();
        source.settings.extend_from_slice(settings);
        ScenarioFile::build(source)
    }

    fn build(source: ScenarioSource) -> Result<ScenarioFile, ScenarioError> {
        let mut value = source.value.clone();
        source.settings.iter().try_for_each(|setting| setting.lay_over(&mut value))?;
        let gives_ball_place = value.pointer("/ball/position_m").is_some();
        if let Value::Object(root) = &mut value {
            presets::resolve(root).map_err(|fault| source.error(&fault))?;
        }
        let mut scenario: Scenario = shape::read(&value).map_err(|fault| shape_error(&source, &fault))?;
        if !gives_ball_place {
            place_ball_beside_robots(&mut scenario);
        }
        scenario.validate().map_err(|fault| source.error(&fault))?;
        Ok(ScenarioFile { scenario, source })
    }
}

impl Scenario {
    /// Reads the file at `path`: [`ScenarioFile::load`] without the text.
    ///
    /// # Errors
    /// What is wrong with the file, and where.
    pub fn load(path: impl AsRef<Path>) -> Result<Scenario, ScenarioError> {
        ScenarioFile::load(path).map(|file| file.scenario)
    }

    /// The built-in scenario of this name: one of the [`LIBRARY`].
    ///
    /// # Errors
    /// When there is none.
    pub fn named(name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::named(name).map(|file| file.scenario)
    }

    /// What a command line means: the name of a built-in scenario, or the path of a file.
    ///
    /// # Errors
    /// When there is neither, or the file is wrong.
    pub fn find(path_or_name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::find(path_or_name).map(|file| file.scenario)
    }

    /// Reads a text. `name` is what errors call it.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn from_text(text: &str, format: Format, name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::from_text(text, format, name).map(|file| file.scenario)
    }

    /// Reads a scenario in JSON, as programs and tests write it.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn from_json(text: &str) -> Result<Scenario, ScenarioError> {
        Self::from_text(text, Format::Json, "scenario")
    }

    /// Reads a scenario in RON, as programs and tests write it.
    ///
    /// # Errors
    /// What is wrong with the text, and where.
    pub fn from_ron(text: &str) -> Result<Scenario, ScenarioError> {
        Self::from_text(text, Format::Ron, "scenario")
    }

    /// The scenario as JSON with every field, presets filled in. It loads again as it is.
    ///
    /// # Errors
    /// Never, for a [valid](Scenario::validate) scenario.
    pub fn resolved_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(io::Error::other("it is a directory"));
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn expected_name() -> String {
    "the path of a `.ron` or `.json` file, or a name that `naoisis list scenarios` shows".to_owned()
}

fn not_found(name: &str, path: &Path) -> ScenarioError {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let meant = did_you_mean(&stem, LIBRARY.iter().map(|entry| entry.name));
    let meant = if meant.is_empty() { meant } else { format!("{meant} That is a built-in scenario's name") };
    let message = format!("there is no such file{meant}");
    ScenarioError::of_file(ScenarioErrorKind::NotFound, name, message, expected_name())
}

/// Reads settings that scenarios have at `path`, of a type that only the program knows.
///
/// # Errors
/// What is wrong with them, and where.
pub(crate) fn read_settings<T: DeserializeOwned>(value: &Value, path: &FieldPath) -> Result<T, ScenarioFault> {
    shape::read(value).map_err(|fault| settings_fault(&fault, path))
}

fn settings_fault(fault: &ShapeFault, settings: &FieldPath) -> ScenarioFault {
    let path = fault.path().within(settings);
    let (message, expected) = fault.error().words(path.last_field());
    let is_about_key = fault.error().is_about_key();
    let fault = ScenarioFault::new(path, message, expected);
    if is_about_key { fault.at_key() } else { fault }
}

fn shape_error(source: &ScenarioSource, fault: &ShapeFault) -> ScenarioError {
    let path = fault.path();
    let aim = if fault.error().is_about_key() { Aim::Key } else { Aim::Value };
    let (message, expected) = fault.error().words(path.last_field());
    source.located(ScenarioErrorKind::Shape, &path, None, aim, &message, &expected)
}
