//! Overlays of cameras, sonars and detections.

use bevy::prelude::*;

use super::geometry::{arc, sector};
use super::{Brush, Overlay, Showing};
use crate::viewer::palette;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::camera_model::CameraName;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::{Pose, angle_of, unit};
use naoisis_core::pitch::JunctionShape;
use naoisis_core::robot::PreviousPose;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};

/// The greatest distance of a drawn field of view, m.
const FURTHEST_M: f32 = 4.0;

/// Returns the colour of a camera's field of view; that of the lower camera is fainter.
pub fn camera_colour(camera: CameraName) -> Color {
    palette::ink(DrawColour::Yellow).with_alpha(if camera == CameraName::BOTTOM { 0.45 } else { 1.0 })
}

pub(super) fn draw_fields_of_view(
    showing: Showing,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Posture, &HeadAngles, &Body, &CameraSettings)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::FieldsOfView) {
        return;
    }
    for (id, pose, previous, penalty, posture, head, body, settings) in &robots {
        // A robot that lies on the ground sees nothing.
        if !showing.shows(Overlay::FieldsOfView, *id, penalty) || !posture.is_upright() {
            continue;
        }
        let place = showing.place(pose, previous);
        let views = settings.views(body, *head);
        for (side, camera) in views.named().filter(|(name, _)| settings.which.includes(*name)) {
            let outline = camera.seen_ground(FURTHEST_M);
            let colour = camera_colour(side);
            brush.outline(outline.into_iter().map(|corner| place.transform_point(corner)), colour);
        }
    }
}

pub(super) fn draw_sonars(
    showing: Showing,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &SonarSettings, &SonarReading)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Sonar) {
        return;
    }
    for (id, pose, previous, penalty, settings, reading) in &robots {
        if !settings.fitted || !showing.shows(Overlay::Sonar, *id, penalty) {
            continue;
        }
        let place = showing.place(pose, previous);
        for (heading, distance) in [(settings.heading, reading.left), (-settings.heading, reading.right)] {
            let middle = place.heading + heading;
            let edges = [middle - settings.half_angle, middle + settings.half_angle];
            let range = [settings.min_m, settings.max_m];
            let quiet = palette::ink(DrawColour::Sky).with_alpha(if distance.is_some() { 1.0 } else { 0.6 });
            brush.outline(sector(place.position, range, edges), quiet);
            if let Some(distance) = distance {
                let loud = palette::ink(DrawColour::Vermilion);
                for offset in [-0.008, 0.0, 0.008] {
                    brush.path(arc(place.position, distance + offset, edges), loud);
                }
                let label = place.position + distance * unit(middle);
                brush.words(label, format!("{distance:.2} m"), palette::ink(DrawColour::Sky));
            }
        }
    }
}

pub(super) fn draw_percepts(
    showing: Showing,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Percepts)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Percepts) {
        return;
    }
    for (id, pose, previous, penalty, percepts) in &robots {
        if showing.shows(Overlay::Percepts, *id, penalty) {
            draw_percepts_of(showing.place(pose, previous), percepts, &mut brush);
        }
    }
}

fn draw_percepts_of(place: Pose, percepts: &Percepts, brush: &mut Brush) {
    let on_pitch = |position: Vec2| place.transform_point(position);
    let sight = |brush: &mut Brush, end: Vec2, colour: Color| brush.line(place.position, end, colour.with_alpha(0.35));
    for landmark in &percepts.landmarks {
        let at = on_pitch(landmark.position_m);
        let colour = palette::ink(DrawColour::White);
        match landmark.kind {
            LandmarkKind::Line { end_position_m, .. } => brush.line(at, on_pitch(end_position_m), colour),
            LandmarkKind::Junction { shape } => {
                brush.cross(at, 0.12, colour);
                brush.words(at, junction_letter(shape), colour);
            }
            LandmarkKind::PenaltyCross => brush.cross(at, 0.2, colour),
            LandmarkKind::CentreCircle => brush.circle(at, 0.1, colour),
            LandmarkKind::CornerArc => brush.circle(at, 0.05, colour),
        }
    }
    for post in &percepts.goal_posts {
        let at = on_pitch(post.position_m);
        let colour = palette::goal(post.colour);
        sight(brush, at, colour);
        brush.circle(at, 0.08, colour);
        brush.line_in_space(at.extend(0.0), at.extend(0.4), colour);
    }
    for robot in &percepts.robots {
        let at = on_pitch(robot.position_m);
        let colour = palette::team(robot.team);
        sight(brush, at, colour);
        let around = angle_of(place.position - at);
        // Blue's is a square and pink's a circle.
        let corners = if robot.team == naoisis_core::team::Team::Blue { 4 } else { 24 };
        let turn = core::f32::consts::TAU / corners as f32;
        brush.outline((0..corners).map(|corner| at + 0.16 * unit(around + turn * (corner as f32 + 0.5))), colour);
    }
    for ball in percepts.all_balls() {
        let at = on_pitch(ball.position_m);
        let colour = palette::ink(DrawColour::Orange);
        sight(brush, at, colour);
        brush.circle(at, 0.07, colour);
    }
}

/// Returns the letter of a line junction.
pub fn junction_letter(shape: JunctionShape) -> &'static str {
    match shape {
        JunctionShape::L => "L",
        JunctionShape::T => "T",
        JunctionShape::X => "X",
    }
}
