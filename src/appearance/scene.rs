//! What there is to draw at one instant.

use bevy::math::{Affine3A, Vec2};

use super::posing::{Posture, world_from_standing};
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::RobotId;

/// A robot to draw.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SceneRobot {
    /// Who it is.
    pub id: RobotId,
    /// Where it is: standing, lying or in the air.
    pub world_from_robot: Affine3A,
    /// How it holds its limbs.
    pub posture: Posture,
}

impl SceneRobot {
    /// A robot that stands at a pose.
    pub fn standing(id: RobotId, pose: Pose, posture: Posture) -> Self {
        Self { id, world_from_robot: world_from_standing(pose), posture }
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

impl SceneDescription {
    /// A pitch with its goals, and nothing on it.
    pub fn empty(pitch: Pitch) -> Self {
        let posts = pitch.goal_posts().map(|post| (post.into(), post.position)).to_vec();
        Self { pitch, robots: Vec::new(), posts, ball: None }
    }
}
