//! Loads scenarios from files, from the embedded library, and from text.

use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io;
use std::path::Path;
use std::sync::Arc;

use super::bytes::{LARGEST_FILE_BYTES, read_bytes};
use super::deserialize;
use super::error::{Place, ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::foreign::{foreign_file, webots_game};
use super::format::Format;
use super::leagues::LEAGUES;
use super::library::{LIBRARY, LibraryScenario};
use super::model_file;
use super::parse::build;
use super::read;
use super::setting::Setting;
use super::text::{ScenarioFile, ScenarioSource};
use super::validate::MOST_FAULTS;
use super::wording::did_you_mean;
use crate::scenario::Scenario;

impl ScenarioFile {
    /// Number of errors that are reported for a file, at most.
    pub const MOST_ERRORS: usize = MOST_FAULTS;

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// The first fault of the file, and where it is.
    pub fn load(path: impl AsRef<Path>) -> Result<ScenarioFile, ScenarioError> {
        ScenarioText::load(path.as_ref()).and_then(ScenarioText::scenario)
    }

    /// Returns the built-in scenario with this name.
    ///
    /// # Errors
    /// If there is no such scenario.
    pub fn named(name: &str) -> Result<ScenarioFile, ScenarioError> {
        ScenarioText::named(name).and_then(ScenarioText::scenario)
    }

    /// Finds a scenario for the command line: by the name of a built-in one, or by the path of a file.
    ///
    /// # Errors
    /// If there is neither, or the file is faulty.
    pub fn find(path_or_name: &str) -> Result<ScenarioFile, ScenarioError> {
        ScenarioText::find(path_or_name).and_then(ScenarioText::scenario)
    }

    /// Does the same as [`ScenarioFile::find`], but reports all errors. `names` returns faults that only the program can find: unregistered
    /// names.
    ///
    /// # Errors
    /// Errors of the file in the order of the text: those of its form, or otherwise those of ranges, or otherwise those of what belongs together.
    pub fn check(
        path_or_name: &str,
        names: impl FnOnce(&Scenario) -> Vec<ScenarioFault>,
    ) -> Result<ScenarioFile, Vec<ScenarioError>> {
        ScenarioText::find(path_or_name).map_err(|error| vec![error])?.check(names)
    }

    /// Reads a scenario from a text. `name` is its name in error messages.
    ///
    /// # Errors
    /// The first fault of the text, and where it is.
    pub fn from_text(text: &str, format: Format, name: &str) -> Result<ScenarioFile, ScenarioError> {
        ScenarioText::new(name, format, text).scenario()
    }

    /// Returns the same scenario with changed fields. Later settings override earlier ones.
    ///
    /// # Errors
    /// The first fault of a setting, or of the resulting scenario.
    pub fn with(&self, settings: &[Setting]) -> Result<ScenarioFile, ScenarioError> {
        if settings.is_empty() { Ok(self.clone()) } else { self.text_with(settings).scenario() }
    }

    /// Does the same as [`ScenarioFile::with`], but reports all errors.
    ///
    /// # Errors
    /// All faults of the settings, or of the resulting scenario.
    pub fn check_with(&self, settings: &[Setting]) -> Result<ScenarioFile, Vec<ScenarioError>> {
        if settings.is_empty() { Ok(self.clone()) } else { self.text_with(settings).check(|_| Vec::new()) }
    }

    fn text_with(&self, settings: &[Setting]) -> ScenarioText {
        let mut source = self.source.clone();
        source.settings.extend(settings.iter().cloned());
        ScenarioText(source)
    }
}

/// A text that should be a scenario.
struct ScenarioText(ScenarioSource);

impl ScenarioText {
    fn new(name: &str, format: Format, text: &str) -> ScenarioText {
        ScenarioText(ScenarioSource::of_file(name, format, text))
    }

    fn find(path_or_name: &str) -> Result<ScenarioText, ScenarioError> {
        let path = Path::new(path_or_name);
        let is_built_in = LIBRARY.iter().any(|entry| entry.name == path_or_name);
        let looks_like_path = path.extension().is_some() || path.components().count() > 1 || path.exists();
        if !is_built_in && looks_like_path { ScenarioText::load(path) } else { ScenarioText::named(path_or_name) }
    }

    fn named(name: &str) -> Result<ScenarioText, ScenarioError> {
        match LIBRARY.iter().find(|entry| entry.name == name) {
            Some(entry) => Ok(ScenarioText::new(entry.name, entry.format, entry.text)),
            // A league without a scenario of its own, such as a division of another league, is played by two built-in teams.
            None if LEAGUES.iter().any(|league| league.name == name) => {
                let text =
                    format!("(name: \"{name}\", league: \"{name}\", teams: (blue: \"passers\", pink: \"roles\"))\n");
                Ok(ScenarioText::new(name, Format::Ron, &text))
            }
            None => {
                let names = LIBRARY.iter().map(|entry| entry.name).chain(LEAGUES.iter().map(|league| league.name));
                let meant = did_you_mean(name, names);
                let message = format!("there is no built-in scenario of this name, and no such file{meant}");
                Err(ScenarioError::of_file(ScenarioErrorKind::NotFound, name, message, expected_name()))
            }
        }
    }

    fn load(path: &Path) -> Result<ScenarioText, ScenarioError> {
        let name = path.display().to_string();
        let unreadable = |message: String, expected: &str| {
            ScenarioError::of_file(ScenarioErrorKind::Unreadable, &name, message, expected.to_owned())
        };
        let bytes = match read_bytes(path) {
            Ok(bytes) => bytes,
            Err(problem) if problem.kind() == io::ErrorKind::NotFound => return Err(not_found(&name, path)),
            Err(problem) => {
                let message = format!("the file cannot be read: {problem}");
                return Err(unreadable(message, "a readable `.ron` or `.json` file"));
            }
        };
        if let Some(kind) = foreign_file(&bytes) {
            let message = format!("this is {kind}; naoisis cannot read it as a scenario");
            return Err(unreadable(message, "a `.ron` or `.json` file of naoisis"));
        }
        let Some(format) = Format::of_path(path) else {
            if name.ends_with(".jsonl") || name.ends_with(".jsonl.zst") {
                let message = "files with this ending are traces, the recordings of matches".to_owned();
                return Err(unreadable(message, "a scenario; `naoisis replay` shows traces"));
            }
            let message = "the file's name does not tell its format".to_owned();
            return Err(unreadable(message, "a name that ends in `.ron` or `.json`"));
        };
        if bytes.len() as u64 > LARGEST_FILE_BYTES {
            let most = LARGEST_FILE_BYTES >> 20;
            let message = format!("the file is too large for a scenario: it has more than {most} MiB");
            return Err(unreadable(message, &format!("at most {most} MiB")));
        }
        if format == Format::Json
            && let Ok(value) = serde_json::from_slice(&bytes)
            && let Some(game) = webots_game(&value, path)
        {
            let unusable = |(message, expected): (String, String)| unreadable(message, &expected);
            return Ok(ScenarioText::new(&name, format, &game.map_err(unusable)?.to_string()));
        }
        match core::str::from_utf8(&bytes) {
            Ok(text) => Ok(ScenarioText::new(&name, format, text)),
            Err(problem) => {
                let valid = problem.valid_up_to();
                let text: Arc<str> = String::from_utf8_lossy(&bytes).into();
                let error = unreadable("the file is not UTF-8 text".to_owned(), "a text file in UTF-8");
                Err(error.at(Place::new(&text, valid..valid)))
            }
        }
    }

    fn scenario(self) -> Result<ScenarioFile, ScenarioError> {
        let name = self.0.name.clone();
        self.check(|_| Vec::new()).map_err(|errors| {
            errors.into_iter().next().unwrap_or_else(|| {
                let message = "the file is no scenario".to_owned();
                ScenarioError::of_file(ScenarioErrorKind::Shape, &name, message, "a scenario".to_owned())
            })
        })
    }

    fn check(self, names: impl FnOnce(&Scenario) -> Vec<ScenarioFault>) -> Result<ScenarioFile, Vec<ScenarioError>> {
        let ScenarioText(source) = self;
        let value = read::read(&source.text, source.format).map_err(|fault| vec![source.syntax_error(fault)])?;
        if model_file::is_model(&value) {
            return Err(vec![model_file::no_scenario(&source, &value)]);
        }
        build(source, value, names)
    }
}

impl Scenario {
    /// Reads the file at `path`, like [`ScenarioFile::load`] but without keeping the text.
    ///
    /// # Errors
    /// The first fault of the file, and where it is.
    pub fn load(path: impl AsRef<Path>) -> Result<Scenario, ScenarioError> {
        ScenarioFile::load(path).map(|file| file.scenario)
    }

    /// Returns the built-in scenario with this name, one of the [`LIBRARY`].
    ///
    /// # Errors
    /// If there is no such scenario.
    pub fn named(name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::named(name).map(|file| file.scenario)
    }

    /// Finds a scenario for the command line: by the name of a built-in one, or by the path of a file.
    ///
    /// # Errors
    /// If there is neither, or the file is faulty.
    pub fn find(path_or_name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::find(path_or_name).map(|file| file.scenario)
    }

    /// Reads a scenario from a text. `name` is its name in error messages.
    ///
    /// # Errors
    /// The first fault of the text, and where it is.
    pub fn from_text(text: &str, format: Format, name: &str) -> Result<Scenario, ScenarioError> {
        ScenarioFile::from_text(text, format, name).map(|file| file.scenario)
    }

    /// Reads a scenario from JSON, as written by programs and tests.
    ///
    /// # Errors
    /// The first fault of the text, and where it is.
    pub fn from_json(text: &str) -> Result<Scenario, ScenarioError> {
        Self::from_text(text, Format::Json, "scenario")
    }

    /// Reads a scenario from RON, as written by programs and tests.
    ///
    /// # Errors
    /// The first fault of the text, and where it is.
    pub fn from_ron(text: &str) -> Result<Scenario, ScenarioError> {
        Self::from_text(text, Format::Ron, "scenario")
    }

    /// Returns the scenario as JSON with every field and with presets filled in. Reading this text gives the same scenario.
    ///
    /// # Errors
    /// Never for a [valid](Scenario::validate) scenario.
    pub fn resolved_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
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

/// Reads settings at `path` of a scenario. Their type is known only to the program.
///
/// # Errors
/// The fault of the settings, and where it is.
pub fn read_settings<T: DeserializeOwned>(value: &Value, path: &FieldPath) -> Result<T, ScenarioFault> {
    deserialize::read(value).map_err(|fault| ScenarioFault::of_shape(&fault, path))
}

impl LibraryScenario {
    /// Returns the description of the scenario, one sentence.
    ///
    /// # Errors
    /// If the embedded file is faulty, which a test rules out.
    pub fn description(&self) -> Result<String, ScenarioError> {
        ScenarioFile::from_text(self.text, self.format, self.name).map(|file| file.scenario.description)
    }
}
