//! The `naoisis` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    naoisis::cli::run(|_| {})
}
