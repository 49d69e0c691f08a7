//! The entries of a log as they are written. The entries for reading have [fewer fields](super::read_entries).

use core::time::Duration;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// An entry with its time since the start.
#[derive(Serialize, Debug)]
pub(super) struct TimedEntry {
    pub timestamp: Duration,
    pub entry: Entry,
}

/// An entry.
#[derive(Serialize, Debug)]
#[serde(rename_all = "camelCase")]
pub(super) enum Entry {
    Metadata(Metadata),
    Action(Action),
    GameState(Box<State>),
    StatusMessage(StatusMessage),
    TeamMessage(TeamMessage),
    End,
}

/// The name of the writing program, and the parameters of the match.
#[derive(Serialize, Debug)]
pub(super) struct Metadata {
    pub creator: &'static str,
    pub version: u32,
    pub timestamp: &'static str,
    pub params: Value,
}

/// An action of the referee: its source (`user`, `timer` or `network`), and its contents.
#[derive(Serialize, Debug, PartialEq)]
pub(super) struct Action {
    pub source: &'static str,
    pub action: Value,
}

/// A status message of a robot to the GameController.
#[derive(Serialize, Debug)]
pub(super) struct StatusMessage {
    pub host: String,
    pub data: String,
}

/// A message of a robot to its team.
#[derive(Serialize, Debug)]
pub(super) struct TeamMessage {
    pub team: u8,
    pub host: String,
    pub data: String,
}

/// The state of the game.
#[derive(Serialize, Debug)]
#[serde(rename_all = "camelCase")]
pub(super) struct State {
    pub sides: &'static str,
    pub phase: &'static str,
    pub state: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<bool>,
    pub set_play: &'static str,
    pub kicking_side: Option<&'static str>,
    pub primary_timer: Timer,
    pub secondary_timer: Timer,
    pub timeout_rewind_timer: Timer,
    pub teams: Sides,
}

/// Both teams.
#[derive(Serialize, Debug)]
pub(super) struct Sides {
    pub home: TeamState,
    pub away: TeamState,
}

/// The state of a team.
#[derive(Serialize, Debug)]
#[serde(rename_all = "camelCase")]
pub(super) struct TeamState {
    pub goalkeeper: Option<u8>,
    pub score: u32,
    pub penalty_counter: u32,
    pub timeout_budget: u8,
    pub message_budget: u32,
    pub illegal_communication: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback_mode: Option<bool>,
    pub penalty_shot: u32,
    pub penalty_shot_mask: u32,
    pub players: Vec<PlayerState>,
}

/// The state of a player.
#[derive(Serialize, Debug, Clone)]
#[serde(rename_all = "camelCase")]
pub(super) struct PlayerState {
    pub penalty: &'static str,
    pub penalty_timer: Timer,
    /// In the Humanoid Soccer League: the value of the team's penalty counter at the player's penalty, and its warnings and cautions.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub cards: Option<Cards>,
}

/// The warnings and cautions of a player.
#[derive(Serialize, Debug, Clone, Default)]
#[serde(rename_all = "camelCase")]
pub(super) struct Cards {
    pub penalty_increment: u32,
    pub warnings: u8,
    pub cautions: u8,
}

/// A timer.
#[derive(Serialize, Debug, Clone, Default)]
#[serde(rename_all = "camelCase")]
pub(super) enum Timer {
    #[serde(rename_all = "camelCase")]
    Started {
        /// Time left, s.
        #[serde(serialize_with = "seconds_and_nanoseconds")]
        remaining: f64,
        run_condition: &'static str,
        behavior_at_zero: &'static str,
    },
    #[default]
    Stopped,
}

impl Timer {
    /// Returns a running timer, or a stopped one if `left_s` is `None`.
    pub fn of(left_s: Option<f64>, run_condition: &'static str, behavior_at_zero: &'static str) -> Self {
        left_s.map_or(Self::Stopped, |remaining| Self::Started { remaining, run_condition, behavior_at_zero })
    }
}

/// Writes a time that may be negative as whole seconds and nanoseconds.
fn seconds_and_nanoseconds<S: Serializer>(time_s: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    let nanoseconds = (time_s * 1e9).round() as i64;
    (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000).serialize(serializer)
}
