//! Random scenes in which the accuracy of a vision is measured.

use bevy::math::{Vec2, ops};
use core::f32::consts::TAU;

use super::Conditions;
use crate::appearance::posing::STEP_FREQUENCY;
use crate::appearance::scene::{Scene, SceneBall, SceneRobot};
use crate::appearance::stride::Stride;
use naoisis_core::geometry::{Pose, to_radians};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::{RobotId, Team};

/// The number of other robots in a scene.
const OTHERS: u8 = 5;
/// The free space around robots and the ball, m.
const ROOM_M: f32 = 0.03;
/// The greatest distance of the ball, as a share of the pitch's length: 3.5 m on one of 6 m.
const FARTHEST_BALL: f32 = 0.58;
/// The range of the head's yaw, within its limits, degrees.
const HEAD_YAW_DEG: [f32; 2] = [-60.0, 60.0];
/// The range of the head's pitch, within its limits, degrees.
const HEAD_PITCH_DEG: [f32; 2] = [-10.0, 25.0];
/// The greatest angle between the ball and the direction of the head, degrees.
const BALL_ASIDE_DEG: f32 = 28.0;

/// A random scene with a robot that looks in a random direction, five others, and the ball approximately ahead. The robot that looks is the
/// first.
pub(super) fn random_scene(conditions: &Conditions, stream: &mut RandomStream) -> Scene {
    let Conditions { pitch, ball_radius_m, bodies, head: limits, .. } = conditions;
    let mut scene = Scene::empty(pitch.clone());
    let mut between = |least: f32, most: f32| least + (most - least) * stream.uniform();
    let (along, across) = (pitch.half_length() - 0.2, pitch.half_width() - 0.2);
    let yaw = to_radians(between(HEAD_YAW_DEG[0], HEAD_YAW_DEG[1])).clamp(limits.yaw[0], limits.yaw[1]);
    let nod = to_radians(between(HEAD_PITCH_DEG[0], HEAD_PITCH_DEG[1])).clamp(limits.pitch[0], limits.pitch[1]);
    let head = HeadAngles { yaw, pitch: nod };
    let pose = Pose::new(between(-along, along), between(-across, across), to_radians(between(-180.0, 180.0)));
    let bearing = pose.heading + head.yaw + to_radians(between(-BALL_ASIDE_DEG, BALL_ASIDE_DEG));
    let own = RobotId::new(Team::Blue, 1);
    let own_body = bodies[own.team];
    let nearest = own_body.base.x_m[1] + ball_radius_m + ROOM_M / 3.0;
    let distance = between(nearest, FARTHEST_BALL * pitch.length_m);
    let ball = pose.position + distance * Vec2::new(ops::cos(bearing), ops::sin(bearing));
    scene.ball = Some(SceneBall { look: conditions.ball_look, ..SceneBall::on_ground(ball, *ball_radius_m) });
    scene.robots.push(SceneRobot { head, ..SceneRobot::standing(own, pose, own_body) });
    for index in 0..OTHERS {
        let id = RobotId::new(if index % 2 == 0 { Team::Pink } else { Team::Blue }, 2 + index);
        let body = bodies[id.team];
        let heading = to_radians(between(-180.0, 180.0));
        let phase = between(0.0, TAU);
        let (speed, head_yaw) = (between(0.0, 0.2), between(-1.0, 1.0).clamp(limits.yaw[0], limits.yaw[1]));
        let reach = body.torso.reach().max(body.base.reach());
        let is_free = |place: Vec2| {
            let others = scene.robots.iter();
            let mut are_free = others.map(|other| place.distance(other.pose.position) > reach + other.reach + ROOM_M);
            are_free.all(|is_free| is_free)
                && scene.posts.iter().all(|post| place.distance(post.position) > reach + post.post.radius + ROOM_M)
                && place.distance(ball) > reach + ball_radius_m
        };
        let place =
            (0..100).map(|_| Vec2::new(between(-along, along), between(-across, across))).find(|place| is_free(*place));
        let Some(place) = place else { continue };
        let time_s = f64::from(phase / TAU / STEP_FREQUENCY);
        scene.robots.push(SceneRobot {
            head: HeadAngles { yaw: head_yaw, pitch: 0.0_f32.clamp(limits.pitch[0], limits.pitch[1]) },
            stride: Stride { time_s, speed, liveliness: 1.0, kick: None },
            ..SceneRobot::standing(id, Pose { position: place, heading }, body)
        });
    }
    scene
}
