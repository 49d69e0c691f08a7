//! The match as data: its state, score, half, clock and sides, its rules, penalties and set plays, and the evidence for decisions. Only the
//! [referee](crate::referee) writes these data.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

mod evidence;
mod intervention;
mod outside_referee;
mod penalty;
mod result;
mod rules;
mod set_play;
mod shoot_out;

pub use evidence::{Evidence, Measurement, RobotEvidence};
pub use intervention::{Intervention, Interventions, TimedIntervention};
pub use outside_referee::OutsideReferee;
pub use penalty::{ActivePenalty, Penalty, PenaltyReason, RuleName};
pub use result::{DecidedBy, MatchResult};
pub use rules::{
    BallOutRestart, DefenderLimit, KickOffPositions, KickOffProcedure, ReturnPlace, Rules, ShootOutProcedure,
    SideContacts, SubstitutionProcedure,
};
pub use set_play::{SetPlay, SetPlayKind};
pub use shoot_out::{ShootOut, Shot, ShotRank, Standing};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::team::{PerTeam, RobotId, Team};

/// The state of the game (2010 rule book, section 3.2).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema, IntoStaticStr)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum GameState {
    /// Before the match.
    #[default]
    Initial,
    /// Before the first `ready` of a half: robots stand and wait for the referee to raise its arms (2025 rule book, section 3.2).
    Standby,
    /// Robots walk to their places for a kick-off.
    Ready,
    /// Robots stand and wait for the whistle.
    Set,
    /// The ball is in play.
    Playing,
    /// A time-out: robots stand, and only the time of the time-out runs.
    Timeout,
    /// After the final whistle.
    Finished,
}

impl GameState {
    /// The name of the state in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The goals of each team.
pub type Score = PerTeam<u32>;

impl Score {
    /// The team with more goals.
    pub fn leader(&self) -> Option<Team> {
        (self.blue != self.pink).then_some(if self.blue > self.pink { Team::Blue } else { Team::Pink })
    }
}

/// A brief stop, in which no robot may move and no clock runs (HSL 2026, emergency stop).
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct BriefStop {
    /// Position of the ball when the stop began, to which it returns when play continues, m, pitch frame.
    pub ball_m: Option<Vec2>,
    /// Cycles since the stop began.
    pub cycles: u64,
    /// Duration in cycles; if absent, the stop lasts until the referee is asked to continue.
    pub duration_cycles: Option<u64>,
}

/// A time-out (2025 rule book, sections 3.13 and 3.14; HSL 2026, time-out).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
pub struct Timeout {
    /// The team that took it; `None` for the referee.
    pub team: Option<Team>,
    /// Cycles until it ends.
    pub cycles_left: u64,
    /// Whether the shoot-out follows, rather than a kick-off.
    pub before_shoot_out: bool,
}

/// The true state of the match.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Game {
    /// The state of play.
    pub state: GameState,
    /// Cycles since the state began.
    pub state_cycles: u64,
    /// Goals of both teams so far.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Cycles left in this half; `None` if the rules have no clock.
    pub cycles_left: Option<u64>,
    /// Cycles for which this half has gone on after its time.
    pub overtime_cycles: u64,
    /// The end that the blue team defends.
    pub blue_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// Whether play was last restarted by a drop ball instead: neither team has the kick-off.
    pub drop_ball: bool,
    /// The free kick under way, or the kick-off while the ball belongs to one team.
    pub set_play: Option<SetPlay>,
    /// The number of each team's goalkeeper, if a substitute has replaced number 1.
    #[reflect(default)]
    pub goalkeepers: PerTeam<Option<u8>>,
    /// How many messages each team may still send; none if unlimited.
    pub messages_left: Option<PerTeam<u32>>,
    /// Whether each team has exceeded its message budget: its goals do not count.
    pub goals_void: PerTeam<bool>,
    /// The penalty shoot-out under way, or that decided the match.
    pub shoot_out: Option<ShootOut>,
    /// The brief stop under way.
    pub stop: Option<BriefStop>,
    /// The time-out under way.
    pub timeout: Option<Timeout>,
    /// Number of time-outs that each team may still take.
    pub timeouts_left: PerTeam<u32>,
    /// Number of restarts for which the robots were placed so far.
    pub restarts: u32,
    /// Number of times that the referee has whistled.
    pub whistles: u32,
    /// Number of times that the referee has raised its arms for the first `ready` of a half.
    pub ready_signals: u32,
}

impl Game {
    /// The match before its first cycle: blue defends the blue goal and kicks off. Without a clock, as in debug mode, the ball
    /// is in play at once.
    pub fn at_start(rules: &Rules, clock: &CycleClock) -> Self {
        Self {
            state: if rules.clock { GameState::Initial } else { GameState::Playing },
            half: 1,
            cycles_left: rules.clock.then(|| rules.half_cycles(1, clock)),
            kick_off_team: rules.first_kick_off,
            messages_left: rules.message_budget.map(|budget| PerTeam { blue: budget, pink: budget }),
            timeouts_left: PerTeam { blue: rules.timeouts, pink: rules.timeouts },
            ..Self::default()
        }
    }

    /// The end that `team` defends.
    pub fn own_end(&self, team: Team) -> End {
        match team {
            Team::Blue => self.blue_end,
            Team::Pink => self.blue_end.opposite(),
        }
    }

    /// The number by which a robot has its place and its task.
    pub fn role_number(&self, id: RobotId) -> u8 {
        id.role_number(self.goalkeepers[id.team])
    }

    /// Whether a robot is its team's goalkeeper.
    pub fn is_goalkeeper(&self, id: RobotId) -> bool {
        id.is_goalkeeper_of(&self.goalkeepers)
    }

    /// The team that defends `end`.
    pub fn defender_of(&self, end: End) -> Team {
        if end == self.blue_end { Team::Blue } else { Team::Pink }
    }

    /// Whether `team` has, or had last, the kick-off.
    pub fn has_kick_off(&self, team: Team) -> bool {
        self.kick_off() == Some(team)
    }

    /// The team that has, or had last, the kick-off; `None` after a drop ball.
    pub fn kick_off(&self) -> Option<Team> {
        (!self.drop_ball).then_some(self.kick_off_team)
    }

    /// Seconds left in this half; `None` if the rules have no clock.
    pub fn time_left_s(&self, clock: &CycleClock) -> Option<f32> {
        self.cycles_left.map(|cycles| (cycles as f64 * clock.period_s) as f32)
    }

    /// Whether this half has been kicked off.
    fn half_has_begun(&self, rules: &Rules, clock: &CycleClock) -> bool {
        self.cycles_left.is_some_and(|left| left < rules.half_cycles(self.half, clock))
    }

    /// Whether the clock of the half runs: in play, and if [`Rules::clock_runs_in_stoppages`] in `ready` and `set`, except before
    /// the first kick-off of the half.
    pub fn clock_runs(&self, rules: &Rules, clock: &CycleClock) -> bool {
        match self.state {
            _ if self.stop.is_some() => false,
            GameState::Playing => self.shoot_out.is_none(),
            GameState::Ready | GameState::Set => {
                rules.clock_runs_in_stoppages && self.shoot_out.is_none() && self.half_has_begun(rules, clock)
            }
            GameState::Initial | GameState::Standby | GameState::Timeout | GameState::Finished => false,
        }
    }

    /// Longest duration of `ready` before a kick-off, or before the penalty kick under way, s.
    pub fn ready_s(&self, rules: &Rules) -> f32 {
        if self.penalty_kick().is_some() { rules.penalty_kick_ready_s } else { rules.ready_s }
    }

    /// The penalty kick under way, or being prepared.
    pub fn penalty_kick(&self) -> Option<SetPlay> {
        self.set_play.filter(|set_play| set_play.kind == SetPlayKind::PenaltyKick)
    }

    /// The secondary time in cycles: the remaining time of `ready` or `set`, of a free kick, of a time-out, or of a shot in a shoot-out.
    pub fn secondary_cycles_left(&self, rules: &Rules, clock: &CycleClock) -> Option<u64> {
        let left = |duration_s: f32, cycles: u64| u64::from(clock.cycles_in(duration_s)).saturating_sub(cycles);
        match (self.state, &self.set_play, &self.shoot_out) {
            (GameState::Ready, ..) => Some(left(self.ready_s(rules), self.state_cycles)),
            (GameState::Set, ..) => Some(left(rules.set_s, self.state_cycles)),
            (GameState::Timeout, ..) => self.timeout.map(|timeout| timeout.cycles_left),
            (GameState::Playing, Some(set_play), _) => Some(set_play.cycles_left),
            (GameState::Playing, None, Some(shoot_out)) => Some(left(shoot_out.shot_s(rules), shoot_out.shot.cycles)),
            (GameState::Initial | GameState::Standby | GameState::Playing | GameState::Finished, ..) => None,
        }
    }
}
