//! A referee outside the match, such as a person at a real GameController.

use bevy::prelude::*;

use super::{GameState, PenaltyReason, Score, SetPlayKind};
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::team::{RobotId, Team};

/// The decisions of a referee outside the match. While this resource exists, the match's own referee judges nothing and applies
/// these decisions.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct OutsideReferee {
    /// The state of the game.
    pub state: GameState,
    /// Whether the match is stopped briefly.
    pub is_stopped: bool,
    /// The half, from 1.
    pub half: u32,
    /// The end that the blue team defends.
    pub blue_end: End,
    /// Goals of both teams.
    pub score: Score,
    /// The team that takes the kick, if known.
    pub kicking_team: Option<Team>,
    /// The free kick or penalty kick.
    pub set_play: Option<SetPlayKind>,
    /// Time left in the half, s.
    pub time_left_s: f32,
    /// The secondary time that is left, s.
    pub secondary_time_left_s: f32,
    /// The penalised robots, each with the offence and the remaining time, s.
    pub penalties: Vec<(RobotId, PenaltyReason, f32)>,
}
