//! A shot straight from the kick-off cannot score (2010 rule book, section 4.5): a goal of the team that kicked off counts only if one of
//! its robots has played the ball after the whole ball had left the centre circle. A ball that opponents only deflected is still that shot;
//! a ball that they kicked is not.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::boundary::Crossing;
use super::snapshot::MatchSnapshot;
use crate::game::Evidence;
use crate::team::Team;

/// The course of play since the kick-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
pub struct KickOffPlay {
    /// The team that kicked off.
    pub team: Team,
    /// Whether the whole ball has left the centre circle.
    pub left_circle: bool,
    /// Whether the next shot is no longer a shot from the kick-off.
    pub over: bool,
}

impl KickOffPlay {
    /// The state just after the whistle.
    pub fn new(team: Team) -> Self {
        Self { team, left_circle: false, over: false }
    }

    /// Records a cycle: first its touches, then the path of the ball.
    pub fn advance(&mut self, snapshot: &MatchSnapshot) {
        for (robot, kick) in snapshot.touches {
            let played_on = if robot.team == self.team { self.left_circle } else { *kick };
            self.over |= played_on;
        }
        let Some(ball) = snapshot.ball else { return };
        let pitch = snapshot.pitch;
        let radius = (pitch.centre_circle_diameter_m + pitch.line_width_m) / 2.0 + ball.radius;
        self.left_circle |= ball.path.iter().chain([&ball.position]).any(|place| place.length() > radius);
    }
}

/// The evidence against a goal of `team` that was shot from the kick-off.
pub fn judge(
    snapshot: &MatchSnapshot,
    play: Option<&KickOffPlay>,
    team: Team,
    crossing: &Crossing,
) -> Option<Evidence> {
    let play = play.filter(|play| snapshot.rules.no_kick_off_shots && play.team == team && !play.over)?;
    let evidence = snapshot.evidence(
        "A shot from the kick-off, before the whole ball has left the centre circle, cannot score.",
        crossing.position,
    );
    Some(evidence.otherwise(format!(
        "A robot of the {} team had to play the ball again after it had left the circle.",
        play.team
    )))
}
