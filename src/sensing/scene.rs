//! What there is to sense in a cycle: robots, posts, ball and the markings of the pitch, gathered once for the sensors
//! of all robots.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ball::{Ball, BallPhysics};
use crate::cycle::{Cycle, CycleSystems};
use crate::game::Penalty;
use crate::geometry::{Pose, unit};
use crate::knowledge::Knowledge;
use crate::pitch::{End, GoalColour, LineJunction, LineSegment, Pitch, Post};
use crate::robot::body::BodyBounds;
use crate::robot::posture::Posture;
use crate::state::ReflectState;
use crate::team::RobotId;

/// Gathers the [`Scene`] in every cycle, and orders the sensors.
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Scene>()
            .init_resource::<Pitch>()
            .init_resource::<Scene>()
            .configure_sets(
                Cycle,
                (
                    SensingSystems::Scene,
                    SensingSystems::Images,
                    SensingSystems::Vision,
                    SensingSystems::Sonar,
                    SensingSystems::Odometry,
                    SensingSystems::Custom,
                )
                    .chain()
                    .in_set(CycleSystems::Sense),
            )
            .add_systems(Cycle, gather_scene.in_set(SensingSystems::Scene));
    }
}

/// The sensors, in the order in which they are read. All read the same instant; the order only settles who draws on a
/// robot's random streams first, and they are separate anyway.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SensingSystems {
    /// The [`Scene`] is gathered.
    Scene,
    /// [`CameraImages`](crate::sensing::camera::CameraImages) are taken.
    Images,
    /// [`Percepts`](crate::sensing::vision::Percepts) are filled.
    Vision,
    /// [`SonarReading`](crate::sensing::sonar::SonarReading)s are filled.
    Sonar,
    /// [`Odometry`](crate::sensing::odometry::Odometry) is filled.
    Odometry,
    /// A place for a user's own sensors, and for noise of a user's own on readings that are filled by now.
    Custom,
}

/// What there is to sense in this cycle.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(State, @Knowledge::Truth)]
pub struct Scene {
    /// The robots, ordered by their ids. Those that the referee has taken off the pitch are not among them, but they
    /// sense the others.
    pub robots: Vec<SceneRobot>,
    /// The posts, ordered by their places.
    pub posts: Vec<ScenePost>,
    /// The ball.
    pub ball: Option<SceneBall>,
    /// What is painted on the ground.
    pub markings: Markings,
}

/// A robot's body.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SceneRobot {
    /// Who it is.
    pub id: RobotId,
    /// Where it stands, m, pitch frame.
    pub position: Vec2,
    /// The unit vector that it faces along, pitch frame.
    pub forward: Vec2,
    /// Its boxes, as it stands or lies.
    pub bounds: BodyBounds,
    /// The greatest distance of a point of its boxes from its origin, on the ground, m.
    pub reach: f32,
}

/// A post.
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

/// What is painted on the ground, m, pitch frame.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Markings {
    /// The straight lines.
    pub lines: Vec<LineSegment>,
    /// Where lines meet.
    pub junctions: Vec<LineJunction>,
    /// The two penalty crosses.
    pub penalty_crosses: [Vec2; 2],
    /// Points on the centre circle, equally spaced; its centre is the origin.
    pub centre_circle: [Vec2; 8],
    /// The colours of the goals at -x and +x.
    pub goal_colours: Option<[GoalColour; 2]>,
}

impl Markings {
    /// The markings of a pitch.
    pub fn new(pitch: &Pitch) -> Self {
        let [negative, positive, _] = pitch.marks();
        let mut centre_circle = [Vec2::ZERO; 8];
        for (slot, point) in centre_circle.iter_mut().zip(pitch.centre_circle_points(8)) {
            *slot = point;
        }
        Self {
            lines: pitch.line_segments(),
            junctions: pitch.line_junctions(),
            penalty_crosses: [negative, positive],
            centre_circle,
            goal_colours: Some(End::BOTH.map(|end| pitch.goal_colour(end))),
        }
    }
}

fn gather_scene(
    mut scene: ResMut<Scene>,
    pitch: Res<Pitch>,
    robots: Query<(&RobotId, &Pose, &BodyBounds, Option<&Posture>, Option<&Penalty>)>,
    posts: Query<(&Post, &Pose)>,
    ball: Query<(&Pose, &BallPhysics), With<Ball>>,
) {
    let scene = &mut *scene;
    scene.robots.clear();
    let playing = robots.iter().filter(|(.., penalty)| !penalty.is_some_and(Penalty::is_active));
    scene.robots.extend(playing.map(|(&id, pose, bounds, posture, _)| SceneRobot {
        id,
        position: pose.position,
        forward: unit(pose.heading),
        bounds: bounds.in_posture(posture.copied().unwrap_or_default()),
        reach: bounds.torso.reach().max(bounds.base.reach()),
    }));
    scene.robots.sort_unstable_by_key(|robot| robot.id);
    scene.posts.clear();
    scene.posts.extend(posts.iter().map(|(&post, pose)| ScenePost { position: pose.position, post }));
    scene
        .posts
        .sort_unstable_by(|a, b| a.position.x.total_cmp(&b.position.x).then(a.position.y.total_cmp(&b.position.y)));
    scene.ball =
        ball.iter().next().map(|(pose, physics)| SceneBall { position: pose.position, radius: physics.radius_m });
    if pitch.is_changed() {
        scene.markings = Markings::new(&pitch);
    }
}
