//! Convex polygons: the samples that they cover, and their shading.

use bevy::math::Vec3;
use core::ops::Range;

use super::frame::{Frame, NEAR, first_sample, samples_between};
use super::light::Paint;
use super::prepared::{Corner, Face};

/// A polygon's corner in the picture: its coordinates in samples, and its light.
type Point = [f32; 3];

/// Memory for the outline of one polygon at a time.
#[derive(Default)]
pub(super) struct Outline {
    in_camera: Vec<(Vec3, f32)>,
    points: Vec<Point>,
    /// The left and right ends of each row, with the light there.
    rows: Vec<[[f32; 2]; 2]>,
}

impl Outline {
    /// Takes corners in the pitch frame, cuts off the part behind the lens, and projects the rest. Returns false if nothing is left.
    #[inline(always)]
    pub(super) fn project(&mut self, frame: &Frame, corners: impl Iterator<Item = (Vec3, f32)>) -> bool {
        self.in_camera.clear();
        self.points.clear();
        let (mut behind, mut ahead) = (false, false);
        for (corner, light) in corners {
            let in_camera = frame.to_camera(corner);
            if in_camera.z >= NEAR {
                ahead = true;
            } else {
                behind = true;
            }
            self.in_camera.push((in_camera, light));
        }
        if !ahead {
            return false;
        }
        let count = self.in_camera.len();
        for index in 0..count {
            let (here, light) = self.in_camera[index];
            if here.z >= NEAR {
                let [u, v] = frame.project(here);
                self.points.push([u, v, light]);
            }
            if behind {
                let (next, next_light) = self.in_camera[if index + 1 == count { 0 } else { index + 1 }];
                if (here.z >= NEAR) != (next.z >= NEAR) {
                    let share = (NEAR - here.z) / (next.z - here.z);
                    let [u, v] = frame.project((here + share * (next - here)).with_z(NEAR));
                    self.points.push([u, v, light + share * (next_light - light)]);
                }
            }
        }
        true
    }

    /// Finds the left and right end of the polygon in each of the given rows. Returns the first row that it covers and the row after the
    /// last.
    #[inline(always)]
    pub(super) fn scan(&mut self, width: usize, height: usize, rows: &Range<usize>) -> (usize, usize) {
        let (mut top, mut bottom) = (f32::INFINITY, f32::NEG_INFINITY);
        let (mut left, mut right) = (f32::INFINITY, f32::NEG_INFINITY);
        for &[u, v, _] in &self.points {
            if v < top {
                top = v;
            }
            if v > bottom {
                bottom = v;
            }
            if u < left {
                left = u;
            }
            if u > right {
                right = u;
            }
        }
        if right < 0.0 || left > width as f32 {
            return (0, 0);
        }
        let within = |row: usize| row.clamp(rows.start, rows.end);
        let (first, end) = samples_between(top, bottom, height);
        let (first, end) = (within(first), within(end));
        if first >= end {
            return (0, 0);
        }
        if self.rows.len() < height {
            self.rows.resize(height, [[0.0; 2]; 2]);
        }
        for row in &mut self.rows[first..end] {
            *row = [[f32::INFINITY, 0.0], [f32::NEG_INFINITY, 0.0]];
        }
        let count = self.points.len();
        for index in 0..count {
            let one = self.points[index];
            let other = self.points[if index + 1 == count { 0 } else { index + 1 }];
            let (upper, lower) = if one[1] <= other[1] { (one, other) } else { (other, one) };
            let (from, to) = (within(first_sample(upper[1], height)), within(first_sample(lower[1], height)));
            if from >= to {
                continue;
            }
            let height_inverse = 1.0 / (lower[1] - upper[1]);
            let slope = (lower[0] - upper[0]) * height_inverse;
            let light_slope = (lower[2] - upper[2]) * height_inverse;
            for (offset, row) in self.rows[from..to].iter_mut().enumerate() {
                let down = (from + offset) as f32 + 0.5 - upper[1];
                let u = upper[0] + down * slope;
                let light = upper[2] + down * light_slope;
                if u < row[0][0] {
                    row[0] = [u, light];
                }
                if u > row[1][0] {
                    row[1] = [u, light];
                }
            }
        }
        (first, end)
    }

    /// Divides each row of the projected polygon into `parts` rows.
    #[inline(always)]
    pub(super) fn divide_rows(&mut self, parts: usize) {
        for point in &mut self.points {
            point[1] *= parts as f32;
        }
    }

    /// The left and right end of the polygon in a row, after a scan.
    #[inline(always)]
    pub(super) fn ends(&self, row: usize, width: usize) -> [f32; 2] {
        let [[left, _], [right, _]] = self.rows[row];
        let width = width as f32;
        [left, right].map(|end| if end > 0.0 { if end < width { end } else { width } } else { 0.0 })
    }

    /// The samples of a row that the polygon covers, after a scan.
    #[inline(always)]
    pub(super) fn span(&self, row: usize, width: usize) -> (usize, usize) {
        let [[left, _], [right, _]] = self.rows[row];
        samples_between(left, right, width)
    }
}

/// Draws the parts of a face in front of which there is no other body.
#[inline(always)]
pub(super) fn draw_face(frame: &mut Frame, outline: &mut Outline, face: &Face, corners: &[Corner]) {
    // The distance of the eye in front of the face.
    let before = face.normal.dot(frame.eye) - face.offset;
    if before <= 0.0 {
        return;
    }
    let corners = &corners[face.first as usize..(face.first + face.count) as usize];
    if !outline.project(frame, corners.iter().map(|corner| (corner.position, corner.light))) {
        return;
    }
    let (width, height) = (frame.width, frame.height);
    let (first, end) = outline.scan(width, height, &frame.window.rows);
    // On the plane n · p = -before in the camera's frame, one over the distance is linear in the picture:
    // 1 / z = -(n.x (u - cu) / f + n.y (v - cv) / f + n.z) / before.
    let gradient = frame.camera_from_world * face.normal / -before;
    let (per_u, per_v) = (gradient.x / frame.focal_length, gradient.y / frame.focal_length);
    let at_centre = gradient.z - per_u * (frame.centre[0] - 0.5) - per_v * (frame.centre[1] - 0.5);
    for row in first..end {
        let (from, to) = outline.span(row, width);
        if from >= to {
            continue;
        }
        let start = at_centre + per_v * row as f32 + per_u * from as f32;
        let (columns, skipped) = frame.window.clip(from, to);
        let range = row * width + columns.start..row * width + columns.end;
        let (pixels, nearness) = (&mut frame.pixels[range.clone()], &mut frame.nearness[range]);
        if face.is_flat {
            fill_flat(pixels, nearness, skipped, start, per_u, face.colour);
        } else {
            let [[left, left_light], [right, right_light]] = outline.rows[row];
            // In 256ths, as integers, so that the light of a sample does not depend on the way it is computed.
            let slope = if right - left > 1e-3 { (right_light - left_light) / (right - left) } else { 0.0 };
            let light = left_light + slope * (from as f32 + 0.5 - left);
            let [light, slope] = [light, slope].map(|light| (light * 256.0) as i32);
            fill_shaded(pixels, nearness, skipped, start, per_u, face.paint, light, slope);
        }
    }
}

/// Fills the samples of a span, except the `skipped` ones at its start.
#[inline(always)]
fn fill_flat(pixels: &mut [u32], nearness: &mut [f32], skipped: usize, start: f32, step: f32, colour: u32) {
    for (index, (pixel, nearness)) in pixels.iter_mut().zip(nearness).enumerate() {
        let here = start + step * ((skipped + index) as i32 as f32);
        let is_nearer = here > *nearness;
        *nearness = if is_nearer { here } else { *nearness };
        *pixel = if is_nearer { colour } else { *pixel };
    }
}

/// Fills the samples of a span, except the `skipped` ones at its start.
#[inline(always)]
fn fill_shaded(
    pixels: &mut [u32],
    nearness: &mut [f32],
    skipped: usize,
    start: f32,
    step: f32,
    paint: Paint,
    light: i32,
    light_step: i32,
) {
    for (index, (pixel, nearness)) in pixels.iter_mut().zip(nearness).enumerate() {
        let index = skipped + index;
        let here = start + step * (index as i32 as f32);
        let is_nearer = here > *nearness;
        let light = light.wrapping_add(light_step.wrapping_mul(index as i32)) >> 8;
        let colour = paint.lit(light.clamp(0, 256) as u32);
        *nearness = if is_nearer { here } else { *nearness };
        *pixel = if is_nearer { colour } else { *pixel };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_covers_the_samples_whose_middles_are_in_it() {
        let points = vec![[1.2, 2.2, 0.0], [4.2, 2.2, 0.0], [4.2, 4.8, 0.0], [1.2, 4.8, 0.0]];
        let mut outline = Outline { points, ..Outline::default() };
        assert_eq!(outline.scan(10, 10, &(0..10)), (2, 5));
        // Middles 1.5 to 3.5 and 2.5 to 4.5.
        assert_eq!(outline.span(2, 10), (1, 4));
        assert_eq!(outline.span(4, 10), (1, 4));
    }

    #[test]
    fn neighbours_share_no_sample_and_leave_none_out() {
        let corners = [[3.3, 1.1], [17.9, 4.2], [9.4, 18.7], [-3.0, 12.0]];
        let middle = [8.2, 9.3];
        let mut covered = vec![0; 400];
        for index in 0..4 {
            let points = [corners[index], corners[(index + 1) % 4], middle].map(|[u, v]| [u, v, 0.0]).to_vec();
            let mut outline = Outline { points, ..Outline::default() };
            let (first, end) = outline.scan(20, 20, &(0..20));
            for row in first..end {
                let (from, to) = outline.span(row, 20);
                (from..to).for_each(|sample| covered[20 * row + sample] += 1);
            }
        }
        let points = corners.map(|[u, v]| [u, v, 0.0]).to_vec();
        let mut whole = Outline { points, ..Outline::default() };
        let (first, end) = whole.scan(20, 20, &(0..20));
        for row in 0..20 {
            let (from, to) = if (first..end).contains(&row) { whole.span(row, 20) } else { (0, 0) };
            for sample in 0..20 {
                assert_eq!(covered[20 * row + sample], i32::from((from..to).contains(&sample)), "{sample} {row}");
            }
        }
    }
}
