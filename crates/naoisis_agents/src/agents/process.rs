//! The process of a program that plays a robot. It never outlives the match.
//!
//! The match communicates with the process over the pipes of its standard input and output. The process and its children form a process
//! group. A guard, a shell that waits for the end of naoisis, then kills the group, even if naoisis was killed by a signal that no program
//! can catch.

use core::time::Duration;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use super::connection::Stream;
use super::pipes::{Pipes, SharedChild};
use super::settings::ErrorLines;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::wording::quoted;

/// The guard: a shell command that waits for its standard input to end, and then kills a process group.
const GUARD: &str = "read -r _; kill -s KILL -- \"-$1\"";
/// The time between two checks whether a process has ended.
const LOOK: Duration = Duration::from_millis(2);
/// The time to wait for the last lines of standard error if another process still holds it open.
const LAST_LINES: Duration = Duration::from_secs(1);
/// The longest line of standard error that is passed on in one piece, bytes.
const LONGEST_LINE: u64 = 4096;

/// A program that plays a robot.
#[derive(Debug)]
pub struct Process {
    child: SharedChild,
    guard: Child,
    /// The thread that passes on the lines of its standard error.
    lines: Option<JoinHandle<()>>,
}

impl Process {
    /// Starts a program for a robot, with the variables `environment` beside its `NAOISIS_ROBOT`.
    ///
    /// # Errors
    /// The reason why the program cannot be started.
    pub fn start(
        words: &[String],
        folder: Option<&Path>,
        robot: RobotId,
        environment: Vec<(&'static str, String)>,
        error_lines: Option<ErrorLines>,
    ) -> Result<(Self, Stream), String> {
        let (program, arguments) = words.split_first().ok_or("no program is named")?;
        let cannot = |error| format!("{} cannot be started: {error}", quoted(program));
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            return Err(format!(
                "{} cannot be started in {}: there is no such folder",
                quoted(program),
                folder.display()
            ));
        }
        let (mut pipes, standard_input, standard_output) = Pipes::new().map_err(cannot)?;
        let mut command = Command::new(program);
        command.args(arguments).env("NAOISIS_ROBOT", robot.to_string()).envs(environment).process_group(0);
        command.stdin(standard_input).stdout(standard_output);
        command.stderr(if error_lines.is_some() { Stdio::piped() } else { Stdio::inherit() });
        if let Some(folder) = folder {
            command.current_dir(folder);
        }
        let mut child = command.spawn().map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => {
                format!(
                    "there is no program {}; expected one in a folder of PATH, or a path such as ./my_team",
                    quoted(program)
                )
            }
            _ => cannot(error),
        })?;
        let mut guard = Command::new("/bin/sh");
        guard.args(["-c", GUARD, "naoisis-guard", &child.id().to_string()]).process_group(0);
        guard.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        let guard = guard.spawn().map_err(|error| {
            // Without a guard the program does not run.
            let _ = child.kill().and_then(|()| child.wait());
            cannot(error)
        })?;
        let lines = child
            .stderr
            .take()
            .zip(error_lines)
            .map(|(stderr, pass_on)| thread::spawn(move || pass_lines_on(stderr, |line| pass_on(robot, line))));
        let child = Arc::new(Mutex::new(child));
        pipes.belong_to(child.clone());
        Ok((Self { child, guard, lines }, Stream::Pipes(pipes)))
    }

    /// The number of the process group of the program.
    pub fn group(&self) -> u32 {
        self.child().id()
    }

    fn child(&self) -> MutexGuard<'_, Child> {
        self.child.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The exit status of the process; `None` if it has not ended by the deadline.
    pub fn exit_status(&mut self, deadline: Instant) -> Option<ExitStatus> {
        loop {
            let status = self.child().try_wait();
            match status {
                Ok(None) if Instant::now() < deadline => thread::sleep(LOOK),
                Ok(status) => return status,
                Err(_) => return None,
            }
        }
    }
}

impl Drop for Process {
    /// Ends the process and its children.
    fn drop(&mut self) {
        drop(self.guard.stdin.take());
        // An error here means that the process has ended already.
        let _ = self.guard.wait();
        let _ = self.child().wait();
        let last = Instant::now() + LAST_LINES;
        while self.lines.as_ref().is_some_and(|lines| !lines.is_finished()) && Instant::now() < last {
            thread::sleep(LOOK);
        }
    }
}

/// The exit status of a process in words.
pub fn ending(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(code), _) => format!("it ended with status {code}"),
        (None, Some(signal)) => format!("it was ended by signal {signal}"),
        (None, None) => "it ended".to_owned(),
    }
}

/// Passes on each line that is read, a long line in pieces.
fn pass_lines_on(stderr: impl Read, mut pass_on: impl FnMut(&str)) {
    let mut reader = BufReader::new(stderr);
    let mut line = Vec::new();
    loop {
        line.clear();
        match (&mut reader).take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => break,
            Ok(_) => pass_on(String::from_utf8_lossy(&line).trim_end_matches(['\n', '\r'])),
        }
    }
}
