//! Expectations of the command line and of scenarios: how they are judged and reported.

use bevy::prelude::*;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::interrupt::Interrupt;
use super::outputs::Output;
use super::terminal::Printer;
use naoisis_core::replace_file::replace_file;
use naoisis_record::expectations::{Verdict, junit, play_all};
use naoisis_sim::scenario::{Expectation, NotAnExpectation, Quantity, Scenario};

/// Arguments about expectations.
#[derive(Args, Debug, Clone, Default)]
pub struct ExpectArguments {
    /// What is expected of the match: "blue.goals >= 1 within 30 s"; with "in 25 % of 200", of that many seeds. Exit
    /// status 1 if it fails
    #[arg(long, value_name = "EXPECTATION", value_parser = expectation)]
    pub expect: Vec<Expectation>,
    /// Write the verdicts on expectations as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

fn expectation(text: &str) -> Result<Expectation, String> {
    text.parse().map_err(|error: NotAnExpectation| error.to_string())
}

impl ExpectArguments {
    /// Returns the file to write.
    pub fn output(&self) -> Option<Output> {
        self.junit.clone().map(|path| Output { option: "--junit", path })
    }

    /// Checks that the robots of the expectations are in the match.
    pub fn check(&self, scenario: &Scenario) -> Result<(), String> {
        for expectation in &self.expect {
            if let Quantity::OfRobot(robot, _) = expectation.quantity
                && !scenario.has_robot(robot)
            {
                return Err(format!("--expect: `{expectation}`: there is no robot `{robot}` in the match"));
            }
        }
        Ok(())
    }

    /// Returns the expectations about the match itself.
    pub fn of_match(&self) -> Vec<Expectation> {
        self.expect.iter().copied().filter(|expectation| expectation.frequency.is_none()).collect()
    }

    /// Returns whether an expectation is about many matches.
    pub fn asks_for_many(&self) -> bool {
        self.expect.iter().any(|expectation| expectation.frequency.is_some())
    }

    /// Plays the matches of the expectations about many matches, and returns their verdicts.
    pub fn judge_many(
        &self,
        simulator: impl Fn() -> App + Sync,
        scenario: &Scenario,
        interrupt: &Interrupt,
    ) -> Result<Vec<Verdict>, String> {
        let many: Vec<Expectation> =
            self.expect.iter().copied().filter(|expectation| expectation.frequency.is_some()).collect();
        play_many(simulator, scenario, &many, interrupt)
    }
}

/// Plays the matches of all expectations on all cores, and returns their verdicts.
pub fn play_many(
    simulator: impl Fn() -> App + Sync,
    scenario: &Scenario,
    expected: &[Expectation],
    interrupt: &Interrupt,
) -> Result<Vec<Verdict>, String> {
    play_all(simulator, scenario, expected, cores(), interrupt.stop()).map_err(|error| error.to_string())
}

/// Returns the number of matches that are played at the same time.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Prints the verdicts; with `quiet`, only failed ones. Returns whether all expectations hold.
pub fn print_verdicts(printer: &mut Printer, verdicts: &[Verdict], quiet: bool) -> bool {
    for verdict in verdicts.iter().filter(|verdict| !quiet || !verdict.holds) {
        let word = if verdict.holds { "ok   " } else { "wrong" };
        printer.print(format_args!("  {word}  {verdict}\n"));
    }
    verdicts.iter().all(|verdict| verdict.holds)
}

/// Writes the verdicts on each scenario, or why it could not be played, as JUnit XML.
pub fn write_junit(path: &Path, scenarios: &[(String, Result<Vec<Verdict>, String>)]) -> Result<(), String> {
    let text = junit(scenarios);
    let written = replace_file(path, |mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| format!("cannot write {}: {error}", path.display()))
}
