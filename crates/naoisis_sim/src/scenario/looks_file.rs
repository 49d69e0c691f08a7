//! Files with the ranges from which the looks of images are drawn. They are laid over those of the program in `assets/looks`.

use serde::de::DeserializeOwned;
use std::path::Path;

use super::bytes::{LARGEST_FILE_BYTES, read_bytes};
use super::deserialize;
use super::error::{ScenarioError, ScenarioErrorKind};
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::format::Format;
use super::merge::lay_over;
use super::preset::{Preset, presets};
use super::read::read;
use super::text::ScenarioSource;

/// The looks that come with the program.
pub const LOOKS: &[Preset] = presets!["looks": "robocup"];

/// Reads the looks of the file at `path`, laid over those of the program. Returns the program's looks if there is no file. `T` is the type
/// of the looks.
///
/// # Errors
/// The first fault of the file, and where it is.
pub fn read_looks<T: DeserializeOwned>(path: Option<&Path>) -> Result<T, ScenarioError> {
    let preset = &LOOKS[0];
    let mut value = preset.value();
    let source = match path {
        None => ScenarioSource::of_file(preset.name, Format::Ron, preset.text),
        Some(path) => {
            let (source, own) = read_file(path)?;
            if !own.is_object() {
                let fault = ScenarioFault::new(
                    FieldPath::default(),
                    "these are no looks",
                    "an object with `light`, `turf` or others",
                );
                return Err(source.error(&fault));
            }
            lay_over(&mut value, own, "");
            source
        }
    };
    deserialize::read(&value).map_err(|fault| source.error(&ScenarioFault::of_shape(&fault, &FieldPath::default())))
}

fn read_file(path: &Path) -> Result<(ScenarioSource, serde_json::Value), ScenarioError> {
    let name = path.display().to_string();
    let unreadable =
        |kind, message: String, expected: &str| ScenarioError::of_file(kind, &name, message, expected.to_owned());
    let Some(format) = Format::of_path(path) else {
        let message = "the name of the file does not say its format".to_owned();
        return Err(unreadable(ScenarioErrorKind::Unreadable, message, "a name that ends in `.ron` or `.json`"));
    };
    let bytes = read_bytes(path).map_err(|problem| {
        unreadable(ScenarioErrorKind::Unreadable, format!("it cannot be read: {problem}"), "a file with looks")
    })?;
    if bytes.len() as u64 > LARGEST_FILE_BYTES {
        let message = format!("it has more than {} MiB", LARGEST_FILE_BYTES >> 20);
        return Err(unreadable(ScenarioErrorKind::Syntax, message, "a file with looks"));
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| unreadable(ScenarioErrorKind::Syntax, "it is not UTF-8 text".to_owned(), "a file with looks"))?;
    let source = ScenarioSource::of_file(&name, format, &text);
    let value = read(source.text(), format).map_err(|fault| source.syntax_error(fault))?;
    Ok((source, value))
}
