//! Tests whether the cameras of a robot can show the ball at any head angles.

use bevy::math::{Vec2, ops};

use super::CameraSettings;
use naoisis_core::geometry::angle_of;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};

/// The step between the head pitches that are tried, radians: a degree.
const STEP: f32 = 0.017_453_3;
/// The nearest and the farthest distance of the ball that is tried, m.
const DISTANCES_M: [f32; 2] = [0.02, 10.0];

/// Whether a camera of a robot with this `body` shows the centre of a ball that lies at `place`, m, robot frame, when the head turns
/// towards it as far as its `limits` allow.
pub fn sees_ball(cameras: &CameraSettings, body: &Body, limits: &HeadLimits, place: Vec2, radius_m: f32) -> bool {
    let yaw = angle_of(place).max(limits.yaw[0]).min(limits.yaw[1]);
    let [highest, lowest] = limits.pitch_at(yaw);
    let steps = ops::ceil((lowest - highest).max(0.0) / STEP).max(1.0) as usize;
    (0..=steps).any(|step| {
        let pitch = highest + (lowest - highest) * step as f32 / steps as f32;
        let views = cameras.views(body, HeadAngles { yaw, pitch });
        views.iter().any(|view| view.pixel_in_image(place.extend(radius_m)).is_some())
    })
}

/// Returns the distance of the nearest ball straight ahead that a camera shows, m, to a centimetre; `None` if no camera shows one.
pub fn nearest_ball_seen_m(cameras: &CameraSettings, body: &Body, limits: &HeadLimits, radius_m: f32) -> Option<f32> {
    let [nearest, farthest] = DISTANCES_M.map(|metres| (metres * 100.0) as u16);
    (nearest..=farthest)
        .map(|centimetres| f32::from(centimetres) / 100.0)
        .find(|&distance_m| sees_ball(cameras, body, limits, Vec2::new(distance_m, 0.0), radius_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use bevy::math::Vec3;
    use naoisis_core::camera_model::{CameraMount, CameraMounts};

    /// A camera 1 m above the neck, which is 1 m high, with an image that reaches 45° up and down.
    fn mast(tilt_deg: f32) -> CameraSettings {
        let lens = CameraMount::new("head".parse().unwrap(), Vec3::Z * 1.0, tilt_deg.to_radians());
        CameraSettings {
            mounts: CameraMounts::new(&[lens]).unwrap(),
            width: 100,
            height: 100,
            // Half the diagonal of a square whose half side is 1.
            diagonal_fov: 2.0 * 2.0_f32.sqrt().atan(),
            ..CameraSettings::default()
        }
    }

    /// A body with its neck 1 m high.
    fn tall() -> Body {
        Body { neck_m: Vec3::Z, ..Body::default() }
    }

    fn fixed() -> HeadLimits {
        HeadLimits { yaw: [0.0; 2], pitch: [0.0; 2], ..HeadLimits::default() }
    }

    #[test]
    fn a_level_camera_without_a_neck_sees_no_ball_nearer_than_its_image_reaches_down() {
        // 45° down from 1 m, a point on the ground is 1 m ahead.
        assert_abs_diff_eq!(nearest_ball_seen_m(&mast(0.0), &tall(), &fixed(), 0.0).unwrap(), 1.0, epsilon = 0.011);
        // 45° + 15° down: tan 30° ahead.
        assert_abs_diff_eq!(nearest_ball_seen_m(&mast(15.0), &tall(), &fixed(), 0.0).unwrap(), 0.577, epsilon = 0.011);
        assert_eq!(nearest_ball_seen_m(&mast(-60.0), &tall(), &fixed(), 0.0), None);
        let blind = CameraSettings { mounts: CameraMounts::new(&[]).unwrap(), ..mast(0.0) };
        assert_eq!(nearest_ball_seen_m(&blind, &tall(), &HeadLimits::default(), 0.05), None);
    }

    #[test]
    fn a_head_that_nods_or_turns_sees_what_a_fixed_one_does_not() {
        let nods = HeadLimits { pitch: [0.0, 0.6], ..fixed() };
        assert!(!sees_ball(&mast(0.0), &tall(), &fixed(), Vec2::new(0.5, 0.0), 0.0));
        assert!(sees_ball(&mast(0.0), &tall(), &nods, Vec2::new(0.5, 0.0), 0.0));
        let turns = HeadLimits { yaw: [-2.0, 2.0], ..fixed() };
        assert!(!sees_ball(&mast(0.0), &tall(), &fixed(), Vec2::new(0.0, 2.0), 0.0));
        assert!(sees_ball(&mast(0.0), &tall(), &turns, Vec2::new(0.0, 2.0), 0.0));
        // The NAO sees the ball at its feet.
        assert!(sees_ball(
            &CameraSettings::default(),
            &Body::default(),
            &HeadLimits::default(),
            Vec2::new(0.17, 0.05),
            0.03
        ));
    }
}
