//! Writes the mistakes of a match to a JSON file, and returns a table of robots and kinds.

use bevy::prelude::*;
use core::fmt::Write as _;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

use super::mistakes::{Mistake, MistakeFinder, MistakeKind};
use super::output_file::OutputFile;
use super::recorder::{MatchEnd, RecordError, Recorder};
use naoisis_core::team::RobotId;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::trace_numbers::shortest_double;
use naoisis_sim::scenario::Scenario;

/// Writes a file of mistakes.
pub struct MistakeRecorder {
    output: OutputFile,
    finder: Option<MistakeFinder>,
    scenario: String,
    realism: String,
    seed: u64,
}

/// The contents of the file.
#[derive(Serialize)]
struct Report<'a> {
    scenario: &'a str,
    realism: &'a str,
    seed: u64,
    duration_s: f64,
    mistakes: Vec<Entry>,
}

/// A mistake, with the unit of its value.
#[derive(Serialize)]
struct Entry {
    #[serde(flatten)]
    mistake: Mistake,
    unit: &'static str,
}

impl MistakeRecorder {
    /// Creates a file. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let (scenario, realism) = Default::default();
        Ok(Self { output: OutputFile::create(path)?, finder: None, scenario, realism, seed: 0 })
    }
}

impl Recorder for MistakeRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, _: &mut World) {
        let mut finder = MistakeFinder::new(scenario);
        finder.look(record);
        self.finder = Some(finder);
        self.scenario.clone_from(&scenario.name);
        self.realism = scenario.realism_in_words();
        self.seed = scenario.seed;
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        if let Some(finder) = &mut self.finder {
            finder.look(record);
        }
    }

    /// Returns a table of how many mistakes of each kind each robot made.
    fn finish(self: Box<Self>, _: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        let mistakes = self.finder.map(|finder| finder.mistakes()).unwrap_or_default();
        let table = table(&mistakes);
        let shortest = |mistake: Mistake| Mistake {
            from_s: shortest_double(mistake.from_s),
            until_s: shortest_double(mistake.until_s),
            ..mistake
        };
        let mistakes = mistakes.into_iter().map(|mistake| Entry { mistake: shortest(mistake), unit: mistake.unit() });
        let mistakes = mistakes.collect();
        let (scenario, realism) = (&self.scenario, &self.realism);
        let report = Report { scenario, realism, seed: self.seed, duration_s: last.time_s, mistakes };
        let written = serde_json::to_string_pretty(&report)
            .map_err(std::io::Error::other)
            .and_then(|text| writeln!(self.output.writer().map_err(std::io::Error::other)?, "{text}"));
        self.output.close(written)?;
        Ok(Some(table))
    }
}

/// Returns a table of how many mistakes of each kind each robot made: a line for each robot, a column for each kind that occurred.
pub fn table(mistakes: &[Mistake]) -> String {
    let count = |robot: RobotId, kind: MistakeKind| {
        mistakes.iter().filter(|mistake| mistake.robot == robot && mistake.kind == kind).count()
    };
    let mut robots: Vec<RobotId> = mistakes.iter().map(|mistake| mistake.robot).collect();
    robots.sort_unstable();
    robots.dedup();
    let is_there = |kind: &MistakeKind| mistakes.iter().any(|mistake| mistake.kind == *kind);
    let kinds: Vec<MistakeKind> = MistakeKind::ALL.into_iter().filter(is_there).collect();
    if robots.is_empty() {
        return "no mistakes were found\n".to_owned();
    }
    let mut text = "mistakes".to_owned();
    // Writing to a string cannot fail.
    for kind in &kinds {
        _ = write!(text, "  {kind}");
    }
    for robot in robots {
        _ = write!(text, "\n{:<8}", robot.to_string());
        for &kind in &kinds {
            _ = write!(text, "  {:>width$}", count(robot, kind), width = kind.words().len());
        }
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn the_table_has_a_line_a_robot_and_a_column_a_kind() {
        let mistake = |kind, number| Mistake {
            kind,
            robot: RobotId::new(Team::Blue, number),
            other: None,
            from_s: 1.0,
            until_s: 2.0,
            position_m: Vec2::ZERO,
            worst: None,
        };
        let (missed, lost) = (MistakeKind::KickMissed, MistakeKind::OwnPoseLost);
        let expected = "mistakes  own pose lost  kick missed\n\
                        blue1                 1            2\n\
                        blue3                 0            1\n";
        assert_eq!(table(&[mistake(missed, 1), mistake(missed, 3), mistake(lost, 1), mistake(missed, 1)]), expected);
        assert_eq!(table(&[]), "no mistakes were found\n");
    }
}
