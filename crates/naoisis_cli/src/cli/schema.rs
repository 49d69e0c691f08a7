//! `naoisis schema`: the messages between a match and a program, for other tools.

use std::process::ExitCode;

use super::terminal::Printer;
use naoisis_agents::agents::schema::schema;

/// Runs the command.
pub fn print_schema() -> ExitCode {
    let mut printer = Printer::default();
    printer.print(format_args!("{:#}\n", schema()));
    printer.finish(ExitCode::SUCCESS)
}
