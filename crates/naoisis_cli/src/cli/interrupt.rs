//! Signals that ask the program to end: commands close their files, and their exit status tells the signal.

use bevy::prelude::*;
use std::process::{self, ExitCode};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use super::report;

/// State of the request to end the program. After the first signal the command may end in its own way. The second signal ends the program
/// at once.
#[derive(Resource, Clone, Debug, Default)]
pub struct Interrupt(Arc<Flags>);

#[derive(Debug, Default)]
struct Flags {
    stop: AtomicBool,
    /// The exit status for the signal; 0 before a signal.
    status: AtomicU8,
}

impl Interrupt {
    /// Watches for signals from now on, and calls `on_first` at the first one.
    ///
    /// # Errors
    /// When signals cannot be watched.
    pub fn watch(on_first: impl Fn() + Send + 'static) -> Result<Self, String> {
        let interrupt = Self::default();
        let flags = Arc::clone(&interrupt.0);
        on_signal(move |status| {
            let before = flags.status.swap(status, Ordering::SeqCst);
            flags.stop.store(true, Ordering::SeqCst);
            if before != 0 {
                process::exit(i32::from(status));
            }
            on_first();
        })?;
        Ok(interrupt)
    }

    /// Watches for signals from now on, for commands that finish what is running at the first one.
    ///
    /// # Errors
    /// When signals cannot be watched.
    pub fn finish_running() -> Result<Self, String> {
        Self::watch(|| report::note("finishing what is running; interrupt again to stop at once"))
    }

    /// Ends the program at once when a signal arrives, for commands that have no open files.
    ///
    /// # Errors
    /// When signals cannot be watched.
    pub fn end_at_once() -> Result<(), String> {
        on_signal(|status| process::exit(i32::from(status)))
    }

    /// Returns a flag that becomes true at the first signal. Setting it stops the command for another reason.
    pub fn stop(&self) -> &AtomicBool {
        &self.0.stop
    }

    /// Returns whether the command should stop.
    pub fn is_stopped(&self) -> bool {
        self.0.stop.load(Ordering::SeqCst)
    }

    /// Returns the exit status of a command that would end with `status`: 130 after Ctrl-C and 143 after SIGTERM, unless something else
    /// failed.
    pub fn finish(&self, status: ExitCode) -> ExitCode {
        match self.0.status.load(Ordering::SeqCst) {
            interrupted if interrupted != 0 && status == ExitCode::SUCCESS => ExitCode::from(interrupted),
            _ => status,
        }
    }
}

/// Calls `act` with the exit status of each signal that asks the program to end.
///
/// # Errors
/// When signals cannot be watched.
#[cfg(unix)]
fn on_signal(act: impl Fn(u8) + Send + 'static) -> Result<(), String> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals =
        Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(|error| format!("cannot watch for interrupts: {error}"))?;
    std::thread::spawn(move || {
        for signal in signals.forever() {
            // The same status as in shells for a program ended by a signal.
            act(u8::try_from(128 + signal).unwrap_or(u8::MAX));
        }
    });
    Ok(())
}

/// Calls `act` with the exit status of each interrupt.
///
/// # Errors
/// When interrupts cannot be watched.
#[cfg(not(unix))]
fn on_signal(act: impl Fn(u8) + Send + 'static) -> Result<(), String> {
    const CTRL_C: u8 = 130;

    ctrlc::set_handler(move || act(CTRL_C)).map_err(|error| format!("cannot watch for interrupts: {error}"))
}
