//! Drawing of ellipsoids, which are intersected with each ray, so that their outlines and shading are smooth at any size.

use bevy::math::Vec3;

use super::conic::Conic;
use super::frame::{Frame, NEAR, first_sample};
use super::light::{Light, Paint};
use super::prepared::{Patch, Round};

/// Draws the parts of an ellipsoid in front of which there is no other body.
#[inline(always)]
pub(super) fn draw(frame: &mut Frame, light: &Light, round: &Round, patches: &[Patch]) {
    if patches.is_empty() {
        draw_in(frame, light, round, |_| round.paint);
    } else {
        draw_in(frame, light, round, |point| {
            let patch = patches.iter().rev().find(|patch| patch.covers(point));
            patch.map_or(round.paint, |patch| patch.paint)
        });
    }
}

/// Draws an ellipsoid. `paint` returns the paint at each point of the unit sphere.
#[inline(always)]
fn draw_in(frame: &mut Frame, light: &Light, round: &Round, paint: impl Fn(Vec3) -> Paint) {
    let centre = frame.to_camera(round.centre);
    if !frame.may_see(centre, round.reach) {
        return;
    }
    let unit_from_world = round.unit_from_world;
    // The eye in the frame in which the ellipsoid is the unit sphere.
    let eye = unit_from_world.transform_point3(frame.eye);
    let outside = eye.length_squared() - 1.0;
    if outside <= 0.0 {
        return;
    }
    let turned = |direction: Vec3| Vec3::from(unit_from_world.matrix3 * bevy::math::Vec3A::from(direction));
    let world_from_camera = frame.camera_from_world.transpose();
    let (right, down) = (turned(world_from_camera.x_axis), turned(world_from_camera.y_axis));
    let forward = turned(world_from_camera.z_axis);
    // A ray of direction d meets the sphere where (e·d)² - d² (e² - 1) is not negative.
    let wide = |vector: Vec3| vector.as_dvec3();
    let [eye_wide, right_wide, down_wide, forward_wide] = [eye, right, down, forward].map(wide);
    let outside_wide = eye_wide.length_squared() - 1.0;
    let conic = Conic::of_form([forward_wide, right_wide, down_wide], |x, y| {
        outside_wide * x.dot(y) - eye_wide.dot(x) * eye_wide.dot(y)
    });
    let focal_length = f64::from(frame.focal_length);
    let [centre_u, centre_v] = frame.centre.map(f64::from);
    let [top, bottom] = conic.rows().map(|slope| (slope * focal_length + centre_v) as f32);
    let (width, height) = (frame.width, frame.height);
    let within = |row: usize| row.clamp(frame.window.rows.start, frame.window.rows.end);
    let (first, end) = (within(first_sample(top, height)), within(first_sample(bottom, height)));
    // The normal at a point x of the unit sphere is Mᵀ x, M being the rotation and scale of `unit_from_world`. Its scalar products with the
    // gradient g and the sun s are those of x with M g and M s, and its length is that of Mᵀ x.
    let shading =
        Shading { light, gradient: turned(light.gradient), sun: turned(light.sun), squared: normal_form(round) };
    let per_sample = right / frame.focal_length;
    // Rays are followed from the point where they pass the middle: from the eye, a small ellipsoid is lost in rounding.
    let ahead = centre.z;
    for row in first..end {
        let row_slope = frame.slope(row, 1);
        for [from, to] in conic.spans(f64::from(row_slope)).into_iter().flatten() {
            let [from, to] = [from, to].map(|slope| first_sample((slope * focal_length + centre_u) as f32, width));
            if from >= to {
                continue;
            }
            let start = forward + row_slope * down + frame.slope(from, 0) * right;
            let (columns, skipped) = frame.window.clip(from, to);
            let range = row * width + columns.start..row * width + columns.end;
            let (pixels, nearness) = (&mut frame.pixels[range.clone()], &mut frame.nearness[range]);
            for (index, (pixel, nearness)) in pixels.iter_mut().zip(nearness).enumerate() {
                let direction = start + per_sample * ((skipped + index) as i32 as f32);
                let beside = eye + direction * ahead;
                let along = beside.dot(direction);
                let squared = direction.length_squared();
                let discriminant = along * along - squared * (beside.length_squared() - 1.0);
                let discriminant = if discriminant > 0.0 { discriminant } else { 0.0 };
                let further = -(discriminant.sqrt() + along) / squared;
                let point = beside + direction * further;
                let here = 1.0 / (ahead + further);
                let light = shading.light(point);
                let is_nearer = here > *nearness && here < 1.0 / NEAR;
                let colour = paint(point).lit(light as i32 as u32);
                *nearness = if is_nearer { here } else { *nearness };
                *pixel = if is_nearer { colour } else { *pixel };
            }
        }
    }
}

/// The matrix M Mᵀ as the quadratic form that gives the squared length of a normal: xx, yy, zz, 2 xy, 2 xz, 2 yz.
#[inline(always)]
fn normal_form(round: &Round) -> [f32; 6] {
    let rows = round.unit_from_world.matrix3.transpose();
    let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis];
    [x.dot(x), y.dot(y), z.dot(z), 2.0 * x.dot(y), 2.0 * x.dot(z), 2.0 * y.dot(z)]
}

struct Shading<'a> {
    light: &'a Light,
    gradient: Vec3,
    sun: Vec3,
    squared: [f32; 6],
}

impl Shading<'_> {
    #[inline(always)]
    fn light(&self, point: Vec3) -> f32 {
        let [xx, yy, zz, xy, xz, yz] = self.squared;
        let Vec3 { x, y, z } = point;
        let squared = x * (xx * x + xy * y + xz * z) + y * (yy * y + yz * z) + zz * z * z;
        let inverse = 1.0 / squared.sqrt();
        self.light.of_cosines(self.gradient.dot(point) * inverse, self.sun.dot(point) * inverse)
    }
}
