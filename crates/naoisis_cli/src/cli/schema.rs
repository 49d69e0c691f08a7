//! `naoisis schema`: JSON Schema of files, for editors, and of the messages between a match and a program, for other tools.

use clap::{Args, ValueEnum};
use std::process::ExitCode;

use super::report::CommandResult;
use super::terminal::Printer;
use naoisis_agents::agents::schema::schema;
use naoisis_sim::scenario::FileKind;

/// Arguments of `naoisis schema`.
#[derive(Args, Debug)]
pub struct SchemaArguments {
    /// What is described
    #[arg(value_enum, default_value_t = What::Messages)]
    what: What,
}

#[derive(ValueEnum, Clone, Copy, Debug)]
enum What {
    /// The messages between a match and a program
    Messages,
    /// Scenario files
    Scenario,
    /// Robot models
    Robot,
    /// Leagues
    League,
    /// Rules
    Rules,
}

/// Runs the command.
pub fn print_schema(arguments: &SchemaArguments) -> CommandResult {
    let schema = match arguments.what {
        What::Messages => schema(),
        What::Scenario => FileKind::Scenario.schema(),
        What::Robot => FileKind::Robot.schema(),
        What::League => FileKind::League.schema(),
        What::Rules => FileKind::Rules.schema(),
    };
    let mut printer = Printer::default();
    printer.print(format_args!("{schema:#}\n"));
    Ok(printer.finish(ExitCode::SUCCESS))
}
