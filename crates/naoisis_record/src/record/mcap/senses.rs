//! Percepts and beliefs of robots as Foxglove scenes.

use bevy::math::Vec2;
use foxglove::messages::{
    CircleAnnotation, Color, ImageAnnotations, Point2, PointsAnnotation, SceneUpdate, Timestamp, points_annotation,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::shapes::{Entity, PITCH, colour, timestamp};
use naoisis_core::camera_model::CameraName;
use naoisis_core::geometry::to_degrees;
use naoisis_core::pitch::End;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::appearance::colours::{self, Colour};
use naoisis_sensing::belief::error::BeliefError;
use naoisis_sensing::belief::{Belief, point_pitch_from_team};
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};

/// Colour of a robot at its own believed pose.
const OWN: Colour = Colour([150, 70, 220]);
/// Opacity of believed objects and their ellipses.
const BELIEVED: f64 = 0.5;
const ELLIPSE: f64 = 0.25;
/// Height of marks on the ground, m.
const FLAT_M: f32 = 0.004;
/// Radii of balls, robots, posts, and marks on the ground, m.
const BALL_M: f32 = 0.05;
const ROBOT_M: f32 = 0.1;
const POST_M: f32 = 0.03;
const MARK_M: f32 = 0.03;
/// Heights of robots and posts, m.
const ROBOT_HEIGHT_M: f32 = 0.4;
const POST_HEIGHT_M: f32 = 0.6;
/// Width of lines, m.
const LINE_M: f32 = 0.015;
/// Length of the arrow that shows a believed heading, m.
const ARROW_M: f32 = 0.3;
/// Width of lines and diameter of circles in image annotations, pixels.
const LINE_PIXELS: f64 = 2.0;
const CIRCLE_PIXELS: f64 = 12.0;

/// Draws the percepts of a robot, relative to its pose at the time of the images.
pub(super) fn percepts_scene(id: RobotId, percepts: &Percepts) -> SceneUpdate {
    let Percepts { time_s, goal_posts, robots, landmarks, .. } = percepts;
    let mut entity = Entity::new("percepts", &id.to_string(), super::nanoseconds(*time_s));
    let chalk = colour(colours::CHALK, 1.0);
    for ball in percepts.all_balls() {
        entity.sphere(ball.position_m.extend(BALL_M), BALL_M, colour(colours::BALL, 1.0));
    }
    for post in goal_posts {
        entity.pillar(post.position_m, POST_M, POST_HEIGHT_M, colour(colours::goal(post.colour), 1.0));
    }
    for robot in robots {
        entity.pillar(robot.position_m, ROBOT_M, ROBOT_HEIGHT_M, colour(colours::team(robot.team), BELIEVED));
    }
    let mut lines = Vec::new();
    for landmark in landmarks {
        let place = landmark.position_m;
        match landmark.kind {
            LandmarkKind::Line { end_position_m, .. } => lines.push([place, end_position_m]),
            // A cross on the ground.
            _ => lines.extend([Vec2::X, Vec2::Y].map(|along| [place - MARK_M * along, place + MARK_M * along])),
        }
    }
    entity.lines(lines.into_iter().map(|ends| ends.map(|end| end.extend(LINE_M))), LINE_M, chalk);
    entity.scene()
}

/// Draws the belief of a robot whose team defends `own_end`.
pub(super) fn belief_scene(id: RobotId, belief: &Belief, own_end: End, time_ns: u64) -> SceneUpdate {
    let Belief { pose_covariance: [xx, xy, yy, ..], ball, team_mates, opponents, .. } = belief;
    let mut entity = Entity::new("belief", PITCH, time_ns);
    let place = |place: Vec2| point_pitch_from_team(place, own_end);
    let pose = belief.pose_in_pitch(own_end);
    let nose = pose.position + ARROW_M * pose.forward();
    let above = |place: Vec2| place.extend(LINE_M);
    entity.pillar(pose.position, ROBOT_M, LINE_M, colour(OWN, BELIEVED));
    entity.lines([[above(pose.position), above(nose)]], 2.0 * LINE_M, colour(OWN, 1.0));
    entity.ellipse(pose.position, [*xx, *xy, *yy], FLAT_M, colour(OWN, ELLIPSE));
    if let Some(ball) = ball {
        let centre = place(ball.position_m);
        let rolls_to = place(ball.position_m + ball.velocity_mps);
        entity.sphere(centre.extend(BALL_M), BALL_M, colour(colours::BALL, BELIEVED));
        entity.lines([[above(centre), above(rolls_to)]], LINE_M, colour(colours::BALL, BELIEVED));
        entity.ellipse(centre, ball.position_covariance, FLAT_M, colour(colours::BALL, ELLIPSE));
    }
    let of = |team: Team| colours::team(team);
    let mates = team_mates.iter().map(|robot| (robot, of(id.team)));
    for (robot, team) in mates.chain(opponents.iter().map(|robot| (robot, of(id.team.opponent())))) {
        entity.ellipse(place(robot.position_m), robot.covariance, ROBOT_HEIGHT_M, colour(team, BELIEVED));
    }
    // In a frame turned by half a turn, ellipses are the same.
    entity.scene()
}

/// Draws annotations of the objects recognised in the image of a camera.
pub(super) fn annotations(camera: CameraName, percepts: &Percepts) -> ImageAnnotations {
    let time = timestamp(super::nanoseconds(percepts.time_s));
    let mut annotations = ImageAnnotations { timestamp: time, ..ImageAnnotations::default() };
    let mut circle = |seen_by: CameraName, pixel: Vec2, of: Colour| {
        if seen_by == camera {
            annotations.circles.push(CircleAnnotation {
                timestamp: time,
                position: Some(point(pixel)),
                diameter: CIRCLE_PIXELS,
                thickness: LINE_PIXELS,
                outline_color: colour(of, 1.0),
                ..CircleAnnotation::default()
            });
        }
    };
    percepts.all_balls().for_each(|ball| circle(ball.camera, ball.pixel, colours::BALL));
    percepts.goal_posts.iter().for_each(|post| circle(post.camera, post.pixel, colours::goal(post.colour)));
    percepts.robots.iter().for_each(|robot| circle(robot.camera, robot.pixel, colours::team(robot.team)));
    let mut lines = Vec::new();
    for landmark in percepts.landmarks.iter().filter(|landmark| landmark.camera == camera) {
        match landmark.kind {
            LandmarkKind::Line { end_pixel, .. } => lines.extend([landmark.pixel, end_pixel].map(point)),
            _ => circle(camera, landmark.pixel, colours::CHALK),
        }
    }
    annotations.points.extend((!lines.is_empty()).then(|| line_list(lines, time, colour(OWN, 1.0))));
    annotations
}

fn point(pixel: Vec2) -> Point2 {
    let [x, y] = pixel.to_array().map(f64::from);
    Point2 { x, y }
}

fn line_list(points: Vec<Point2>, time: Option<Timestamp>, outline_color: Option<Color>) -> PointsAnnotation {
    let kind = points_annotation::Type::LineList.into();
    let thickness = LINE_PIXELS;
    PointsAnnotation { timestamp: time, r#type: kind, points, outline_color, thickness, ..PointsAnnotation::default() }
}

/// The errors of a belief.
#[derive(Serialize, JsonSchema)]
pub(super) struct ErrorOfBelief {
    /// The error of the robot's own place, m.
    position_m: f32,
    /// The error of its heading, degrees.
    heading_deg: f32,
    /// The error of the ball's position, m; missing without a ball or a belief about it.
    ball_m: Option<f32>,
    /// The mean position error of believed opponents, m; missing without any.
    opponent_m: Option<f32>,
    /// The number of believed opponents that do not exist.
    false_tracks: u32,
}

impl From<BeliefError> for ErrorOfBelief {
    fn from(error: BeliefError) -> Self {
        Self {
            position_m: error.position_m,
            heading_deg: to_degrees(error.heading),
            ball_m: error.ball.map(|ball| ball.position_m),
            opponent_m: error.opponent_m,
            false_tracks: error.false_tracks,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_sensing::belief::{BallBelief, RobotBelief};
    use naoisis_sensing::sensing::vision::{BallPercept, LandmarkPercept};

    #[test]
    fn what_is_seen_stays_where_the_robot_was() {
        let ball = BallPercept::new(CameraName::TOP, Vec2::new(10.0, 20.0), Vec2::new(1.0, 0.5));
        let kind = LandmarkKind::Line { end_pixel: Vec2::ONE, end_position_m: Vec2::Y };
        let line = LandmarkPercept::new(CameraName::BOTTOM, kind, Vec2::ZERO, Vec2::X);
        let mut percepts = Percepts::default();
        (percepts.time_s, percepts.ball, percepts.landmarks) = (1.5, Some(ball), vec![line]);
        let scene = percepts_scene(RobotId::new(Team::Blue, 2), &percepts);
        let entity = &scene.entities[0];
        assert_eq!((entity.frame_id.as_str(), entity.frame_locked), ("blue2", false));
        assert_eq!(entity.timestamp, Some(Timestamp::new(1, 500_000_000)));
        let centre = entity.spheres[0].pose.as_ref().unwrap().position.unwrap();
        assert_eq!((centre.x, centre.y), (1.0, 0.5));
        assert_eq!(entity.lines[0].points.len(), 2);
        let top = annotations(CameraName::TOP, &percepts);
        assert_eq!((top.circles.len(), top.circles[0].position), (1, Some(Point2 { x: 10.0, y: 20.0 })));
        let bottom = annotations(CameraName::BOTTOM, &percepts);
        assert_eq!((bottom.circles.len(), bottom.points[0].points.len()), (0, 2));
    }

    #[test]
    fn a_belief_is_drawn_in_the_frame_of_the_pitch_with_ellipses() {
        let opponent =
            RobotBelief { id: None, position_m: Vec2::new(2.0, 0.0), covariance: [0.04, 0.0, 0.01], age_s: 0.0 };
        let ball = BallBelief { position_m: Vec2::X, ..BallBelief::default() };
        let belief = Belief { ball: Some(ball), opponents: vec![opponent], ..Belief::at(Pose::new(-1.0, 0.5, 0.0)) };
        let scene = belief_scene(RobotId::new(Team::Pink, 1), &belief, End::PositiveX, 0);
        let entity = &scene.entities[0];
        let place = |pose: &Option<foxglove::messages::Pose>| {
            let at = pose.as_ref().unwrap().position.unwrap();
            (at.x, at.y)
        };
        // The pitch frame is turned by half a turn: the robot itself, and the opponent's ellipse with half axes of 2.448 times 0.2 and 0.1
        // m.
        assert_eq!(place(&entity.cylinders[0].pose), (1.0, -0.5));
        assert_eq!(place(&entity.cylinders[1].pose), (-2.0, 0.0));
        let size = entity.cylinders[1].size.unwrap();
        assert!((size.x - 0.979).abs() < 1e-3 && (size.y - 0.4895).abs() < 1e-3, "{size:?}");
        assert_eq!(place(&entity.spheres[0].pose), (-1.0, 0.0));
    }
}
