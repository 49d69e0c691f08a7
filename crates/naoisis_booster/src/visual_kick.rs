//! The visual kick: a mode in which the robot itself walks to the ball and kicks it.
//!
//! The maker says that it works from 0.2 to 4.0 m, and that a message on `/kick_ball` tells it direction and power; its walk is not printed, so
//! the one here is a guess. Without a direction, the robot turns to the ball and kicks straight on.

use bevy::prelude::*;

use naoisis_core::geometry::{Pose, angle_of, unit, wrap_angle};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::kick::{KickRequest, KickSettings};

/// The furthest ball that the robot goes to, m (Booster).
const FURTHEST_M: f32 = 4.0;
/// How long the robot goes to a ball that it no longer sees, cycles.
const REMEMBERED_CYCLES: u32 = 30;
/// Greatest speed on the way, m/s. A guess.
const FASTEST_MPS: f32 = 0.7;
/// Greatest speed of turning, rad/s. A guess.
const FASTEST_RADPS: f32 = 1.2;
/// Velocity for each metre that is left, 1/s. A guess.
const GAIN_PER_S: f32 = 2.0;
/// How much further from the ball the robot stays while it faces elsewhere, m. A guess.
const AROUND_M: f32 = 0.3;
/// Greatest angle between the kick and its wanted direction, radians. A guess.
const PRECISION: f32 = 0.15;

/// The power of the fastest kick; half of it is a kick half as fast. A guess: the interface of agents says 1 to 10.
const MOST_POWER: f32 = 10.0;
/// The time from seeing the ball until the wind-up begins, s. A guess.
const LATENCY_S: f32 = 0.1;
/// How long the robot waits for a kick to begin before it kicks again, cycles.
const BEGINNING_CYCLES: u32 = 10;

/// What the visual kick knows.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Aim {
    /// Where the ball shall go: a heading in the frame of odometry, radians.
    pub heading: Option<f32>,
    /// The speed of the ball, as a share of the fastest kick's; `None` for the fastest.
    pub speed: Option<f32>,
    /// How long the last kick may still take to begin, cycles.
    begins_within: u32,
    /// The last ball seen, in the frame of odometry, m, and the cycles since then.
    ball: Option<(Vec2, u32)>,
}

impl Aim {
    /// A kick to `heading`, radians, frame of odometry, with this power.
    pub fn new(heading: f32, power: f32) -> Self {
        // A message that says nothing of power has zero.
        let speed = (power > 0.0).then_some((power / MOST_POWER).min(1.0));
        Self { heading: Some(heading), speed, ..default() }
    }

    /// Keeps where the ball is that a robot at `odometry` sees at `ball`, m, robot frame.
    fn see(&mut self, ball: Option<Vec2>, odometry: Pose) {
        self.ball = match (ball, self.ball) {
            (Some(ball), _) => Some((odometry.transform_point(ball), 0)),
            (None, Some((ball, cycles))) if cycles < REMEMBERED_CYCLES => Some((ball, cycles + 1)),
            _ => None,
        };
    }

    /// Keeps what the robot sees during a kick, which has begun.
    pub fn see_in_kick(&mut self, ball: Option<Vec2>, odometry: Pose) {
        self.begins_within = 0;
        self.see(ball, odometry);
    }

    /// Takes direction and power from `other`.
    pub fn turn_to(&mut self, other: Aim) {
        (self.heading, self.speed) = (other.heading, other.speed);
    }
}

/// Velocity (m/s, m/s, rad/s) and kick of a robot at `odometry`, which walks with `velocity` and sees the ball at `ball`, m, robot frame. In a
/// kick in walking it keeps its velocity.
pub fn act(
    aim: &mut Aim,
    ball: Option<Vec2>,
    odometry: Pose,
    velocity: Vec3,
    kicks: &KickSettings,
) -> (Vec3, Option<KickRequest>) {
    aim.see(ball, odometry);
    let Some((ball, _)) = aim.ball else { return (Vec3::ZERO, None) };
    let ball = odometry.inverse_transform_point(ball);
    if ball.length() > FURTHEST_M {
        return (Vec3::ZERO, None);
    }
    let Some((kick, spot, aims_within)) = choose(kicks, ball) else { return (Vec3::ZERO, None) };
    // Without a direction, straight on: with the ball before the foot that kicks.
    let straight_on = || angle_of(ball - Vec2::new(0.0, spot.y));
    let wanted = aim.heading.map_or_else(straight_on, |heading| wrap_angle(heading - odometry.heading));
    let going_on = if kicks.is_in_walk(kick) { velocity } else { Vec3::ZERO };
    let struck = ball - going_on.truncate() * (kicks.wind_up_of_s(kick) + LATENCY_S);
    let is_within_reach = kicks.geometry(kick).is_some_and(|geometry| geometry.admits(struck));
    if is_within_reach && wanted.abs() <= aims_within + PRECISION {
        let is_asked = aim.begins_within > 0;
        aim.begins_within = if is_asked { aim.begins_within - 1 } else { BEGINNING_CYCLES };
        let speed = aim.speed.unwrap_or(1.0);
        let request =
            KickRequest { direction: wanted.clamp(-aims_within, aims_within), ..KickRequest::new(kick, speed) };
        return (going_on, (!is_asked).then_some(request));
    }
    // The robot turns to the ball on its way, and beside it in the direction of the kick.
    let is_near = ball.length() < 0.8;
    let turn = if is_near { wanted } else { angle_of(ball) };
    // Around the ball as long as it is not behind it.
    let behind_m = spot.x + AROUND_M * turn.abs().min(1.0);
    let place = ball - unit(turn) * behind_m - Vec2::new(0.0, spot.y);
    let velocity = (place * GAIN_PER_S).clamp_length_max(FASTEST_MPS);
    (velocity.extend((turn * GAIN_PER_S).clamp(-FASTEST_RADPS, FASTEST_RADPS)), None)
}

/// The kick for a ball: `visual` if the robot has it, otherwise straight by the nearer foot; with the place of the ball that suits it best, m,
/// robot frame, and how far to either side it can be aimed, radians.
fn choose(kicks: &KickSettings, ball: Vec2) -> Option<(KickType, Vec2, f32)> {
    let visual = kicks.types().find(|kick| kick.name() == "visual");
    let straight = if ball.y > 0.0 { KickType::LeftStraight } else { KickType::RightStraight };
    let kick = visual.unwrap_or(straight);
    kicks.geometry(kick).map(|geometry| (kick, geometry.best_m, geometry.aims_within()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The kick of a robot that begins at the origin and moves exactly as the visual kick wants, the heading in which the ball leaves, and the
    /// time.
    fn kick_of(ball: Vec2, heading: Option<f32>) -> Option<(f32, f32)> {
        let (mut robot, mut velocity, mut aim) = (Pose::default(), Vec3::ZERO, Aim { heading, ..default() });
        for cycle in 0..600 {
            let seen = robot.inverse_transform_point(ball);
            let (next, kick) = act(&mut aim, Some(seen), robot, velocity, &KickSettings::default());
            velocity = next;
            if let Some(kick) = kick {
                return Some((wrap_angle(robot.heading + kick.direction), cycle as f32 / 30.0));
            }
            let step = velocity / 30.0;
            robot = robot.compose(Pose { position: step.truncate(), heading: step.z });
        }
        None
    }

    #[test]
    fn the_robot_walks_to_the_ball_and_kicks_it_in_the_wanted_direction() {
        for ball in [Vec2::new(2.0, 0.0), Vec2::new(1.0, 1.0), Vec2::new(0.3, -0.2), Vec2::new(-1.0, 0.5)] {
            for heading in [0.0, 0.6, -0.6] {
                let (left, time_s) = kick_of(ball, Some(heading)).unwrap();
                assert!(wrap_angle(left - heading).abs() < 0.2 && time_s < 12.0, "{ball} {heading}: {left} {time_s}");
            }
        }
        for ball in [Vec2::new(2.0, 0.0), Vec2::new(1.0, 1.0), Vec2::new(3.0, -2.0)] {
            let (left, _) = kick_of(ball, None).unwrap();
            assert!(wrap_angle(left - angle_of(ball)).abs() < 0.3, "{ball}: {left}");
        }
    }

    #[test]
    fn a_kick_is_asked_for_once_until_it_has_begun() {
        let (mut aim, kicks) = (Aim::default(), KickSettings::default());
        let spot = kicks.geometry(KickType::LeftStraight).unwrap().best_m;
        let asks = |aim: &mut Aim| act(aim, Some(spot), Pose::default(), Vec3::ZERO, &kicks).1.is_some();
        let asked: Vec<bool> = (0..4).map(|_| asks(&mut aim)).collect();
        assert_eq!(asked, [true, false, false, false]);
        aim.see_in_kick(Some(spot), Pose::default());
        assert!(asks(&mut aim), "the next kick waits for nothing");
    }

    #[test]
    fn the_power_is_a_share_of_the_fastest_kick_and_none_is_the_fastest() {
        let kicks = KickSettings::default();
        let spot = kicks.geometry(KickType::LeftStraight).unwrap().best_m;
        for (power, speed) in [(0.0, 1.0), (5.0, 0.5), (10.0, 1.0), (60.0, 1.0)] {
            let mut aim = Aim::new(0.0, power);
            let kick = act(&mut aim, Some(spot), Pose::default(), Vec3::ZERO, &kicks).1;
            assert_eq!(kick.map(|kick| kick.speed), Some(speed), "{power}");
        }
    }

    #[test]
    fn a_ball_too_far_away_or_long_out_of_sight_is_left_alone() {
        assert_eq!(kick_of(Vec2::new(4.5, 0.0), None), None);
        let (mut aim, kicks) = (Aim::default(), KickSettings::default());
        let mut moves = |ball| act(&mut aim, ball, Pose::default(), Vec3::ZERO, &kicks).0 != Vec3::ZERO;
        assert!(!moves(None) && moves(Some(Vec2::X)) && moves(None));
        assert!((0..REMEMBERED_CYCLES).filter(|_| moves(None)).count() < REMEMBERED_CYCLES as usize);
        assert!(!moves(None));
    }
}
