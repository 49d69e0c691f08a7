//! Limits of time and size for programs, and the folders they run in.

use bevy::prelude::*;
use core::fmt;
use core::time::Duration;
use std::path::PathBuf;
use std::sync::Arc;

use naoisis_core::team::{PerTeam, RobotId, Team};

/// The time between two checks of the clock while a program is silent.
pub(super) const LOOK: Duration = Duration::from_millis(20);

/// A function that receives the lines that programs write to standard error.
pub type ErrorLines = Arc<dyn Fn(RobotId, &str) + Send + Sync>;

/// A function that returns whether the match is broken off, in which case waiting for programs ends.
#[derive(Clone)]
pub struct BreakOff(pub Arc<dyn Fn() -> bool + Send + Sync>);

impl fmt::Debug for BreakOff {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("BreakOff")
    }
}

/// Limits and settings for programs. Times are wall-clock times; they only decide whether a program is lost.
#[derive(Resource, Clone)]
pub struct AgentSettings {
    /// The longest time for an answer: 5 s; `None` for no limit.
    pub answer_timeout: Option<Duration>,
    /// The longest time until the hello: 30 s, because large libraries load slowly; `None` for no limit.
    pub start_timeout: Option<Duration>,
    /// The longest message, bytes: 65 536.
    pub longest_message: usize,
    /// The password that programs must send to connect; `None` for no password.
    pub token: Option<String>,
    /// The folder in which the programs of each team run; `None` for the current folder.
    pub folders: PerTeam<Option<PathBuf>>,
    /// Receives the lines that programs write to standard error; `None` leaves standard error as it is.
    pub error_lines: Option<ErrorLines>,
    /// Returns whether to stop waiting; `None` waits as long as the limits allow.
    pub break_off: Option<BreakOff>,
}

/// The numbers of the teams in their league, and the offset of the UDP ports of the match. Programs that are started learn them from their
/// environment.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug)]
pub struct LeagueNumbers {
    /// The league's number of each team; `None` before the numbers are known.
    pub team_numbers: Option<PerTeam<u8>>,
    /// The offset, which is added to every port.
    pub port_offset: u16,
}

impl LeagueNumbers {
    /// The environment variables for the program of a robot of `team`.
    pub(super) fn environment(&self, team: Team) -> Vec<(&'static str, String)> {
        let number = self.team_numbers.map(|numbers| ("NAOISIS_TEAM_NUMBER", numbers[team].to_string()));
        number.into_iter().chain([("NAOISIS_PORT_OFFSET", self.port_offset.to_string())]).collect()
    }
}

impl Default for AgentSettings {
    fn default() -> Self {
        Self {
            answer_timeout: Some(Duration::from_secs(5)),
            start_timeout: Some(Duration::from_secs(30)),
            longest_message: 64 << 10,
            token: None,
            folders: PerTeam::default(),
            error_lines: None,
            break_off: None,
        }
    }
}
