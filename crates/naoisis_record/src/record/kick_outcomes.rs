//! What becomes of kicks: where each was aimed, and who touched the ball next, from the [records of the cycles](CycleRecord).

use bevy::math::ops;
use bevy::prelude::*;

use naoisis_core::ball::Rolling;
use naoisis_core::events::{CollisionPartner, MatchEvent};
use naoisis_core::game::GameState;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Whoever touches the ball so soon after its own kick is still kicking, s.
const SAME_KICK_S: f64 = 0.5;

/// A kick that struck the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StruckKick {
    /// Who kicked.
    pub robot: RobotId,
    /// When, s since the start of the match.
    pub time_s: f64,
    /// From where, m, pitch frame.
    pub position_m: Vec2,
    /// How fast the ball left, m/s.
    pub speed_mps: f32,
    /// How far beside the middle of the opponents' goal it would cross the line, m; none where it would not get there.
    pub at_goal_m: Option<f32>,
    /// The same of the own goal.
    pub at_own_goal_m: Option<f32>,
}

impl StruckKick {
    /// Whether the ball would pass between the posts of the opponents' goal, or so near beside them, m.
    pub fn is_at_goal(&self, pitch: &Pitch, beside_m: f32) -> bool {
        self.at_goal_m.is_some_and(|away_m| away_m < pitch.goal.width_m / 2.0 + beside_m)
    }

    /// Whether the ball would pass between the posts of the own goal.
    pub fn is_at_own_goal(&self, pitch: &Pitch) -> bool {
        self.at_own_goal_m.is_some_and(|away_m| away_m < pitch.goal.width_m / 2.0)
    }
}

/// What ended the way of a kicked ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KickEnd {
    /// This robot touched it next, the kicker itself for instance.
    Touched(RobotId),
    /// It was out.
    Out,
    /// It was a goal for this team.
    Goal(Team),
    /// Play was stopped for another reason, or the match is over.
    Stopped,
}

/// Follows the ball from kick to kick.
#[derive(Clone, Debug)]
pub struct KickFollower {
    pitch: Pitch,
    rolling: Rolling,
    open: Option<StruckKick>,
}

impl KickFollower {
    /// A follower for the matches of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        let rolling = scenario.ball.unwrap_or_default().rolling;
        Self { pitch: scenario.field.clone(), rolling, open: None }
    }

    /// The pitch that is played on.
    pub fn pitch(&self) -> &Pitch {
        &self.pitch
    }

    /// Looks at the next cycle: the kicks that ended in it, and how.
    pub fn look(&mut self, record: &CycleRecord) -> Vec<(StruckKick, KickEnd)> {
        let mut ended = Vec::new();
        for event in &record.events {
            match event {
                MatchEvent::Kick { robot, direction: Some(direction), launch_speed_mps: Some(speed), .. } => {
                    self.touched(record, *robot, &mut ended);
                    ended.extend(self.open.take().map(|kick| (kick, KickEnd::Touched(*robot))));
                    self.open = self.struck(record, *robot, *direction, *speed);
                }
                MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => {
                    self.touched(record, *robot, &mut ended);
                }
                MatchEvent::BallOut { .. } => ended.extend(self.open.take().map(|kick| (kick, KickEnd::Out))),
                MatchEvent::Goal { team, .. } => {
                    ended.extend(self.open.take().map(|kick| (kick, KickEnd::Goal(*team))));
                }
                _ => {}
            }
        }
        if record.game.state != GameState::Playing {
            ended.extend(self.finish());
        }
        ended
    }

    /// The match is over: the kick whose ball still rolls, if there is one.
    pub fn finish(&mut self) -> Option<(StruckKick, KickEnd)> {
        self.open.take().map(|kick| (kick, KickEnd::Stopped))
    }

    fn touched(&mut self, record: &CycleRecord, robot: RobotId, ended: &mut Vec<(StruckKick, KickEnd)>) {
        let is_other = |kick: &mut StruckKick| kick.robot != robot || record.time_s - kick.time_s > SAME_KICK_S;
        ended.extend(self.open.take_if(is_other).map(|kick| (kick, KickEnd::Touched(robot))));
    }

    fn struck(&self, record: &CycleRecord, robot: RobotId, direction: f32, speed_mps: f32) -> Option<StruckKick> {
        let position_m = record.ball?.position_m.truncate();
        let own_end = record.game.own_end(robot.team);
        let reach_m = self.rolling.distance(speed_mps);
        let away_m = |end: End| {
            let place = crossing(&self.pitch, position_m, direction, end)?;
            (place.distance(position_m) < reach_m).then_some(place.y.abs())
        };
        let (at_goal_m, at_own_goal_m) = (away_m(own_end.opposite()), away_m(own_end));
        Some(StruckKick { robot, time_s: record.time_s, position_m, speed_mps, at_goal_m, at_own_goal_m })
    }
}

/// Where a ball that leaves a place in a direction (radians, pitch frame) crosses the goal line at an end, m.
fn crossing(pitch: &Pitch, from: Vec2, direction: f32, end: End) -> Option<Vec2> {
    let along = Vec2::new(ops::cos(direction), ops::sin(direction));
    let way_m = (end.sign() * pitch.half_length() - from.x) / along.x;
    (way_m.is_finite() && way_m > 0.0).then(|| from + way_m * along)
}

/// A kick at 2 m/s in this direction (radians, pitch frame), for tests.
#[cfg(test)]
pub(super) fn kick(robot: RobotId, direction: f32) -> MatchEvent {
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
        // At 45° from (1, 0): 2 m ahead, and 2 m aside.
        let place = crossing(&pitch, Vec2::X, core::f32::consts::FRAC_PI_4, End::PositiveX).unwrap();
        assert!(place.abs_diff_eq(Vec2::new(3.0, 2.0), 1e-5));
        assert_eq!(crossing(&pitch, Vec2::X, core::f32::consts::FRAC_PI_4, End::NegativeX), None);
    }
}
