//! `naoisis robot import`: makes a robot model from a URDF or MJCF file.

use clap::Args;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;

use super::notes;
use super::outputs::{self, Output};
use super::report;
use super::report::{CommandResult, OrReport};
use super::robot_sheet::{draw_sheet, sheet_name};
use super::terminal::Printer;
use naoisis_lab::description::{ImportOptions, Imported, import as make_model};
use naoisis_sim::scenario::RobotModel;

/// Arguments of `naoisis robot import`.
#[derive(Args, Debug, Clone)]
pub struct ImportArguments {
    /// The robot's description: URDF or MJCF
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The joint by which the head turns to the sides [default: the one called head or neck]
    #[arg(long, value_name = "JOINT")]
    head_yaw: Option<String>,
    /// The joint by which the head nods [default: the one called head or neck]
    #[arg(long, value_name = "JOINT")]
    head_pitch: Option<String>,
    /// A link or camera of the description that is a camera; may be repeated, for up to four [default: the most likely one]
    #[arg(long, value_name = "NAME")]
    camera: Vec<String>,
    /// A calibration of its camera in YAML, of ROS, Kalibr (a camera for each --camera) or OpenCV
    #[arg(long, value_name = "FILE")]
    camera_info: Option<PathBuf>,
    /// Angles of joints when the robot stands, radians; those of others are 0 [default: slightly bent knees]
    #[arg(long, value_name = "JOINT=RAD,...", value_delimiter = ',')]
    stand: Vec<Angle>,
    /// Name of the model [default: that of the description]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// The folder to write NAME.ron and its sheet NAME.png into
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

/// The angle of a joint, such as `left_knee=0.5`.
#[derive(Debug, Clone)]
struct Angle(String, f64);

impl FromStr for Angle {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once('=').and_then(|(joint, angle)| Some((joint.trim(), angle.trim().parse().ok()?)));
        match parts {
            Some((joint, angle)) if !joint.is_empty() && f64::is_finite(angle) => Ok(Angle(joint.to_owned(), angle)),
            _ => Err("expected the name of a joint and its angle in radians, such as left_knee=0.5".to_owned()),
        }
    }
}

/// Makes a model from a description, and writes it with its sheet. Prints the figures that were found and not found, and what to measure.
pub(super) fn import(arguments: &ImportArguments) -> CommandResult {
    let options = ImportOptions {
        name: arguments.name.clone(),
        head_yaw: arguments.head_yaw.clone(),
        head_pitch: arguments.head_pitch.clone(),
        cameras: arguments.camera.clone(),
        camera_info: arguments.camera_info.clone(),
        stand: arguments.stand.iter().map(|Angle(joint, angle)| (joint.clone(), *angle)).collect(),
    };
    let imported = make_model(&arguments.file, &options).or_usage_error()?;
    let sheet = arguments.out.join(sheet_name(&imported.name));
    let model = sheet.with_extension("ron");
    let files = [&model, &sheet].map(|path| Output { option: "--out", path: path.clone() });
    outputs::check_files(&arguments.file, &files, arguments.force).or_usage_error()?;
    let written = fs::create_dir_all(&arguments.out).and_then(|()| fs::write(&model, &imported.text));
    written.map_err(|problem| format!("{}: {problem}", model.display())).or_failure()?;
    let mut printer = Printer::default();
    printer.print(findings(&imported));
    let path = model.to_string_lossy();
    let checked = match RobotModel::check(&path) {
        Some(Ok(checked)) => checked,
        Some(Err(errors)) => {
            printer.print(format_args!("\n{path}: it cannot play yet: mend what is wrong in it\n"));
            return Ok(printer.finish(report::scenario_errors(&errors)));
        }
        None => return Err(report::failure(&format!("{path}: it cannot be read again"))),
    };
    for words in notes::of_model(&checked) {
        printer.print(format_args!("\nnote: {words}\n"));
    }
    draw_sheet(&checked, &sheet).or_failure()?;
    printer.print(format_args!("\n{path}\n{}\n", sheet.display()));
    let path = if model.is_absolute() || path.starts_with('.') { path.into_owned() } else { format!("./{path}") };
    printer.print(format_args!("\nto play with it: naoisis run match3v3 --set model={path} --set realism=realistic\n"));
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Returns a text about the figures that were found and not found, and those to measure.
fn findings(imported: &Imported) -> String {
    /// Greatest width of the column of values, letters.
    const WIDEST: usize = 30;
    /// Greatest length of a value, letters.
    const LONGEST: usize = 80;

    let all = || imported.found.iter().chain(&imported.guessed);
    let paths = all().map(|figure| figure.path.len()).max().unwrap_or_default();
    let values = all().map(|figure| figure.value.len().min(WIDEST)).max().unwrap_or_default();
    let mut text = imported.name.clone();
    for (title, figures) in [("found", &imported.found), ("guessed", &imported.guessed)] {
        text.push_str(&format!("\n\n{title}:"));
        for figure in figures {
            let mut value: String = figure.value.chars().take(LONGEST).collect();
            if value.len() < figure.value.len() {
                value.push('…');
            }
            text.push_str(&format!("\n  {:paths$}  {value:values$}  {}", figure.path, figure.source));
        }
    }
    text.push('\n');
    let mut list = |title: &str, lines: &[&str]| {
        if !lines.is_empty() {
            text.push_str(&format!("\n{title}:\n"));
            lines.iter().for_each(|line| text.push_str(&format!("  - {line}\n")));
        }
    };
    list("not found", &imported.lacking.iter().map(String::as_str).collect::<Vec<_>>());
    list("to be measured", &imported.to_measure);
    text
}
