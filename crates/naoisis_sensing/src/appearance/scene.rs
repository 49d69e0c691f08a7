//! What there is on the pitch at one instant. All sensors and all pictures are of it.

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;
use serde::{Deserialize, Serialize};

use super::posing::{Limb, about_x, about_y, world_from_standing};
use super::stride::Stride;
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::kick_geometry::Side;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{Markings, Pitch, Post};
use naoisis_core::robot::body::{Body, BodyBox};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;

/// What there is on the pitch at one instant, pitch frame. As a resource, it is what there is to sense in this cycle.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Scene {
    /// The sizes of carpet, pitch and goals, and the colours of the goals.
    pub pitch: Pitch,
    /// What is painted on it.
    pub markings: Markings,
    /// The robots, ordered by their ids. Those that the referee has taken off the pitch are not among them, but they
    /// sense the others.
    pub robots: Vec<SceneRobot>,
    /// The posts, those of the goals included, ordered by their places.
    pub posts: Vec<ScenePost>,
    /// The ball, if there is one.
    pub ball: Option<SceneBall>,
}

/// A robot on the pitch.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SceneRobot {
    /// Who it is.
    pub id: RobotId,
    /// Where it is.
    pub pose: Pose,
    /// The unit vector that it faces along.
    pub forward: Vec2,
    /// How its body is: upright, lying or on the way.
    pub posture: Posture,
    /// Where its head looks.
    pub head: HeadAngles,
    /// How its limbs are moving.
    pub stride: Stride,
    /// Its body on its feet.
    pub body: Body,
    /// The room that its body takes, as it stands or lies: torso and base.
    pub boxes: [BodyBox; 2],
    /// The greatest distance of a point of its boxes from its origin, on the ground, m.
    pub reach: f32,
}

/// A post, and where it stands.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ScenePost {
    /// Where it stands, m, pitch frame.
    pub position: Vec2,
    /// Its cylinder and colour.
    pub post: Post,
}

/// The ball.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SceneBall {
    /// Its centre above the ground, m, pitch frame.
    pub position: Vec2,
    /// Its radius, m.
    pub radius: f32,
}

impl SceneBall {
    /// Its centre: it lies on the ground.
    pub fn centre(&self) -> Vec3 {
        self.position.extend(self.radius)
    }
}

impl Default for Scene {
    /// The usual pitch, without goals and with nothing on it.
    fn default() -> Self {
        let pitch = Pitch::default();
        Self { markings: Markings::new(&pitch), pitch, robots: Vec::new(), posts: Vec::new(), ball: None }
    }
}

impl Scene {
    /// A pitch with its goals, and nothing on it.
    pub fn empty(pitch: Pitch) -> Self {
        let posts = pitch.goal_posts().map(|post| ScenePost { position: post.position, post: post.into() });
        Self { markings: Markings::new(&pitch), pitch, robots: Vec::new(), posts: posts.to_vec(), ball: None }
    }

    /// The robot with this id, if it is on the pitch.
    pub fn robot(&self, id: RobotId) -> Option<&SceneRobot> {
        self.robots.iter().find(|robot| robot.id == id)
    }

    /// Takes over a pitch, and what is painted on it.
    pub(super) fn set_pitch(&mut self, pitch: &Pitch) {
        if self.pitch != *pitch {
            self.pitch.clone_from(pitch);
            self.markings = Markings::new(pitch);
        }
    }
}

impl SceneRobot {
    /// A robot that stands upright and still at a pose, with this body.
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

    /// The robot in this posture instead.
    #[must_use]
    pub fn in_posture(self, posture: Posture) -> Self {
        let Body { torso, base, .. } = self.body.in_posture(posture);
        Self { posture, boxes: [torso, base], ..self }
    }

    /// Where its body is: standing, lying or in the air.
    pub fn world_from_robot(&self) -> Affine3A {
        world_from_body(self.pose, self.posture, &self.body)
    }

    /// Where its limbs are, each at the index of its [`Limb`].
    pub fn world_from_limbs(&self) -> [Affine3A; Limb::COUNT] {
        self.stride.joints(self.id, self.head, &self.body).world_from_limbs(&self.body, self.world_from_robot())
    }

    /// Whether it stands on its feet.
    pub fn is_upright(&self) -> bool {
        self.world_from_robot().matrix3.z_axis.z > 0.999
    }
}

/// Where a robot is whose body is in this posture at a pose.
pub fn world_from_body(pose: Pose, posture: Posture, body: &Body) -> Affine3A {
    let middle_m = body.height_m / 2.0;
    // On its face its back is as high as a body that lies; on its side, its upper arm.
    let lying_middle_m = body.lying_height_m / 2.0;
    let aside_middle_m = body.torso.half_width_m;
    let standing = world_from_standing(pose);
    // Tilted by so much of a quarter turn, about the middle of the body, which then is so high above the ground.
    let tilted = |tilt: Mat3, middle: Vec3| {
        standing * Affine3A::from_mat3_translation(tilt, middle) * Affine3A::from_translation(Vec3::NEG_Z * middle_m)
    };
    let forward = |share: f32| {
        let height = lying_middle_m + (1.0 - share) * (middle_m - lying_middle_m);
        tilted(about_y(share * FRAC_PI_2), Vec3::Z * height)
    };
    match posture {
        Posture::Upright => standing,
        Posture::Fallen { .. } => forward(1.0),
        Posture::GettingUp { cycles_left, .. } => forward((cycles_left as f32 / GETTING_UP_CYCLES).min(1.0)),
        Posture::Diving { side, .. } => {
            let sign = if side == Side::Left { 1.0 } else { -1.0 };
            tilted(about_x(-sign * FRAC_PI_2), Vec3::new(0.0, sign * middle_m, aside_middle_m))
        }
    }
}

/// A robot that gets up straightens itself in the last cycles of that.
const GETTING_UP_CYCLES: f32 = 30.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_fallen_lies_on_its_face_and_a_diver_beside_its_place() {
        let pose = Pose::new(1.0, 2.0, 0.0);
        let head = |posture| world_from_body(pose, posture, &Body::default()).transform_point3(Vec3::Z * 0.55);
        assert!(head(Posture::Upright).abs_diff_eq(Vec3::new(1.0, 2.0, 0.55), 1e-6));
        // Half of the body lies before the place, which is 0.55 - 0.2865 = 0.2635 m.
        let fallen = head(Posture::Fallen { cycles: 3 });
        assert!(fallen.abs_diff_eq(Vec3::new(1.2635, 2.0, 0.075), 1e-4), "{fallen}");
        let dive = Posture::Diving { side: Side::Right, cycles_left: 3, blocks: true };
        assert!((head(dive) - Vec3::new(1.0, 1.45, 0.15)).length() < 1e-4, "{}", head(dive));
    }
}
