//! The object that the mouse drags, and the place where it would be put.

use bevy::prelude::*;

use naoisis_core::ball::Rolling;
use naoisis_core::game::Intervention;
use naoisis_core::geometry::{Pose, angle_of};
use naoisis_core::team::RobotId;

/// The greatest speed of a kick by the mouse, m/s.
const FASTEST_KICK_MPS: f32 = 8.0;

/// A ray in the pitch frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sight {
    /// The origin, m.
    pub origin: Vec3,
    /// The direction.
    pub direction: Vec3,
}

impl Sight {
    /// Returns the point at this height, m; `None` if the ray does not reach it.
    pub fn at_height(&self, height: f32) -> Option<Vec2> {
        let along = (height - self.origin.z) / self.direction.z;
        (along.is_finite() && along > 0.0).then(|| (self.origin + along * self.direction).truncate())
    }

    /// Returns the height at which the ray passes nearest to a vertical axis, m, at most `highest_m`.
    pub fn height_at(&self, axis: Vec2, highest_m: f32) -> f32 {
        let level = self.direction.truncate();
        let along = (axis - self.origin.truncate()).dot(level) / level.length_squared();
        if along.is_finite() { (self.origin.z + along * self.direction.z).clamp(0.0, highest_m) } else { 0.0 }
    }
}

/// The object that the mouse drags.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Held {
    /// Moves a robot.
    Robot(RobotId),
    /// Turns a robot towards the mouse.
    RobotToTurn(RobotId),
    /// Moves the ball.
    Ball,
    /// Kicks the ball towards the mouse.
    BallToKick,
}

/// A drag that has started.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Grip {
    /// The object that is dragged.
    pub held: Held,
    /// Its pose, pitch frame.
    pub pose: Pose,
    /// The height of the point at which it was taken, m.
    pub height: f32,
    /// The offset from this point to its position, seen from above, m.
    pub offset: Vec2,
}

impl Grip {
    /// Starts a drag of something of height `height_m` along a ray. `None` near the horizon.
    pub fn new(held: Held, pose: Pose, height_m: f32, sight: &Sight) -> Option<Self> {
        let height = match held {
            Held::Robot(_) => sight.height_at(pose.position, height_m),
            _ => 0.0,
        };
        let offset = match held {
            Held::Robot(_) => pose.position - sight.at_height(height)?,
            _ => Vec2::ZERO,
        };
        Some(Self { held, pose, height, offset })
    }

    /// Returns the intervention of releasing the mouse at a ray, on a carpet of these half extents, m.
    pub fn release(&self, sight: &Sight, carpet: Vec2, rolling: Rolling) -> Option<Intervention> {
        let place = sight.at_height(self.height)? + self.offset;
        let on_carpet = place.clamp(-carpet, carpet);
        let away = place - self.pose.position;
        Some(match self.held {
            Held::Robot(robot) => Intervention::PlaceRobot { robot, pose: Pose { position: on_carpet, ..self.pose } },
            Held::RobotToTurn(robot) => {
                Intervention::PlaceRobot { robot, pose: Pose { heading: angle_of(away), ..self.pose } }
            }
            Held::Ball => Intervention::PlaceBall { position_m: on_carpet, velocity_mps: Vec2::ZERO },
            Held::BallToKick => {
                let speed = rolling.speed_for_distance(away.length()).min(FASTEST_KICK_MPS);
                let velocity_mps = speed * away.normalize_or_zero();
                Intervention::PlaceBall { position_m: self.pose.position, velocity_mps }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::team::Team;

    const ROBOT: RobotId = RobotId::new(Team::Blue, 1);
    const CARPET: Vec2 = Vec2::new(3.7, 2.7);

    /// A ray to `point` from 4 m above and 4 m away.
    fn to(point: Vec3) -> Sight {
        let origin = Vec3::new(0.0, -4.0, 4.0);
        Sight { origin, direction: (point - origin).normalize() }
    }

    fn released(held: Held, at: Pose, from: Vec3, towards: Vec3) -> Intervention {
        let grip = Grip::new(held, at, 0.57, &to(from)).unwrap();
        grip.release(&to(towards), CARPET, Rolling::ExponentialPerS(0.5)).unwrap()
    }

    #[test]
    fn a_robot_taken_at_the_head_goes_where_its_head_goes() {
        let at = Pose::new(0.0, 1.0, 0.3);
        let Intervention::PlaceRobot { robot, pose } =
            released(Held::Robot(ROBOT), at, Vec3::new(0.0, 1.0, 0.5), Vec3::new(1.0, 0.5, 0.5))
        else {
            panic!("a robot")
        };
        assert_eq!((robot, pose.heading), (ROBOT, 0.3));
        assert!(pose.position.abs_diff_eq(Vec2::new(1.0, 0.5), 1e-4), "{}", pose.position);
    }

    #[test]
    fn nothing_is_put_beside_the_carpet() {
        let Intervention::PlaceBall { position_m, velocity_mps } =
            released(Held::Ball, Pose::default(), Vec3::ZERO, Vec3::new(9.0, 1.0, 0.0))
        else {
            panic!("the ball")
        };
        assert!(position_m.abs_diff_eq(Vec2::new(3.7, 1.0), 1e-4), "{position_m}");
        assert_eq!(velocity_mps, Vec2::ZERO);
    }

    #[test]
    fn a_robot_turns_to_the_mouse() {
        let at = Pose::new(1.0, 1.0, 0.0);
        let turned = released(Held::RobotToTurn(ROBOT), at, Vec3::new(1.0, 1.0, 0.3), Vec3::new(1.0, 2.0, 0.0));
        let Intervention::PlaceRobot { pose, .. } = turned else { panic!("a robot") };
        assert_eq!(pose.position, at.position);
        assert_abs_diff_eq!(pose.heading, core::f32::consts::FRAC_PI_2, epsilon = 1e-4);
    }

    #[test]
    fn a_kicked_ball_is_as_fast_as_it_must_be_to_rest_at_the_mouse() {
        let at = Pose::new(0.5, 0.0, 0.0);
        let kicked = released(Held::BallToKick, at, Vec3::new(0.5, 0.0, 0.0), Vec3::new(2.5, 0.0, 0.0));
        let Intervention::PlaceBall { position_m, velocity_mps } = kicked else { panic!("the ball") };
        assert_eq!(position_m, at.position);
        // 2 m with a drag of 0.5 /s are 1 m/s, and the speed at which it counts as at rest.
        assert!(velocity_mps.abs_diff_eq(Vec2::new(1.001, 0.0), 1e-4), "{velocity_mps}");
    }

    #[test]
    fn nothing_is_put_into_the_sky() {
        let grip = Grip::new(Held::Ball, Pose::default(), 0.0, &to(Vec3::ZERO)).unwrap();
        let up = Sight { origin: Vec3::Z, direction: Vec3::new(1.0, 0.0, 0.1) };
        assert_eq!(grip.release(&up, CARPET, Rolling::default()), None);
        let level = Sight { origin: Vec3::Z, direction: Vec3::X };
        assert_eq!(Grip::new(Held::Robot(ROBOT), Pose::default(), 0.57, &level), None);
    }
}
