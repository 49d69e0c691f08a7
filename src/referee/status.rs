//! What the robots are told of the game.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::game::{Game, GameState, Score};
use super::penalty::{Penalty, PenaltyReason};
use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::robot::{RobotId, Team};

/// What a robot is told of the game, as by a GameController.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct GameStatus {
    /// The state of the game.
    pub state: GameState,
    /// Goals.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Seconds left in this half; none where the rules have no clock.
    pub time_left_s: Option<f32>,
    /// Seconds since the start of the match.
    pub time_s: f32,
    /// The end of the pitch that this robot's team defends.
    pub own_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// Whether this robot is penalised.
    pub penalised: bool,
    /// What for, if it is.
    pub penalty: Option<PenaltyReason>,
    /// How often the robots were placed for a restart: it changes when the robot has been placed at its
    /// kick-off position, in its team's agreed formation.
    pub restarts: u32,
}

pub(super) fn tell_status(
    clock: Res<CycleClock>,
    game: Res<Game>,
    mut robots: Query<(&RobotId, &Penalty, &mut GameStatus)>,
) {
    for (id, penalty, mut status) in &mut robots {
        *status = GameStatus {
            state: game.state,
            score: game.score,
            half: game.half,
            time_left_s: game.time_left_s(&clock),
            time_s: clock.start_time_s() as f32,
            own_end: game.own_end(id.team),
            kick_off_team: game.kick_off_team,
            penalised: penalty.is_active(),
            penalty: penalty.0.map(|penalty| penalty.reason),
            restarts: game.restarts,
        };
    }
}
