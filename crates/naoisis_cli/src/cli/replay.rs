//! `naoisis replay`: a recorded match in the window.

use clap::Args;
use core::ops::ControlFlow;
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use super::convert::{ConvertArguments, convert};
use super::play::display;
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
    /// A trace, as `naoisis run --trace` writes it (.jsonl or .jsonl.zst)
    pub trace: PathBuf,
    /// Write this file instead, as `naoisis convert` does
    pub file: Option<PathBuf>,
    /// The window.
    #[command(flatten)]
    pub window: WindowArguments,
}

/// The note about a trace without an end.
const BROKEN_OFF: &str = "the trace is incomplete: it is shown as far as it goes";

/// Runs the command. Without a display, the trace is read and summarised.
pub fn replay(program: Program<'static>, arguments: &ReplayArguments) -> ExitCode {
    if let Some(file) = arguments.file.clone() {
        return convert(program, &ConvertArguments::to_file(arguments.trace.clone(), file));
    }
    // A long one takes a while.
    let progress = ProgressBar::new_spinner().with_message(format!("reading {}", arguments.trace.display()));
    if let Ok(style) = ProgressStyle::with_template("{msg}: {pos} s of the match") {
        progress.set_style(style);
    }
    let trace = ReadTrace::open_told(&arguments.trace, |time_s| {
        progress.set_position(time_s as u64);
        ControlFlow::Continue(())
    });
    progress.finish_and_clear();
    let trace = match trace {
        Ok(trace) => trace,
        Err(error) => return report::usage_error(&error.to_string()),
    };
    if trace.last.is_none() {
        let path = arguments.trace.display();
        return report::usage_error(&format!("{path}: the trace has no cycle after its header; expected at least one"));
    }
    if trace.ending == Ending::BrokenOff {
        report::note(BROKEN_OFF);
    }
    match display() {
        #[cfg(feature = "viewer")]
        Ok(()) => watch(program, arguments, trace),
        #[cfg(not(feature = "viewer"))]
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            report::note(&format!("{reason}: printing a summary of the trace instead"));
            let mut printer = Printer::default();
            printer.print(summary(&trace));
            printer.finish(ExitCode::SUCCESS)
        }
    }
}

#[cfg(feature = "viewer")]
fn watch(program: Program<'static>, arguments: &ReplayArguments, trace: ReadTrace) -> ExitCode {
    use super::window;
    use naoisis_viewer::viewer::memory::ViewerMemory;
    use naoisis_viewer::viewer::shared::Notice;
    use naoisis_viewer::viewer::teach::bookmark_file::OpenedTrace;
    use naoisis_viewer::viewer::timeline;

    let mut app = match window::open(program, &arguments.window) {
        Ok(app) => app,
        Err(message) => return report::usage_error(&message),
    };
    let is_broken_off = trace.ending == Ending::BrokenOff;
    if let Err(fault) = timeline::start_replay(app.world_mut(), trace) {
        return report::usage_error(&format!("{}:1: {fault}", arguments.trace.display()));
    }
    app.insert_resource(OpenedTrace(Some(arguments.trace.clone())));
    if let Some(file) = arguments.trace.canonicalize().ok().as_deref().and_then(|path| path.to_str()) {
        app.world_mut().resource_mut::<ViewerMemory>().note_recent(file);
    }
    if is_broken_off {
        app.world_mut().resource_mut::<Notice>().tell(BROKEN_OFF);
    }
    window::show(app)
}

/// A summary of a trace in a few lines.
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
    let count = |kind| trace.history.marks().iter().filter(|mark| mark.kind == kind).count();
    let (goals, outs, penalties) = (count(MarkKind::Goal), count(MarkKind::Out), count(MarkKind::Penalty));
    let _ = writeln!(text, "{goals} goals, {outs} times out, {penalties} penalties");
    text
}
