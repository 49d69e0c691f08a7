//! Shapes on the ground, as pure functions.

use bevy::math::ops;
use bevy::prelude::*;

use crate::belief::PlaceCovariance;
use crate::camera_model::CameraView;
use crate::geometry::unit;

/// Within so many standard deviations lies a place with a probability of 95 %: the root of χ² with two degrees of
/// freedom.
pub const SIGMAS_95: f32 = 2.447_7;

/// The corners of the ground that a camera sees, robot frame, m, at most `furthest_m` ahead of the lens; none if it sees
/// no ground.
///
/// The image is cut off where the ground is that far away. What is straight in the image is so on the ground, too.
pub fn seen_ground(camera: &CameraView, furthest_m: f32) -> Vec<Vec2> {
    let size = camera.intrinsics.size;
    let corners = [Vec2::ZERO, size.with_y(0.0), size, size.with_x(0.0)];
    // A ray with a unit component ahead that falls by so much reaches the ground that far away.
    let level = Vec2::new(camera.forward.x, camera.forward.y).length().max(1e-6);
    let least_fall = camera.lens.z / furthest_m * level;
    let fall = |pixel: Vec2| -camera.ray(pixel).z - least_fall;
    let mut outline = Vec::with_capacity(5);
    for (index, &corner) in corners.iter().enumerate() {
        let next = corners[(index + 1) % corners.len()];
        let (here, there) = (fall(corner), fall(next));
        if here >= 0.0 {
            outline.push(corner);
        }
        if here * there < 0.0 {
            outline.push(corner.lerp(next, here / (here - there)));
        }
    }
    outline.into_iter().filter_map(|pixel| camera.ground_point(pixel)).collect()
}

/// The half axes of the ellipse of one standard deviation, the greater first, m, and the direction of the greater, radians.
/// None of what is no covariance.
pub fn ellipse([xx, xy, yy]: PlaceCovariance) -> Option<([f32; 2], f32)> {
    let middle = (xx + yy) / 2.0;
    let half_difference = (xx - yy) / 2.0;
    let offset = (half_difference * half_difference + xy * xy).sqrt();
    let variances = [middle + offset, middle - offset];
    if !variances.iter().all(|variance| variance.is_finite()) || variances[0] <= 0.0 {
        return None;
    }
    let direction = 0.5 * ops::atan2(xy, half_difference);
    // Rounding may leave a line's breadth below nothing.
    Some((variances.map(|variance| variance.max(0.0).sqrt()), direction))
}

/// Points of an arc about a centre, from an angle to another, radians.
pub fn arc(centre: Vec2, radius: f32, [from, to]: [f32; 2]) -> impl Iterator<Item = Vec2> {
    /// Of a whole circle.
    const CORNERS: f32 = 64.0;
    let count = (CORNERS * (to - from).abs() / core::f32::consts::TAU).ceil().max(1.0) as u32;
    (0..=count).map(move |index| centre + radius * unit(from + (to - from) * index as f32 / count as f32))
}

/// The outline of the part of a ring between two angles, radians.
pub fn sector(centre: Vec2, [inner, outer]: [f32; 2], [from, to]: [f32; 2]) -> Vec<Vec2> {
    arc(centre, inner, [from, to]).chain(arc(centre, outer, [to, from])).collect()
}

/// The corners of a rectangle.
pub fn corners(rectangle: Rect) -> [Vec2; 4] {
    let Rect { min, max } = rectangle;
    [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_model::CameraName;
    use crate::robot::head::HeadAngles;
    use crate::sensing::camera::CameraSettings;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};

    fn camera(side: CameraName, head: HeadAngles) -> CameraView {
        CameraSettings::default().view(side, head).unwrap()
    }

    #[test]
    fn the_lower_camera_of_a_level_head_sees_a_trapezium() {
        let camera = camera(CameraName::BOTTOM, HeadAngles::default());
        let outline = seen_ground(&camera, 8.0);
        // The edges look 40° ± 18.4° down: the lens is h above the ground, so that they meet it at h / tan(angle).
        let half = ops::atan(camera.intrinsics.size.y / 2.0 / camera.intrinsics.focal_length);
        let tilt = 40.0_f32.to_radians();
        let at = |angle: f32| camera.lens.x + camera.lens.z / ops::tan(angle);
        let xs = [tilt - half, tilt - half, tilt + half, tilt + half].map(at);
        assert_eq!(outline.len(), 4);
        for (corner, x) in outline.iter().zip(xs) {
            assert_abs_diff_eq!(corner.x, x, epsilon = 1e-3);
        }
        assert!(outline[0].y > 0.0 && outline[1].y < 0.0 && outline[0].y > outline[3].y, "{outline:?}");
    }

    #[test]
    fn the_upper_camera_sees_the_ground_as_far_as_asked_for_and_none_above_the_horizon() {
        let level = camera(CameraName::TOP, HeadAngles::default());
        let outline = seen_ground(&level, 6.0);
        let furthest = outline.iter().map(|corner| corner.x).fold(0.0, f32::max);
        assert_abs_diff_eq!(furthest, 6.0 + level.lens.x, epsilon = 1e-3);
        let up = camera(CameraName::TOP, HeadAngles { yaw: 0.0, pitch: -30.0_f32.to_radians() });
        assert_eq!(seen_ground(&up, 6.0), []);
        // Turned with the head.
        let left = camera(CameraName::TOP, HeadAngles { yaw: FRAC_PI_2, pitch: 0.0 });
        assert!(seen_ground(&left, 6.0).iter().all(|corner| corner.y > 1.0));
    }

    #[test]
    fn an_ellipse_has_the_axes_that_were_turned_into_the_covariance() {
        // R diag(0.09, 0.01) Rᵀ with R a turn by 30°.
        let (sin, cos) = ops::sin_cos(FRAC_PI_6);
        let covariance =
            [0.09 * cos * cos + 0.01 * sin * sin, (0.09 - 0.01) * sin * cos, 0.09 * sin * sin + 0.01 * cos * cos];
        let (axes, direction) = ellipse(covariance).unwrap();
        assert_abs_diff_eq!(axes[0], 0.3, epsilon = 1e-4);
        assert_abs_diff_eq!(axes[1], 0.1, epsilon = 1e-4);
        assert_abs_diff_eq!(direction, FRAC_PI_6, epsilon = 1e-4);
        assert_abs_diff_eq!(ellipse([0.01, 0.0, 0.04]).unwrap().1.abs(), FRAC_PI_2, epsilon = 1e-6);
        assert_eq!(ellipse([0.0, 0.0, 0.0]), None);
        assert_eq!(ellipse([f32::NAN, 0.0, 1.0]), None);
    }

    #[test]
    fn a_sector_goes_out_along_one_edge_and_back_along_the_other() {
        let outline = sector(Vec2::new(1.0, 0.0), [0.5, 2.0], [-FRAC_PI_4, FRAC_PI_4]);
        let count = outline.len() / 2;
        let edge = unit(-FRAC_PI_4);
        assert!(outline[0].abs_diff_eq(Vec2::X + 0.5 * edge, 1e-5));
        assert!(outline[2 * count - 1].abs_diff_eq(Vec2::X + 2.0 * edge, 1e-5));
        for (index, point) in outline.iter().enumerate() {
            assert_abs_diff_eq!(point.distance(Vec2::X), if index < count { 0.5 } else { 2.0 }, epsilon = 1e-5);
        }
        assert_eq!(arc(Vec2::ZERO, 1.0, [0.0, 2.0 * PI]).count(), 65);
    }
}
