//! What behaviours draw.

use bevy::prelude::*;

use super::{Brush, Overlay, Showing};
use crate::behaviour::drawings::{Drawings, DrawnShape, Frame};
use crate::belief::point_pitch_from_team;
use crate::game::{Game, Penalty};
use crate::geometry::Pose;
use crate::robot::PreviousPose;
use crate::team::RobotId;
use crate::viewer::palette;

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
                // Those have a switch of their own.
                DrawnShape::Target { .. } => {}
            }
        }
    }
}
