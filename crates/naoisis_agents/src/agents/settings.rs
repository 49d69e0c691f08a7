//! How long programs may take, how much they may say, and where they are run.

use bevy::prelude::*;
use core::fmt;
use core::time::Duration;
use std::path::PathBuf;
use std::sync::Arc;

use naoisis_core::team::{PerTeam, RobotId};

/// Between two looks at the clock, while a program is silent.
pub(super) const LOOK: Duration = Duration::from_millis(20);

/// Whoever wants the lines that programs write to their standard error.
pub type ErrorLines = Arc<dyn Fn(RobotId, &str) + Send + Sync>;

/// Whoever knows whether the match is to be broken off, so that nobody waits for programs any longer.
#[derive(Clone)]
pub struct BreakOff(pub Arc<dyn Fn() -> bool + Send + Sync>);

impl fmt::Debug for BreakOff {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("BreakOff")
    }
}

/// How programs are treated. What takes time is measured by the wall clock, and decides only whether a program is lost.
#[derive(Resource, Clone)]
pub struct AgentSettings {
    /// The longest that an answer may take: 5 s; none for any time.
    pub answer_timeout: Option<Duration>,
    /// The longest that a program may take until its hello: 30 s, as large libraries are slow to load; none for any time.
    pub start_timeout: Option<Duration>,
    /// The longest message, bytes: 65 536.
    pub longest_message: usize,
    /// The word that programs have to say that connect; none if nobody is asked.
    pub token: Option<String>,
    /// The folder in which the programs of each team are run; none for that of this program.
    pub folders: PerTeam<Option<PathBuf>>,
    /// What is done with what they write to standard error; none to let it pass as it is.
    pub error_lines: Option<ErrorLines>,
    /// Who is asked whether to wait on; nobody, and programs are waited for as long as they may take.
    pub break_off: Option<BreakOff>,
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
