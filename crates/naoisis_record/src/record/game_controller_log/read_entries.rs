//! The entries of a log, with the fields that are read. Other fields are ignored.

use serde::Deserialize;

use naoisis_core::team::Team;

/// An entry with its time since the start.
#[derive(Deserialize)]
pub(super) struct TimedEntry {
    pub timestamp: Timestamp,
    pub entry: Entry,
}

#[derive(Deserialize)]
pub(super) struct Timestamp {
    pub secs: u64,
    pub nanos: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) enum Entry {
    Metadata(Metadata),
    Action(LoggedAction),
    GameState(State),
    StatusMessage(Data),
    TeamMessage(Sender),
    MonitorRequest(serde::de::IgnoredAny),
    End,
}

#[derive(Deserialize)]
pub(super) struct Metadata {
    #[serde(default)]
    pub timestamp: String,
    pub params: Params,
}

#[derive(Deserialize)]
pub(super) struct Params {
    pub competition: Competition,
    pub game: GameParams,
}

#[derive(Deserialize)]
pub(super) struct Competition {
    pub name: String,
}

#[derive(Deserialize)]
pub(super) struct GameParams {
    pub teams: Sides<TeamParams>,
}

#[derive(Deserialize)]
pub(super) struct TeamParams {
    pub number: u8,
}

#[derive(Deserialize, Clone)]
pub(super) struct Sides<T> {
    pub home: T,
    pub away: T,
}

impl<T> Sides<T> {
    pub fn of(&self, team: Team) -> &T {
        match team {
            Team::Blue => &self.home,
            Team::Pink => &self.away,
        }
    }
}

#[derive(Deserialize)]
pub(super) struct LoggedAction {
    pub source: String,
    pub action: Action,
}

#[derive(Deserialize)]
pub(super) struct Action {
    #[serde(rename = "type")]
    pub kind: String,
    pub args: Option<Arguments>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Arguments {
    pub side: Option<String>,
    pub player: Option<u8>,
    pub call: Option<String>,
    pub set_play: Option<String>,
    pub states: usize,
}

#[derive(Deserialize, Clone)]
#[serde(rename_all = "camelCase")]
pub(super) struct State {
    pub phase: String,
    pub state: String,
    pub teams: Sides<TeamState>,
}

#[derive(Deserialize, Clone)]
pub(super) struct TeamState {
    pub score: u32,
    pub players: Vec<Player>,
}

#[derive(Deserialize, Clone)]
pub(super) struct Player {
    pub penalty: String,
}

#[derive(Deserialize)]
pub(super) struct Data {
    pub data: String,
}

#[derive(Deserialize)]
pub(super) struct Sender {
    pub team: u8,
}
