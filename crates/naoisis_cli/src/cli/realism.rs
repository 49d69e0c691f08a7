//! `naoisis realism`: measures simulated robots and compares them with real ones; or [whole matches](super::match_realism).

use clap::Args;
use core::fmt::Write;
use std::process::ExitCode;

use super::interrupt::Interrupt;
use super::match_realism::{MatchRealismArguments, explain, match_realism};
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_core::statistics::rounded;
use naoisis_lab::trials::{self, MeasuredQuantity};
use naoisis_sim::scenario::{MODELS, ModelError, RobotModel};

/// Returns the relative difference from which a figure is marked: three standard errors of a standard deviation from `repetitions` samples,
/// each `1 / sqrt(2 n)`; 15 % for 200 repetitions.
fn far(repetitions: u32) -> f64 {
    f64::max(0.15, 3.0 / (2.0 * f64::from(repetitions)).sqrt())
}

/// Arguments of `naoisis realism`.
#[derive(Args, Debug, Clone)]
pub struct RealismArguments {
    /// A robot model: a name (see `naoisis list robots`), or a .ron file [default: a table for each]
    #[arg(long, value_name = "MODEL")]
    robot: Option<String>,
    /// Repetitions of each walk and kick, each with another seed
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    repetitions: u32,
    #[command(flatten)]
    matches: MatchRealismArguments,
}

/// Measures the robots, or plays the matches, and prints the tables.
pub fn realism(program: Program, arguments: &RealismArguments) -> CommandResult {
    if arguments.matches.explain {
        return explain();
    }
    if arguments.matches.are_given() {
        return match_realism(program, &arguments.matches);
    }
    let chosen: Vec<RobotModel> = match &arguments.robot {
        None => MODELS.iter().filter_map(|model| RobotModel::named(model.name)).collect(),
        Some(name) => vec![RobotModel::find(name).map_err(|error| no_model("--robot: ", &error))?],
    };
    // There are no files to close.
    Interrupt::end_at_once().or_failure()?;
    let mut printer = Printer::default();
    for model in chosen {
        let quantities = trials::measure(&model, arguments.repetitions).or_failure()?;
        let left_out = trials::not_measured(&model).or_failure()?;
        printer.print(table(&model, &quantities, &left_out, far(arguments.repetitions)));
        if printer.is_closed() {
            break;
        }
    }
    Ok(printer.finish(ExitCode::SUCCESS))
}

/// Reports the errors of the model that `argument` names; all of them if it is a file. Returns exit status 2.
pub(super) fn no_model(argument: &str, error: &ModelError) -> ExitCode {
    match error {
        ModelError::Wrong(errors) => report::scenario_errors(errors),
        _ => report::usage_error(&format!("{argument}{error}; expected {}", error.expected())),
    }
}

/// Returns the table of a model. `left_out` are trials that do not apply to it. `!` marks a difference above `far`, and `?` a real figure
/// without a source.
fn table(model: &RobotModel, quantities: &[MeasuredQuantity], left_out: &[&str], far: f64) -> String {
    let names: Vec<String> = quantities
        .iter()
        .map(|quantity| match quantity.unit {
            "" => quantity.name.clone(),
            unit => format!("{}, {unit}", quantity.name),
        })
        .collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or_default();
    let mut text = format!("{}: {}\n", model.name, model.description);
    let _ = writeln!(text, "  {:width$}  simulated      real  difference    source", "quantity");
    for (name, quantity) in names.iter().zip(quantities) {
        let guess = if quantity.is_guess() { '?' } else { ' ' };
        let MeasuredQuantity { measured, real, source, .. } = quantity;
        let _ = match (quantity.difference(), quantity.not_seen) {
            (Some(share), _) => {
                let mark = if share.abs() > far { '!' } else { guess };
                writeln!(
                    text,
                    "  {name:width$}  {measured:9.3} {real:9.3}  {:+8.1} % {mark}  {source}",
                    rounded(100.0 * share, 1)
                )
            }
            (None, why) => {
                let why = why.unwrap_or_default();
                writeln!(
                    text,
                    "  {name:width$}  {:>9} {real:9.3}  {:>8}   {guess}  {source} (not measured: {why})",
                    "-", "-"
                )
            }
        };
    }
    let _ = write!(text, "  ! differs from the real figure by more than {:.0} %", 100.0 * far);
    text.push_str(if far > 0.15 { ", which may be chance with so few repetitions" } else { "" });
    text.push_str("; ? marks a real figure that is a guess without a source\n");
    for words in left_out {
        let _ = writeln!(text, "  note: {words}");
    }
    text.push('\n');
    text
}
