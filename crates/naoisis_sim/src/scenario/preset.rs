//! A named set of values that comes with the program.

use serde_json::Value;

use super::format::Format;
use super::read::read;

/// A named set of values, in a RON file that is embedded in the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Preset {
    /// The name in scenarios.
    pub name: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

impl Preset {
    /// Returns the values of the preset.
    pub(super) fn value(&self) -> Value {
        // A test reads all embedded files.
        read(self.text, Format::Ron).unwrap_or_default()
    }
}

/// Embeds the presets of a folder of `assets`, each with the name of its file.
macro_rules! presets {
    ($folder:literal: $($name:literal)*) => {
        &[$($crate::scenario::preset::Preset {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/", $folder, "/", $name, ".ron")),
        }),*]
    };
}
pub(super) use presets;
