//! Follows kicks: where each was aimed, and which robot touched the ball next.

use bevy::math::ops;
use bevy::prelude::*;

use super::Observed;
use naoisis_core::ball::Rolling;
use naoisis_core::events::{CollisionPartner, MatchEvent};
use naoisis_core::game::GameState;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::scenario::Scenario;

/// A touch by the kicker within this time after its kick belongs to the kick, s.
const SAME_KICK_S: f64 = 0.5;
/// Distance from a post, outside the goal, up to which a kick is still a shot, m.
const BESIDE_GOAL_M: f32 = 0.5;

/// A kick that struck the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StruckKick {
    /// The robot that kicked.
    pub robot: RobotId,
    /// The time of the kick, s since the start of the match.
    pub time_s: f64,
    /// The position of the ball, m, pitch frame.
    pub position_m: Vec2,
    /// The speed of the ball after the kick, m/s.
    pub speed_mps: f32,
    /// Distance between the centre of the opponents' goal and the point where the ball would cross their goal line, m. `None` if the ball
    /// would not reach the line.
    pub at_goal_m: Option<f32>,
    /// The same for the team's own goal.
    pub at_own_goal_m: Option<f32>,
}

impl StruckKick {
    /// Returns whether the ball would cross the team's own goal line between the posts.
    pub fn is_at_own_goal(&self, pitch: &Pitch) -> bool {
        self.at_own_goal_m.is_some_and(|away_m| away_m < pitch.goal.width_m / 2.0)
    }

    /// Returns whether the ball would cross the opponents' goal line between the posts, or up to `beside_m` outside a post.
    fn is_at_goal(&self, pitch: &Pitch, beside_m: f32) -> bool {
        self.at_goal_m.is_some_and(|away_m| away_m < pitch.goal.width_m / 2.0 + beside_m)
    }

    /// Classifies the kick by its `end` and the [definitions](super) of passes and shots.
    pub fn outcome(&self, end: KickEnd, pitch: &Pitch) -> KickOutcome {
        let team = self.robot.team;
        match end {
            KickEnd::Touched(robot) if robot == self.robot => KickOutcome::Neither,
            KickEnd::Touched(robot) if robot.team == team => KickOutcome::PassCompleted,
            KickEnd::Goal(scored) if scored == team => KickOutcome::ShotOnTarget { stopped_by: None },
            _ if self.is_at_goal(pitch, 0.0) => KickOutcome::ShotOnTarget {
                stopped_by: if let KickEnd::Touched(robot) = end { Some(robot) } else { None },
            },
            _ if self.is_at_goal(pitch, BESIDE_GOAL_M) => KickOutcome::ShotOffTarget,
            KickEnd::Touched(robot) => KickOutcome::PassFailed { to: Some(robot) },
            KickEnd::Out => KickOutcome::PassFailed { to: None },
            KickEnd::Goal(_) | KickEnd::Stopped => KickOutcome::Neither,
        }
    }
}

/// How the flight of a kicked ball ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KickEnd {
    /// This robot touched the ball next. It may be the kicker.
    Touched(RobotId),
    /// The ball left the pitch.
    Out,
    /// The ball went into a goal, for this team.
    Goal(Team),
    /// Play was stopped for another reason, or the match ended.
    Stopped,
}

/// The result of a kick.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KickOutcome {
    /// A pass that a team-mate touched next.
    PassCompleted,
    /// A pass that an opponent touched next, or that left the pitch.
    PassFailed {
        /// The opponent. `None` if the ball left the pitch.
        to: Option<RobotId>,
    },
    /// A goal, or a shot that would have been one.
    ShotOnTarget {
        /// The opponent that touched the ball next, if one did.
        stopped_by: Option<RobotId>,
    },
    /// A shot that misses the goal.
    ShotOffTarget,
    /// Neither a pass nor a shot: the kicker touched the ball again, or play was stopped.
    Neither,
}

/// Follows the ball from kick to kick.
#[derive(Clone, Debug, Default)]
pub struct KickFollower {
    pitch: Pitch,
    rolling: Rolling,
    open: Option<StruckKick>,
}

impl KickFollower {
    /// Creates a follower for matches of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        let rolling = scenario.ball.unwrap_or_default().rolling;
        Self { pitch: scenario.field.clone(), rolling, open: None }
    }

    /// Returns the pitch of the match.
    pub fn pitch(&self) -> &Pitch {
        &self.pitch
    }

    /// Reads the next cycle and returns the kicks that ended in it.
    pub fn look(&mut self, cycle: &Observed) -> Vec<(StruckKick, KickEnd)> {
        let mut ended = Vec::new();
        for event in cycle.events {
            match event {
                MatchEvent::Kick { robot, direction: Some(direction), launch_speed_mps: Some(speed), .. } => {
                    self.touched(cycle, *robot, &mut ended);
                    ended.extend(self.open.take().map(|kick| (kick, KickEnd::Touched(*robot))));
                    self.open = self.struck(cycle, *robot, *direction, *speed);
                }
                MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => {
                    self.touched(cycle, *robot, &mut ended);
                }
                MatchEvent::BallOut { .. } => ended.extend(self.open.take().map(|kick| (kick, KickEnd::Out))),
                MatchEvent::Goal { team, .. } => {
                    ended.extend(self.open.take().map(|kick| (kick, KickEnd::Goal(*team))));
                }
                _ => {}
            }
        }
        if cycle.state != GameState::Playing {
            ended.extend(self.finish());
        }
        ended
    }

    /// Ends the kick whose ball is still rolling, if any, because the match is over.
    pub fn finish(&mut self) -> Option<(StruckKick, KickEnd)> {
        self.open.take().map(|kick| (kick, KickEnd::Stopped))
    }

    fn touched(&mut self, cycle: &Observed, robot: RobotId, ended: &mut Vec<(StruckKick, KickEnd)>) {
        let is_other = |kick: &mut StruckKick| kick.robot != robot || cycle.time_s - kick.time_s > SAME_KICK_S;
        ended.extend(self.open.take_if(is_other).map(|kick| (kick, KickEnd::Touched(robot))));
    }

    fn struck(&self, cycle: &Observed, robot: RobotId, direction: f32, speed_mps: f32) -> Option<StruckKick> {
        let position_m = cycle.ball_m?;
        let own_end = cycle.own_end(robot.team);
        let reach_m = self.rolling.distance(speed_mps);
        let away_m = |end: End| {
            let place = crossing(&self.pitch, position_m, direction, end)?;
            (place.distance(position_m) < reach_m).then_some(place.y.abs())
        };
        let (at_goal_m, at_own_goal_m) = (away_m(own_end.opposite()), away_m(own_end));
        Some(StruckKick { robot, time_s: cycle.time_s, position_m, speed_mps, at_goal_m, at_own_goal_m })
    }
}

/// Returns the point where a ball from `from` in `direction` (radians, pitch frame) crosses the goal line at `end`, m.
fn crossing(pitch: &Pitch, from: Vec2, direction: f32, end: End) -> Option<Vec2> {
    let along = Vec2::new(ops::cos(direction), ops::sin(direction));
    let way_m = (end.sign() * pitch.half_length() - from.x) / along.x;
    (way_m.is_finite() && way_m > 0.0).then(|| from + way_m * along)
}

/// Returns a kick at 2 m/s in `direction` (radians, pitch frame), for tests.
#[cfg(test)]
pub(in crate::record) fn kick(robot: RobotId, direction: f32) -> MatchEvent {
    MatchEvent::Kick {
        robot,
        kick_type: naoisis_core::kick_geometry::KickType::LeftStraight,
        speed: Some(1.0),
        result: naoisis_core::events::KickResult::Kicked,
        reason: None,
        direction: Some(direction),
        launch_speed_mps: Some(2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_crosses_the_goal_line_that_it_rolls_to() {
        let pitch = Pitch::default();
        // At 45° from (1, 0): 2 m ahead and 2 m to the side.
        let place = crossing(&pitch, Vec2::X, core::f32::consts::FRAC_PI_4, End::PositiveX).unwrap();
        assert!(place.abs_diff_eq(Vec2::new(3.0, 2.0), 1e-5));
        assert_eq!(crossing(&pitch, Vec2::X, core::f32::consts::FRAC_PI_4, End::NegativeX), None);
    }

    #[test]
    fn a_kick_is_a_pass_a_shot_or_neither() {
        let pitch = Pitch::default();
        let post_m = pitch.goal.width_m / 2.0;
        let [blue2, blue3, pink1, pink2] = [(Team::Blue, 2), (Team::Blue, 3), (Team::Pink, 1), (Team::Pink, 2)]
            .map(|(team, id)| RobotId::new(team, id));
        let outcome = |at_goal_m: Option<f32>, end: KickEnd| {
            let kick = StruckKick {
                robot: blue2,
                time_s: 0.0,
                position_m: Vec2::ZERO,
                speed_mps: 2.0,
                at_goal_m,
                at_own_goal_m: None,
            };
            kick.outcome(end, &pitch)
        };
        let [inside, beside, wide] = [post_m - 0.01, post_m + 0.49, post_m + 0.51].map(Some);
        let saved = KickOutcome::ShotOnTarget { stopped_by: Some(pink1) };
        let on_target = KickOutcome::ShotOnTarget { stopped_by: None };
        for (at_goal_m, end, expected) in [
            (inside, KickEnd::Touched(pink1), saved),
            (inside, KickEnd::Touched(pink2), KickOutcome::ShotOnTarget { stopped_by: Some(pink2) }),
            (inside, KickEnd::Stopped, on_target),
            (None, KickEnd::Goal(Team::Blue), on_target),
            (beside, KickEnd::Touched(pink1), KickOutcome::ShotOffTarget),
            (beside, KickEnd::Out, KickOutcome::ShotOffTarget),
            (wide, KickEnd::Out, KickOutcome::PassFailed { to: None }),
            (None, KickEnd::Touched(pink2), KickOutcome::PassFailed { to: Some(pink2) }),
            (None, KickEnd::Touched(blue3), KickOutcome::PassCompleted),
            (inside, KickEnd::Touched(blue3), KickOutcome::PassCompleted),
            (inside, KickEnd::Touched(blue2), KickOutcome::Neither),
            (None, KickEnd::Goal(Team::Pink), KickOutcome::Neither),
            (None, KickEnd::Stopped, KickOutcome::Neither),
        ] {
            assert_eq!(outcome(at_goal_m, end), expected, "{at_goal_m:?} {end:?}");
        }
    }
}
