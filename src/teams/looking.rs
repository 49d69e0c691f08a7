//! Where to look: at the ball, now and then around, and everywhere when the ball is lost.

use bevy::math::ops;
use bevy::prelude::*;

use crate::belief::sighting::LENS_HEIGHT_M;
use crate::camera_model::BOTTOM_TILT;
use crate::geometry::angle_of;
use crate::robot::head::HeadCommand;

/// What is looked at stays so far from the upper and lower edge of the image, which reaches to 18.4°: radians.
const PITCH_MARGIN: f32 = 0.22;
/// The pitch from which the head is moved as little as possible, radians: level, the top camera has the goals in view.
const PREFERRED_PITCH: f32 = 0.0;
/// The greatest and least pitch that are used, radians.
const PITCH_RANGE: [f32; 2] = [-0.4, 0.52];
/// How far to either side a search goes, radians.
const SEARCH_YAW: f32 = 1.75;
/// Duration of a search from side to side and back, s.
const SEARCH_PERIOD_S: f32 = 4.0;
/// Pitch of the two halves of a search, radians: near and far, so that no strip of the ground is left out.
const SEARCH_PITCHES: [f32; 2] = [0.0, 0.31];

/// Looks at a place on the ground, m, robot frame, with the camera for which the head stays nearest to level.
pub fn look_at(place: Vec2) -> HeadCommand {
    let depression = ops::atan2(LENS_HEIGHT_M, (place.length() - 0.05).max(0.01));
    let nearest = |axis: f32| PREFERRED_PITCH.clamp(depression - axis - PITCH_MARGIN, depression - axis + PITCH_MARGIN);
    let (top, bottom) = (nearest(0.0), nearest(BOTTOM_TILT));
    let pitch = if top.abs() <= bottom.abs() { top } else { bottom };
    HeadCommand { yaw: angle_of(place), pitch: pitch.clamp(PITCH_RANGE[0], PITCH_RANGE[1]) }
}

/// Looks everywhere, in turn: where at this time, s.
pub fn search(time_s: f32) -> HeadCommand {
    let phase = (time_s / SEARCH_PERIOD_S).rem_euclid(1.0);
    // From side to side and back.
    let sweep = 1.0 - 4.0 * (phase - 0.5).abs();
    HeadCommand { yaw: SEARCH_YAW * sweep, pitch: SEARCH_PITCHES[usize::from(phase >= 0.5)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::robot::head::HeadAngles;
    use crate::sensing::camera::CameraSettings;

    fn sees(head: HeadCommand, place: Vec2) -> bool {
        CameraSettings::default()
            .views(HeadAngles { yaw: head.yaw, pitch: head.pitch })
            .iter()
            .any(|view| view.pixel_in_image(place.extend(0.03)).is_some())
    }

    #[test]
    fn whoever_looks_at_a_ball_has_it_in_an_image() {
        for step in 3..100 {
            let place = Vec2::new(step as f32 * 0.05, 0.0);
            assert!(sees(look_at(place), place), "{place} {:?}", look_at(place));
            let aside = Pose::new(0.0, 0.0, 1.2).transform_point(place);
            assert!(sees(look_at(aside), aside), "{aside}");
        }
    }

    #[test]
    fn a_search_sees_every_place_around_in_front() {
        for distance in [0.3, 0.6, 1.0, 1.3, 1.45, 1.6, 2.0, 4.0] {
            for bearing in [-1.7, -1.0, 0.0, 0.7, 1.7] {
                let place = Pose::new(0.0, 0.0, bearing).transform_point(Vec2::new(distance, 0.0));
                let seen = (0..120).filter(|cycle| sees(search(*cycle as f32 / 30.0), place)).count();
                assert!(seen >= 3, "{distance} m at {bearing}: {seen}");
            }
        }
    }
}
