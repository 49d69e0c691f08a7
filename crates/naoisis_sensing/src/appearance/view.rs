//! The camera of a picture.

use bevy::math::{Affine3A, Mat3, Vec2, Vec3, ops};

use naoisis_core::camera_model::{CameraView, Pinhole};
use naoisis_core::team::RobotId;

/// A pinhole camera anywhere, and the options of its picture. Pitch frame, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct View {
    /// The intrinsics. The picture has their size, in whole pixels.
    pub intrinsics: Pinhole,
    /// The place of the lens.
    pub eye: Vec3,
    /// The direction of the picture's u axis, unit vector.
    pub right: Vec3,
    /// The direction of the picture's v axis, unit vector.
    pub down: Vec3,
    /// The direction in which the camera looks, unit vector.
    pub forward: Vec3,
    /// The robot with the camera, which does not see itself.
    pub hidden: Option<RobotId>,
    /// The number of samples along each side of a pixel, at least 1. More samples give smoother edges.
    pub supersampling: u32,
    /// Whether pixels of one sample integrate the light over their area, as those of a sensor do, so that distant lines remain visible. The
    /// software renderer does so on the ground, a graphics card everywhere.
    pub antialiasing: bool,
    /// Whether bodies cast shadows.
    pub shadows: bool,
}

impl View {
    /// The view of a camera of `robot`, whose transform is `world_from_robot`: everything that the camera shows, without its distortion.
    pub fn of_robot(camera: &CameraView, world_from_robot: Affine3A, robot: RobotId) -> Self {
        let turned = |direction: Vec3| world_from_robot.transform_vector3(direction);
        Self {
            intrinsics: camera.intrinsics.drawn(),
            eye: world_from_robot.transform_point3(camera.lens),
            right: turned(camera.right),
            down: turned(camera.down),
            forward: turned(camera.forward),
            hidden: Some(robot),
            supersampling: 1,
            antialiasing: true,
            shadows: false,
        }
    }

    /// The view from `eye` to `target` with this size, pixels, and vertical field of view, radians, with shadows and smooth edges. In a view
    /// straight down, +y is up.
    pub fn looking_at(eye: Vec3, target: Vec3, vertical_fov: f32, [width, height]: [u32; 2]) -> Self {
        let forward = (target - eye).normalize_or(Vec3::X);
        let right = forward.cross(Vec3::Z).try_normalize().unwrap_or(Vec3::X);
        let size = Vec2::new(width as f32, height as f32);
        let focal_length = size.y / 2.0 / ops::tan(vertical_fov / 2.0);
        Self {
            intrinsics: Pinhole { focal_length, centre: size / 2.0, size },
            eye,
            right,
            down: forward.cross(right),
            forward,
            hidden: None,
            supersampling: 3,
            antialiasing: true,
            shadows: true,
        }
    }

    /// The width and height of the picture, pixels.
    pub fn size(&self) -> [usize; 2] {
        let size = self.intrinsics.size;
        [size.x as usize, size.y as usize]
    }

    /// The rotation from the pitch frame to the camera's axes (right, down, forward).
    pub fn camera_from_world(&self) -> Mat3 {
        Mat3::from_cols(self.right, self.down, self.forward).transpose()
    }

    /// Transforms a point from the pitch frame to the camera frame: to the right, down and ahead of the lens, m.
    pub fn to_camera(&self, point: Vec3) -> Vec3 {
        let offset = point - self.eye;
        Vec3::new(self.right.dot(offset), self.down.dot(offset), self.forward.dot(offset))
    }

    /// The pixel of a point ahead of the lens, in the picture or not; `None` for a point behind it.
    pub fn project(&self, point: Vec3) -> Option<Vec2> {
        let in_camera = self.to_camera(point);
        let Pinhole { focal_length, centre, .. } = self.intrinsics;
        (in_camera.z > 1e-3).then(|| centre + in_camera.truncate() * (focal_length / in_camera.z))
    }

    /// The direction of a pixel's ray, with a unit component along [`View::forward`].
    pub fn ray(&self, pixel: Vec2) -> Vec3 {
        let slope = (pixel - self.intrinsics.centre) / self.intrinsics.focal_length;
        self.forward + slope.x * self.right + slope.y * self.down
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_it_looks_at_is_in_the_middle_and_up_is_up() {
        let target = Vec3::new(1.0, 2.0, 0.3);
        for eye in [Vec3::new(4.0, -3.0, 5.0), Vec3::new(1.0, 2.0, 6.0)] {
            let view = View::looking_at(eye, target, 0.8, [640, 480]);
            assert!(view.project(target).unwrap().abs_diff_eq(Vec2::new(320.0, 240.0), 1e-3));
            assert!((view.right.cross(view.down) - view.forward).length() < 1e-6);
        }
        let view = View::looking_at(Vec3::new(4.0, -3.0, 5.0), target, 0.8, [640, 480]);
        assert!(view.project(target + Vec3::Z * 0.1).unwrap().y < 240.0);
    }

    #[test]
    fn a_ray_goes_through_the_points_of_its_pixel() {
        let view = View::looking_at(Vec3::new(4.0, -3.0, 5.0), Vec3::ZERO, 0.8, [640, 480]);
        let pixel = Vec2::new(100.5, 300.25);
        let point = view.eye + 3.0 * view.ray(pixel);
        assert!(view.project(point).unwrap().abs_diff_eq(pixel, 1e-2));
    }
}
