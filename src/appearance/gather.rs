//! From a match to the scene that is drawn of it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::gait::Gait;
use super::posing::JointAngles;
use super::scene::{SceneDescription, SceneRobot, world_from_body};
use crate::ball::{Ball, BallPhysics};
use crate::game::Penalty;
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::Velocity;
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::team::RobotId;

/// What a system needs to draw the match.
#[derive(SystemParam)]
pub struct MatchScene<'w, 's> {
    pitch: Res<'w, Pitch>,
    robots: Query<
        'w,
        's,
        (
            &'static RobotId,
            &'static Pose,
            &'static HeadAngles,
            Option<&'static Velocity>,
            Option<&'static Posture>,
            Option<&'static Penalty>,
            Option<&'static mut Gait>,
        ),
    >,
    posts: Query<'w, 's, (&'static Post, &'static Pose)>,
    balls: Query<'w, 's, (&'static Pose, &'static BallPhysics), With<Ball>>,
}

impl MatchScene<'_, '_> {
    /// Puts the match as it is at `now_s` into `scene`, whose memory is used again. The robots' legs get into step with
    /// what they did until then. Robots that the referee has taken off the pitch are not there.
    pub fn gather(&mut self, now_s: f64, scene: &mut SceneDescription) {
        if scene.pitch != *self.pitch {
            scene.pitch.clone_from(&self.pitch);
        }
        scene.robots.clear();
        for (id, pose, head, velocity, posture, penalty, gait) in &mut self.robots {
            if penalty.is_some_and(Penalty::is_active) {
                continue;
            }
            let joints = match gait {
                Some(mut gait) => {
                    gait.follow(*pose, velocity.copied().unwrap_or_default(), now_s);
                    gait.joints(*id, *head)
                }
                None => JointAngles { head: *head, ..JointAngles::default() },
            };
            let posture = posture.copied().unwrap_or_default();
            let world_from_robot = world_from_body(*pose, posture);
            scene.robots.push(SceneRobot { id: *id, world_from_robot, joints });
        }
        scene.robots.sort_unstable_by_key(|robot| robot.id);
        scene.posts.clear();
        scene.posts.extend(self.posts.iter().map(|(post, pose)| (*post, pose.position)));
        scene.posts.sort_unstable_by(|(_, a), (_, b)| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        scene.ball = self.balls.iter().next().map(|(pose, physics)| (pose.position, physics.radius_m));
    }
}
