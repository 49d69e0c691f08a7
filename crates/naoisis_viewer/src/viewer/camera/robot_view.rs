//! The view of a robot's camera, as the camera model of the simulation defines it.

use bevy::math::{Affine3A, ops};
use bevy::prelude::*;
use naoisis_core::camera_model::{CameraIntrinsics, CameraView};

/// Returns the transform, in the pitch frame, of a Bevy camera that looks like the robot's camera.
pub fn transform(camera: &CameraView, pitch_from_robot: Affine3A) -> Transform {
    // Bevy's cameras look along -z, with y up.
    let axes = Mat3::from_cols(camera.right, -camera.down, -camera.forward);
    let rotation = Quat::from_mat3(&(Mat3::from(pitch_from_robot.matrix3) * axes));
    Transform::from_translation(pitch_from_robot.transform_point3(camera.lens)).with_rotation(rotation)
}

/// Returns the vertical field of view, radians, with which the image of a robot just fits into an area of the given `aspect`
/// (width by height).
pub fn field_of_view(intrinsics: CameraIntrinsics, aspect: f32) -> f32 {
    let drawn = intrinsics.drawn();
    let half = drawn.size / 2.0 / drawn.focal_length;
    2.0 * ops::atan(half.y.max(half.x / aspect))
}

/// Returns the part of an area of the window that the robot's image fills, without the distortion of the lens.
pub fn image_in(intrinsics: CameraIntrinsics, area: Rect) -> Rect {
    let size = intrinsics.drawn().size;
    let scale = (area.size() / size).min_element();
    Rect::from_center_size(area.center(), scale * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::body::Body;
    use naoisis_core::robot::head::HeadAngles;
    use naoisis_core::robot::posture::Posture;
    use naoisis_sensing::appearance::scene::world_from_body;
    use naoisis_sensing::sensing::camera::CameraSettings;

    /// The window coordinates of a point of the pitch in the view of a robot's camera, logical pixels.
    fn in_window(camera: &CameraView, robot: Pose, point: Vec3, window: Vec2) -> Vec2 {
        let aspect = window.x / window.y;
        let place = transform(camera, world_from_body(robot, Posture::Upright, &Body::default()));
        let seen = place.to_matrix().inverse().transform_point3(point);
        let half_height = ops::tan(field_of_view(camera.intrinsics, aspect) / 2.0);
        let in_half_windows = Vec2::new(seen.x / aspect, -seen.y) / (-seen.z * half_height);
        window / 2.0 * (Vec2::ONE + in_half_windows)
    }

    #[test]
    fn the_window_shows_what_is_in_the_robots_image_at_the_same_place() {
        let intrinsics = CameraIntrinsics::from(&CameraSettings::default());
        let robot = Pose::new(-1.0, 0.7, 0.8);
        let head = HeadAngles { yaw: -0.4, pitch: 0.2 };
        let views = CameraSettings::default().views(&Body::default(), head);
        for ((side, &camera), window) in views.named().zip([Vec2::new(1280.0, 720.0), Vec2::new(600.0, 900.0)]) {
            for pixel in [Vec2::new(10.0, 200.0), Vec2::new(300.0, 230.0), Vec2::new(160.0, 120.0)] {
                let Some(ground) = camera.ground_point(pixel) else { continue };
                let point = robot.transform_point(ground).extend(0.0);
                let frame = image_in(intrinsics, Rect::from_corners(Vec2::ZERO, window));
                let expected = frame.min + pixel / intrinsics.size * frame.size();
                let actual = in_window(&camera, robot, point, window);
                assert!(actual.abs_diff_eq(expected, 0.1), "{side:?} {pixel}: {actual} instead of {expected}");
            }
        }
    }
}
