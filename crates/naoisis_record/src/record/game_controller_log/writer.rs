//! Writes the log of a simulated match.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use bevy::prelude::*;
use core::time::Duration;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::NO_DATE;
use super::dialect::Dialect;
use super::entries::{
    Action, Cards, Entry, Metadata, PlayerState, Sides, State, StatusMessage, TeamMessage, TeamState, TimedEntry, Timer,
};
use super::parameters::{message_budget, number_of, parameters, sides};
use crate::record::output_file::OutputFile;
use crate::record::recorder::{MatchEnd, RecordError, Recorder};
use naoisis_agents::game_controller::{ReturnPacket, TeamColours};
use naoisis_core::communication::StatusReport;
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Game, GameState, PenaltyReason, Rules, SetPlayKind};
use naoisis_core::robot::body::Body;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sim::interface::cycle_record::{CycleRecord, GameRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// Number of players of a team in a log, present or not.
const PLAYERS: u8 = 20;
/// Cycles between two status messages of a robot: two seconds. A robot that is silent for four seconds would count as absent.
const CYCLES_PER_STATUS: u64 = 60;

/// Writes a match as a log of the league's GameController, for the league's own programs.
pub struct GameControllerLogRecorder {
    output: OutputFile,
    writer: BufWriter<File>,
    error: Option<io::Error>,
    dialect: Dialect,
    rules: Rules,
    penalties: [u32; 2],
    /// The game state in the last state entry.
    written: GameState,
    /// Whether the match is stopped briefly.
    is_stopped: bool,
}

impl GameControllerLogRecorder {
    /// Creates a log in a file. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let writer = BufWriter::new(output.writer()?);
        let (dialect, rules) = (Dialect::default(), Rules::default());
        let written = GameState::default();
        Ok(Self { output, writer, error: None, dialect, rules, penalties: [0; 2], written, is_stopped: false })
    }

    fn write(&mut self, time_s: f64, entry: Entry) {
        if self.error.is_some() {
            return;
        }
        let entry = TimedEntry { timestamp: Duration::from_secs_f64(time_s.max(0.0)), entry };
        let written = serde_norway::to_string(&[entry]).map_err(io::Error::other);
        self.error = written.and_then(|text| self.writer.write_all(text.as_bytes())).err();
    }

    /// Writes the messages of the robots.
    fn write_messages(&mut self, record: &CycleRecord) {
        for robot in &record.robots {
            let (team, player) = (number_of(robot.id.team), robot.id.number);
            let host = format!("10.0.{team}.{player}");
            if (record.cycle + 3 * u64::from(player)).is_multiple_of(CYCLES_PER_STATUS) {
                let report = status_report(robot, record.time_s);
                let bytes = ReturnPacket { player, team, report }.to_bytes();
                let data = BASE64_STANDARD.encode(bytes);
                self.write(record.time_s, Entry::StatusMessage(StatusMessage { host: host.clone(), data }));
            }
            let Some(say) = robot.command.as_ref().and_then(|command| command.say.as_ref()) else { continue };
            let data = BASE64_STANDARD.encode(vec![0; say.size_bytes()]);
            self.write(record.time_s, Entry::TeamMessage(TeamMessage { team, host, data }));
            let arguments = json!({ "side": side(robot.id.team), "illegal": false });
            let action = action("network", "teamMessage", arguments);
            self.write(record.time_s, Entry::Action(action));
        }
    }

    fn write_state(&mut self, record: &CycleRecord) {
        self.written = record.game.state;
        let state = self.state(record);
        self.write(record.time_s, Entry::GameState(Box::new(state)));
    }

    fn state(&self, record: &CycleRecord) -> State {
        let game = &record.game;
        let phase = match (game.shoot_out, game.half) {
            (Some(_), _) => "penaltyShootout",
            (None, half) if half == self.rules.halves + 1 => "firstExtraHalf",
            (None, half) if half > self.rules.halves + 1 => "secondExtraHalf",
            (None, 0 | 1) => "firstHalf",
            (None, _) => "secondHalf",
        };
        State {
            sides: sides(game.blue_end),
            phase,
            state: self.dialect.state(game.state),
            stopped: (self.dialect == Dialect::Humanoid).then_some(game.stopped),
            set_play: self.dialect.set_play(set_play(game)),
            kicking_side: game.kicking_team.map(side),
            primary_timer: Timer::of(game.time_left_s, "mainTimer", "overflow"),
            secondary_timer: Timer::of(game.secondary_time_left_s, "always", "clip"),
            timeout_rewind_timer: Timer::Stopped,
            teams: Sides { home: self.team(record, Team::Blue), away: self.team(record, Team::Pink) },
        }
    }

    fn team(&self, record: &CycleRecord, team: Team) -> TeamState {
        let cards = || (self.dialect == Dialect::Humanoid).then(Cards::default);
        let mut players =
            vec![PlayerState { penalty: "substitute", penalty_timer: Timer::Stopped, cards: cards() }; PLAYERS.into()];
        for robot in record.robots.iter().filter(|robot| robot.id.team == team) {
            let Some(player) = players.get_mut(usize::from(robot.id.number).wrapping_sub(1)) else { continue };
            player.penalty = robot.penalised.map_or("noPenalty", |penalty| self.dialect.penalty(penalty.reason)[1]);
            let left_s = robot.penalised.map(|penalty| penalty.time_left_s);
            player.penalty_timer = Timer::of(left_s, "readyOrPlaying", "clip");
        }
        let shoot_out = record.game.shoot_out;
        TeamState {
            goalkeeper: Some(record.game.goalkeepers[team].unwrap_or(RobotId::GOALKEEPER)),
            score: record.game.score[team],
            penalty_counter: self.penalties[team as usize],
            timeout_budget: u8::try_from(record.game.timeouts_left[team]).unwrap_or(u8::MAX),
            message_budget: record.game.messages_left.map_or_else(|| message_budget(&self.rules), |left| left[team]),
            illegal_communication: false,
            fallback_mode: (self.dialect == Dialect::StandardPlatform).then_some(false),
            penalty_shot: shoot_out.map_or(0, |shoot_out| shoot_out.taken[team]),
            penalty_shot_mask: 0,
            players,
        }
    }
}

impl Recorder for GameControllerLogRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        self.dialect = Dialect::of_league(scenario.league.as_deref());
        self.rules = scenario.rules.clone();
        let params = parameters(scenario, record, worn_by(record, world), self.dialect);
        let metadata = Metadata { creator: "naoisis", version: 1, timestamp: NO_DATE, params };
        self.write(record.time_s, Entry::Metadata(metadata));
        self.write_state(record);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        self.write_messages(record);
        let was_stopped = core::mem::replace(&mut self.is_stopped, record.game.stopped);
        for action in actions(record, &self.rules, self.dialect) {
            self.write(record.time_s, Entry::Action(action));
            self.write_state(record);
        }
        if record.game.state != self.written || record.game.stopped != was_stopped {
            self.write_state(record);
        }
        for event in &record.events {
            if let MatchEvent::Penalty { robot, reason, .. } = event {
                self.penalties[robot.team as usize] += u32::from(reason.is_infraction());
            }
        }
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    fn finish(mut self: Box<Self>, _: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.write_state(last);
        self.write(last.time_s, Entry::End);
        let Self { output, mut writer, error, .. } = *self;
        let written = error.map_or_else(|| writer.flush(), Err);
        output.close(written).map(|()| None)
    }
}

/// Returns the actions of the referee in a cycle.
fn actions(record: &CycleRecord, rules: &Rules, dialect: Dialect) -> Vec<Action> {
    // The Humanoid Soccer League has no call for a pushing foul with a free kick.
    let foul = foul(&record.events).filter(|_| dialect == Dialect::StandardPlatform);
    let mut uncalled = foul;
    let mut actions = Vec::new();
    for event in &record.events {
        match event {
            MatchEvent::Penalty { robot, reason, .. } => {
                let is_foul =
                    |(_, team): &mut (SetPlayKind, Team)| *reason == PenaltyReason::Pushing && *team != robot.team;
                let call = match uncalled.take_if(is_foul) {
                    Some((SetPlayKind::PenaltyKick, _)) => "penaltyKick",
                    Some(_) => "foul",
                    None => dialect.penalty(*reason)[0],
                };
                let arguments = json!({ "side": side(robot.team), "player": robot.number, "call": call });
                actions.push(action("user", "penalize", arguments));
            }
            MatchEvent::FreeKick { set_play, team, .. } if foul != Some((*set_play, *team)) => {
                let arguments = json!({ "side": side(*team), "setPlay": dialect.set_play(Some(*set_play)) });
                actions.push(action("user", "startSetPlay", arguments));
            }
            MatchEvent::HalfBegins { half } if *half > 1 => {
                actions.push(action("user", "finishHalf", Value::Null));
                let call = if *half == rules.halves + 1 { "startExtraTime" } else { "switchHalf" };
                actions.push(action("timer", call, Value::Null));
            }
            MatchEvent::StateChanged { state } => actions.extend(change(*state, record, dialect)),
            _ => actions.extend(simple_action(event, record)),
        }
    }
    actions
}

/// Returns the action that brings the game into `state`. Returns `None` if there is no such action.
fn change(state: GameState, record: &CycleRecord, dialect: Dialect) -> Option<Action> {
    // After a goal the kick-off follows automatically, and a set play under way has its own `ready`.
    let follows =
        record.events.iter().any(|event| matches!(event, MatchEvent::Goal { .. })) || record.game.set_play.is_some();
    Some(match state {
        GameState::Standby if dialect == Dialect::StandardPlatform => action("user", "waitForReady", Value::Null),
        GameState::Ready if !follows => {
            let team = record.game.kicking_team.map(side);
            action("user", "startSetPlay", json!({ "side": team, "setPlay": "kickOff" }))
        }
        GameState::Set => action("user", "waitForSetPlay", Value::Null),
        GameState::Playing => action("user", "freeSetPlay", Value::Null),
        _ => return None,
    })
}

/// Returns the set play under way. The `ready` and `set` before a kick-off are a part of it.
fn set_play(game: &GameRecord) -> Option<SetPlayKind> {
    let before_kick_off = matches!(game.state, GameState::Ready | GameState::Set) && game.shoot_out.is_none();
    game.set_play.map(|set_play| set_play.kind).or(before_kick_off.then_some(SetPlayKind::KickOff))
}

/// Returns the action of an event that has exactly one.
fn simple_action(event: &MatchEvent, record: &CycleRecord) -> Option<Action> {
    Some(match event {
        MatchEvent::Goal { team, .. } => action("user", "goal", json!({ "side": side(*team) })),
        MatchEvent::Timeout { team, .. } => action("user", "timeout", json!({ "side": team.map(side) })),
        MatchEvent::Substitution { robot, replaced } => {
            let arguments = json!({ "side": side(robot.team), "playerIn": robot.number, "playerOut": replaced.number });
            action("user", "substitute", arguments)
        }
        MatchEvent::PenaltyOver { robot, .. } => {
            let arguments = json!({ "side": side(robot.team), "player": robot.number, "force": false });
            action("user", "unpenalize", arguments)
        }
        MatchEvent::FreeKickOver { taken, .. } => {
            action(if *taken { "user" } else { "timer" }, "finishSetPlay", Value::Null)
        }
        MatchEvent::FinalWhistle => action("user", "finishHalf", Value::Null),
        MatchEvent::GameStuck { robot: None, .. } => action("user", "globalGameStuck", Value::Null),
        MatchEvent::ShootOutBegins => {
            action("user", "startPenaltyShootout", json!({ "sides": sides(record.game.blue_end) }))
        }
        _ => return None,
    })
}

/// Returns the free kick or penalty kick that a push brings to the opponents, since the log has a single call for both.
fn foul(events: &[MatchEvent]) -> Option<(SetPlayKind, Team)> {
    events.iter().find_map(|event| match event {
        MatchEvent::FreeKick { set_play, team, .. }
            if matches!(set_play, SetPlayKind::PushingFreeKick | SetPlayKind::PenaltyKick) =>
        {
            let is_cause = |event: &MatchEvent| {
                matches!(event, MatchEvent::Penalty { robot, reason: PenaltyReason::Pushing, .. } if robot.team != *team)
            };
            events.iter().any(is_cause).then_some((*set_play, *team))
        }
        _ => None,
    })
}

fn action(source: &'static str, kind: &str, arguments: Value) -> Action {
    Action { source, action: json!({ "type": kind, "args": arguments }) }
}

fn side(team: Team) -> &'static str {
    match team {
        Team::Blue => "home",
        Team::Pink => "away",
    }
}

/// Returns a robot's status report: what its program reported, or otherwise what the robot believes.
fn status_report(robot: &RobotRecord, time_s: f64) -> StatusReport {
    robot.reported.unwrap_or_else(|| {
        let belief = robot.belief.clone().unwrap_or_default();
        let ball = belief.ball.as_ref().map(|ball| belief.pose.inverse_transform_point(ball.position_m));
        StatusReport {
            time_s,
            fallen: !robot.posture.is_upright(),
            pose: belief.pose,
            ball_age_s: ball.map(|_| 0.0),
            ball_m: ball,
        }
    })
}

/// Returns the colours of the jerseys that the robots wear.
fn worn_by(record: &CycleRecord, world: &mut World) -> PerTeam<TeamColours> {
    let mut robots = world.query::<(&RobotId, &Body)>();
    let mut robots: Vec<_> = robots.iter(world).map(|(id, body)| (*id, body.jersey)).collect();
    robots.sort_by_key(|(id, _)| *id);
    let game = Game { goalkeepers: record.game.goalkeepers, ..default() };
    TeamColours::worn_by(&robots, &game)
}
