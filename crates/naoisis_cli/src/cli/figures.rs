//! `naoisis figures`: draws the figures of the paper from running matches, with its robots or with others.

use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::interrupt::Interrupt;
use super::outputs::EXISTS;
use super::realism::no_model;
use super::report;
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use naoisis_lab::figures::{FIGURES, Figure, FigureError};
use naoisis_record::record::encoder::{Layer, write_png};
use naoisis_sim::scenario::RobotModel;

/// Arguments of `naoisis figures`.
#[derive(Args, Debug, Clone)]
pub struct FiguresArguments {
    /// The folder to write PNG files into
    #[arg(long, value_name = "DIR", default_value = "figures")]
    pub out: PathBuf,
    /// Draw only these figures: 3,5
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', value_parser = clap::value_parser!(u8).range(1..=8))]
    pub only: Vec<u8>,
    /// The robots in the figures: a model (see `naoisis list robots`), or a file
    #[arg(long, value_name = "MODEL", default_value = "nao")]
    pub robot: String,
    /// Pixels per point: at 1, a figure is 1600 pixels wide
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = scale, allow_negative_numbers = true)]
    pub scale: f32,
    /// Replace existing figures
    #[arg(long)]
    pub force: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Parses a scale. Its limits keep words legible and pictures small enough for memory.
fn scale(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(scale) if (0.1..=6.0).contains(&scale) => Ok(scale),
        _ => Err("expected a number from 0.1 to 6".to_owned()),
    }
}

/// Runs the command.
pub fn figures(arguments: &FiguresArguments) -> CommandResult {
    let model = RobotModel::find(&arguments.robot).map_err(|error| no_model("--robot: ", &error))?;
    let chosen: Vec<(&Figure, PathBuf)> = FIGURES
        .iter()
        .filter(|figure| arguments.only.is_empty() || arguments.only.contains(&figure.number))
        .map(|figure| (figure, arguments.out.join(figure.file_name())))
        .collect();
    prepare(&arguments.out, &chosen, arguments.force).or_usage_error()?;
    let interrupt = Interrupt::watch(|| {}).or_failure()?;
    let mut printer = Printer::default();
    for (figure, path) in chosen {
        if interrupt.is_stopped() {
            break;
        }
        let image = match figure.draw(&model, arguments.scale) {
            Ok(image) => image,
            Err(error @ (FigureError::Lacking { .. } | FigureError::Missing { .. } | FigureError::TooLarge { .. })) => {
                if !arguments.quiet {
                    report::note(&format!("not drawn: {error}"));
                }
                continue;
            }
            Err(error) => return Err(report::failure(&error.to_string())),
        };
        write_png(&path, Layer::Colours, &image)
            .map_err(|error| format!("{}: {error}", path.display()))
            .or_failure()?;
        if !arguments.quiet {
            printer.print(format_args!("{}\n", path.display()));
        }
    }
    Ok(interrupt.finish(printer.finish(ExitCode::SUCCESS)))
}

/// Creates the folder, and checks before the first figure is drawn that all can be written.
fn prepare(folder: &Path, chosen: &[(&Figure, PathBuf)], force: bool) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("--out: {}: {error}", folder.display()))?;
    for (_, path) in chosen {
        if path.exists() && !force {
            return Err(format!("--out: {}: {EXISTS}", path.display()));
        }
    }
    Ok(())
}
