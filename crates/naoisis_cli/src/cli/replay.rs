//! `naoisis replay`: shows a recorded match in the window.

use clap::Args;
use core::ops::ControlFlow;
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::convert::{ConvertArguments, convert};
use super::play::display;
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::window::WindowArguments;
use super::{Program, report};
use naoisis_core::game::MatchResult;
use naoisis_record::record::match_marks::MarkKind;
use naoisis_record::record::read::Ending;
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_record::record::recorder::EndReason;

/// Arguments of `naoisis replay`.
#[derive(Args, Debug, Clone)]
pub struct ReplayArguments {
    /// A trace, as `naoisis run --trace` or `--mcap` writes it (.jsonl, .jsonl.zst or .mcap)
    pub trace: PathBuf,
    /// Write this file instead, as `naoisis convert` does
    pub file: Option<PathBuf>,
    /// Replace this file if it exists
    #[arg(long, requires = "file")]
    pub force: bool,
    /// The window.
    #[command(flatten)]
    pub window: WindowArguments,
}

/// Note about an incomplete trace.
const BROKEN_OFF: &str = "the trace is incomplete: it is shown as far as it goes";

/// Runs the command. Without a display, the trace is read and summarised.
pub fn replay(program: Program<'static>, arguments: &ReplayArguments) -> CommandResult {
    if let Some(file) = arguments.file.clone() {
        return convert(program, &ConvertArguments::to_file(arguments.trace.clone(), file, arguments.force));
    }
    match display() {
        #[cfg(feature = "viewer")]
        Ok(()) => watch(program, arguments),
        #[cfg(not(feature = "viewer"))]
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(reason) => summarise(&arguments.trace, reason),
    }
}

/// Reads a trace and prints a summary.
fn summarise(path: &Path, reason: &str) -> CommandResult {
    let progress = ProgressBar::new_spinner().with_message(format!("reading {}", path.display()));
    if let Ok(style) = ProgressStyle::with_template("{msg}: {pos} s of the match") {
        progress.set_style(style);
    }
    let trace = ReadTrace::open_told(path, |time_s| {
        progress.set_position(time_s as u64);
        ControlFlow::Continue(())
    });
    progress.finish_and_clear();
    let trace = trace.map_err(|error| error.to_string()).and_then(|trace| not_empty(path, trace)).or_usage_error()?;
    report::note(&format!("{reason}: printing a summary of the trace instead"));
    if trace.ending == Ending::BrokenOff {
        report::note(BROKEN_OFF);
    }
    let mut printer = Printer::default();
    printer.print(summary(&trace));
    Ok(printer.finish(ExitCode::SUCCESS))
}

fn not_empty(path: &Path, trace: ReadTrace) -> Result<ReadTrace, String> {
    match trace.last {
        Some(_) => Ok(trace),
        None => Err(format!("{}: the trace has no cycle after its header; expected at least one", path.display())),
    }
}

#[cfg(feature = "viewer")]
fn watch(program: Program<'static>, arguments: &ReplayArguments) -> CommandResult {
    use super::window;
    use naoisis_viewer::viewer::match_panel::trace_reading::TraceReading;
    use naoisis_viewer::viewer::memory::ViewerMemory;
    use naoisis_viewer::viewer::shared::{OpenedTrace, Playback};
    use naoisis_viewer::viewer::timeline;

    let path = &arguments.trace;
    let mut reading = TraceReading::default();
    let trace = match reading.begin(path) {
        Ok(()) => reading.wait().map_err(|error| error.map_or_else(String::new, |error| error.to_string())),
        Err(error) => Err(format!("{}: cannot be read: {error}", path.display())),
    };
    let trace = trace.and_then(|trace| not_empty(path, trace)).or_usage_error()?;
    let mut app = window::open(program, &arguments.window).or_usage_error()?;
    let ending = trace.ending;
    timeline::start_replay(app.world_mut(), trace)
        .map_err(|fault| format!("{}:1: {fault}", path.display()))
        .or_usage_error()?;
    if ending == Ending::NotYet {
        app.insert_resource(reading);
    }
    app.insert_resource(OpenedTrace(Some(path.clone())));
    if let Some(file) = path.canonicalize().ok().as_deref().and_then(|path| path.to_str()) {
        app.world_mut().resource_mut::<ViewerMemory>().note_recent(file);
    }
    if ending == Ending::BrokenOff {
        report::note(BROKEN_OFF);
        app.world_mut().resource_mut::<Playback>().problem = Some(format!("{}: {BROKEN_OFF}", path.display()));
    }
    window::show(app, &arguments.window)
}

/// Returns a summary of a trace in a few lines.
fn summary(trace: &ReadTrace) -> String {
    let scenario = &trace.scenario;
    let name = if scenario.name.is_empty() { "a match" } else { &scenario.name };
    let (realism, robots) = (scenario.realism_in_words(), scenario.robots.len());
    let mut text = format!("{name}, realism {realism}, seed {}, {robots} robots\n", scenario.seed);
    let Some(last) = &trace.last else { return text };
    let result = trace.result.unwrap_or(MatchResult { score: last.game.score, ..MatchResult::default() });
    let cycles = trace.history.cycles().map_or(0, |cycles| cycles.end() - cycles.start());
    let end = match trace.ending {
        Ending::Proper(EndReason::FinalWhistle) => "to the final whistle",
        Ending::Proper(EndReason::Duration) => "to the end of the scenario",
        Ending::Proper(EndReason::Interrupted) => "until it was interrupted",
        Ending::Proper(EndReason::Failed) => "until it failed",
        Ending::NotYet | Ending::BrokenOff => "until it broke off",
    };
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{cycles} cycles, {:.1} s, {end}; {result}", last.time_s);
    let count = |kind, one, several| {
        let number = trace.history.marks().iter().filter(|mark| mark.kind == kind).count();
        format!("{number} {}", if number == 1 { one } else { several })
    };
    let goals = count(MarkKind::Goal, "goal", "goals");
    let outs = count(MarkKind::Out, "time out", "times out");
    let penalties = count(MarkKind::Penalty, "penalty", "penalties");
    let _ = writeln!(text, "{goals}, {outs}, {penalties}");
    text
}
