//! Reads the log of a match, simulated or real, and counts its events.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use bevy::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::NO_DATE;
use super::dialect::{offence_of, set_play_of, state_of};
use super::read_entries::{Action, Arguments, Data, Entry, LoggedAction, Sender, State, TimedEntry};
use crate::record::match_counts::{MatchCounts, Observed, ObservedRobot};
use naoisis_agents::game_controller::ReturnPacket;
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Evidence, GameState, Score};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sim::scenario::Scenario;

/// A robot without a status message for longer than this when play begins takes no part, s, as in the statistics of the league.
const SILENT_S: f64 = 4.0;
/// The mark at the start of a file with which some editors save UTF-8.
const BYTE_ORDER_MARK: char = '\u{feff}';
/// The kinds of entries that are known.
const KINDS: [&str; 7] = ["metadata", "action", "gameState", "statusMessage", "teamMessage", "monitorRequest", "end"];
/// Length limit of an entry, bytes.
const LARGEST_ENTRY: usize = 1 << 20;

/// A match, counted from its log.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GameControllerLog {
    /// The name of the competition.
    pub competition: String,
    /// The date at which the log was begun, such as `2024-07-19T14:00:00+02:00`; empty for a simulated match.
    pub date: String,
    /// The numbers of the teams in the league: the home team is blue.
    pub team_numbers: PerTeam<u8>,
    /// The counts, without a shoot-out. The log has no data about the motion of robots and ball.
    pub counts: MatchCounts,
    /// The messages that each team sent to its robots in `ready`, `set` and `playing`.
    pub messages: PerTeam<u32>,
    /// Whether the log has the final entry.
    pub is_complete: bool,
    /// Whether the match was played to its end: to `finished` in the second half or later.
    pub is_whole_match: bool,
}

/// Why a log cannot be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum GameControllerLogError {
    /// The file cannot be read.
    #[error("{path}: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// An entry is not from a GameController.
    #[error("{path}:{line}: {message}; expected an entry of a log that a GameController of 2023 or later wrote")]
    NotAnEntry {
        /// The file.
        path: PathBuf,
        /// Line where the entry begins, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// The log has no parameters of a match.
    #[error("{0}: the first entry is not `metadata`; expected the log of a whole match")]
    NoMetadata(PathBuf),
}

naoisis_core::debug_as_displayed!(GameControllerLogError);

impl GameControllerLog {
    /// Reads the file at `path` and counts its match.
    ///
    /// # Errors
    /// If the file cannot be read, or is no log of a GameController of 2023 or later.
    pub fn read(path: &Path) -> Result<Self, GameControllerLogError> {
        let file = File::open(path).map_err(|error| GameControllerLogError::Io { path: path.to_owned(), error })?;
        let entries = entries(path, BufReader::new(file))?;
        let Some(TimedEntry { entry: Entry::Metadata(metadata), .. }) = entries.first() else {
            return Err(GameControllerLogError::NoMetadata(path.to_owned()));
        };
        let numbers = &metadata.params.game.teams;
        let mut log = Self {
            competition: metadata.params.competition.name.clone(),
            date: if metadata.timestamp == NO_DATE { String::new() } else { metadata.timestamp.clone() },
            team_numbers: PerTeam::new(|team| numbers.of(team).number),
            counts: MatchCounts::new(&Scenario::default()),
            messages: PerTeam::default(),
            is_complete: matches!(entries.last(), Some(TimedEntry { entry: Entry::End, .. })),
            is_whole_match: false,
        };
        Counting::new(&mut log).count(&entries);
        Ok(log)
    }

    fn team(&self, number: u8) -> Option<Team> {
        Team::BOTH.into_iter().find(|team| self.team_numbers[*team] == number)
    }
}

/// Reads the entries of a log one by one, because a log of many megabytes would be too long for one YAML document.
///
/// Entries of a kind that is not known are left out. The log ends before a last entry that cannot be read: the computer of a GameController
/// may be switched off while it writes.
fn entries(path: &Path, reader: impl BufRead) -> Result<Vec<TimedEntry>, GameControllerLogError> {
    let mut entries = Vec::new();
    let (mut text, mut begins) = (String::new(), 1);
    let read_entry = |text: &str, line: usize| {
        let wrong = |message: String| GameControllerLogError::NotAnEntry { path: path.to_owned(), line, message };
        if text.len() > LARGEST_ENTRY {
            return Err(wrong("this is too long".to_owned()));
        }
        serde_norway::from_str::<Vec<TimedEntry>>(text)
            .or_else(|error| if is_unknown(text) { Ok(Vec::new()) } else { Err(wrong(error.to_string())) })
    };
    for (line, read) in (1..).zip(reader.split(b'\n')) {
        let read = read.map_err(|error| GameControllerLogError::Io { path: path.to_owned(), error })?;
        let read = String::from_utf8_lossy(&read);
        let read = if line == 1 { read.trim_start_matches(BYTE_ORDER_MARK) } else { &read };
        if read.starts_with("- ") {
            if !text.trim().is_empty() {
                entries.extend(read_entry(&text, begins)?);
            }
            text.clear();
            begins = line;
        }
        // A file without entries is refused before it fills the memory.
        if text.len() <= LARGEST_ENTRY {
            text.push_str(read.trim_end_matches(['\r', '\0']));
            text.push('\n');
        }
    }
    if !text.trim().is_empty() {
        match read_entry(&text, begins) {
            Ok(last) => entries.extend(last),
            Err(_) if !entries.is_empty() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(entries)
}

/// Returns whether the text is an entry of a kind that is not known.
fn is_unknown(text: &str) -> bool {
    let kind = text.lines().find_map(|line| line.strip_prefix("  entry: "));
    kind.is_some_and(|kind| !KINDS.contains(&kind.trim().trim_start_matches('!')))
}

/// Counts a log by turning its entries into cycles with events.
struct Counting<'a> {
    log: &'a mut GameControllerLog,
    period_s: f64,
    state: Option<State>,
    /// Events since the last state entry.
    events: Vec<MatchEvent>,
    /// When each robot sent its last status message, s. Empty for logs without any.
    heard_at: BTreeMap<RobotId, f64>,
    /// The last time at which the game was not in `ready`, `set` or `playing`, s.
    stopped_at: f64,
}

impl<'a> Counting<'a> {
    fn new(log: &'a mut GameControllerLog) -> Self {
        let period_s = Scenario::default().cycle_s;
        Self { log, period_s, state: None, events: Vec::new(), heard_at: BTreeMap::new(), stopped_at: 0.0 }
    }

    fn count(mut self, entries: &[TimedEntry]) {
        let undone = undone(entries);
        for (index, TimedEntry { timestamp, entry }) in entries.iter().enumerate() {
            let time_s = timestamp.secs as f64 + f64::from(timestamp.nanos) * 1e-9;
            match entry {
                Entry::Action(action) if !undone.contains(&index) && !self.is_in_shoot_out() => {
                    self.events.extend(events_of(&action.action));
                }
                Entry::GameState(state) => self.enter(state, time_s),
                Entry::StatusMessage(message) => self.hear(message, time_s),
                Entry::TeamMessage(Sender { team }) if is_counted(self.game_state()) => {
                    if let Some(team) = self.log.team(*team) {
                        self.log.messages[team] += 1;
                    }
                }
                Entry::End => {
                    if let Some(state) = self.state.clone() {
                        self.enter(&state, time_s);
                    }
                }
                _ => {}
            }
        }
    }

    fn is_in_shoot_out(&self) -> bool {
        self.state.as_ref().is_some_and(|state| state.phase == "penaltyShootout")
    }

    /// Returns the state of the game. A shoot-out counts as after the match.
    fn game_state(&self) -> GameState {
        match &self.state {
            Some(_) if self.is_in_shoot_out() => GameState::Finished,
            Some(state) => state_of(&state.state),
            None => GameState::Initial,
        }
    }

    fn hear(&mut self, Data { data }: &Data, time_s: f64) {
        let packet = BASE64_STANDARD.decode(data).ok().and_then(|bytes| ReturnPacket::from_bytes(&bytes, time_s).ok());
        if let Some(packet) = packet
            && let Some(team) = self.log.team(packet.team)
        {
            self.heard_at.insert(RobotId::new(team, packet.player), time_s);
        }
    }

    /// Counts the time since the last state entry, and then the events that lead to `state`.
    fn enter(&mut self, state: &State, time_s: f64) {
        self.look(time_s, &[]);
        if !is_counted(self.game_state()) {
            self.stopped_at = time_s;
        }
        self.log.is_whole_match |= state.state == "finished" && state.phase != "firstHalf";
        self.state = Some(state.clone());
        let events = core::mem::take(&mut self.events);
        self.look(time_s, &events);
    }

    fn look(&mut self, time_s: f64, events: &[MatchEvent]) {
        let score = self
            .state
            .as_ref()
            .filter(|_| !self.is_in_shoot_out())
            .map(|state| Score { blue: state.teams.home.score, pink: state.teams.away.score });
        let half = match self.state.as_ref().map(|state| state.phase.as_str()) {
            None | Some("firstHalf") => 1,
            Some("firstExtraHalf") => 3,
            Some("secondExtraHalf") => 4,
            Some(_) => 2,
        };
        let cycle = Observed {
            cycle: (time_s / self.period_s).round() as u64,
            time_s,
            state: self.game_state(),
            half,
            score: score.unwrap_or(self.log.counts.goals),
            blue_end: End::default(),
            goalkeepers: PerTeam::default(),
            ball_m: None,
            events,
        };
        let robots = self.robots();
        self.log.counts.look(&cycle, robots.into_iter());
    }

    /// Returns the robots that are not substitutes.
    fn robots(&self) -> Vec<ObservedRobot<'static>> {
        let Some(state) = &self.state else { return Vec::new() };
        let of_team = |team: Team| {
            let players = state.teams.of(team).players.iter().zip(1u8..);
            players.filter(|(player, _)| player.penalty != "substitute").map(move |(player, number)| {
                let id = RobotId::new(team, number);
                let is_heard = self.heard_at.is_empty()
                    || self.heard_at.get(&id).is_some_and(|at_s| at_s + SILENT_S >= self.stopped_at);
                ObservedRobot {
                    id,
                    pose: Pose::default(),
                    speed_mps: 0.0,
                    is_penalised: player.penalty != "noPenalty" || !is_heard,
                    is_upright: true,
                    sees_ball: false,
                    belief: None,
                }
            })
        };
        Team::BOTH.into_iter().flat_map(of_team).collect()
    }
}

/// Returns whether time in this state is counted.
fn is_counted(state: GameState) -> bool {
    matches!(state, GameState::Ready | GameState::Set | GameState::Playing)
}

/// Returns the indices of actions that were undone later. An undo takes back a number of user actions, and all other actions in between.
fn undone(entries: &[TimedEntry]) -> Vec<usize> {
    let (mut standing, mut undone) = (Vec::new(), Vec::new());
    for (index, entry) in entries.iter().enumerate() {
        let Entry::Action(LoggedAction { source, action }) = &entry.entry else { continue };
        if action.kind != "undo" {
            standing.push((index, source == "user"));
            continue;
        }
        let mut left = action.args.as_ref().map_or(0, |arguments| arguments.states);
        while left > 0
            && let Some((index, is_of_user)) = standing.pop()
        {
            undone.push(index);
            left -= usize::from(is_of_user);
        }
    }
    undone.sort_unstable();
    undone
}

/// Converts an action to events for the counter.
fn events_of(action: &Action) -> Vec<MatchEvent> {
    let nothing = Arguments::default();
    let arguments = action.args.as_ref().unwrap_or(&nothing);
    let team = match arguments.side.as_deref() {
        Some("home") => Team::Blue,
        Some("away") => Team::Pink,
        _ => return Vec::new(),
    };
    let free_kick = |set_play, team| MatchEvent::FreeKick { set_play, team, position_m: Vec2::ZERO };
    match action.kind.as_str() {
        "goal" => vec![MatchEvent::Goal { team, scorer: None, own_goal: false, evidence: Evidence::default() }],
        "penalize" => {
            let Some((reason, set_play)) = arguments.call.as_deref().and_then(offence_of) else { return Vec::new() };
            // A call for a whole team has no player.
            let robot = RobotId::new(team, arguments.player.unwrap_or(RobotId::GOALKEEPER));
            let penalty = MatchEvent::Penalty { robot, reason, until_s: 0.0, evidence: Evidence::default() };
            let given = set_play.map(|set_play| free_kick(set_play, team.opponent()));
            [penalty].into_iter().chain(given).collect()
        }
        "startSetPlay" => {
            let set_play = arguments.set_play.as_deref().and_then(set_play_of);
            set_play.map(|set_play| free_kick(set_play, team)).into_iter().collect()
        }
        _ => Vec::new(),
    }
}
