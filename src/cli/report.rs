//! How the commands say what went wrong.

use std::process::ExitCode;

use crate::scenario::ScenarioError;

/// Exit status of a command whose arguments or files are wrong.
const USAGE_ERROR: u8 = 2;

/// Says what failed while running; exit status 1.
pub fn failure(message: &str) -> ExitCode {
    print_error(message);
    ExitCode::FAILURE
}

/// Says what is wrong with the arguments or files; exit status 2.
pub fn usage_error(message: &str) -> ExitCode {
    print_error(message);
    ExitCode::from(USAGE_ERROR)
}

#[expect(clippy::print_stderr, reason = "the command line is where errors are printed")]
fn print_error(message: &str) {
    eprintln!("error: {message}");
}

/// Says what is wrong with a scenario, and where; exit status 2.
pub fn scenario_error(error: &ScenarioError) -> ExitCode {
    usage_error(&error.to_string())
}
