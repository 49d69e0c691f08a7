//! `naoisis convert`: a trace in another format.

use clap::Args;
use core::ops::ControlFlow;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::interrupt::Interrupt;
use super::outputs::{Output, check_files};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_record::record::RecordPlugin;
use naoisis_record::record::convert::{ConvertError, convert as convert_trace};
use naoisis_record::record::formats::{LogFormat, LogFormats};
use naoisis_record::record::read::{Ending, TraceReader};

/// Arguments of `naoisis convert`.
#[derive(Args, Debug, Clone)]
pub struct ConvertArguments {
    /// A trace, as `naoisis run --trace` writes it (.jsonl or .jsonl.zst)
    pub trace: PathBuf,
    /// The file to write; its ending says the format: .html, .jsonl, .jsonl.zst
    pub file: PathBuf,
    /// Replace the file if it exists
    #[arg(long)]
    pub force: bool,
}

/// Runs the command.
pub fn convert(program: Program<'_>, ConvertArguments { trace, file, force }: &ConvertArguments) -> ExitCode {
    let app = program.simulator_with(RecordPlugin);
    let formats = app.world().resource::<LogFormats>();
    let Some(format) = formats.of_file(file) else {
        return report::usage_error(&unknown_ending(file, formats));
    };
    let outputs = [Output { option: "convert", path: file.clone() }];
    if let Err(message) = check_files(trace, &outputs, *force) {
        return report::usage_error(&message);
    }
    write(trace, format, file)
}

fn unknown_ending(file: &Path, formats: &LogFormats) -> String {
    let endings: Vec<&str> = formats.iter().flat_map(|(_, format)| format.endings).copied().collect();
    format!("{}: no format has this ending; expected one of {}", file.display(), endings.join(", "))
}

fn write(trace: &Path, format: &LogFormat, file: &Path) -> ExitCode {
    let interrupt = match Interrupt::watch(|| {}) {
        Ok(interrupt) => interrupt,
        Err(message) => return report::failure(&message),
    };
    let mut reader = match TraceReader::open(trace) {
        Ok(reader) => reader,
        Err(error) => return report::usage_error(&error.to_string()),
    };
    let progress = ProgressBar::new_spinner().with_message(format!("converting {}", trace.display()));
    if let Ok(style) = ProgressStyle::with_template("{msg}: {pos} s of the match") {
        progress.set_style(style);
    }
    let create = || format.create(file);
    let converted = convert_trace(&mut reader, create, |time_s| {
        progress.set_position(time_s as u64);
        if interrupt.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    progress.finish_and_clear();
    match converted {
        Ok(said) => {
            if reader.ending() == Ending::BrokenOff {
                report::note("the trace is incomplete: it is converted as far as it goes");
            }
            let mut printer = Printer::default();
            printer.print(said.unwrap_or_default());
            printer.finish(interrupt.finish(ExitCode::SUCCESS))
        }
        Err(ConvertError::Record(error)) => report::failure(&error.to_string()),
        Err(ConvertError::Trace(error)) => report::usage_error(&error.to_string()),
        Err(error) => report::usage_error(&format!("{}: {error}", trace.display())),
    }
}
