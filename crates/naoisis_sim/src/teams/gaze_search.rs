//! Head commands for looking at a place, and for searching from side to side.

use bevy::math::ops;
use bevy::prelude::*;

use naoisis_core::geometry::angle_of;
use naoisis_core::robot::head::{HeadCommand, HeadLimits};
use naoisis_sensing::sensing::camera::field_of_view::FieldOfView;

/// The greatest angle of a target above or below the middle of a NAO's image, which reaches to 18.4°, radians; other images in
/// proportion.
const PITCH_MARGIN: f32 = 0.22;
/// The preferred pitch of the head, radians: level, so that the top camera has the goals in view.
const PREFERRED_PITCH: f32 = 0.0;
/// The least and greatest pitch that are used, radians, if the head reaches them.
const PITCH_RANGE: [f32; 2] = [-0.4, 0.52];
/// The greatest yaw of a search to either side, radians, if the head reaches it.
const SEARCH_YAW: f32 = 1.75;
/// Duration of a search from side to side and back, s.
const SEARCH_PERIOD_S: f32 = 4.0;
/// Pitch of the two halves of a search, radians: far and near, so that no strip of the ground is left out.
const SEARCH_PITCHES: [f32; 2] = [0.0, 0.31];
/// Pitch of the lower half for a robot with a single camera, as a multiple of the height of its image in a NAO's.
const SINGLE_SEARCH_PITCH: f32 = 0.45;

/// The limits of a head and the field of view of its cameras.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Head {
    view: FieldOfView,
    yaw: [f32; 2],
    pitch: [f32; 2],
}

impl Head {
    /// A head with these `limits`, whose cameras have this `view`.
    pub fn new(limits: &HeadLimits, view: FieldOfView) -> Self {
        let [highest, lowest] = limits.pitch;
        // A head that reaches further down than a NAO's is used as far as it goes.
        let lowest = if lowest > 0.6 { lowest } else { lowest.min(PITCH_RANGE[1]) };
        Self { view, yaw: limits.yaw, pitch: [highest.max(PITCH_RANGE[0]), lowest] }
    }

    /// Returns the command to look at `place` on the ground, m, robot frame, with the camera for which the head stays nearest to level.
    pub fn look_at(&self, place: Vec2) -> HeadCommand {
        let depression = self.view.depression(place.length());
        let pitches = self.view.cameras().map(|(axis, height)| {
            let margin = PITCH_MARGIN * height;
            PREFERRED_PITCH.clamp(depression - axis - margin, depression - axis + margin)
        });
        let nearest = |best: f32, next: f32| if next.abs() < best.abs() { next } else { best };
        let pitch = pitches.reduce(nearest).unwrap_or(PREFERRED_PITCH);
        self.within_limits(angle_of(place), pitch)
    }

    /// Returns whether the head can nod so far that a camera shows `place` on the ground ahead, m, robot frame.
    pub fn can_see(&self, place: Vec2) -> bool {
        /// Half the height of a NAO's image, radians.
        const HALF_IMAGE: f32 = 0.321;
        let (pitch, depression) = (self.look_at(place).pitch, self.view.depression(place.length()));
        self.view.cameras().any(|(axis, height)| (depression - axis - pitch).abs() < HALF_IMAGE * height)
    }

    /// Returns the command of a search from side to side, near and far in turn, at the time `time_s`.
    pub fn search(&self, time_s: f32) -> HeadCommand {
        let phase = (time_s / SEARCH_PERIOD_S).rem_euclid(1.0);
        // From side to side and back.
        let sweep = 1.0 - 4.0 * (phase - 0.5).abs();
        let mut cameras = self.view.cameras();
        let pitch = match (phase >= 0.5, cameras.next(), cameras.next()) {
            (true, Some((_, height)), None) => SINGLE_SEARCH_PITCH * height,
            (is_low, ..) => SEARCH_PITCHES[usize::from(is_low)],
        };
        self.within_limits(SEARCH_YAW.min(self.yaw[1]) * sweep, pitch)
    }

    /// Returns whether the head turns at all.
    pub fn turns(&self) -> bool {
        self.yaw[0] < self.yaw[1]
    }

    /// Returns the cosine of the greatest angle from straight ahead that the middle of an image reaches.
    pub fn reach_cosine(&self) -> f32 {
        ops::cos((self.yaw[1].max(0.0) + self.view.widest_pan()).min(core::f32::consts::PI))
    }

    fn within_limits(&self, yaw: f32, pitch: f32) -> HeadCommand {
        let clamp = |value: f32, [least, most]: [f32; 2]| value.max(least).min(most);
        // The yaw is not limited here: the head itself turns as far as it can.
        HeadCommand { yaw, pitch: clamp(pitch, self.pitch) }
    }
}

impl Default for Head {
    /// The head of a NAO.
    fn default() -> Self {
        Self::new(&HeadLimits::default(), FieldOfView::default())
    }
}

/// Returns the command with which a NAO looks at `place` on the ground, m, robot frame: see [`Head::look_at`].
pub fn look_at(place: Vec2) -> HeadCommand {
    Head::default().look_at(place)
}

/// Returns the command with which a NAO searches at the time `time_s`: see [`Head::search`].
pub fn search(time_s: f32) -> HeadCommand {
    Head::default().search(time_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::head::HeadAngles;
    use naoisis_sensing::sensing::camera::CameraSettings;

    fn sees(head: HeadCommand, place: Vec2) -> bool {
        CameraSettings::default()
            .views(&naoisis_core::robot::body::Body::default(), HeadAngles { yaw: head.yaw, pitch: head.pitch })
            .iter()
            .any(|view| view.pixel_in_image(place.extend(0.03)).is_some())
    }

    #[test]
    fn a_head_that_looks_at_a_ball_has_it_in_an_image() {
        for step in 3..100 {
            let place = Vec2::new(step as f32 * 0.05, 0.0);
            assert!(sees(look_at(place), place), "{place} {:?}", look_at(place));
            let aside = Pose::new(0.0, 0.0, 1.2).transform_point(place);
            assert!(sees(look_at(aside), aside), "{aside}");
        }
    }

    #[test]
    fn a_head_that_does_not_nod_sees_no_ball_at_its_feet() {
        let level = HeadLimits { pitch: [0.0; 2], ..HeadLimits::default() };
        // The image of the lower camera reaches 58.4° down: to 0.36 m ahead.
        let head = Head::new(&level, FieldOfView::default());
        assert!(!head.can_see(Vec2::new(0.2, 0.05)) && head.can_see(Vec2::new(0.45, 0.0)));
        assert!(Head::default().can_see(Vec2::new(0.12, 0.05)));
        // A head without speed neither nods nor turns, even if its limits would let it.
        let still = HeadLimits { max_speed: 0.0, ..HeadLimits::default() };
        let still = Head::new(&still.reached_from(HeadAngles::default()), FieldOfView::default());
        assert!(!still.turns() && !still.can_see(Vec2::new(0.2, 0.05)));
        let down = HeadLimits { max_speed: 0.0, ..HeadLimits::default() };
        let down = down.reached_from(HeadAngles { yaw: 0.0, pitch: 0.5 });
        assert!(Head::new(&down, FieldOfView::default()).can_see(Vec2::new(0.2, 0.05)));
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
