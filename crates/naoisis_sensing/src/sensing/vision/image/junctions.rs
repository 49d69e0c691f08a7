//! Detection of junctions of line segments.

use bevy::math::Vec2;

use super::Look;
use super::colour::ColourClass;
use super::pieces::{Circle, Piece};
use naoisis_core::pitch::JunctionShape;

/// The least length of segments that form a junction, m.
const SHORTEST_THAT_MEETS_M: f32 = 0.3;
/// The greatest distance of a segment's end from the line in which it ends, m.
const GAP_M: f32 = 0.15;
/// A line ends if there is carpet at these distances beyond the edge of the other line, m.
const BEYOND_M: [f32; 2] = [0.05, 0.15];
/// The greatest distance of the halfway line from the centre of the circle, m.
const THROUGH_CENTRE_M: f32 = 0.1;

impl Look<'_> {
    /// The shape and the position of the junction of two segments, if they meet at a right angle.
    pub(super) fn junction(&self, one: &Piece, other: &Piece) -> Option<(JunctionShape, Vec2)> {
        let (along, across) = (one.direction(), other.direction());
        let are_long = one.length() >= SHORTEST_THAT_MEETS_M && other.length() >= SHORTEST_THAT_MEETS_M;
        // 70° to 110°.
        if !are_long || along.dot(across).abs() > 0.34 {
            return None;
        }
        let between = other.places[0] - one.places[0];
        let on_one = between.perp_dot(across) / along.perp_dot(across);
        let on_other = between.perp_dot(along) / along.perp_dot(across);
        let place = one.places[0] + on_one * along;
        let shape = match [self.ends_at(one, on_one)?, self.ends_at(other, on_other)?] {
            [true, true] => JunctionShape::L,
            [false, false] => JunctionShape::X,
            _ => JunctionShape::T,
        };
        // On a pitch, no two straight lines cross.
        (shape != JunctionShape::X).then_some((shape, place))
    }

    /// The points at which a segment through the centre of a circle crosses the circle, m, as far as the segment is in the image.
    pub(super) fn crossings(&self, piece: &Piece, circle: &Circle) -> impl Iterator<Item = Vec2> + use<> {
        let along = piece.direction();
        let [start, end] = piece.places.map(|place| along.dot(place - circle.centre));
        let passes_by = along.perp_dot(piece.places[0] - circle.centre).abs();
        let is_through = passes_by < THROUGH_CENTRE_M && piece.length() >= SHORTEST_THAT_MEETS_M;
        let (centre, reach) = (circle.centre, start.min(end) - GAP_M..start.max(end) + GAP_M);
        [-circle.radius, circle.radius]
            .into_iter()
            .filter(move |at| is_through && reach.contains(at))
            .map(move |at| centre + at * along)
    }

    /// Whether a segment ends in another line at the distance `along` from its start; `None` if that is unclear.
    fn ends_at(&self, piece: &Piece, along: f32) -> Option<bool> {
        let length = piece.length();
        let direction = piece.direction();
        let place = piece.places[0] + along * direction;
        // There is carpet beyond its end.
        let is_end = |outwards: Vec2| {
            BEYOND_M.into_iter().all(|beyond| {
                let beyond = place + outwards * (self.model.line_width / 2.0 + beyond);
                let pixel = self.view.pixel_in_image(beyond.extend(0.0));
                pixel.is_some_and(|pixel| self.class(pixel.x as usize, pixel.y as usize) == ColourClass::Green)
            })
        };
        if (GAP_M..length - GAP_M).contains(&along) {
            Some(false)
        } else if along.abs() <= GAP_M {
            is_end(-direction).then_some(true)
        } else if (along - length).abs() <= GAP_M {
            is_end(direction).then_some(true)
        } else {
            None
        }
    }
}
