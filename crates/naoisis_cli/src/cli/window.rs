//! Arguments and functions that all commands with a window share.

use clap::Args;
use naoisis_core::team::RobotId;
use std::path::PathBuf;
#[cfg(feature = "viewer")]
use std::time::Instant;

/// Arguments of the commands that open a window.
#[derive(Args, Debug, Clone, Default)]
pub struct WindowArguments {
    /// Write the state of the window as JSON lines, for tests that drive it from outside
    #[arg(long, value_name = "FILE")]
    pub report_state: Option<PathBuf>,
    /// Show the match at this time, paused: seconds, or MINUTES:SECONDS
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub at: Option<f64>,
    /// Select this robot, such as blue1
    #[arg(long, value_name = "ROBOT")]
    pub select: Option<RobotId>,
    /// Start time of the program.
    #[cfg(feature = "viewer")]
    #[arg(skip)]
    pub began: Began,
}

/// Reads a time of a match, s: seconds, or minutes and seconds.
fn time(text: &str) -> Result<f64, String> {
    let (minutes, seconds) = text.rsplit_once(':').unwrap_or(("0", text));
    let time_s = minutes.parse::<u32>().ok().zip(seconds.parse::<f64>().ok());
    let time_s = time_s.map(|(minutes, seconds)| 60.0 * f64::from(minutes) + seconds);
    let is_valid = |time_s: &f64| time_s.is_finite() && *time_s >= 0.0;
    time_s.filter(is_valid).ok_or_else(|| "expected a time such as 123.5 or 2:03".to_owned())
}

/// Start time of the program, taken when the command line is parsed.
#[cfg(feature = "viewer")]
#[derive(Debug, Clone, Copy)]
pub struct Began(pub Instant);

#[cfg(feature = "viewer")]
impl Default for Began {
    fn default() -> Self {
        Self(Instant::now())
    }
}

/// Returns an app with a window, without a match.
///
/// # Errors
/// A message about the command line if it is wrong.
#[cfg(feature = "viewer")]
pub(super) fn open(program: super::Program<'static>, arguments: &WindowArguments) -> Result<bevy::app::App, String> {
    use super::interrupt::Interrupt;
    use bevy::app::{PluginGroup, TerminalCtrlCHandlerPlugin};
    use naoisis_viewer::viewer::ViewerPlugins;
    use naoisis_viewer::viewer::first_frame::FirstFramePlugin;
    use naoisis_viewer::viewer::keyframes::Simulator;
    use naoisis_viewer::viewer::memory::ViewerMemory;
    use naoisis_viewer::viewer::report_state::StateReport;

    let report = match &arguments.report_state {
        Some(path) => Some(StateReport::create(path).map_err(|error| format!("{}: {error}", path.display()))?),
        None => None,
    };
    let mut app = bevy::app::App::new();
    // Bevy's own handler would let a program started in the background be killed, which would leave incomplete files.
    let interrupt = Interrupt::watch(TerminalCtrlCHandlerPlugin::gracefully_exit)?;
    let viewer = ViewerPlugins.set(FirstFramePlugin { began: arguments.began.0 });
    app.add_plugins(viewer);
    program.add_to(&mut app);
    app.insert_resource(ViewerMemory::of_user()).insert_resource(interrupt);
    let simulator = move || program.simulator();
    app.insert_resource(Simulator(Box::leak(Box::new(simulator))));
    if let Some(report) = report {
        app.insert_resource(report);
    }
    Ok(app)
}

/// Shows the window until it is closed, at the time and with the robot of the command line.
#[cfg(feature = "viewer")]
pub(super) fn show(mut app: bevy::app::App, arguments: &WindowArguments) -> super::report::CommandResult {
    use super::interrupt::Interrupt;
    use bevy::app::AppExit;
    use naoisis_core::robot::Roster;
    use naoisis_viewer::viewer::shared::Selection;
    use naoisis_viewer::viewer::start_at::StartAt;
    use std::process::ExitCode;

    if let Some(robot) = arguments.select {
        if app.world().resource::<Roster>().get(robot).is_none() {
            return Err(super::report::usage_error(&format!("--select {robot}: the match has no such robot")));
        }
        app.insert_resource(Selection(Some(robot)));
    }
    if let Some(time_s) = arguments.at {
        app.insert_resource(StartAt(time_s));
    }
    // The app no longer exists after the window is closed.
    let interrupt = app.world().resource::<Interrupt>().clone();
    match app.run() {
        AppExit::Error(code) if !interrupt.is_stopped() => Err(ExitCode::from(code.get())),
        AppExit::Success | AppExit::Error(_) => Ok(interrupt.finish(ExitCode::SUCCESS)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_seconds_or_minutes_and_seconds() {
        assert_eq!(["0", "123.5", "2:03", "90:00.5"].map(time), [Ok(0.0), Ok(123.5), Ok(123.0), Ok(5400.5)]);
        for wrong in ["", "-1", "2:", ":3", "1:2:3", "inf", "NaN", "soon"] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }
}
