//! `naoisis calibrate`: fits a robot model to logs of a real robot.

use clap::Args;
use core::fmt::Write;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::PathBuf;
use std::process::ExitCode;

use super::realism::no_model;
use super::report;
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use naoisis_lab::calibration::{COLUMNS, Calibration, OdometryTrack, RobotLog, calibrate as find_figures, model_file};
use naoisis_record::record::mcap_records::is_mcap;
use naoisis_sim::scenario::RobotModel;

/// Arguments of `naoisis calibrate`.
#[derive(Args, Debug, Clone)]
#[command(after_long_help = columns())]
pub struct CalibrateArguments {
    /// CSV tables of walks, kicks and sightings, whose columns are listed below, and MCAP files with the odometry of walks
    /// (topic `/odometer_state`)
    #[arg(required = true, value_name = "LOG.csv|LOG.mcap")]
    logs: Vec<PathBuf>,
    /// The model to start from, for figures that the logs do not determine: a name (see `naoisis list robots`), or a
    /// .ron file
    #[arg(long, value_name = "MODEL")]
    robot: String,
    /// Name of the new model [default: the name of the robot with `_calibrated`]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
}

/// Reads logs. Prints the model to standard output, and the figures that were found or could not be found to standard
/// error.
pub fn calibrate(arguments: &CalibrateArguments) -> CommandResult {
    let model = RobotModel::find(&arguments.robot).map_err(|error| no_model("--robot: ", &error))?;
    let log = read(&arguments.logs).or_usage_error()?;
    let calibration = find_figures(&log, &model);
    report::note(&found(&model, &calibration));
    if calibration.figures.is_empty() {
        return Err(report::failure("the logs have too few rows for any figure"));
    }
    let name = arguments.name.clone().unwrap_or_else(|| format!("{}_calibrated", model.name));
    let file_name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let logs = arguments.logs.iter().map(file_name).collect::<Vec<String>>().join(", ");
    let mut printer = Printer::default();
    let text = model_file(&model, &name, &logs, &calibration);
    // What is written must be accepted by the other commands.
    RobotModel::from_ron(&format!("{name}.ron"), &text).map_err(|error| no_model("the calibrated model: ", &error))?;
    printer.print(text);
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Reads recordings, and then the tables that refer to them.
fn read(paths: &[PathBuf]) -> Result<RobotLog, String> {
    let mut log = RobotLog::default();
    let mut tables = Vec::new();
    for path in paths {
        let unreadable = |problem: io::Error| format!("{} cannot be read: {problem}", path.display());
        let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
        if is_mcap(file.fill_buf().map_err(unreadable)?) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            log.odometry.extend(OdometryTrack::read_all(&name, file).map_err(unreadable)?);
        } else {
            tables.push((path, file));
        }
    }
    for (path, file) in tables {
        log.read(file).map_err(|error| format!("{}, {error}", path.display()))?;
    }
    Ok(log)
}

/// Returns a table of the figures that were found, with those of the model for comparison, and of those that could not be found.
pub(super) fn found(model: &RobotModel, calibration: &Calibration) -> String {
    let width = calibration.figures.iter().map(|figure| figure.path.chars().count()).max().unwrap_or_default();
    let mut text = format!("{:width$}      found   95 % confidence          {}\n", "figure", model.name);
    for figure in &calibration.figures {
        let settings = model.all_settings();
        let before = figure.path.split('.').try_fold(None, |value: Option<&serde_json::Value>, name| {
            let inner = match value {
                None => settings.get(name),
                Some(value) => value.get(name),
            };
            inner.map(Some)
        });
        let before = before.flatten().map_or_else(|| "-".to_owned(), ToString::to_string);
        let estimate = figure.estimate;
        let _ = writeln!(
            text,
            "{:width$}  {:9.4}   {:9.4} to {:9.4}  {before:>9}   {}",
            figure.path, estimate.value, estimate.low, estimate.high, figure.basis
        );
    }
    for lacking in &calibration.lacking {
        let _ = writeln!(text, "not found: {lacking}");
    }
    text
}

/// Returns the columns of logs, for the help text.
fn columns() -> String {
    let mut text =
        "Columns (others are ignored; angles are positive to the left, positions to the front and to the left):\n"
            .to_owned();
    for (kind, name, meaning, needed) in COLUMNS {
        let mark = if *needed { "" } else { " (optional)" };
        let _ = writeln!(text, "  {kind:8}  {name:20}  {meaning}{mark}");
    }
    text.push_str(
        "A walk is straight, or a turn on the spot. An object that was in view but not detected is a sighting, too.\n",
    );
    text
}
