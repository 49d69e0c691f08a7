//! The markings: lines, their junctions, crosses, circle and arcs, and the areas that they enclose.

use bevy::prelude::*;
use core::f32::consts::{FRAC_PI_2, TAU};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{AreaDimensions, End, GoalColour, Pitch};
use crate::geometry::unit;

/// A straight piece of line marking, at the centre of the line.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct LineSegment {
    /// One end, m, pitch frame.
    pub start: Vec2,
    /// The other end, m, pitch frame.
    pub end: Vec2,
}

/// The shape of a line junction.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JunctionShape {
    /// Two lines end in each other: a corner.
    L,
    /// A line ends on another.
    T,
    /// Two lines cross.
    X,
}

/// A junction of lines.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct LineJunction {
    /// Position, m, pitch frame.
    pub position: Vec2,
    /// Shape.
    pub shape: JunctionShape,
}

/// The markings of a pitch, m, pitch frame.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Markings {
    /// The straight lines.
    pub lines: Vec<LineSegment>,
    /// The junctions of the lines.
    pub junctions: Vec<LineJunction>,
    /// The two penalty crosses.
    pub penalty_crosses: [Vec2; 2],
    /// Points on the centre circle, equally spaced; its centre is the origin.
    pub centre_circle: [Vec2; 8],
    /// The arcs at the corners; empty if the pitch has none.
    #[serde(default)]
    pub corner_arcs: Vec<CornerArc>,
    /// The colours of the goals at -x and +x.
    pub goal_colours: [GoalColour; 2],
}

/// The quarter circle at a corner.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct CornerArc {
    /// The corner at the centre of the arc, m, pitch frame.
    pub corner: Vec2,
    /// Points on the arc, equally spaced from end to end, m, pitch frame.
    pub points: [Vec2; 5],
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
            corner_arcs: pitch.corner_arcs(),
            goal_colours: End::BOTH.map(|end| pitch.goal_colour(end)),
        }
    }
}

impl Pitch {
    /// The quarter circles at the corners; empty if the pitch has none.
    pub fn corner_arcs(&self) -> Vec<CornerArc> {
        let radius = self.corner_arc_radius_m;
        let signs = [Vec2::ONE, Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0), Vec2::NEG_ONE];
        let corner = Vec2::new(self.half_length(), self.half_width());
        let arc = |sign: Vec2| {
            let inwards = [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| radius * unit(FRAC_PI_2 * share));
            CornerArc { corner: sign * corner, points: inwards.map(|inwards| sign * (corner - inwards)) }
        };
        if radius > 0.0 { signs.into_iter().map(arc).collect() } else { Vec::new() }
    }

    /// The corner arcs as polylines of `pieces` segments each, for drawing.
    pub fn corner_arc_pieces(&self, pieces: usize) -> Vec<LineSegment> {
        let radius = self.corner_arc_radius_m;
        let piece = |CornerArc { corner, .. }: CornerArc, index: usize| {
            let point = |index: usize| {
                corner - corner.signum() * radius * unit(FRAC_PI_2 * index as f32 / pieces.max(1) as f32)
            };
            LineSegment { start: point(index), end: point(index + 1) }
        };
        let arcs = self.corner_arcs().into_iter();
        arcs.flat_map(|arc| (0..pieces).map(move |index| piece(arc, index))).collect()
    }

    /// The straight line markings, without penalty crosses and centre circle.
    pub fn line_segments(&self) -> Vec<LineSegment> {
        let (x, y) = (self.half_length(), self.half_width());
        let segment = |x1, y1, x2, y2| LineSegment { start: Vec2::new(x1, y1), end: Vec2::new(x2, y2) };
        let mut segments = vec![
            segment(-x, -y, x, -y),
            segment(-x, y, x, y),
            segment(-x, -y, -x, y),
            segment(x, -y, x, y),
            segment(0.0, -y, 0.0, y),
        ];
        for end in End::BOTH {
            for area in self.areas() {
                let (goal_line, front) = (end.sign() * x, end.sign() * (x - area.depth_m));
                let side = area.width_m / 2.0;
                segments.push(segment(goal_line, -side, front, -side));
                segments.push(segment(goal_line, side, front, side));
                segments.push(segment(front, -side, front, side));
            }
        }
        segments
    }

    /// The centres of the two penalty crosses and of the centre mark, in that order.
    pub fn marks(&self) -> [Vec2; 3] {
        let x = self.half_length() - self.penalty_mark_distance_m;
        [Vec2::new(-x, 0.0), Vec2::new(x, 0.0), Vec2::ZERO]
    }

    /// The line junctions: corners, ends and crossings, including those with the centre circle.
    pub fn line_junctions(&self) -> Vec<LineJunction> {
        let (x, y) = (self.half_length(), self.half_width());
        let mut junctions = Vec::new();
        let mut push = |x: f32, y: f32, shape| {
            junctions.push(LineJunction { position: Vec2::new(x, y), shape });
        };
        for side in [-1.0, 1.0] {
            push(0.0, side * y, JunctionShape::T);
            push(0.0, side * self.centre_circle_diameter_m / 2.0, JunctionShape::X);
            for end in End::BOTH {
                push(end.sign() * x, side * y, JunctionShape::L);
                for area in self.areas() {
                    push(end.sign() * x, side * area.width_m / 2.0, JunctionShape::T);
                    push(end.sign() * (x - area.depth_m), side * area.width_m / 2.0, JunctionShape::L);
                }
            }
        }
        junctions
    }

    /// `count` points on the centre circle's line, for drawing.
    fn centre_circle_points(&self, count: usize) -> impl Iterator<Item = Vec2> {
        let radius = self.centre_circle_diameter_m / 2.0;
        (0..count).map(move |index| radius * unit(TAU * index as f32 / count as f32))
    }

    /// Whether a point is inside the penalty area at this end, lines included.
    pub fn in_penalty_area(&self, end: End, point: Vec2) -> bool {
        let depth = self.half_length() + self.line_width_m / 2.0 - end.sign() * point.x;
        let half_line = self.line_width_m / 2.0;
        (0.0..=self.penalty_area.depth_m + self.line_width_m).contains(&depth)
            && point.y.abs() <= self.penalty_area.width_m / 2.0 + half_line
    }

    /// The nearest point on the pitch, goal lines and side lines included.
    pub(crate) fn within_lines(&self, point: Vec2) -> Vec2 {
        let corner = Vec2::new(self.half_length(), self.half_width());
        point.clamp(-corner, corner)
    }

    fn areas(&self) -> impl Iterator<Item = AreaDimensions> + use<> {
        core::iter::once(self.penalty_area).chain(self.goal_area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_junction_lies_on_a_line() {
        let pitch = Pitch { goal_area: Some(AreaDimensions { depth_m: 0.3, width_m: 1.8 }), ..Pitch::default() };
        for junction in pitch.line_junctions() {
            let on_line = pitch.line_segments().iter().any(|line| {
                let direction = (line.end - line.start).normalize();
                let offset = junction.position - line.start;
                direction.perp_dot(offset).abs() < 1e-5
                    && (-1e-5..=line.start.distance(line.end) + 1e-5).contains(&direction.dot(offset))
            });
            assert!(on_line, "{junction:?}");
        }
    }

    #[test]
    fn the_penalty_area_includes_its_lines() {
        let pitch = Pitch::default();
        assert!(pitch.in_penalty_area(End::NegativeX, Vec2::new(-2.376, 0.0)));
        assert!(!pitch.in_penalty_area(End::NegativeX, Vec2::new(-2.374, 0.0)));
        assert!(!pitch.in_penalty_area(End::PositiveX, Vec2::new(-2.9, 0.0)));
    }
}
