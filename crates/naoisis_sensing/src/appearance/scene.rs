//! The state of the pitch at one instant, from which all sensors and pictures are computed.

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;
use serde::{Deserialize, Serialize};

use super::posing::{Limb, about_x, about_y, world_from_standing};
use super::stride::Stride;
use naoisis_core::ball::BallLook;
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::kick_geometry::Side;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{Markings, Pitch, Post};
use naoisis_core::robot::body::{Body, BodyBox};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::RobotId;

/// The state of the pitch at one instant, pitch frame. As a resource, it is the state that the sensors measure in this cycle.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Scene {
    /// The pitch.
    pub pitch: Pitch,
    /// The markings of the pitch.
    pub markings: Markings,
    /// The robots, in the order of their ids, without those that the referee has removed.
    pub robots: Vec<SceneRobot>,
    /// All posts, including those of the goals, in the order of their places.
    pub posts: Vec<ScenePost>,
    /// The ball, if there is one.
    pub ball: Option<SceneBall>,
    /// Further balls of a training.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more_balls: Vec<SceneBall>,
}

/// A robot on the pitch.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SceneRobot {
    /// Its id.
    pub id: RobotId,
    /// Its pose.
    pub pose: Pose,
    /// The unit vector along which it faces.
    pub forward: Vec2,
    /// Its posture: upright, lying or in between.
    pub posture: Posture,
    /// Its head angles.
    pub head: HeadAngles,
    /// The motion of its limbs.
    pub stride: Stride,
    /// Its body, standing.
    pub body: Body,
    /// The boxes of its body in its posture: torso and base.
    pub boxes: [BodyBox; 2],
    /// The greatest distance of a point of its boxes from its origin, on the ground, m.
    pub reach: f32,
}

/// A post and its position.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ScenePost {
    /// Its place, m, pitch frame.
    pub position: Vec2,
    /// Its cylinder and colour.
    pub post: Post,
}

/// The ball.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SceneBall {
    /// Its place on the ground, m, pitch frame.
    pub position: Vec2,
    /// Its radius, m.
    pub radius: f32,
    /// Height of its lowest point above the ground, m.
    pub height: f32,
    /// Its colours.
    #[reflect(default)]
    #[serde(default, skip_serializing_if = "BallLook::is_orange")]
    pub look: BallLook,
}

impl SceneBall {
    /// An orange ball on the ground.
    pub fn on_ground(position: Vec2, radius: f32) -> SceneBall {
        SceneBall { position, radius, height: 0.0, look: BallLook::Orange }
    }

    /// Its centre, m.
    pub fn centre(&self) -> Vec3 {
        self.position.extend(self.radius + self.height)
    }
}

impl Default for Scene {
    /// The default pitch without goals, robots and ball.
    fn default() -> Self {
        let pitch = Pitch::default();
        let markings = Markings::new(&pitch);
        Self { markings, pitch, robots: Vec::new(), posts: Vec::new(), ball: None, more_balls: Vec::new() }
    }
}

impl Scene {
    /// A pitch with its goals, without robots and ball.
    pub fn empty(pitch: Pitch) -> Self {
        let posts = pitch.goal_posts().map(|post| ScenePost { position: post.position, post: post.into() });
        Self { markings: Markings::new(&pitch), pitch, posts: posts.to_vec(), ..Self::default() }
    }

    /// All balls, the first first.
    pub fn balls(&self) -> impl Iterator<Item = &SceneBall> {
        self.ball.iter().chain(&self.more_balls)
    }

    /// The robot with this id, if it is on the pitch.
    pub fn robot(&self, id: RobotId) -> Option<&SceneRobot> {
        self.robots.iter().find(|robot| robot.id == id)
    }

    /// Sets the pitch and its markings.
    pub(super) fn set_pitch(&mut self, pitch: &Pitch) {
        if self.pitch != *pitch {
            self.pitch.clone_from(pitch);
            self.markings = Markings::new(pitch);
        }
    }
}

impl SceneRobot {
    /// A robot with this body that stands still at `pose`.
    pub fn standing(id: RobotId, pose: Pose, body: Body) -> Self {
        Self {
            id,
            pose,
            forward: unit(pose.heading),
            posture: Posture::Upright,
            head: HeadAngles::default(),
            stride: Stride::default(),
            body,
            boxes: [body.torso, body.base],
            reach: body.torso.reach().max(body.base.reach()),
        }
    }

    /// The robot in another posture.
    #[must_use]
    pub fn in_posture(self, posture: Posture) -> Self {
        let Body { torso, base, .. } = self.body.in_posture(posture);
        Self { posture, boxes: [torso, base], reach: torso.reach().max(base.reach()), ..self }
    }

    /// The transform of its body: standing, lying or in the air.
    pub fn world_from_robot(&self) -> Affine3A {
        world_from_body(self.pose, self.posture, &self.body)
    }

    /// The transforms of its limbs, indexed by [`Limb`].
    pub fn world_from_limbs(&self) -> [Affine3A; Limb::COUNT] {
        self.stride.joints(self.id, self.head, &self.body).world_from_limbs(&self.body, self.world_from_robot())
    }

    /// Whether the robot stands on its feet.
    pub fn is_upright(&self) -> bool {
        self.world_from_robot().matrix3.z_axis.z > 0.999
    }
}

/// The transform of a robot with this posture at `pose`.
pub fn world_from_body(pose: Pose, posture: Posture, body: &Body) -> Affine3A {
    let middle_m = body.height_m / 2.0;
    // The height of the middle of the body: lying on its face, and lying on its side.
    let lying_middle_m = body.lying_height_m / 2.0;
    let aside_middle_m = body.torso.half_width_m;
    let standing = world_from_standing(pose);
    // Tilted about the middle of the body, which is then at `middle`.
    let tilted = |tilt: Mat3, middle: Vec3| {
        standing * Affine3A::from_mat3_translation(tilt, middle) * Affine3A::from_translation(Vec3::NEG_Z * middle_m)
    };
    let lying = |on: LyingOn, share: f32| {
        let height = lying_middle_m + (1.0 - share) * (middle_m - lying_middle_m);
        let forward = if on == LyingOn::Front { share } else { -share };
        tilted(about_y(forward * FRAC_PI_2), Vec3::Z * height)
    };
    match posture {
        Posture::Upright => standing,
        Posture::Fallen { on, .. } => lying(on, 1.0),
        Posture::GettingUp { on, cycles_left, .. } => lying(on, (cycles_left as f32 / GETTING_UP_CYCLES).min(1.0)),
        Posture::Diving { side, .. } => {
            let sign = if side == Side::Left { 1.0 } else { -1.0 };
            tilted(about_x(-sign * FRAC_PI_2), Vec3::new(0.0, sign * middle_m, aside_middle_m))
        }
    }
}

/// The number of cycles at the end of getting up in which a robot straightens itself.
const GETTING_UP_CYCLES: f32 = 30.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fallen_robot_lies_before_or_behind_its_place_and_a_diver_beside_its_place() {
        let pose = Pose::new(1.0, 2.0, 0.0);
        let head = |posture| world_from_body(pose, posture, &Body::default()).transform_point3(Vec3::Z * 0.55);
        assert!(head(Posture::Upright).abs_diff_eq(Vec3::new(1.0, 2.0, 0.55), 1e-6));
        // Half of the body lies before the place, which is 0.55 - 0.2865 = 0.2635 m.
        let fallen = head(Posture::fallen(LyingOn::Front));
        assert!(fallen.abs_diff_eq(Vec3::new(1.2635, 2.0, 0.075), 1e-4), "{fallen}");
        let on_its_back = head(Posture::fallen(LyingOn::Back));
        assert!(on_its_back.abs_diff_eq(Vec3::new(0.7365, 2.0, 0.075), 1e-4), "{on_its_back}");
        let dive = Posture::Diving { side: Side::Right, cycles_left: 3, blocks: true };
        assert!((head(dive) - Vec3::new(1.0, 1.45, 0.15)).length() < 1e-4, "{}", head(dive));
    }
}
