//! The visible part of the ground.

use bevy::prelude::*;

use super::CameraView;

impl CameraView {
    /// The corners of the visible ground, robot frame, m, at most `furthest_m` ahead of the lens; empty if no ground is visible.
    ///
    /// The image is cut off at that distance. Straight lines in the image are straight on the ground, unless the lens distorts them; then
    /// there are points between the corners.
    pub fn seen_ground(&self, furthest_m: f32) -> Vec<Vec2> {
        let corners: Vec<Vec2> = self.intrinsics.outline().collect();
        // The least fall of a ray with a unit component ahead that reaches the ground at `furthest_m` or nearer.
        let level = Vec2::new(self.forward.x, self.forward.y).length().max(1e-6);
        let least_fall = self.lens.z / furthest_m * level;
        let fall = |pixel: Vec2| -self.ray(pixel).z - least_fall;
        let mut outline = Vec::with_capacity(corners.len() + 1);
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
        outline.into_iter().filter_map(|pixel| self.ground_point(pixel)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::camera_model::CameraName;
    use crate::camera_model::tests::camera;
    use crate::robot::head::HeadAngles;
    use approx::assert_abs_diff_eq;
    use bevy::math::ops;
    use core::f32::consts::FRAC_PI_2;

    #[test]
    fn the_lower_camera_of_a_level_head_sees_a_trapezium() {
        let camera = camera(CameraName::BOTTOM, HeadAngles::default());
        let outline = camera.seen_ground(8.0);
        // The edges look 40° ± 18.4° down: the lens is h above the ground, so that they meet it at h / tan(angle).
        let half = ops::atan(camera.intrinsics.half_slopes().y);
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
        let outline = level.seen_ground(6.0);
        let furthest = outline.iter().map(|corner| corner.x).fold(0.0, f32::max);
        assert_abs_diff_eq!(furthest, 6.0 + level.lens.x, epsilon = 1e-3);
        let up = camera(CameraName::TOP, HeadAngles { yaw: 0.0, pitch: -30.0_f32.to_radians() });
        assert_eq!(up.seen_ground(6.0), []);
        // Turned with the head.
        let left = camera(CameraName::TOP, HeadAngles { yaw: FRAC_PI_2, pitch: 0.0 });
        assert!(left.seen_ground(6.0).iter().all(|corner| corner.y > 1.0));
    }
}
