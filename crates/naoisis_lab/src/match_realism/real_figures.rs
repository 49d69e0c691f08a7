//! Figures of real matches: files in `assets/real`, and users' own files.
//!
//! A file is RON, or JSON with the same names:
//!
//! ```ron
//! (
//!     name: "RoboCup 2022-2024, Standard Platform League",
//!     year: "2022-2024",
//!     // The built-in scenarios, or names of your own, that these figures are compared with; without any, all.
//!     scenarios: ["spl2025"],
//!     // The handicaps of the teams in simulated matches are between 0 and this, at most 0.9.
//!     spread: 0.865,
//!     figures: {
//!         // By the key of a quantity, as `naoisis realism --match --explain` prints it; in the same unit.
//!         "goals": (value: 4.88, low: 4.44, high: 5.34, n: 172, of: "matches", source: "the league's list of results"),
//!     },
//! )
//! ```
//!
//! `low` and `high` are the ends of the 95 % interval; without them a difference is not judged. `certainty` is `hard` (the default), or
//! `derived` for figures of a single match or computed from others. `bound` is `exact` (the default), `at_least` or `at_most`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::quantities::quantities;
use naoisis_core::read_file::read_file;

/// Prefix of the keys of kicks by kind. Any kind is possible.
const KICK_KIND: &str = "kicks.";

macro_rules! embedded {
    ($($name:literal)*) => {
        [$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/real/", $name, ".ron")))),*]
    };
}

/// The files that are embedded in the program.
const BUILT_IN: [(&str, &str); 6] =
    embedded!["hsl_k1" "hsl_messages" "spl_2010" "spl_2022_2024" "spl_2023_b_human" "spl_2019_final"];

/// How certain a real figure is.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Certainty {
    /// The figure was counted in a primary source.
    #[default]
    Hard,
    /// The figure is of a single match, or derived from others.
    Derived,
}

/// How a real figure relates to the true value.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// The figure is the true value.
    #[default]
    Exact,
    /// The true value is at least as large.
    AtLeast,
    /// The true value is at most as large.
    AtMost,
}

/// A figure of real matches.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealFigure {
    /// The value, in the unit of its quantity.
    pub value: f64,
    /// The lower end of the 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// The upper end of the 95 % interval.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Size of the sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n: Option<u32>,
    /// What was sampled, such as `matches`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub of: String,
    /// How certain the figure is.
    #[serde(default)]
    pub certainty: Certainty,
    /// How the figure relates to the true value.
    #[serde(default)]
    pub bound: Bound,
    /// The source of the figure.
    pub source: String,
}

/// A file with figures of real matches.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealFigures {
    /// The matches of the figures.
    pub name: String,
    /// The year of these matches.
    pub year: String,
    /// The scenarios that the figures are compared with. If empty, all scenarios.
    #[serde(default)]
    pub scenarios: Vec<String>,
    /// How much the teams of these matches differ in strength: the range of the handicaps, from 0 to this, that the teams of simulated
    /// matches draw. At most 0.9. It is fitted to the spread of the goals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<f32>,
    /// The figures, by the keys of their quantities.
    pub figures: BTreeMap<String, RealFigure>,
}

/// Why figures of real matches cannot be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum RealFiguresError {
    /// The file cannot be read.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The file has no valid figures.
    #[error("{path}: {message}")]
    NotRead {
        /// The file.
        path: PathBuf,
        /// The reason, with its place.
        message: String,
    },
    /// There is no quantity with this key.
    #[error(
        "{path}: there is no quantity `{key}`; expected one of those that `naoisis realism --match --explain` prints"
    )]
    NoSuchQuantity {
        /// The file.
        path: PathBuf,
        /// The key.
        key: String,
    },
    /// A number is not possible.
    #[error("{path}: `{key}`: expected finite numbers, and `low` <= `value` <= `high`")]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// The key of its quantity.
        key: String,
    },
    /// The folder has no files with figures.
    #[error("{0}: the folder has no .ron or .json file; expected at least one")]
    Empty(PathBuf),
}

naoisis_core::debug_as_displayed!(RealFiguresError);

impl RealFigures {
    /// Returns the figures that are embedded in the program.
    pub fn built_in() -> Vec<Self> {
        // A test reads all of them.
        BUILT_IN
            .iter()
            .filter_map(|(name, text)| Self::from_text(text, Path::new(&format!("{name}.ron"))).ok())
            .collect()
    }

    /// Reads a file, or all `.ron` and `.json` files of a folder in the order of their names.
    ///
    /// # Errors
    /// If a file cannot be read, or has a quantity that does not exist.
    pub fn read(path: &Path) -> Result<Vec<Self>, RealFiguresError> {
        if !path.is_dir() {
            return Ok(vec![Self::read_file(path)?]);
        }
        let io_error = |error| RealFiguresError::Io { path: path.to_owned(), error };
        let entries = fs::read_dir(path).map_err(io_error)?.collect::<io::Result<Vec<_>>>().map_err(io_error)?;
        let mut files: Vec<PathBuf> = entries.iter().map(fs::DirEntry::path).collect();
        files.retain(|file| file.extension().is_some_and(|extension| extension == "ron" || extension == "json"));
        files.sort();
        if files.is_empty() {
            return Err(RealFiguresError::Empty(path.to_owned()));
        }
        files.iter().map(|file| Self::read_file(file)).collect()
    }

    fn read_file(path: &Path) -> Result<Self, RealFiguresError> {
        let bytes = read_file(path);
        let bytes = bytes.map_err(|error| RealFiguresError::Io { path: path.to_owned(), error })?;
        Self::from_text(&String::from_utf8_lossy(&bytes), path)
    }

    /// Reads a text: JSON if the file name ends in `.json`, otherwise RON.
    fn from_text(text: &str, path: &Path) -> Result<Self, RealFiguresError> {
        let is_json = path.extension().is_some_and(|extension| extension == "json");
        let read: Result<Self, String> = if is_json {
            serde_json::from_str(text).map_err(|error| error.to_string())
        } else {
            let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
            options.from_str(text).map_err(|error| error.to_string())
        };
        let path = path.to_owned();
        let read = read.map_err(|message| RealFiguresError::NotRead { path: path.clone(), message })?;
        if !read.spread.is_none_or(|spread| (0.0..=0.9).contains(&spread)) {
            let message = "expected a `spread` from 0 to 0.9".to_owned();
            return Err(RealFiguresError::NotRead { path, message });
        }
        let known = quantities(&[]);
        for (key, figure) in &read.figures {
            if !key.starts_with(KICK_KIND) && !known.iter().any(|quantity| quantity.key == *key) {
                return Err(RealFiguresError::NoSuchQuantity { path, key: key.clone() });
            }
            let (low, high) = (figure.low.unwrap_or(figure.value), figure.high.unwrap_or(figure.value));
            if ![low, figure.value, high].iter().all(|number| number.is_finite())
                || low > figure.value
                || figure.value > high
            {
                return Err(RealFiguresError::NotANumber { path, key: key.clone() });
            }
        }
        Ok(read)
    }

    /// Returns whether the figures are compared with this scenario.
    pub fn are_of(&self, scenario: &str) -> bool {
        self.scenarios.is_empty() || self.scenarios.iter().any(|name| name == scenario)
    }

    /// Returns the range of the handicaps that teams draw in simulated matches of `scenario`: that of the first figures in `real` that are
    /// of this scenario and have one, otherwise 0.85.
    pub fn spread(real: &[Self], scenario: &str) -> f32 {
        const DEFAULT: f32 = 0.85;
        real.iter().filter(|figures| figures.are_of(scenario)).find_map(|figures| figures.spread).unwrap_or(DEFAULT)
    }

    /// Returns the text of a file with these figures, in RON.
    ///
    /// # Errors
    /// If the figures cannot be serialised, which does not happen.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        let pretty =
            ron::ser::PrettyConfig::new().struct_names(false).extensions(ron::extensions::Extensions::IMPLICIT_SOME);
        ron::ser::to_string_pretty(self, pretty).map(|text| text + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_embedded_and_reads() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"))).join("real");
        let read = RealFigures::read(&folder).unwrap_or_else(|error| panic!("{error}"));
        let built_in = RealFigures::built_in();
        assert_eq!(built_in.len(), read.len(), "a file of assets/real is not embedded");
        for figures in &read {
            assert!(
                built_in.contains(figures) && !figures.year.is_empty() && !figures.figures.is_empty(),
                "{}",
                figures.name
            );
            assert!(
                figures.figures.values().all(|figure| figure.source.len() > 10),
                "{}: a figure without a source",
                figures.name
            );
        }
    }

    #[test]
    fn teams_differ_in_strength_as_the_first_figures_of_their_scenario_say() {
        let own = r#"(name: "a", year: "2026", scenarios: ["spl2010", "my cup"], spread: 0.3, figures: {})"#;
        let own = RealFigures::from_text(own, Path::new("a.ron")).unwrap();
        let real: Vec<_> = [own].into_iter().chain(RealFigures::built_in()).collect();
        assert_eq!(["spl2010", "my cup", "another"].map(|name| RealFigures::spread(&real, name)), [0.3, 0.3, 0.85]);
        assert_ne!(RealFigures::spread(&real[1..], "spl2010"), RealFigures::spread(&real[1..], "spl2025"));
    }

    fn error(text: &str, name: &str) -> String {
        RealFigures::from_text(text, Path::new(name)).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_in_a_file_is_said() {
        let with = |figures: &str| format!(r#"(name: "a", year: "2025", figures: {{ {figures} }})"#);
        assert!(
            error(&with(r#""gaols": (value: 1, source: "s")"#), "a.ron")
                .contains("a.ron: there is no quantity `gaols`")
        );
        assert!(
            error(&with(r#""goals": (value: 1, low: 2, high: 3, source: "s")"#), "a.ron").contains("`low` <= `value`")
        );
        assert!(error(&with(r#""goals": (value: 1)"#), "a.ron").contains("source"));
        let far = error(r#"(name: "a", year: "2025", spread: 1.5, figures: {})"#, "a.ron");
        assert_eq!(far, "a.ron: expected a `spread` from 0 to 0.9");
        assert!(error(r#"{"name": "a"}"#, "a.json").contains("year"));
        assert!(RealFigures::read(Path::new("nowhere.ron")).unwrap_err().to_string().starts_with("nowhere.ron: "));
    }

    #[test]
    fn what_is_written_reads_the_same() {
        for figures in RealFigures::built_in() {
            let text = figures.to_ron().unwrap();
            assert_eq!(RealFigures::from_text(&text, Path::new("a.ron")).unwrap(), figures, "{text}");
        }
    }

    #[test]
    fn a_folder_of_a_user_is_read_in_the_order_of_names() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(RealFigures::read(folder.path()), Err(RealFiguresError::Empty(_))));
        let json = |name: &str| {
            format!(
                r#"{{"name": "{name}", "year": "2026", "figures": {{"kicks.walk": {{"value": 1, "source": "s"}}}}}}"#
            )
        };
        fs::write(folder.path().join("b.json"), json("b")).unwrap();
        fs::write(folder.path().join("a.json"), json("a")).unwrap();
        fs::write(folder.path().join("notes.txt"), "none").unwrap();
        let read = RealFigures::read(folder.path()).unwrap();
        assert_eq!(read.iter().map(|figures| figures.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        assert!(read[0].are_of("spl2025") && read[0].figures["kicks.walk"].certainty == Certainty::Hard);
    }
}
