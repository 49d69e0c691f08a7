//! Output to the terminal: control characters of files are made visible, and failures to print are reported.

use core::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

use super::report;
use super::visible::visible;

/// Prints to standard output or standard error. If the reader of the output closes it, the rest is dropped without an error. Other failures
/// are reported at the end.
#[derive(Debug, Default)]
pub struct Printer {
    is_stderr: bool,
    error: Option<io::Error>,
}

impl Printer {
    /// Returns a printer to standard error, for commands that write other data to standard output.
    pub fn to_stderr() -> Self {
        Self { is_stderr: true, error: None }
    }

    /// Prints a text, with control characters made visible.
    pub fn print(&mut self, text: impl fmt::Display) {
        if self.error.is_some() {
            return;
        }
        let text = text.to_string();
        let text = visible(&text);
        let printed =
            if self.is_stderr { write(io::stderr().lock(), &text) } else { write(io::stdout().lock(), &text) };
        self.error = printed.err();
    }

    /// Returns whether nothing more can be printed.
    pub fn is_closed(&self) -> bool {
        self.error.is_some()
    }

    /// Returns the exit status of a command that would end with `status`. If some output could not be printed, this is reported and is a
    /// failure.
    pub fn finish(self, status: ExitCode) -> ExitCode {
        match self.error {
            Some(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                let name = if self.is_stderr { "standard error" } else { "standard output" };
                report::failure(&format!("cannot write to {name}: {error}"))
            }
            _ => status,
        }
    }
}

fn write(mut stream: impl Write, text: &str) -> io::Result<()> {
    stream.write_all(text.as_bytes())?;
    stream.flush()
}
