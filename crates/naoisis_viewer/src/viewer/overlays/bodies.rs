//! Bodies, trails and plans of robots, and the drawings of their behaviours.

use bevy::prelude::*;

use super::geometry::corners;
use super::{Brush, Overlay, Showing};
use crate::viewer::cycle_samples::{CycleSample, CycleSamples};
use crate::viewer::palette;
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::behaviour::drawings::{DrawColour, Drawings, DrawnShape, Frame};
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::robot::PreviousPose;
use naoisis_core::robot::body::{Body, BodyBox};
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::point_pitch_from_team;
use naoisis_sim::interface::gather::CurrentRecord;

/// The length of trails, s.
const TRAIL_S: f64 = 10.0;
/// How far ahead the effect of a command is drawn, s.
const AHEAD_S: f32 = 1.0;
/// The distance of a turn's arc from the body, m.
const AROUND_BODY_M: f32 = 0.07;
/// The length of the line of sight, m.
const LOOK_M: f32 = 0.35;
/// The length of the arrow of a kick, m.
const KICK_M: f32 = 0.6;
/// The distance in a cycle from which a motion counts as a jump, m.
const JUMP_M: f32 = 0.4;

pub(super) fn draw_bounds(
    showing: Showing,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Body)>,
    balls: Query<(&Pose, &PreviousPose, &BallPhysics), Without<RobotId>>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Bounds) {
        return;
    }
    for (id, pose, previous, penalty, bounds) in &robots {
        if showing.shows(Overlay::Bounds, *id, penalty) {
            let place = showing.place(pose, previous);
            draw_box(bounds.base, place, palette::ink(DrawColour::Yellow), &mut brush);
            draw_box(bounds.torso, place, palette::ink(DrawColour::Sky), &mut brush);
        }
    }
    for (pose, previous, physics) in &balls {
        brush.circle(showing.place(pose, previous).position, physics.radius_m, palette::ink(DrawColour::White));
    }
}

fn draw_box(body: BodyBox, place: Pose, colour: Color, brush: &mut Brush) {
    let corners = body.footprint(place).corners();
    for height in body.z_m {
        brush.outline_at(corners, height.max(0.012), colour);
    }
    for corner in corners {
        brush.line_in_space(corner.extend(body.z_m[0]), corner.extend(body.z_m[1]), colour);
    }
}

pub(super) fn draw_kick_areas(
    showing: Showing,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &KickSettings)>,
    balls: Query<&Pose, (With<Ball>, Without<RobotId>)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::KickAreas) {
        return;
    }
    let ball = balls.iter().next().map(|pose| pose.position);
    for (id, pose, previous, penalty, kicks) in &robots {
        if !showing.shows(Overlay::KickAreas, *id, penalty) {
            continue;
        }
        let place = showing.place(pose, previous);
        for kick_type in kicks.types() {
            let Some(geometry) = kicks.geometry(kick_type) else { continue };
            let strike = ball.and_then(|ball| kicks.strike(kick_type, pose.inverse_transform_point(ball), 0.0));
            let ink = match (kick_type, strike) {
                (_, Some(_)) => DrawColour::Vermilion,
                (kick, None) if kick.is_side_kick() => DrawColour::Sky,
                (_, None) => DrawColour::White,
            };
            let area = corners(geometry.rectangle());
            brush.outline(area.map(|corner| place.transform_point(corner)), palette::ink(ink));
            // The direction in which the ball would go.
            if let (Some(strike), Some(ball)) = (strike, ball) {
                let way = place.transform_point(KICK_M * strike.direction) - place.position;
                brush.arrow(ball, ball + way, palette::ink(DrawColour::Vermilion));
            }
        }
    }
}

pub(super) fn draw_trails(
    showing: Showing,
    samples: Res<CycleSamples>,
    robots: Query<(&RobotId, &Penalty)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Trails) {
        return;
    }
    let last = showing.clock.cycle;
    let length = (TRAIL_S / showing.clock.period_s) as u64;
    let first = last.saturating_sub(length);
    let trail = |place: &dyn Fn(&CycleSample) -> Option<Vec2>, colour: Color, brush: &mut Brush| {
        let mut before: Option<Vec2> = None;
        for (cycle, sample) in samples.between(first, last) {
            let here = place(sample);
            if let (Some(start), Some(end)) = (before, here)
                && start.distance(end) < JUMP_M
            {
                let age = (last - cycle) as f32 / length.max(1) as f32;
                brush.line(start, end, colour.with_alpha(1.0 - 0.85 * age));
            }
            before = here;
        }
    };
    for (id, penalty) in &robots {
        if showing.shows(Overlay::Trails, *id, penalty) {
            let place = |sample: &CycleSample| {
                sample.robots.get(id).filter(|robot| !robot.penalised).map(|robot| robot.pose.position)
            };
            trail(&place, palette::team(id.team), &mut brush);
        }
    }
    trail(&|sample| sample.ball, palette::ink(DrawColour::Orange), &mut brush);
}

pub(super) fn draw_targets(
    showing: Showing,
    current: Res<CurrentRecord>,
    game: Res<Game>,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Drawings, &Body)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Targets) {
        return;
    }
    for (id, pose, previous, penalty, drawings, body) in &robots {
        if !showing.shows(Overlay::Targets, *id, penalty) {
            continue;
        }
        let place = showing.place(pose, previous);
        let own_end = game.own_end(id.team);
        for drawing in drawings.iter() {
            let DrawnShape::Target { position_m, .. } = &drawing.shape else { continue };
            let target = match drawing.frame {
                Frame::Team => point_pitch_from_team(*position_m, own_end),
                Frame::Robot => place.transform_point(*position_m),
            };
            let colour = palette::ink(drawing.ink);
            dashes(place.position, target, colour, &mut brush);
            brush.circle(target, 0.06, colour);
            brush.cross(target, 0.12, colour);
            if let DrawnShape::Target { words, .. } = &drawing.shape
                && !words.is_empty()
            {
                brush.words(target, words.clone(), colour);
            }
        }
        let command = current.record.robot(*id).and_then(|robot| robot.command.as_ref());
        let Some(command) = command else { continue };
        let cycles = AHEAD_S / showing.clock.period();
        if let Some(walk) = command.walk {
            let end = place.transform_point(cycles * walk.translation());
            brush.arrow(place.position, end, palette::ink(DrawColour::White));
            let turn = (cycles * walk.dtheta).clamp(-3.0, 3.0);
            let from = place.heading;
            let around = body.torso.half_width_m + AROUND_BODY_M;
            brush.path(
                super::geometry::arc(place.position, around, [from, from + turn]),
                palette::ink(DrawColour::White),
            );
        }
        if let Some(head) = command.head {
            let gaze = unit(place.heading + head.yaw);
            brush.line(place.position + 0.1 * gaze, place.position + LOOK_M * gaze, palette::ink(DrawColour::Sky));
        }
    }
}

/// Draws a dashed line on the ground.
fn dashes(start: Vec2, end: Vec2, colour: Color, brush: &mut Brush) {
    /// The length of a dash and of the gap after it, m.
    const DASH_M: f32 = 0.12;
    let length = start.distance(end);
    let direction = (end - start).normalize_or_zero();
    let count = (length / DASH_M).ceil().min(200.0) as u32;
    for dash in 0..count {
        let from = dash as f32 * DASH_M;
        brush.line(start + from * direction, start + (from + 0.6 * DASH_M).min(length) * direction, colour);
    }
}

/// Draws the drawings of behaviours, except for targets, which have a switch of their own.
pub(super) fn draw_drawings(
    showing: Showing,
    game: Res<Game>,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Drawings)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Drawings) {
        return;
    }
    for (id, pose, previous, penalty, drawings) in &robots {
        if !showing.shows(Overlay::Drawings, *id, penalty) {
            continue;
        }
        let (place, own_end) = (showing.place(pose, previous), game.own_end(id.team));
        for drawing in drawings.iter() {
            let on_pitch = |point: Vec2| match drawing.frame {
                Frame::Team => point_pitch_from_team(point, own_end),
                Frame::Robot => place.transform_point(point),
            };
            let colour = palette::ink(drawing.ink);
            match &drawing.shape {
                DrawnShape::Line { start_m, end_m } => brush.line(on_pitch(*start_m), on_pitch(*end_m), colour),
                DrawnShape::Circle { centre_m, radius_m } => brush.circle(on_pitch(*centre_m), *radius_m, colour),
                DrawnShape::Text { position_m, words } => brush.words(on_pitch(*position_m), words.clone(), colour),
                // Targets have an overlay of their own.
                DrawnShape::Target { .. } => {}
            }
        }
    }
}
