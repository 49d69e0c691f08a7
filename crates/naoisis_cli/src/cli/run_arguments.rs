//! The arguments of `naoisis run`.

use bevy::prelude::*;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

use super::agents::AgentArguments;
#[cfg(feature = "booster")]
use super::booster::BoosterArguments;
use super::expect::{ExpectArguments, cores};
use super::game_controller::GameControllerArguments;
use super::outputs::{Output, check_files, check_files_of_policy, cycle_at};
use super::pace::times_real_time;
use super::recordings::Recordings;
use super::teams::TeamArguments;
use naoisis_agents::game_controller::MatchNetwork;
use naoisis_core::cycle::CycleClock;
use naoisis_sensing::sensing::camera::CameraRendering;
use naoisis_sim::scenario::wording::one_of;
use naoisis_sim::scenario::{NotASetting, Realism, Scenario, Setting};
use naoisis_sim::simulation::snapshot::EXTENSION;

/// The values of `--cameras`.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cameras {
    /// No images
    Off,
    /// On the processor
    Software,
    /// On a graphics card
    Gpu,
}

impl From<Cameras> for CameraRendering {
    fn from(cameras: Cameras) -> Self {
        match cameras {
            Cameras::Off => CameraRendering::Off,
            Cameras::Software => CameraRendering::Software,
            Cameras::Gpu => CameraRendering::Gpu,
        }
    }
}

/// Arguments of `naoisis run`.
#[derive(Args, Debug, Clone, Default)]
pub struct RunArguments {
    /// A scenario file (.ron or .json), the name of a built-in scenario (see `naoisis list scenarios`), or a saved
    /// match to continue (.naoisis)
    pub scenario: String,
    #[command(flatten)]
    pub teams: TeamArguments,
    /// Seed of all random numbers, instead of the scenario's
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Set a field of the scenario: messages.loss=0.2
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<Setting>,
    /// Level of realism, instead of the scenario's; the same as --set realism=WORD
    #[arg(long, value_name = "paper|ideal|realistic", value_parser = realism)]
    pub realism: Option<Setting>,
    /// Stop after this many simulated seconds
    #[arg(long, value_name = "S", value_parser = positive_seconds, allow_negative_numbers = true)]
    pub duration: Option<f32>,
    /// Whether and how camera images are rendered, instead of the scenario's value
    #[arg(long, value_enum, value_name = "off|software|gpu")]
    pub cameras: Option<Cameras>,
    #[command(flatten)]
    pub recordings: Recordings,
    #[command(flatten)]
    pub agents: AgentArguments,
    #[command(flatten)]
    pub game_controller: GameControllerArguments,
    #[cfg(feature = "booster")]
    #[command(flatten)]
    pub booster: BoosterArguments,
    /// Play at this multiple of real time, instead of as fast as possible
    #[arg(long, value_name = "X", value_parser = times_real_time, allow_negative_numbers = true)]
    pub pace: Option<f64>,
    #[command(flatten)]
    pub expectations: ExpectArguments,
    /// Save the match (.naoisis), to continue it later
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Save it at this time instead of at the end
    #[arg(long, value_name = "S", value_parser = positive_seconds, allow_negative_numbers = true, requires = "save")]
    pub save_at: Option<f32>,
    /// Replace existing files and frames
    #[arg(long)]
    pub force: bool,
    /// Print the match report: every decision of the referee with its reason
    #[arg(long)]
    pub explain: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Parses a level of realism.
pub(super) fn realism(word: &str) -> Result<Setting, String> {
    if !Realism::NAMES.contains(&word) {
        return Err(format!("expected {}", one_of(Realism::NAMES)));
    }
    format!("realism={word}").parse().map_err(|error: NotASetting| error.to_string())
}

impl RunArguments {
    /// Returns the settings of the command line, in their order.
    pub fn settings(&self) -> Vec<Setting> {
        self.realism.iter().chain(&self.set).cloned().collect()
    }

    /// Returns the network of the matches of further seeds, which have ports of their own.
    pub fn network_of_many(&self) -> Result<Option<MatchNetwork>, String> {
        if self.expectations.asks_for_many() { self.game_controller.of_many(cores()) } else { Ok(None) }
    }

    /// Checks that the outputs can be written, as far as this is known before the match.
    pub fn check_outputs(&self) -> Result<(), String> {
        self.recordings.check()?;
        let mut files = self.recordings.outputs();
        files.extend(self.save.clone().map(|path| Output { option: "--save", path }));
        files.extend(self.expectations.output());
        check_files(Path::new(&self.scenario), &files, self.force)?;
        for policy in self.teams.policies() {
            check_files_of_policy(policy, &files, self.force)?;
        }
        let Some(path) = &self.save else { return Ok(()) };
        if path.extension().is_none_or(|extension| extension != EXTENSION) {
            return Err(format!("--save: {}: expected a file name that ends in .{EXTENSION}", path.display()));
        }
        // This is reported before the match rather than after it.
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() || path.is_dir() {
            return Err(format!("--save: {}: expected a file in a folder that exists", path.display()));
        }
        Ok(())
    }

    /// Checks that the match reaches the time at which it is to be saved.
    pub fn check_time_of_saving(&self, world: &World, scenario: &Scenario) -> Result<(), String> {
        let Some(save_at_s) = self.save_at else { return Ok(()) };
        let clock = world.resource::<CycleClock>();
        let cycle = cycle_at(save_at_s, clock);
        if cycle < clock.cycle {
            let now_s = clock.end_time_s();
            return Err(format!(
                "--save-at: {save_at_s} s are over, the match goes on at {now_s:.1} s; expected a later time"
            ));
        }
        match scenario.last_cycle() {
            Some(last) if cycle > last => {
                let end_s = last as f64 * clock.period_s;
                Err(format!("--save-at: the match ends at {end_s:.1} s; expected a time before {save_at_s} s"))
            }
            _ => Ok(()),
        }
    }
}

pub(super) fn positive_seconds(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        _ => Err("expected a positive number of seconds".to_owned()),
    }
}
