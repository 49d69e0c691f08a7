//! `naoisis robot show`: a model's sheet, and its figures with their sources.

use bevy::math::Vec2;
use clap::{Args, Subcommand};
use core::fmt::Write;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use super::outputs::EXISTS;
use super::realism::no_model;
use super::report;
use super::terminal::Printer;
use crate::figures::model_sheet;
use crate::kick_geometry::KickGeometry;
use crate::record::encoder::{Layer, write_png};
use crate::scenario::{RobotModel, Scenario};
use crate::sensing::camera::CameraSettings;
use crate::sensing::camera::ball_in_view::{nearest_ball_seen_m, sees_ball};

/// Arguments of `naoisis robot`.
#[derive(Args, Debug, Clone)]
pub struct RobotArguments {
    #[command(subcommand)]
    command: RobotCommand,
}

#[derive(Subcommand, Debug, Clone)]
enum RobotCommand {
    /// Show a model: its figures with their sources, and with --out a sheet with pictures
    Show(ShowArguments),
}

/// Arguments of `naoisis robot show`.
#[derive(Args, Debug, Clone)]
pub struct ShowArguments {
    /// The model: a name (see `naoisis list robots`), or the path of a .ron file
    #[arg(value_name = "MODEL")]
    pub model: String,
    /// The folder to write the sheet into, as MODEL.png
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write over a sheet that is there already
    #[arg(long)]
    pub force: bool,
}

/// Runs the command.
pub fn robot(arguments: &RobotArguments) -> ExitCode {
    let RobotCommand::Show(arguments) = &arguments.command;
    let model = match RobotModel::find(&arguments.model) {
        Ok(model) => model,
        Err(error) => return no_model("", &error),
    };
    let sheet = arguments.out.as_ref().map(|folder| folder.join(sheet_name(&model.name)));
    if let (Some(folder), Some(path)) = (&arguments.out, &sheet) {
        if let Err(error) = fs::create_dir_all(folder) {
            return report::usage_error(&format!("--out: {}: {error}", folder.display()));
        }
        if path.exists() && !arguments.force {
            return report::usage_error(&format!("--out: {}: {EXISTS}", path.display()));
        }
    }
    let mut printer = Printer::default();
    printer.print(format_args!("{}", figures_of(&model)));
    if let Some(words) = blindness(&model) {
        printer.print(format_args!("\nnote: {words}\n"));
    }
    if let Some(path) = &sheet {
        let image = match model_sheet::draw(&model, 1.0) {
            Ok(image) => image,
            Err(error) => return report::failure(&error.to_string()),
        };
        if let Err(error) = write_png(path, Layer::Colours, &image) {
            return report::failure(&format!("{}: {error}", path.display()));
        }
        printer.print(format_args!("\n{}\n", path.display()));
    }
    printer.finish(ExitCode::SUCCESS)
}

/// What is to be said of a robot whose cameras do not show it the ball that it is about to kick.
pub(super) fn blindness(model: &RobotModel) -> Option<String> {
    blindness_in(&model.scenario().ok()?)
}

/// The same of a scenario's robots.
fn blindness_in(scenario: &Scenario) -> Option<String> {
    let Scenario { body, cameras, head, kicks, ball, .. } = scenario;
    if cameras.mounts.as_slice().is_empty() {
        return Some("it has no cameras: it sees no ball".to_owned());
    }
    let cameras = CameraSettings { neck_m: body.neck_m, ..*cameras };
    let radius_m = ball.unwrap_or_default().radius_m;
    // Where the ball lies best, and as far away as it may.
    let places = |region: KickGeometry| [region.best_m, Vec2::new(region.x_m[1], region.best_m.y)];
    let mut places = kicks.types().filter_map(|kick| kicks.geometry(kick)).flat_map(places).peekable();
    if places.peek().is_none() {
        return Some("it has no kicks: built-in teams push the ball".to_owned());
    }
    if places.any(|place| sees_ball(&cameras, head, place, radius_m)) {
        return None;
    }
    let nearest = match nearest_ball_seen_m(&cameras, head, radius_m) {
        Some(distance_m) => format!("the nearest ball that it sees straight ahead is {distance_m:.2} m away"),
        None => "it sees no ball straight ahead at all".to_owned(),
    };
    Some(format!(
        "no camera shows it the ball where it kicks from: {nearest}; built-in teams kick by what they saw last, other players may not"
    ))
}

/// Values are in a column of so many letters at most.
const WIDEST_COLUMN: usize = 44;

/// The model's figures, a line each, with their sources.
fn figures_of(model: &RobotModel) -> String {
    let mut figures = Vec::new();
    collect("", &Value::Object(model.all_settings()), &mut figures);
    let wide = |of: fn(&(String, String)) -> &String| figures.iter().map(|figure| of(figure).chars().count()).max();
    let (paths, values) = (wide(|figure| &figure.0).unwrap_or_default(), wide(|figure| &figure.1).unwrap_or_default());
    // A long list is wider than its column.
    let values = values.min(WIDEST_COLUMN);
    let mut text = format!("{}: {}\n\n", model.name, model.description);
    for (path, value) in &figures {
        let source = model.source(path).unwrap_or_default();
        let _ = writeln!(text, "{path:paths$}  {value:values$}  {source}");
    }
    text
}

/// The figures below a path, with their values. Lists of numbers are one.
fn collect(path: &str, value: &Value, figures: &mut Vec<(String, String)>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                collect(&if path.is_empty() { name.clone() } else { format!("{path}.{name}") }, value, figures);
            }
        }
        Value::Array(values) if values.iter().any(Value::is_object) => {
            for (index, value) in values.iter().enumerate() {
                collect(&format!("{path}.{index}"), value, figures);
            }
        }
        Value::Null => figures.push((path.to_owned(), "none".to_owned())),
        Value::String(word) => figures.push((path.to_owned(), word.clone())),
        value => figures.push((path.to_owned(), value.to_string())),
    }
}

/// The file of a model's sheet. A name is whatever somebody has written: a file's name it is without what leads elsewhere.
fn sheet_name(model: &str) -> String {
    let allowed = |character: char| character.is_alphanumeric() || "-_+ ".contains(character);
    let name: String = model.chars().map(|character| if allowed(character) { character } else { '_' }).collect();
    format!("{}.png", if name.trim().is_empty() { "robot" } else { &name })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::MODELS;

    #[test]
    fn a_sheet_lies_in_its_folder_whatever_the_model_is_called() {
        let names = ["booster_k1", "../../evil", "/etc/x", ""].map(sheet_name);
        assert_eq!(names, ["booster_k1.png", "______evil.png", "_etc_x.png", "robot.png"]);
    }

    #[test]
    fn who_sees_no_ball_at_its_feet_is_pointed_out() {
        for preset in MODELS {
            assert_eq!(blindness(&RobotModel::named(preset.name).unwrap()), None, "{}", preset.name);
        }
        let words = |own: &str| {
            let text = format!(r#"{{ "model": {{ "preset": "booster_k1", {own} }}, "realism": "realistic" }}"#);
            blindness_in(&Scenario::from_json(&text).unwrap())
        };
        let level = words(r#""head": { "pitch_deg": [0, 0] }"#).unwrap();
        assert!(level.contains("the nearest ball that it sees straight ahead is 0.7"), "{level}");
        let up = words(r#""head": { "pitch_deg": [-80, -80] }"#).unwrap();
        assert!(up.contains("it sees no ball straight ahead at all"), "{up}");
        let blind = words(r#""cameras": { "mounts": [] }"#).unwrap();
        assert!(blind.contains("it has no cameras"), "{blind}");
    }

    #[test]
    fn every_figure_is_shown_with_its_source() {
        let model = RobotModel::named("booster_k1").unwrap();
        let text = figures_of(&model);
        let line = text.lines().find(|line| line.starts_with("cameras.mounts.0.tilt_deg")).unwrap();
        assert!(line.contains("12.2") && line.contains("MuJoCo"), "{line}");
        assert!(
            text.lines().skip(2).all(|line| line.split("  ").filter(|part| !part.is_empty()).count() >= 3),
            "{text}"
        );
    }
}
