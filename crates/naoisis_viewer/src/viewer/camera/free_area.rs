//! A projection that centres the match in the part of the window that panels leave free. The picture continues behind
//! the panels.

use bevy::camera::{CameraProjection, SubCameraView};
use bevy::math::{Vec3A, ops};
use bevy::prelude::*;

/// A perspective projection with the field of view and the centre of an area of the window. The rest of the window
/// shows the surroundings.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AreaPerspective {
    /// The vertical field of view of the area, radians.
    pub field_of_view: f32,
    /// The near plane, m.
    pub near_m: f32,
    /// The area, logical pixels of the window.
    pub area: Rect,
    /// The size of the window, logical pixels.
    pub window: Vec2,
}

/// The far plane, m.
const FAR_M: f32 = 1000.0;

impl AreaPerspective {
    /// The edges of the window from the camera: left, right, lower and upper, as tangents of their angles.
    fn tangents(&self) -> [f32; 4] {
        let per_pixel = 2.0 * ops::tan(self.field_of_view / 2.0) / self.area.height().max(1.0);
        let middle = self.area.center();
        let edges = [-middle.x, self.window.x - middle.x, middle.y - self.window.y, middle.y];
        edges.map(|pixels| pixels * per_pixel)
    }
}

impl CameraProjection for AreaPerspective {
    fn get_clip_from_view(&self) -> Mat4 {
        let [left, right, lower, upper] = self.tangents();
        let (width, height) = (right - left, upper - lower);
        // Near points have depth 1, infinitely distant ones 0.
        Mat4::from_cols(
            Vec4::new(2.0 / width, 0.0, 0.0, 0.0),
            Vec4::new(0.0, 2.0 / height, 0.0, 0.0),
            Vec4::new((right + left) / width, (upper + lower) / height, 0.0, -1.0),
            Vec4::new(0.0, 0.0, self.near_m, 0.0),
        )
    }

    fn get_clip_from_view_for_sub(&self, _part: &SubCameraView) -> Mat4 {
        self.get_clip_from_view()
    }

    fn update(&mut self, width: f32, height: f32) {
        self.window = Vec2::new(width, height);
    }

    fn far(&self) -> f32 {
        FAR_M
    }

    fn get_frustum_corners(&self, z_near: f32, z_far: f32) -> [Vec3A; 8] {
        let [left, right, lower, upper] = self.tangents();
        let corners = [[right, lower], [right, upper], [left, upper], [left, lower]];
        let at = |z: f32| corners.map(|[x, y]| Vec3A::new(x * z.abs(), y * z.abs(), z));
        let ([a, b, c, d], [e, f, g, h]) = (at(z_near), at(z_far));
        [a, b, c, d, e, f, g, h]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The window coordinates of a point, logical pixels.
    fn seen(perspective: &AreaPerspective, place: Vec3) -> Vec2 {
        let clip = perspective.get_clip_from_view().project_point3(place);
        (clip.truncate() * Vec2::new(0.5, -0.5) + 0.5) * perspective.window
    }

    #[test]
    fn what_is_looked_at_is_in_the_middle_of_the_free_area_and_fills_it() {
        let area = Rect::new(300.0, 40.0, 900.0, 440.0);
        let perspective = AreaPerspective { field_of_view: 0.5, near_m: 0.02, area, window: Vec2::new(1000.0, 600.0) };
        let upper = 10.0 * ops::tan(0.25);
        for (place, expected) in [
            (Vec3::new(0.0, 0.0, -10.0), area.center()),
            (Vec3::new(0.0, 0.0, -3.0), area.center()),
            (Vec3::new(0.0, upper, -10.0), Vec2::new(600.0, 40.0)),
            (Vec3::new(1.5 * upper, -upper, -10.0), area.max),
        ] {
            let actual = seen(&perspective, place);
            assert!(actual.abs_diff_eq(expected, 0.01), "{place} is seen at {actual} instead of {expected}");
        }
        // The corners of the frustum are those of the window.
        let [near, .., far] = perspective.get_frustum_corners(-1.0, -8.0);
        assert!(seen(&perspective, near.into()).abs_diff_eq(Vec2::new(1000.0, 600.0), 0.01));
        assert!(seen(&perspective, far.into()).abs_diff_eq(Vec2::new(0.0, 600.0), 0.01));
    }
}
