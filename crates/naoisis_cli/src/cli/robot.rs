//! `naoisis robot`: shows the figures of a robot model with their sources, and makes models from descriptions.

use clap::{Args, Subcommand};
use core::fmt::Write;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

use super::notes;
use super::outputs::EXISTS;
use super::realism::no_model;
use super::report;
use super::report::{CommandResult, OrReport};
use super::robot_import::{ImportArguments, import};
use super::robot_sheet::{draw_sheet, sheet_name};
use super::terminal::Printer;
use naoisis_sim::scenario::RobotModel;

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
    /// Make a model from a robot's description (URDF or MJCF), with a sheet
    Import(ImportArguments),
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
    /// Replace an existing sheet
    #[arg(long)]
    pub force: bool,
}

/// Runs the command.
pub fn robot(arguments: &RobotArguments) -> CommandResult {
    match &arguments.command {
        RobotCommand::Show(arguments) => show(arguments),
        RobotCommand::Import(arguments) => import(arguments),
    }
}

fn show(arguments: &ShowArguments) -> CommandResult {
    let model = RobotModel::find(&arguments.model).map_err(|error| no_model("", &error))?;
    let sheet = arguments.out.as_ref().map(|folder| folder.join(sheet_name(&model.name)));
    if let (Some(folder), Some(path)) = (&arguments.out, &sheet) {
        fs::create_dir_all(folder).map_err(|error| format!("--out: {}: {error}", folder.display())).or_usage_error()?;
        if path.exists() && !arguments.force {
            return Err(report::usage_error(&format!("--out: {}: {EXISTS}", path.display())));
        }
    }
    let mut printer = Printer::default();
    printer.print(format_args!("{}", figures_of(&model)));
    for words in notes::of_model(&model) {
        printer.print(format_args!("\nnote: {words}\n"));
    }
    if let Some(path) = &sheet {
        draw_sheet(&model, path).or_failure()?;
        printer.print(format_args!("\n{}\n", path.display()));
    }
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Greatest width of the column of values, letters.
const WIDEST_COLUMN: usize = 44;

/// Returns the figures of a model with their sources, one line each.
fn figures_of(model: &RobotModel) -> String {
    let mut figures = Vec::new();
    collect("", &Value::Object(model.all_settings()), &mut figures);
    let wide = |of: fn(&(String, String)) -> &String| figures.iter().map(|figure| of(figure).chars().count()).max();
    let (paths, values) = (wide(|figure| &figure.0).unwrap_or_default(), wide(|figure| &figure.1).unwrap_or_default());
    // Longer values extend beyond the column.
    let values = values.min(WIDEST_COLUMN);
    let mut text = format!("{}: {}\n\n", model.name, model.description);
    for (path, value) in &figures {
        let source = model.source(path).unwrap_or_default();
        let _ = writeln!(text, "{path:paths$}  {value:values$}  {source}");
    }
    text
}

/// Collects the figures below `path` with their values. A list of numbers is one figure.
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

#[cfg(test)]
mod tests {
    use super::*;

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
