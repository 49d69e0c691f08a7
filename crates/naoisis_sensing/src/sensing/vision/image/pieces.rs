//! Straight segments and circles, fitted to chains of points.

use bevy::math::Vec2;
use core::ops::Range;

use super::line_point::Point;

/// The least length of a segment, m.
const SHORTEST_M: f32 = 0.2;
/// The least length of a segment of a curve that is taken for a line, m.
const LONG_M: f32 = 0.6;
/// The greatest deviation of a chain from a straight segment: m, and pixels.
const STRAIGHT: [f32; 2] = [0.015, 0.72];
/// The greatest distance between segments of one line, m.
const SAME_LINE_M: f32 = 0.03;
/// Tolerance added to [`SAME_LINE_M`], pixels.
const SAME_LINE_PX: f32 = 1.8;
/// The greatest length on the ground of [`SAME_LINE_PX`], m.
const MOST_SAME_LINE_M: f32 = 0.04;
/// The greatest gap between segments of one line, m.
const GAP_M: f32 = 0.3;
/// The share of a chain's length from which a gap divides it into two lines.
const WIDEST_GAP: f32 = 0.5;
/// The range of the angle between successive segments of a curve, radians. Lines meet at right angles.
const TURN: Range<f32> = 0.1..1.05;
/// The tolerance of the radius of a circle: a share of it, plus m.
const CIRCLE_TOLERANCE: [f32; 2] = [0.04, 0.045];
/// The greatest distance of nine of ten points from their circle, m.
const ON_CIRCLE_M: f32 = 0.04;
/// The least number of points of a circle.
const LEAST_POINTS_OF_CIRCLE: usize = 8;

/// A straight segment of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Piece {
    pub(super) pixels: [Vec2; 2],
    pub(super) places: [Vec2; 2],
}

impl Piece {
    pub(super) fn length(&self) -> f32 {
        self.places[0].distance(self.places[1])
    }

    pub(super) fn direction(&self) -> Vec2 {
        (self.places[1] - self.places[0]).normalize_or(Vec2::X)
    }
}

/// A painted circle, or a part of one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Circle {
    /// Its centre on the ground, m, robot frame.
    pub(super) centre: Vec2,
    /// Its radius, one of those of the pitch, m.
    pub(super) radius: f32,
}

impl Circle {
    /// The tolerance of a radius, m.
    fn tolerance(radius: f32) -> f32 {
        CIRCLE_TOLERANCE[0] * radius + CIRCLE_TOLERANCE[1]
    }

    /// Whether a segment is a part of the circle.
    pub(super) fn has(&self, piece: &Piece) -> bool {
        let [start, end] = piece.places;
        let is_on = |place: Vec2| (place.distance(self.centre) - self.radius).abs() < Self::tolerance(self.radius);
        is_on(start) && is_on(end) && is_on(start.midpoint(end))
    }

    /// The circle with one of these radii on which the points lie, if there is one.
    pub(super) fn of(points: &[Point], radii: [f32; 2]) -> Option<Circle> {
        let (first, last) = (points.first()?, points.last()?);
        let is_bent = deviation(points).1 >= 0.05 && first.place.distance(last.place) >= 0.3;
        if points.len() < LEAST_POINTS_OF_CIRCLE || !is_bent {
            return None;
        }
        // Least squares of x² + y² = 2 a x + 2 b y + c, about the mean (Kåsa, 1976).
        let count = points.len() as f32;
        let mean = points.iter().map(|point| point.place).sum::<Vec2>() / count;
        let (mut xx, mut xy, mut yy, mut xz, mut yz) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for point in points {
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
        let fitted = points.iter().map(distance).sum::<f32>() / count;
        let off = points.iter().filter(|point| (distance(point) - fitted).abs() > ON_CIRCLE_M).count();
        let radius =
            radii.into_iter().find(|&radius| radius > 0.0 && (fitted - radius).abs() < Self::tolerance(radius))?;
        ((off as f32) < 0.1 * count).then_some(Circle { centre, radius })
    }
}

/// Cuts a chain into straight segments, and finds circles with these radii. `pixel_on_ground` returns the length of ground that a pixel
/// covers at a position, m.
pub(super) fn cut(
    chain: &[Point],
    radii: [f32; 2],
    pixel_on_ground: &dyn Fn(Vec2) -> f32,
    ranges: &mut Vec<Range<usize>>,
    pieces: &mut Vec<Piece>,
    circles: &mut Vec<Circle>,
) {
    if let Some(circle) = Circle::of(chain, radii) {
        circles.push(circle);
        return;
    }
    ranges.clear();
    straight_parts(chain, 0..chain.len(), pixel_on_ground, ranges);
    let direction = |range: &Range<usize>| chain[range.end - 1].place - chain[range.start].place;
    let mut start = 0;
    while start < ranges.len() {
        // A part that keeps turning in one direction is a curve.
        let mut end = start + 1;
        let mut turn = 0.0_f32;
        while end < ranges.len() && ranges[end].start + 1 == ranges[end - 1].end {
            let next = direction(&ranges[end - 1]).angle_to(direction(&ranges[end]));
            if !TURN.contains(&next.abs()) || next * turn < 0.0 {
                break;
            }
            turn = next;
            end += 1;
        }
        let is_curve = end > start + 1;
        if is_curve {
            circles.extend(Circle::of(&chain[ranges[start].start..ranges[end - 1].end], radii));
        }
        for range in &ranges[start..end] {
            let part = &chain[range.clone()];
            let length = part[0].place.distance(part[part.len() - 1].place);
            if length >= if is_curve { LONG_M } else { SHORTEST_M } {
                pieces.push(fitted(part));
            }
        }
        start = end;
    }
}

/// Cuts a part of a chain where it bends, until the parts are straight.
fn straight_parts(
    chain: &[Point],
    range: Range<usize>,
    pixel_on_ground: &dyn Fn(Vec2) -> f32,
    parts: &mut Vec<Range<usize>>,
) {
    let part = &chain[range.clone()];
    if part.len() < 4 {
        return;
    }
    let (index, off) = deviation(part);
    if off > STRAIGHT[0] + STRAIGHT[1] * pixel_on_ground(part[index].place) && index > 0 && index + 1 < part.len() {
        straight_parts(chain, range.start..range.start + index + 1, pixel_on_ground, parts);
        straight_parts(chain, range.start + index..range.end, pixel_on_ground, parts);
        return;
    }
    let gap = |index: usize| part[index].place.distance(part[index + 1].place);
    let widest = (0..part.len() - 1).max_by(|one, other| gap(*one).total_cmp(&gap(*other))).unwrap_or(0);
    if gap(widest) > WIDEST_GAP * part[0].place.distance(part[part.len() - 1].place) {
        straight_parts(chain, range.start..range.start + widest + 1, pixel_on_ground, parts);
        straight_parts(chain, range.start + widest + 1..range.end, pixel_on_ground, parts);
        return;
    }
    parts.push(range);
}

/// The point of a chain furthest from the line between its ends, and its distance, m.
fn deviation(chain: &[Point]) -> (usize, f32) {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return (0, 0.0) };
    let across = (last.place - first.place).normalize_or(Vec2::X).perp();
    let off = |point: &Point| across.dot(point.place - first.place).abs();
    chain.iter().map(off).enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

/// The segment that fits the points best: through their mean, along their main axis.
fn fitted(points: &[Point]) -> Piece {
    let (first, last) = (points[0], points[points.len() - 1]);
    let mean = points.iter().map(|point| point.place).sum::<Vec2>() / points.len() as f32;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for point in points {
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

/// Joins segments of the same line that were found in columns and in rows, or have a gap between them.
pub(super) fn join(pieces: &mut Vec<Piece>, pixel_on_ground: &dyn Fn(Vec2) -> f32) {
    let mut index = 0;
    while index < pieces.len() {
        let one = pieces[index];
        let along = one.direction();
        let slack = SAME_LINE_M + (SAME_LINE_PX * pixel_on_ground(one.places[0])).min(MOST_SAME_LINE_M);
        let partner = pieces[index + 1..].iter().position(|other| {
            let off = other.places.map(|place| along.perp_dot(place - one.places[0]).abs());
            let at = other.places.map(|place| along.dot(place - one.places[0]));
            off[0].max(off[1]) < slack && at[0].min(at[1]) < one.length() + GAP_M && at[0].max(at[1]) > -GAP_M
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
        // The longer segment may fit others too.
        pieces[index] = Piece { pixels: [least.0, most.0], places: [least.1, most.1] };
    }
}
