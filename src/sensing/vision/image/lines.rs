//! Lines: white between green, about as wide as a line; where they meet, and the centre circle.
//!
//! Every few columns and rows of the image are searched for a stretch of white with green on both sides. Neighbours form
//! chains, which are cut into straight pieces; a chain that bends as the centre circle does is a part of that.

use bevy::math::Vec2;

use super::Look;
use super::colour::ColourClass;
use super::crosses::Spot;
use super::line_point::{GOAL_M, Point};
use crate::pitch::JunctionShape;
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept, RobotPercept};

/// Columns and rows between two that are searched.
const SPACING: usize = 4;
/// Lines are looked for up to this distance, m.
const FARTHEST_M: f32 = 4.0;
/// A line is at least this wide on the ground, and at most so when it is crossed at a slant, m.
const WIDTH_M: [f32; 2] = [0.02, 0.2];
/// Pixels between white and green, where the edge is blurred.
const BLURRED: usize = 1;
/// From one column or row that is searched to the next, a line goes to the side by so many pixels at most.
const STEEPEST: f32 = 6.0;
/// A straight piece is at least so long, m.
const SHORTEST_M: f32 = 0.2;
/// Lines that meet are at least so long, m.
const SHORTEST_THAT_MEETS_M: f32 = 0.3;
/// A line ends where another is if its end is no further from there, m.
const GAP_M: f32 = 0.15;
/// A line goes on unless there is carpet this far beyond its end, m.
const BEYOND_M: f32 = 0.2;
/// What is white nearer than this to a robot is probably a part of it, m.
const ROBOT_M: f32 = 0.25;
/// A piece that is longer is a line for sure, m.
const LONG_M: f32 = 0.6;
/// The radius of the centre circle is measured as exactly as this, m.
const CIRCLE_TOLERANCE_M: f32 = 0.07;

/// A straight piece of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Piece {
    pixels: [Vec2; 2],
    places: [Vec2; 2],
}

impl Piece {
    fn length(&self) -> f32 {
        self.places[0].distance(self.places[1])
    }

    fn direction(&self) -> Vec2 {
        (self.places[1] - self.places[0]).normalize_or(Vec2::X)
    }
}

/// Memory for the lines of one image.
#[derive(Default)]
pub(super) struct Lines {
    points: Vec<Point>,
    chain: Vec<Point>,
    pieces: Vec<Piece>,
    spot: Spot,
}

impl Look<'_> {
    pub(super) fn find_lines(
        &self,
        lines: &mut Lines,
        robots: &[(bool, RobotPercept)],
        posts: &[(bool, GoalPostPercept)],
        found: &mut Vec<LandmarkPercept>,
    ) {
        let Lines { points, chain, pieces, spot } = lines;
        pieces.clear();
        let mut circle = None;
        for along_columns in [true, false] {
            points.clear();
            self.search(along_columns, robots, points);
            if along_columns {
                self.find_crosses(points, robots, posts, spot, found);
            }
            let chains = connect(points, along_columns);
            for index in 0..chains {
                chain.clear();
                chain.extend(points.iter().filter(|point| point.chain == index));
                match centre_of_circle(chain, self.known.circle_radius) {
                    Some(centre) => circle = Some(centre),
                    None => cut(chain, pieces),
                }
            }
        }
        join(pieces);
        if let Some(centre) = circle {
            // Pieces of the circle that were too short to tell.
            let radius = self.known.circle_radius;
            let is_on_circle = |place: Vec2| (place.distance(centre) - radius).abs() < CIRCLE_TOLERANCE_M;
            pieces.retain(|piece| piece.length() > LONG_M || !piece.places.iter().all(|&place| is_on_circle(place)));
            found.extend(self.landmark(LandmarkKind::CentreCircle, centre));
        }
        for piece in pieces.iter() {
            let [pixel, end_pixel] = piece.pixels;
            let [position_m, end_position_m] = piece.places;
            let kind = LandmarkKind::Line { end_pixel, end_position_m };
            found.push(LandmarkPercept { camera: self.side, kind, pixel, position_m });
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
        Some(LandmarkPercept { camera: self.side, kind, pixel, position_m })
    }

    /// Searches every few columns, from the bottom up, or rows, from left to right.
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

    /// The middle of a line between two pixels, if a line may be there.
    fn point(&self, ends: [Vec2; 2], scan: usize, robots: &[(bool, RobotPercept)]) -> Option<Point> {
        let [start, end] = [self.view.ground_point(ends[0])?, self.view.ground_point(ends[1])?];
        let place = (start + end) / 2.0;
        let is_as_wide = (WIDTH_M[0]..WIDTH_M[1]).contains(&start.distance(end));
        let is_near = place.length_squared() < FARTHEST_M * FARTHEST_M;
        let is_free = robots.iter().all(|(_, robot)| robot.position_m.distance(place) > ROBOT_M);
        let pixel = (ends[0] + ends[1]) / 2.0;
        (is_as_wide && is_near && is_free).then_some(Point { pixel, place, scan, chain: usize::MAX })
    }

    /// How and where two pieces of lines meet at a right angle, if they do.
    fn junction(&self, one: &Piece, other: &Piece) -> Option<(JunctionShape, Vec2)> {
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
        // No two straight lines cross on a pitch.
        (shape != JunctionShape::X).then_some((shape, place))
    }

    /// Whether a piece ends this far along it, rather than passing; none where that cannot be said.
    fn ends_at(&self, piece: &Piece, along: f32) -> Option<bool> {
        let length = piece.length();
        // Where it ends, the carpet is seen beyond.
        let is_end = |place: Vec2, outwards: Vec2| {
            [0.08, BEYOND_M].into_iter().all(|distance| {
                let pixel = self.view.pixel_in_image((place + outwards * distance).extend(0.0));
                pixel.is_some_and(|pixel| self.class(pixel.x as usize, pixel.y as usize) == ColourClass::Green)
            })
        };
        let direction = piece.direction();
        if (GAP_M..length - GAP_M).contains(&along) {
            Some(false)
        } else if along.abs() <= GAP_M {
            is_end(piece.places[0], -direction).then_some(true)
        } else if (along - length).abs() <= GAP_M {
            is_end(piece.places[1], direction).then_some(true)
        } else {
            None
        }
    }
}

/// Connects points to those of the scan before. Returns the number of chains.
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

/// The centre of the circle of this radius on which a chain lies, if it bends so.
fn centre_of_circle(chain: &[Point], radius: f32) -> Option<Vec2> {
    let (first, last) = (chain.first()?, chain.last()?);
    if chain.len() < 8 || deviation(chain).1 < 0.05 || first.place.distance(last.place) < 0.3 {
        return None;
    }
    // Least squares of x² + y² = 2 a x + 2 b y + c, about the mean (Kåsa, 1976).
    let count = chain.len() as f32;
    let mean = chain.iter().map(|point| point.place).sum::<Vec2>() / count;
    let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for point in chain {
        let offset = point.place - mean;
        let squared = offset.length_squared();
        xx += offset.x * offset.x;
        xy += offset.x * offset.y;
        yy += offset.y * offset.y;
        xz += offset.x * squared;
        yz += offset.y * squared;
    }
    let determinant = xx * yy - xy * xy;
    if determinant < 1e-6 {
        return None;
    }
    let centre = mean + Vec2::new(yy * xz - xy * yz, xx * yz - xy * xz) / (2.0 * determinant);
    let distance = |point: &Point| point.place.distance(centre);
    let fitted = chain.iter().map(distance).sum::<f32>() / count;
    let off = chain.iter().filter(|point| (distance(point) - fitted).abs() > 0.04).count();
    ((fitted - radius).abs() < CIRCLE_TOLERANCE_M && (off as f32) < 0.1 * count).then_some(centre)
}

/// The point of a chain that is furthest from the line between its ends, and how far that is, m.
fn deviation(chain: &[Point]) -> (usize, f32) {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return (0, 0.0) };
    let across = (last.place - first.place).normalize_or(Vec2::X).perp();
    let off = |point: &Point| across.dot(point.place - first.place).abs();
    chain.iter().map(off).enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

/// Cuts a chain into straight pieces.
fn cut(chain: &[Point], pieces: &mut Vec<Piece>) {
    if chain.len() < 4 {
        return;
    }
    let (index, off) = deviation(chain);
    // Half a pixel is so much on the ground, with the lens half a metre high and a focal length of 360 pixels.
    let place = chain[index].place;
    if off > 0.015 + 0.004 * place.length_squared() && index > 0 && index + 1 < chain.len() {
        cut(&chain[..=index], pieces);
        cut(&chain[index..], pieces);
        return;
    }
    let (first, last) = (chain[0], chain[chain.len() - 1]);
    if first.place.distance(last.place) >= SHORTEST_M {
        pieces.push(fitted(chain, first, last));
    }
}

/// The straight piece that fits a chain best: through its mean, along its main axis.
fn fitted(chain: &[Point], first: Point, last: Point) -> Piece {
    let mean = chain.iter().map(|point| point.place).sum::<Vec2>() / chain.len() as f32;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for point in chain {
        let offset = point.place - mean;
        xx += offset.x * offset.x;
        xy += offset.x * offset.y;
        yy += offset.y * offset.y;
    }
    // The eigenvector of the larger eigenvalue.
    let half = (xx - yy) / 2.0;
    let root = (half * half + xy * xy).sqrt();
    let axis = if half >= 0.0 { Vec2::new(half + root, xy) } else { Vec2::new(xy, root - half) };
    let axis = axis.normalize_or((last.place - first.place).normalize_or(Vec2::X));
    let foot = |point: Point| mean + axis * axis.dot(point.place - mean);
    Piece { pixels: [first.pixel, last.pixel], places: [foot(first), foot(last)] }
}

/// Joins pieces that are the same line, seen along columns and along rows, or with a gap.
fn join(pieces: &mut Vec<Piece>) {
    let mut index = 0;
    while index < pieces.len() {
        let one = pieces[index];
        let along = one.direction();
        let partner = pieces[index + 1..].iter().position(|other| {
            let off = other.places.map(|place| along.perp_dot(place - one.places[0]).abs());
            let at = other.places.map(|place| along.dot(place - one.places[0]));
            let slack = 0.03 + 0.01 * one.places[0].length_squared().min(4.0);
            off[0].max(off[1]) < slack && at[0].min(at[1]) < one.length() + 0.3 && at[0].max(at[1]) > -0.3
        });
        let Some(partner) = partner else {
            index += 1;
            continue;
        };
        let other = pieces.remove(index + 1 + partner);
        let all = [0, 1].map(|end| (one.pixels[end], one.places[end]));
        let all = all.into_iter().chain([0, 1].map(|end| (other.pixels[end], other.places[end])));
        let at = |(_, place): &(Vec2, Vec2)| along.dot(*place - one.places[0]);
        let (mut least, mut most) = ((one.pixels[0], one.places[0]), (one.pixels[1], one.places[1]));
        for end in all {
            if at(&end) < at(&least) {
                least = end;
            }
            if at(&end) > at(&most) {
                most = end;
            }
        }
        // Now longer, it may fit others too.
        pieces[index] = Piece { pixels: [least.0, most.0], places: [least.1, most.1] };
    }
}
