//! A referee outside the match, such as a person at a real GameController.

use bevy::prelude::*;

use super::{GameState, PenaltyReason, Score, SetPlayKind};
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::team::{RobotId, Team};

/// What a referee outside the match says of it. As long as there is one, the match's own referee judges nothing, and carries out
/// what this one says.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct OutsideReferee {
    /// The state of the game.
    pub state: GameState,
    /// The half, from 1.
    pub half: u32,
    /// The end that the blue team defends.
    pub blue_end: End,
    /// Goals of both teams.
    pub score: Score,
    /// The team that the ball is for, if that is said.
    pub kicking_team: Option<Team>,
    /// The free kick or penalty kick.
    pub set_play: Option<SetPlayKind>,
    /// Time left in the half, s.
    pub time_left_s: f32,
    /// Time left of what the game waits for, s.
    pub secondary_time_left_s: f32,
    /// The robots that serve a penalty: what for, and for how long, s.
    pub penalties: Vec<(RobotId, PenaltyReason, f32)>,
}
