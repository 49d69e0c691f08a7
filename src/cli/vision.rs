//! `naoisis vision`: how well image vision sees, as a table.

use clap::{Args, ValueEnum};
use std::process::ExitCode;

use super::interrupt::Interrupt;
use super::report;
use super::terminal::Printer;
use crate::appearance::robot::RobotDesign;
use crate::random::RandomStream;
use crate::sensing::vision::image::accuracy::{self, Conditions};

/// Arguments of `naoisis vision`.
#[derive(Args, Debug, Clone)]
pub struct VisionArguments {
    /// Random scenes, each seen by both cameras of a robot
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    scenes: u32,
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How the robots look [default: a table for each]
    #[arg(long, value_enum)]
    design: Option<Design>,
    /// Let bodies cast shadows
    #[arg(long)]
    shadows: bool,
    /// Let each pixel see what is at its middle, in place of integrating the light over its area
    #[arg(long)]
    no_antialiasing: bool,
}

/// How robots look.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
enum Design {
    /// Few boxes
    Simple,
    /// Like a NAO
    Nao,
}

/// Draws the scenes, looks at them and prints what was found of what is there.
pub fn vision(arguments: &VisionArguments) -> ExitCode {
    let designs = match arguments.design {
        Some(Design::Simple) => &[RobotDesign::Simple][..],
        Some(Design::Nao) => &[RobotDesign::Nao],
        None => &RobotDesign::BOTH,
    };
    // There is nothing to be closed.
    if let Err(message) = Interrupt::end_at_once() {
        return report::failure(&message);
    }
    let mut printer = Printer::default();
    for &design in designs {
        // Both designs stand in the same scenes.
        let mut stream = RandomStream::for_match(arguments.seed, "accuracy of image vision");
        let VisionArguments { shadows, no_antialiasing, .. } = *arguments;
        let conditions = Conditions { design, shadows, antialiasing: !no_antialiasing, ..Conditions::default() };
        let table = accuracy::measure(arguments.scenes as usize, conditions, &mut || stream.uniform());
        printer.print(format_args!("{design:?} robots: {table}\n"));
        if printer.is_closed() {
            break;
        }
    }
    printer.finish(ExitCode::SUCCESS)
}
