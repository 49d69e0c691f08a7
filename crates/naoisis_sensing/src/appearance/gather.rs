//! Gathers the [`Scene`] of a match, for sensors, pictures, films and the viewer.

use bevy::ecs::system::{SystemParam, SystemState};
use bevy::prelude::*;

use super::scene::{Scene, SceneBall, ScenePost, SceneRobot};
use super::stride::Stride;
use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{BallPhysics, ExtraBall};
use naoisis_core::game::Penalty;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{Pitch, Post};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;

/// The system parameter that gathers the [`Scene`] of the match.
#[derive(SystemParam)]
pub struct MatchScene<'w, 's> {
    pitch: Res<'w, Pitch>,
    robots: Query<
        'w,
        's,
        (
            &'static RobotId,
            &'static Pose,
            &'static Body,
            &'static HeadAngles,
            Option<&'static Posture>,
            Option<&'static Stride>,
            Option<&'static Penalty>,
        ),
    >,
    posts: Query<'w, 's, (&'static Post, &'static Pose)>,
    balls:
        Query<'w, 's, (Option<&'static ExtraBall>, &'static Pose, &'static BallPhysics, Option<&'static BallFlight>)>,
}

impl MatchScene<'_, '_> {
    /// Gathers the present state of the match into `scene`, whose memory is reused.
    pub fn gather(&self, scene: &mut Scene) {
        scene.set_pitch(&self.pitch);
        scene.robots.clear();
        for (&id, &pose, &body, &head, posture, stride, penalty) in &self.robots {
            if penalty.is_some_and(Penalty::is_off_pitch) {
                continue;
            }
            let posture = posture.copied().unwrap_or_default();
            let stride = stride.copied().unwrap_or_default();
            scene.robots.push(SceneRobot { head, stride, ..SceneRobot::standing(id, pose, body).in_posture(posture) });
        }
        scene.robots.sort_unstable_by_key(|robot| robot.id);
        scene.posts.clear();
        scene.posts.extend(self.posts.iter().map(|(&post, pose)| ScenePost { position: pose.position, post }));
        scene.posts.sort_unstable_by(|ScenePost { position: a, .. }, ScenePost { position: b, .. }| {
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
        });
        let ball_of = |number: Option<ExtraBall>| {
            let mut balls = self.balls.iter();
            let (_, pose, physics, flight) = balls.find(|(which, ..)| which.copied() == number)?;
            let height = flight.map_or(0.0, |flight| flight.height_m);
            Some(SceneBall { position: pose.position, radius: physics.radius_m, height, look: physics.look })
        };
        scene.ball = ball_of(None);
        scene.more_balls.clear();
        scene.more_balls.extend((1..=u8::MAX).map_while(|number| ball_of(Some(ExtraBall(number)))));
    }
}

impl Scene {
    /// Gathers the present state of the match in `world`. Without a match, the scene does not change.
    pub fn gather(&mut self, world: &mut World) {
        if let Ok(source) = SystemState::<MatchScene>::new(world).get(world) {
            source.gather(self);
        }
    }
}
