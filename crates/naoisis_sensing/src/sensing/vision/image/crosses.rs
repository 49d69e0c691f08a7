//! Detection of penalty crosses: white spots on the carpet with the size and the spread of a cross at their position.

use bevy::math::{Mat2, Vec2};

use super::Look;
use super::colour::ColourClass;
use super::line_point::{GOAL_M, Point};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept, RobotPercept};

/// The least number of pixels of a cross.
const LEAST_PIXELS: f32 = 10.0;
/// The range of the number of pixels of a cross, as multiples of the expected number.
const AREA: core::ops::Range<f32> = 0.6..1.5;
/// The range of the squared widths of a cross in all directions, as multiples of the expected ones.
const SPREAD: core::ops::Range<f32> = 0.5..1.8;
/// The least share of carpet around a cross.
const LEAST_GREEN: f32 = 0.9;
/// The greatest width of a cross, as a share of the length of its bars: from corner to opposite corner, plus the edges.
const BROADEST: f32 = 1.3;
/// The greatest distance by which the arms of a robot extend beyond its body, m.
const BESIDE_ROBOT_M: f32 = 0.02;

/// The white pixels of a spot.
#[derive(Default)]
pub(super) struct Spot {
    /// The part of the image that may contain the cross: left and top, width and height.
    frame: [usize; 4],
    /// Whether each pixel of the frame is in the spot or on its edge.
    is_in: Vec<bool>,
    /// White pixels whose neighbours have not been visited.
    next: Vec<[usize; 2]>,
    /// The number of pixels. A pixel of the edge, which is neither white nor green, counts half.
    count: f32,
    sum: Vec2,
    /// Sums of the squares and of the products of columns and rows, relative to the frame.
    squares: [f32; 3],
    /// The number of pixels around the spot, and the number of carpet pixels among them.
    around: usize,
    green: usize,
}

impl Spot {
    /// Adds a pixel of the frame with the weight `share`.
    fn add(&mut self, [u, v]: [usize; 2], share: f32) {
        let place = Vec2::new(u as f32 + 0.5, v as f32 + 0.5);
        self.count += share;
        self.sum += share * place;
        for (sum, product) in self.squares.iter_mut().zip([place.x * place.x, place.x * place.y, place.y * place.y]) {
            *sum += share * product;
        }
    }
}

impl Look<'_> {
    /// Finds penalty crosses among the points that may belong to lines.
    pub(super) fn find_crosses(
        &self,
        points: &[Point],
        robots: &[(bool, RobotPercept)],
        posts: &[(bool, GoalPostPercept)],
        spot: &mut Spot,
        found: &mut Vec<LandmarkPercept>,
    ) {
        let before = found.len();
        let mut last = None;
        for point in points {
            // Several points may be on one cross.
            let is_known = |&[left, top, width, height]: &[usize; 4]| {
                let [u, v] = [point.pixel.x as usize, point.pixel.y as usize];
                (left..left + width).contains(&u) && (top..top + height).contains(&v)
            };
            if last.as_ref().is_some_and(is_known) {
                continue;
            }
            let Some(pixel) = self.cross(point, spot) else { continue };
            last = Some(spot.frame);
            let Some(position_m) = self.view.ground_point(pixel) else { continue };
            let is_free = robots
                .iter()
                .all(|(_, robot)| !is_beside(robot.position_m, self.model.robot_reach + BESIDE_ROBOT_M, position_m))
                && posts.iter().all(|(_, post)| post.position_m.distance(position_m) > GOAL_M);
            let is_new = found[before..].iter().all(|other| other.position_m.distance(position_m) > self.mark_size());
            if is_free && is_new {
                found.push(LandmarkPercept::new(self.camera, LandmarkKind::PenaltyCross, pixel, position_m));
            }
        }
    }

    /// The length of a cross's bars, m.
    fn mark_size(&self) -> f32 {
        self.model.penalty_mark_size.max(self.model.line_width)
    }

    /// The middle of the cross that contains a point, if it is a cross.
    fn cross(&self, point: &Point, spot: &mut Spot) -> Option<Vec2> {
        let size = self.mark_size();
        let pixels_from_ground = self.pixels_from_ground(point.place)?;
        // Half the extent in columns and rows of a circle on the ground.
        let reach = Vec2::new(pixels_from_ground.row(0).length(), pixels_from_ground.row(1).length());
        if !self.is_short(point, BROADEST * size * reach.x) || !self.fill(point, BROADEST * size * reach + 1.0, spot) {
            return None;
        }
        if spot.count < LEAST_PIXELS || (spot.green as f32) < LEAST_GREEN * spot.around as f32 {
            return None;
        }
        let count = spot.count;
        let mean = spot.sum / count;
        let middle = Vec2::new(spot.frame[0] as f32, spot.frame[1] as f32) + mean;
        // Two bars that share a square.
        let width = self.model.line_width.min(size);
        let area = (2.0 * size - width) * width;
        let second_moment = width * (size * (size * size + width * width) - width * width * width) / 12.0;
        let pixels_from_ground = self.pixels_from_ground(self.view.ground_point(middle)?)?;
        let expected_count = area * pixels_from_ground.determinant().abs();
        if !AREA.contains(&(count / expected_count)) {
            return None;
        }
        // A pixel itself has a width.
        let spread = second_moment / area * pixels_from_ground * pixels_from_ground.transpose()
            + Mat2::from_diagonal(Vec2::splat(1.0 / 12.0));
        let [xx, xy, yy] = spot.squares;
        let seen = Mat2::from_cols(
            Vec2::new(xx / count - mean.x * mean.x, xy / count - mean.x * mean.y),
            Vec2::new(xy / count - mean.x * mean.y, yy / count - mean.y * mean.y),
        );
        // The eigenvalues are the squares of the relative widths along the widest and the narrowest direction.
        let ratio = spread.inverse() * (seen + Mat2::from_diagonal(Vec2::splat(1.0 / 12.0)));
        let half_trace = (ratio.x_axis.x + ratio.y_axis.y) / 2.0;
        let root = (half_trace * half_trace - ratio.determinant()).max(0.0).sqrt();
        let is_as_broad = SPREAD.contains(&(half_trace - root)) && SPREAD.contains(&(half_trace + root));
        is_as_broad.then_some(middle)
    }

    /// The Jacobian of the projection: pixels to the right and downwards per metre on the ground at `place`, along the robot's axes.
    fn pixels_from_ground(&self, place: Vec2) -> Option<Mat2> {
        const STEP_M: f32 = 0.01;
        let along = |axis: Vec2| {
            let ends = [-axis, axis].map(|offset| self.view.project((place + STEP_M * offset).extend(0.0)));
            Some((ends[1]? - ends[0]?) / (2.0 * STEP_M))
        };
        Some(Mat2::from_cols(along(Vec2::X)?, along(Vec2::Y)?))
    }

    /// Whether the white run at a point is at most `columns` wide.
    fn is_short(&self, point: &Point, columns: f32) -> bool {
        let [column, row] = [point.pixel.x as usize, (point.pixel.y as usize).min(self.height() - 1)];
        let white = |column: &usize| self.class(*column, row) == ColourClass::White;
        let left = (0..column).rev().take_while(white).count();
        let right = (column..self.width()).take_while(white).count();
        (left + right) as f32 <= columns + 1.0
    }

    /// Fills `spot` with the white pixels that are connected to a point. Returns whether the spot ends within `reach`, and before the edge
    /// of the image.
    fn fill(&self, point: &Point, reach: Vec2, spot: &mut Spot) -> bool {
        let least = (point.pixel - reach).max(Vec2::ZERO);
        let most = (point.pixel + reach).min(Vec2::new(self.width() as f32, self.height() as f32));
        let [left, top] = [least.x as usize, least.y as usize];
        let [width, height] = [most.x.ceil() as usize - left, most.y.ceil() as usize - top];
        spot.frame = [left, top, width, height];
        spot.is_in.clear();
        spot.is_in.resize(width * height, false);
        (spot.count, spot.sum, spot.squares) = (0.0, Vec2::ZERO, [0.0; 3]);
        (spot.around, spot.green) = (0, 0);
        spot.next.clear();
        let first = [point.pixel.x as usize - left, (point.pixel.y as usize - top).min(height - 1)];
        if self.class(left + first[0], top + first[1]) != ColourClass::White {
            return false;
        }
        spot.is_in[first[1] * width + first[0]] = true;
        spot.next.push(first);
        while let Some([u, v]) = spot.next.pop() {
            if u == 0 || v == 0 || u + 1 == width || v + 1 == height {
                return false;
            }
            spot.add([u, v], 1.0);
            for (u, v) in (v - 1..=v + 1).flat_map(|v| (u - 1..=u + 1).map(move |u| (u, v))) {
                let class = self.class(left + u, top + v);
                let is_known = core::mem::replace(&mut spot.is_in[v * width + u], class != ColourClass::Green);
                match class {
                    ColourClass::White if is_known => {}
                    ColourClass::White => spot.next.push([u, v]),
                    ColourClass::Green => {
                        spot.around += 1;
                        spot.green += 1;
                    }
                    // A pixel of the edge, whose colour is mixed, has a green neighbour.
                    _ if self.is_beside_green(left + u, top + v) => {
                        if !is_known {
                            spot.add([u, v], 0.5);
                        }
                    }
                    _ => spot.around += 1,
                }
            }
        }
        true
    }

    /// Whether one of the four neighbours of a pixel is green.
    fn is_beside_green(&self, column: usize, row: usize) -> bool {
        let [right, below] = [(column + 1).min(self.width() - 1), (row + 1).min(self.height() - 1)];
        let [left, above] = [column.saturating_sub(1), row.saturating_sub(1)];
        let neighbours = [(left, row), (right, row), (column, above), (column, below)];
        neighbours.into_iter().any(|(column, row)| self.class(column, row) == ColourClass::Green)
    }
}

/// Whether `place` is behind a robot with this `reach`, m, so that in the image it is hidden by the robot or just beside it.
fn is_beside(robot: Vec2, reach: f32, place: Vec2) -> bool {
    let direction = robot.normalize_or(Vec2::X);
    direction.dot(place) > robot.length()
        && direction.perp_dot(place / place.length().max(0.1)).abs() * robot.length() < reach
}
