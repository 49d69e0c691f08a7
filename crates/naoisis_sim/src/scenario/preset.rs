//! A named set of values that comes with the program.

use serde_json::Value;

use super::format::Format;
use super::read::read;

/// A named set of values, as a file in RON that is embedded in the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Preset {
    /// The name by which scenarios refer to it.
    pub name: &'static str,
    /// The file's text.
    pub text: &'static str,
}

impl Preset {
    /// Its values.
    pub(super) fn value(&self) -> Value {
        // A test reads every embedded file.
        read(self.text, Format::Ron).unwrap_or_default()
    }
}

/// The presets of a folder of `assets`, each with the name of its file.
macro_rules! presets {
    ($folder:literal: $($name:literal)*) => {
        &[$($crate::scenario::preset::Preset {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/", $folder, "/", $name, ".ron")),
        }),*]
    };
}
pub(super) use presets;
