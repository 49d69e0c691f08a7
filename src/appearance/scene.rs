//! What there is to draw at one instant.

use bevy::math::{Affine3A, Mat3, Vec2, Vec3};
use core::f32::consts::FRAC_PI_2;

use super::posing::{JointAngles, about_x, about_y, world_from_standing};
use crate::geometry::Pose;
use crate::kick_geometry::Side;
use crate::pitch::{Pitch, Post};
use crate::robot::posture::Posture;
use crate::team::RobotId;

/// A robot to draw.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SceneRobot {
    /// Who it is.
    pub id: RobotId,
    /// Where it is: standing, lying or in the air.
    pub world_from_robot: Affine3A,
    /// How it holds its limbs.
    pub joints: JointAngles,
}

impl SceneRobot {
    /// Whether it stands on its feet.
    pub fn is_upright(&self) -> bool {
        self.world_from_robot.matrix3.z_axis.z > 0.999
    }

    /// A robot that stands at a pose.
    pub fn standing(id: RobotId, pose: Pose, joints: JointAngles) -> Self {
        Self { id, world_from_robot: world_from_standing(pose), joints }
    }
}

/// Everything that there is to draw at one instant, pitch frame, m.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct SceneDescription {
    /// The pitch.
    pub pitch: Pitch,
    /// The robots on it.
    pub robots: Vec<SceneRobot>,
    /// The posts, those of the goals included, and where they stand.
    pub posts: Vec<(Post, Vec2)>,
    /// The ball: where its centre is above the ground, and its radius.
    pub ball: Option<(Vec2, f32)>,
}

/// Where a robot is whose body is in this posture at a pose.
pub fn world_from_body(pose: Pose, posture: Posture) -> Affine3A {
    let standing = world_from_standing(pose);
    // Tilted by so much of a quarter turn, about the middle of the body, which then is so high above the ground.
    let tilted = |tilt: Mat3, middle: Vec3| {
        standing * Affine3A::from_mat3_translation(tilt, middle) * Affine3A::from_translation(Vec3::NEG_Z * MIDDLE_M)
    };
    let forward = |share: f32| {
        let height = LYING_MIDDLE_M + (1.0 - share) * (MIDDLE_M - LYING_MIDDLE_M);
        tilted(about_y(share * FRAC_PI_2), Vec3::Z * height)
    };
    match posture {
        Posture::Upright => standing,
        Posture::Fallen { .. } => forward(1.0),
        Posture::GettingUp { cycles_left, .. } => forward((cycles_left as f32 / GETTING_UP_CYCLES).min(1.0)),
        Posture::Diving { side, .. } => {
            let sign = if side == Side::Left { 1.0 } else { -1.0 };
            tilted(about_x(-sign * FRAC_PI_2), Vec3::new(0.0, sign * MIDDLE_M, LYING_ASIDE_MIDDLE_M))
        }
    }
}

/// Height of the middle of a standing body, m.
const MIDDLE_M: f32 = 0.287;
/// Height of the middle of a body that lies on its face, m.
const LYING_MIDDLE_M: f32 = 0.08;
/// Height of the middle of a body that lies on its side, m.
const LYING_ASIDE_MIDDLE_M: f32 = 0.15;
/// A robot that gets up straightens itself in the last cycles of that.
const GETTING_UP_CYCLES: f32 = 30.0;

impl SceneDescription {
    /// A pitch with its goals, and nothing on it.
    pub fn empty(pitch: Pitch) -> Self {
        let posts = pitch.goal_posts().map(|post| (post.into(), post.position)).to_vec();
        Self { pitch, robots: Vec::new(), posts, ball: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_fallen_lies_on_its_face_and_a_diver_beside_its_place() {
        let pose = Pose::new(1.0, 2.0, 0.0);
        let head = |posture| world_from_body(pose, posture).transform_point3(Vec3::Z * 0.55);
        assert!(head(Posture::Upright).abs_diff_eq(Vec3::new(1.0, 2.0, 0.55), 1e-6));
        // Half of the body lies before the place, which is 0.55 - 0.287 = 0.263 m.
        let fallen = head(Posture::Fallen { cycles: 3 });
        assert!(fallen.abs_diff_eq(Vec3::new(1.263, 2.0, 0.08), 1e-4), "{fallen}");
        let dive = Posture::Diving { side: Side::Right, cycles_left: 3, blocks: true };
        assert!((head(dive) - Vec3::new(1.0, 1.45, 0.15)).length() < 1e-4, "{}", head(dive));
    }
}
