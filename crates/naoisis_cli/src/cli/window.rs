//! Arguments and functions that all commands with a window share.

use clap::Args;
use std::path::PathBuf;
#[cfg(feature = "viewer")]
use std::time::Instant;

/// Arguments of the commands that open a window.
#[derive(Args, Debug, Clone, Default)]
pub struct WindowArguments {
    /// Write the state of the window as JSON lines, for tests that drive it from outside
    #[arg(long, value_name = "FILE")]
    pub report_state: Option<PathBuf>,
    /// Start time of the program.
    #[cfg(feature = "viewer")]
    #[arg(skip)]
    pub began: Began,
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

/// Shows the window until it is closed.
#[cfg(feature = "viewer")]
pub(super) fn show(mut app: bevy::app::App) -> std::process::ExitCode {
    use super::interrupt::Interrupt;
    use bevy::app::AppExit;
    use std::process::ExitCode;

    // The app no longer exists after the window is closed.
    let interrupt = app.world().resource::<Interrupt>().clone();
    match app.run() {
        AppExit::Error(code) if !interrupt.is_stopped() => ExitCode::from(code.get()),
        AppExit::Success | AppExit::Error(_) => interrupt.finish(ExitCode::SUCCESS),
    }
}
