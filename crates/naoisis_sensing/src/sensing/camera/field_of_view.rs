//! The approximate field of view of a robot's cameras, by which it decides where to look and whether an object should be in view.

use bevy::math::{Vec2, ops};
use std::sync::LazyLock;

use super::CameraSettings;
use naoisis_core::camera_model::{CameraIntrinsics, CameraMount, CameraMounts};
use naoisis_core::geometry::unit;

/// The approximate field of view of a robot's cameras, with one height for all of them and a margin at the edges of the images.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct FieldOfView {
    /// Height of the lenses, m.
    pub lens_height_m: f32,
    /// The tilt of each camera below the head's axis, radians.
    tilts: [f32; CameraMounts::MOST],
    /// Half the height (an angle) and half the width (a slope) of each image, as multiples of a NAO's.
    sizes: [Vec2; CameraMounts::MOST],
    /// The pan of each camera to the left of the head's axis, radians.
    pans: [f32; CameraMounts::MOST],
    count: usize,
}

/// The greatest pan at which a camera is turned towards a target, radians: 45°.
const AHEAD: f32 = core::f32::consts::FRAC_PI_4;

/// The height of a NAO's lenses, between those of its two cameras (paper, Table 1a), m.
const NAO_LENS_HEIGHT_M: f32 = 0.5;

impl FieldOfView {
    /// The field of view of these cameras.
    pub fn of(cameras: &CameraSettings) -> Self {
        /// A NAO's cameras, half the size of their images, and the mean height of their mounts.
        static NAO: LazyLock<(CameraSettings, Vec2, f32)> = LazyLock::new(|| {
            let cameras = CameraSettings::default();
            let half_size = half_size(CameraIntrinsics::from(&cameras));
            let mean_height = mean_height(cameras.mounts.as_slice());
            (cameras, half_size, mean_height)
        });
        let (nao, nao_half_size, nao_mean_height) = &*NAO;
        let size_of = |cameras: &CameraSettings| (cameras.width, cameras.height, cameras.diagonal_fov);
        // Called in every cycle, so that the most common cameras need no trigonometry.
        let is_undistorted = cameras.calibration.is_none() && cameras.lens.distortion.is_none();
        let is_as_naos = is_undistorted && size_of(cameras) == size_of(nao);
        let common = if is_as_naos { Vec2::ONE } else { half_size(CameraIntrinsics::from(cameras)) / *nao_half_size };
        let mounts = cameras.mounts.as_slice();
        let mut view = Self {
            lens_height_m: NAO_LENS_HEIGHT_M * (mean_height(mounts) / nao_mean_height),
            tilts: [0.0; CameraMounts::MOST],
            sizes: [Vec2::ONE; CameraMounts::MOST],
            pans: [0.0; CameraMounts::MOST],
            count: mounts.len(),
        };
        for (index, mount) in mounts.iter().enumerate() {
            view.tilts[index] = mount.tilt();
            view.pans[index] = mount.pan();
            let own = || half_size(cameras.intrinsics(mount)) / *nao_half_size;
            view.sizes[index] = if mount.is_as_others() { common } else { own() };
        }
        view
    }

    /// The cameras that look ahead, or all of them if none does: the tilt below the head's axis, radians, and the height of the image as a
    /// multiple of a NAO's, which reaches 18.4° up and down.
    pub fn cameras(&self) -> impl Iterator<Item = (f32, f32)> + Clone + '_ {
        let is_ahead = |index: &usize| self.pans[*index].abs() <= AHEAD;
        let any_is = (0..self.count).any(|index| is_ahead(&index));
        let chosen = (0..self.count).filter(move |index| is_ahead(index) || !any_is);
        chosen.map(|index| (self.tilts[index], self.sizes[index].x))
    }

    /// The greatest pan of a camera to either side, radians.
    pub fn widest_pan(&self) -> f32 {
        self.pans[..self.count].iter().fold(0.0, |widest, pan| pan.abs().max(widest))
    }

    /// The angle of a place on the ground at `distance_m` below the horizon, radians.
    pub fn depression(&self, distance_m: f32) -> f32 {
        ops::atan2(self.lens_height_m, (distance_m - 0.05).max(0.01))
    }

    /// Whether `place` on the ground, m, robot frame, is well inside the image of a camera, with the head at this yaw and pitch, radians.
    pub fn contains(&self, place: Vec2, head_yaw: f32, head_pitch: f32) -> bool {
        // Depression of the line of sight.
        let depression = ops::atan2(self.lens_height_m, place.length() - 0.05);
        (0..self.count).any(|index| {
            let pan = self.pans[index];
            let axis = unit(head_yaw + pan);
            let (along, across) = (place.dot(axis), axis.perp_dot(place));
            let Vec2 { x: height, y: width } = self.sizes[index];
            // 0.36 is the tangent of 20°; a NAO's image reaches to 24°.
            let is_beside = along < 0.05 || across.abs() > 0.36 * width * along;
            // The angle from the camera's axis; a NAO's image reaches to 18°. The head's pitch hardly tilts a camera that looks to the
            // side.
            let pitch = head_pitch * ops::cos(pan);
            !is_beside && (depression - pitch - self.tilts[index]).abs() < 0.25 * height
        })
    }
}

impl Default for FieldOfView {
    fn default() -> Self {
        Self::of(&CameraSettings::default())
    }
}

/// Half the height of the image as an angle, radians, and half its width as a slope.
fn half_size(intrinsics: CameraIntrinsics) -> Vec2 {
    let half = intrinsics.half_slopes();
    Vec2::new(ops::atan(half.y), half.x)
}

fn mean_height(mounts: &[CameraMount]) -> f32 {
    let heights = mounts.iter().map(|mount| mount.lens_m.z.max(0.05));
    if mounts.is_empty() { 1.0 } else { heights.sum::<f32>() / mounts.len() as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec3;
    use naoisis_core::robot::body::Body;
    use naoisis_core::robot::head::HeadAngles;

    #[test]
    fn a_ball_should_be_seen_where_a_camera_looks() {
        let tilt = 30.0_f32.to_radians();
        let contains = |x, y, yaw, pitch| FieldOfView::default().contains(Vec2::new(x, y), yaw, pitch);
        // Level head: the bottom camera sees 0.34 to 1.24 m, the top one from 1.67 m on.
        assert!(contains(0.7, 0.0, 0.0, 0.0) && contains(3.0, 0.0, 0.0, 0.0));
        assert!(!contains(0.2, 0.0, 0.0, 0.0) && contains(0.2, 0.0, 0.0, tilt));
        assert!(!contains(1.5, 1.5, 0.0, 0.0) && contains(1.5, 1.5, 0.8, 0.0));
        assert!(!contains(-1.0, 0.0, 0.0, 0.0));
    }

    #[test]
    fn what_is_well_in_view_has_a_pixel() {
        let tall = CameraMount::new("head".parse().unwrap(), Vec3::new(0.06, 0.0, 0.84), 0.2);
        let one = CameraSettings {
            mounts: CameraMounts::new(&[tall]).unwrap(),
            diagonal_fov: 1.9,
            ..CameraSettings::default()
        };
        let body = Body { neck_m: Vec3::Z * 0.745, ..Body::default() };
        for (cameras, body) in [(CameraSettings::default(), Body::default()), (one, body)] {
            let view = FieldOfView::of(&cameras);
            let mut seen = 0;
            for [x, y, yaw, pitch] in
                [[2.0, 0.3, 0.0, 0.0], [0.6, 0.1, 0.0, 0.0], [4.0, 1.0, 0.2, -0.1], [1.0, -0.5, -0.4, 0.3]]
            {
                if view.contains(Vec2::new(x, y), yaw, pitch) {
                    let views = cameras.views(&body, HeadAngles { yaw, pitch });
                    assert!(views.iter().any(|view| view.pixel_in_image(Vec3::new(x, y, 0.0)).is_some()), "{x} {y}");
                    seen += 1;
                }
            }
            assert!(seen >= 3 && !view.contains(Vec2::new(-1.0, 0.0), 0.0, 0.0));
        }
        assert_eq!(FieldOfView::default().lens_height_m, 0.5);
    }
}
