//! Detection of lines, which are white between green and about as wide as a line; of their junctions, and of the centre circle.
//!
//! Every few columns and rows of the image are searched for white runs with green on both sides. Neighbouring points form chains, which are
//! cut into straight segments; a chain with the curvature of the centre circle is a part of it.

use bevy::math::Vec2;
use core::ops::Range;

use super::Look;
use super::colour::ColourClass;
use super::crosses::Spot;
use super::line_point::{GOAL_M, Point};
use super::pieces::{Circle, Piece, cut, join};
use crate::sensing::vision::{GoalPostPercept, GroundPoint, LandmarkKind, LandmarkPercept, RobotPercept};
use naoisis_core::pitch::JunctionShape;

/// The distance between searched columns or rows, pixels.
const SPACING: usize = 4;
/// Points of every so many searched columns and rows are percepts.
const POINTS_EVERY: usize = 5;
/// The range of the width of a line on the ground, as multiples of the line width; it is greater if the line is crossed at a slant.
const WIDTH: Range<f32> = 0.4..4.0;
/// The greatest length of ground that a pixel of a line may cover, as a multiple of the line width.
const COARSEST: f32 = 1.8;
/// Pixels between white and green, where the edge is blurred.
const BLURRED: usize = 1;
/// The greatest offset of a line between two searched columns or rows, pixels.
const STEEPEST: f32 = 6.0;
/// White points within this distance of a robot's body probably belong to it, m.
const BESIDE_ROBOT_M: f32 = 0.09;
/// Circles of the same radius with centres within this distance are the same, m.
const SAME_CIRCLE_M: f32 = 0.3;

/// Memory for the lines of one image.
#[derive(Default)]
pub(super) struct Lines {
    points: Vec<Point>,
    chain: Vec<Point>,
    parts: Vec<Range<usize>>,
    pieces: Vec<Piece>,
    circles: Vec<Circle>,
    spot: Spot,
}

impl Look<'_> {
    pub(super) fn find_lines(
        &self,
        lines: &mut Lines,
        robots: &[(bool, RobotPercept)],
        posts: &[(bool, GoalPostPercept)],
        found: &mut Vec<LandmarkPercept>,
        line_points: &mut Vec<GroundPoint>,
    ) {
        let Lines { points, chain, parts, pieces, circles, spot } = lines;
        pieces.clear();
        circles.clear();
        let radii = self.model.radii();
        let pixel_on_ground = |place: Vec2| self.pixel_on_ground(place);
        for along_columns in [true, false] {
            points.clear();
            self.search(along_columns, robots, points);
            if along_columns {
                self.find_crosses(points, robots, posts, spot, found);
            }
            let chains = connect(points, along_columns);
            let some = points.iter().filter(|point| point.scan % (POINTS_EVERY * SPACING) == SPACING / 2);
            line_points.extend(some.map(|point| GroundPoint {
                camera: self.camera,
                pixel: point.pixel,
                position_m: point.place,
            }));
            for index in 0..chains {
                chain.clear();
                chain.extend(points.iter().filter(|point| point.chain == index));
                cut(chain, radii, &pixel_on_ground, parts, pieces, circles);
            }
        }
        join(pieces, &pixel_on_ground);
        // Remove short segments of circles.
        pieces.retain(|piece| !circles.iter().any(|circle| circle.has(piece)));
        for (index, circle) in circles.iter().enumerate() {
            let is_same =
                |other: &Circle| other.radius == circle.radius && other.centre.distance(circle.centre) < SAME_CIRCLE_M;
            if circles[..index].iter().any(is_same) {
                continue;
            }
            if circle.radius == self.model.circle_radius {
                found.extend(self.landmark(LandmarkKind::CentreCircle, circle.centre));
                let kind = LandmarkKind::Junction { shape: JunctionShape::X };
                let crossings = pieces.iter().flat_map(|piece| self.crossings(piece, circle));
                found.extend(crossings.filter_map(|place| self.landmark(kind, place)));
            } else {
                found.extend(self.landmark(LandmarkKind::CornerArc, circle.centre));
            }
        }
        for piece in pieces.iter() {
            let [pixel, end_pixel] = piece.pixels;
            let [position_m, end_position_m] = piece.places;
            let kind = LandmarkKind::Line { end_pixel, end_position_m };
            found.push(LandmarkPercept::new(self.camera, kind, pixel, position_m));
        }
        for (index, one) in pieces.iter().enumerate() {
            for other in &pieces[index + 1..] {
                if let Some((shape, place)) = self.junction(one, other)
                    && posts.iter().all(|(_, post)| post.position_m.distance(place) > GOAL_M)
                {
                    found.extend(self.landmark(LandmarkKind::Junction { shape }, place));
                }
            }
        }
    }

    fn landmark(&self, kind: LandmarkKind, position_m: Vec2) -> Option<LandmarkPercept> {
        let pixel = self.view.project(position_m.extend(0.0))?;
        Some(LandmarkPercept::new(self.camera, kind, pixel, position_m))
    }

    /// Searches every few columns from the bottom up, or every few rows from left to right.
    fn search(&self, along_columns: bool, robots: &[(bool, RobotPercept)], points: &mut Vec<Point>) {
        let (scans, length) = if along_columns { (self.width(), self.height()) } else { (self.height(), self.width()) };
        for scan in (SPACING / 2..scans).step_by(SPACING) {
            let class = |step: usize| {
                if along_columns { self.class(scan, length - 1 - step) } else { self.class(step, scan) }
            };
            let pixel = |step: f32| {
                let across = scan as f32 + 0.5;
                if along_columns { Vec2::new(across, length as f32 - step) } else { Vec2::new(step, across) }
            };
            let mut green = None;
            let mut step = 0;
            while step < length {
                match class(step) {
                    ColourClass::Green => green = Some(step),
                    ColourClass::White => {
                        let start = step;
                        while step < length && class(step) == ColourClass::White {
                            step += 1;
                        }
                        let begins = green.is_some_and(|green| start - green <= BLURRED + 1);
                        let ends =
                            (step..(step + BLURRED + 1).min(length)).any(|step| class(step) == ColourClass::Green);
                        if begins && ends {
                            let ends = [start as f32, step as f32].map(pixel);
                            points.extend(self.point(ends, scan, robots));
                        }
                        continue;
                    }
                    _ => {}
                }
                step += 1;
            }
        }
    }

    /// The middle of a white run between two pixels, if it may belong to a line.
    fn point(&self, ends: [Vec2; 2], scan: usize, robots: &[(bool, RobotPercept)]) -> Option<Point> {
        let [start, end] = [self.view.ground_point(ends[0])?, self.view.ground_point(ends[1])?];
        let place = (start + end) / 2.0;
        let width = start.distance(end) / self.model.line_width;
        let is_as_wide = WIDTH.contains(&width) && width < COARSEST * ends[0].distance(ends[1]);
        let is_near = place.length_squared() < self.model.farthest * self.model.farthest;
        let reach = self.model.robot_reach + BESIDE_ROBOT_M;
        let is_free = robots.iter().all(|(_, robot)| robot.position_m.distance(place) > reach);
        let pixel = (ends[0] + ends[1]) / 2.0;
        (is_as_wide && is_near && is_free).then_some(Point { pixel, place, scan, chain: usize::MAX })
    }
}

/// Connects points to those of the previous scan. Returns the number of chains.
fn connect(points: &mut [Point], along_columns: bool) -> usize {
    let off = |one: &Point, other: &Point| {
        if along_columns { (one.pixel.y - other.pixel.y).abs() } else { (one.pixel.x - other.pixel.x).abs() }
    };
    let mut chains = 0;
    let mut before = 0;
    for index in 0..points.len() {
        while points[before].scan + SPACING < points[index].scan {
            before += 1;
        }
        let here = points[index];
        let nearest = points[before..index]
            .iter()
            .filter(|other| other.scan + SPACING == here.scan && off(other, &here) <= STEEPEST)
            .min_by(|one, other| off(one, &here).total_cmp(&off(other, &here)));
        points[index].chain = match nearest {
            Some(other) => other.chain,
            None => {
                chains += 1;
                chains - 1
            }
        };
    }
    chains
}
