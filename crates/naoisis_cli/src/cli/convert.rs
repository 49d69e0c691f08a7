//! `naoisis convert`: writes a trace in another format.

use clap::Args;
use core::ops::ControlFlow;
use indicatif::{ProgressBar, ProgressStyle};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::interrupt::Interrupt;
use super::outputs::{Output, check_files, check_folder_of, use_of_a_part};
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_record::record::RecordPlugin;
use naoisis_record::record::convert::{ConvertError, convert as convert_trace};
use naoisis_record::record::formats::{LogFormat, LogFormats};
use naoisis_record::record::read::{Ending, TraceReader};
use naoisis_record::record::recorder::{RecordError, Recorder};
use naoisis_record::record::tables::{TableFormat, TablesRecorder};
use naoisis_sim::interface::fields::Fields;

/// Arguments of `naoisis convert`.
#[derive(Args, Debug, Clone)]
pub struct ConvertArguments {
    /// A trace, as `naoisis run --trace` or `--mcap` writes it (.jsonl, .jsonl.zst or .mcap)
    pub trace: PathBuf,
    /// The file to write; its ending says the format: .html, .jsonl, .jsonl.zst, .mcap
    #[arg(required_unless_present_any = ["parquet", "csv"])]
    pub file: Option<PathBuf>,
    /// Write tables as Parquet into this folder: cycles, robots, percepts, beliefs, events, messages
    #[arg(long, value_name = "DIR")]
    pub parquet: Option<PathBuf>,
    /// Write the same tables as CSV into this folder
    #[arg(long, value_name = "DIR")]
    pub csv: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long)]
    pub force: bool,
}

impl ConvertArguments {
    /// Returns the arguments that convert a trace to `file`.
    pub fn to_file(trace: PathBuf, file: PathBuf, force: bool) -> Self {
        Self { trace, file: Some(file), parquet: None, csv: None, force }
    }
}

/// Target of a conversion.
enum Target<'a> {
    File(&'a Path, &'a LogFormat),
    Tables(&'a Path, TableFormat),
}

impl Target<'_> {
    fn outputs(&self) -> Vec<Output> {
        match self {
            Target::File(file, _) => vec![Output { option: "FILE", path: file.to_path_buf() }],
            Target::Tables(folder, format) => {
                let option = if *format == TableFormat::Csv { "--csv" } else { "--parquet" };
                format.files(folder).map(|path| Output { option, path }).collect()
            }
        }
    }

    /// Checks that the folder is there in which the target will be.
    fn check_folder(&self) -> Result<(), String> {
        let (Target::File(path, _) | Target::Tables(path, _)) = self;
        check_folder_of(path)
    }

    fn recorder(&self, fields: &Fields) -> Result<Box<dyn Recorder>, RecordError> {
        match self {
            Target::File(file, format) => format.create(file),
            Target::Tables(folder, format) => Ok(Box::new(TablesRecorder::create(folder, *format, fields.clone())?)),
        }
    }
}

/// Runs the command.
pub fn convert(program: Program<'_>, arguments: &ConvertArguments) -> CommandResult {
    let ConvertArguments { trace, file, parquet, csv, force } = arguments;
    let app = program.simulator_with(RecordPlugin);
    let formats = app.world().resource::<LogFormats>();
    let mut targets = Vec::new();
    if let Some(file) = file {
        match formats.of_file(file) {
            Some(format) => targets.push(Target::File(file, format)),
            None => return Err(report::usage_error(&unknown_ending(file, formats))),
        }
    }
    targets.extend(parquet.iter().map(|folder| Target::Tables(folder, TableFormat::Parquet)));
    targets.extend(csv.iter().map(|folder| Target::Tables(folder, TableFormat::Csv)));
    let outputs: Vec<Output> = targets.iter().flat_map(Target::outputs).collect();
    let checked = check_files(trace, &outputs, *force).and_then(|()| targets.iter().try_for_each(Target::check_folder));
    checked.or_usage_error()?;
    let interrupt = Interrupt::watch(|| {}).or_failure()?;
    for target in &targets {
        write(trace, app.world().resource::<BehaviourRegistry>(), target, &interrupt)?;
    }
    Ok(interrupt.finish(ExitCode::SUCCESS))
}

fn unknown_ending(file: &Path, formats: &LogFormats) -> String {
    let endings: Vec<&str> = formats.iter().flat_map(|(_, format)| format.endings).copied().collect();
    format!("{}: no format has this ending; expected one of {}", file.display(), endings.join(", "))
}

fn write(
    trace: &Path,
    registry: &BehaviourRegistry,
    target: &Target<'_>,
    interrupt: &Interrupt,
) -> Result<(), ExitCode> {
    let mut reader = TraceReader::open(trace).or_usage_error()?;
    let progress = ProgressBar::new_spinner().with_message(format!("converting {}", trace.display()));
    if let Ok(style) = ProgressStyle::with_template("{msg}: {pos} s of the match") {
        progress.set_style(style);
    }
    let fields = reader.fields().clone();
    let new_file = match target {
        Target::File(file, _) if !file.exists() => Some(*file),
        _ => None,
    };
    let converted = convert_trace(
        &mut reader,
        registry,
        || target.recorder(&fields),
        |time_s| {
            progress.set_position(time_s as u64);
            if interrupt.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    );
    progress.finish_and_clear();
    match converted {
        Ok(said) => {
            if reader.ending() == Ending::BrokenOff {
                report::note("the trace is incomplete: it is converted as far as it goes");
            }
            let mut printer = Printer::default();
            printer.print(said.unwrap_or_default());
            printer.finish(ExitCode::SUCCESS);
            Ok(())
        }
        Err(ConvertError::Record(error)) => Err(report::failure(&format!("{error}{}", use_of_a_part(&error)))),
        Err(error) => {
            // What was made of a damaged trace is no match. The error is about the trace, whether this succeeds or not.
            let _ = new_file.map(fs::remove_file);
            Err(match error {
                ConvertError::Trace(error) => report::usage_error(&error.to_string()),
                error => report::usage_error(&format!("{}: {error}", trace.display())),
            })
        }
    }
}
