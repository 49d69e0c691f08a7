//! `naoisis vision`: measures the accuracy of the vision of a scenario's robots.

use clap::{Args, ValueEnum};
use std::process::ExitCode;

use super::calibrate::found;
use super::interrupt::Interrupt;
use super::realism::no_model;
use super::report;
use super::report::{CommandResult, OrReport};
use super::run_arguments::realism;
use super::terminal::Printer;
use naoisis_core::random::RandomStream;
use naoisis_core::team::{RobotId, Team};
use naoisis_lab::calibration::{calibrate_by_images, model_file};
use naoisis_lab::trials::seeing;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::sensing::vision::VisionSource;
use naoisis_sensing::sensing::vision::image::accuracy::{self, Conditions};
use naoisis_sim::scenario::{RobotModel, ScenarioFile, Setting};

/// Arguments of `naoisis vision`.
#[derive(Args, Debug, Clone)]
pub struct VisionArguments {
    /// The robots, ball and pitch: a scenario file, or the name of a built-in scenario
    #[arg(default_value = "match3v3")]
    scenario: String,
    /// Set a field of the scenario: model=rover
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
    /// Level of realism, instead of the scenario's; the same as --set realism=WORD
    #[arg(long, value_name = "paper|ideal|realistic", value_parser = realism)]
    realism: Option<Setting>,
    /// Number of random scenes; in each a robot looks once with all its cameras
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    scenes: u32,
    /// Seed of the scenes
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Measure the geometric vision in the same scenes instead of image vision, with the errors of the scenario;
    /// neither includes the misalignment of cameras
    #[arg(long)]
    geometric: bool,
    /// Print the model of the robot with the errors of image vision for its geometric vision; the table goes to
    /// standard error
    #[arg(long, conflicts_with = "geometric")]
    fit: bool,
    /// The shape of the robots [default: as in the scenario]
    #[arg(long, value_enum)]
    design: Option<Design>,
    /// Let bodies cast shadows
    #[arg(long)]
    shadows: bool,
    /// Sample each pixel at its centre instead of averaging over its area
    #[arg(long)]
    no_antialiasing: bool,
}

/// The shape of robots.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
enum Design {
    /// Few boxes
    Simple,
    /// Like a NAO
    Nao,
}

impl VisionArguments {
    fn settings(&self) -> Vec<Setting> {
        self.realism.iter().chain(&self.set).cloned().collect()
    }

    /// Returns the scenario with the settings of the command line.
    fn file(&self) -> Result<ScenarioFile, ExitCode> {
        let file = super::begin::scenario_file(&self.scenario)?;
        file.check_with(&self.settings()).map_err(|errors| report::scenario_errors(&errors))
    }

    /// Returns the conditions of the scenario and the command line.
    fn conditions(&self, file: &ScenarioFile) -> Conditions {
        let mut conditions = seeing::conditions(&file.scenario);
        conditions.vision.source = if self.geometric { VisionSource::Geometric } else { VisionSource::Image };
        let cameras = &mut conditions.cameras;
        match self.design {
            Some(Design::Simple) => cameras.design = RobotDesign::Simple,
            Some(Design::Nao) => cameras.design = RobotDesign::Nao,
            None => {}
        }
        cameras.shadows |= self.shadows;
        cameras.antialiasing &= !self.no_antialiasing;
        conditions
    }
}

/// Draws the scenes and prints which of the objects in them were detected.
pub fn vision(arguments: &VisionArguments) -> CommandResult {
    let file = arguments.file()?;
    let conditions = arguments.conditions(&file);
    let model = model_to_fit(arguments, &file)?;
    // There are no files to close.
    Interrupt::end_at_once().or_failure()?;
    let mut printer = Printer::default();
    let mut stream = RandomStream::for_match(arguments.seed, "accuracy of image vision");
    let table = accuracy::measure(arguments.scenes as usize, &conditions, &mut stream);
    match model {
        Some(model) => {
            let mut calibration = calibrate_by_images(&table, &conditions.cameras);
            calibration.keep_possible(&model);
            report::note(&found(&model, &calibration));
            let basis = format!("images of {}", arguments.scenario);
            printer.print(model_file(&model, &format!("{}_by_images", model.name), &basis, &calibration));
        }
        None => {
            let realism = file.scenario.realism_in_words();
            printer.print(format_args!("{}, realism {realism}: {table}\n", arguments.scenario));
        }
    }
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Returns the model of the robots, for --fit.
fn model_to_fit(arguments: &VisionArguments, file: &ScenarioFile) -> Result<Option<RobotModel>, ExitCode> {
    if !arguments.fit {
        return Ok(None);
    }
    let robot = file.scenario.robot(RobotId::new(Team::Blue, 1));
    let name = robot.model.unwrap_or_else(|| file.scenario.model.clone());
    RobotModel::find(&name).map(Some).map_err(|error| no_model("", &error))
}
