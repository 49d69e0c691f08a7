//! The scenarios that come with the program: `assets/scenarios`.

use super::format::Format;

/// A scenario that is embedded in the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LibraryScenario {
    /// The name for commands: the file name without extension.
    pub name: &'static str,
    /// The format of the text.
    pub format: Format,
    /// The text of the file.
    pub text: &'static str,
}

macro_rules! embedded {
    ($($name:literal $extension:literal $format:ident,)*) => {
        &[$(LibraryScenario {
            name: $name,
            format: Format::$format,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/scenarios/", $name, ".", $extension)),
        }),*]
    };
}

/// All scenarios that come with the program, by name.
pub const LIBRARY: &[LibraryScenario] = embedded![
    "collision_ball_post" "ron" Ron,
    "collision_ball_standing_robot" "ron" Ron,
    "collision_moving_ball" "ron" Ron,
    "collision_moving_robots" "ron" Ron,
    "collision_post" "ron" Ron,
    "collision_static_ball" "ron" Ron,
    "collision_static_robot" "ron" Ron,
    "fitness_get_up_back" "ron" Ron,
    "fitness_get_up_front" "ron" Ron,
    "fitness_kick" "ron" Ron,
    "fitness_walk" "ron" Ron,
    "hsl2026_large" "ron" Ron,
    "hsl2026_middle" "ron" Ron,
    "hsl2026_small" "ron" Ron,
    "k1_against_nao" "ron" Ron,
    "kick_left_side" "ron" Ron,
    "kick_left_straight" "ron" Ron,
    "kick_right_side" "ron" Ron,
    "kick_right_straight" "json" Json,
    "kick_wrong_side" "ron" Ron,
    "match3v3" "ron" Ron,
    "match3v3_images" "ron" Ron,
    "match7v7" "ron" Ron,
    "messages" "json" Json,
    "pass" "ron" Ron,
    "spl2010" "ron" Ron,
    "spl2025" "ron" Ron,
    "walk_square" "ron" Ron,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;
    use std::path::Path;

    /// Returns the names of the files in a folder of `assets`, sorted.
    fn files_in(folder: &str) -> Vec<String> {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"))).join(folder);
        let mut names: Vec<String> =
            path.read_dir().unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn every_file_is_embedded_and_loads() {
        let embedded: Vec<String> = LIBRARY
            .iter()
            .map(|entry| {
                let extension = if entry.format == Format::Ron { "ron" } else { "json" };
                format!("{}.{extension}", entry.name)
            })
            .collect();
        assert_eq!(embedded, files_in("scenarios"));
        for entry in LIBRARY {
            let file = ScenarioFile::named(entry.name).unwrap_or_else(|error| panic!("{error}"));
            assert!(!file.scenario.description.is_empty(), "{}", entry.name);
            assert_eq!(file.scenario.name, entry.name);
        }
        let named = |presets: &[super::super::Preset]| {
            let mut names: Vec<String> = presets.iter().map(|preset| format!("{}.ron", preset.name)).collect();
            names.sort();
            names
        };
        assert_eq!(named(super::super::FIELD_PRESETS), files_in("fields"));
        assert_eq!(named(super::super::RULES_PRESETS), files_in("rules"));
        assert_eq!(named(super::super::BALL_PRESETS), files_in("balls"));
        assert_eq!(named(super::super::MODELS), files_in("robots"));
        assert_eq!(named(super::super::LEAGUES), files_in("leagues"));
    }
}
