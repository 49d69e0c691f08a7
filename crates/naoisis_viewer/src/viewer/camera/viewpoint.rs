//! A viewpoint and its changes by the mouse.

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use naoisis_core::geometry::Pose;
use naoisis_core::pitch::Pitch;

/// The vertical field of view, radians.
pub const FIELD_OF_VIEW: f32 = 0.5;
/// The turn for a drag of one pixel, radians.
const TURN_PER_PIXEL: f32 = 0.005;
/// The change of the logarithm of the distance for one notch of the wheel.
const ZOOM_PER_NOTCH: f32 = 0.12;
/// The largest elevation, radians; less than vertical, where the up direction is undefined.
const STEEPEST: f32 = FRAC_PI_2 - 0.002;
/// The smallest elevation, radians, so that the camera stays above the ground.
const FLATTEST: f32 = 0.03;
/// How far the camera may look up when it looks around, radians.
const HIGHEST_LOOK: f32 = -1.2;
/// The lowest height in flight, m.
const LOWEST_FLIGHT: f32 = 0.05;
/// The distance of a flight for one notch of the wheel, m.
const FLIGHT_PER_NOTCH: f32 = 0.3;
/// The range of distances, m. The largest pitches fit into the narrowest windows.
const DISTANCES: [f32; 2] = [0.4, 150.0];

/// Views of the whole pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Overview {
    /// From the side, as on television.
    Broadcast,
    /// From above.
    TopDown,
}

/// A viewpoint of the camera.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Viewpoint {
    /// The point looked at, m, pitch frame.
    pub focus: Vec3,
    /// The direction from the focus to the camera: 0 at -y, a quarter turn at +x, radians.
    pub azimuth: f32,
    /// The elevation above the ground, radians.
    pub elevation: f32,
    /// Distance, m.
    pub distance: f32,
}

impl Viewpoint {
    /// The unit vector from the focus to the camera.
    fn direction(&self) -> Vec3 {
        let (sin_azimuth, cos_azimuth) = ops::sin_cos(self.azimuth);
        let (sin_elevation, cos_elevation) = ops::sin_cos(self.elevation);
        Vec3::new(sin_azimuth * cos_elevation, -cos_azimuth * cos_elevation, sin_elevation)
    }

    /// Returns the position of the camera, m, pitch frame.
    pub fn eye(&self) -> Vec3 {
        self.focus + self.distance * self.direction()
    }

    /// Returns the transform of the camera in the pitch frame.
    pub fn transform(&self) -> Transform {
        Transform::from_translation(self.eye()).looking_at(self.focus, Vec3::Z)
    }

    /// A view of the whole pitch, as large as it fits into an area with this `aspect` (width by height).
    pub fn of_pitch(preset: Overview, pitch: &Pitch, aspect: f32) -> Self {
        Self::of_pitches(preset, pitch, 0.0, aspect)
    }

    /// A view like [`Viewpoint::of_pitch`] of the pitch and of a second one of the same size, `second_m` further in +y.
    pub fn of_pitches(preset: Overview, pitch: &Pitch, second_m: f32, aspect: f32) -> Self {
        /// The height of what stands on the pitch, m.
        const ROBOTS_M: f32 = 0.6;
        let elevation = match preset {
            Overview::Broadcast => 0.6,
            Overview::TopDown => STEEPEST,
        };
        // Half of the border outside the lines is in view, and the goals.
        let half_length = pitch.half_length() + pitch.goal.depth_m.max(pitch.border_m / 2.0);
        let half_width = pitch.half_width() + pitch.border_m / 2.0;
        let signs = [-1.0, 1.0];
        let corners = signs.into_iter().flat_map(|x| signs.map(|y| Vec2::new(x * half_length, y * half_width)));
        let corners = corners.flat_map(|corner| [0.0, second_m].map(|y| corner + Vec2::Y * y));
        let points: Vec<Vec3> = corners.flat_map(|corner| [0.0, ROBOTS_M].map(|z| corner.extend(z))).collect();
        Self { focus: Vec3::ZERO, azimuth: 0.0, elevation, distance: 1.0 }.fitted(&points, aspect)
    }

    /// The viewpoint with the same direction, as near as possible with all `points` in view, in an area with this
    /// `aspect`.
    fn fitted(self, points: &[Vec3], aspect: f32) -> Self {
        let transform = Transform::default().looking_to(-self.direction(), Vec3::Z);
        let (right, up, ahead) = (*transform.right(), *transform.up(), *transform.forward());
        let tangent = ops::tan(FIELD_OF_VIEW / 2.0);
        // The camera has to be behind four planes: each contains an edge of the picture and the point farthest out at that edge.
        let farthest = |side: Vec3, tangent: f32| {
            points.iter().map(|point| (side - tangent * ahead).dot(*point)).fold(f32::NEG_INFINITY, f32::max)
        };
        let [upper, lower] = [up, -up].map(|side| farthest(side, tangent));
        let [rightmost, leftmost] = [right, -right].map(|side| farthest(side, aspect * tangent));
        let back = ((upper + lower) / (2.0 * tangent)).max((rightmost + leftmost) / (2.0 * aspect * tangent));
        let eye = (upper - lower) / 2.0 * up + (rightmost - leftmost) / 2.0 * right - back * ahead;
        let distance = eye.z / -ahead.z;
        Self { focus: eye + distance * ahead, distance, ..self }
    }

    /// A view of the part of the pitch about the ball, from the side: nearer than the whole pitch, and never beyond its
    /// ends.
    pub fn of_play(ball: Vec2, pitch: &Pitch, aspect: f32) -> Self {
        /// The distance, as a fraction of that for the whole pitch.
        const NEARNESS: f32 = 0.6;
        /// How far the centre of the picture follows the ball, as fractions.
        const ALONG: Vec2 = Vec2::new(0.75, 0.4);
        let whole = Self::of_pitch(Overview::Broadcast, pitch, aspect);
        let half = Vec2::new(pitch.half_length(), pitch.half_width());
        let focus = (ALONG * ball.clamp(-half, half)).extend(0.0) + Vec3::Y * whole.focus.y * NEARNESS;
        Self { focus, elevation: 0.5, distance: NEARNESS * whole.distance, ..whole }
    }

    /// Returns whether only a small part of the pitch is in view.
    pub fn is_close_up(&self, pitch: &Pitch) -> bool {
        /// The distance below which it is, as a fraction of that for the whole pitch in a usual window.
        const NEARNESS: f32 = 0.5;
        const ASPECT: f32 = 1.5;
        self.distance < NEARNESS * Self::of_pitch(Overview::Broadcast, pitch, ASPECT).distance
    }

    /// A close view of the ball from the side.
    pub fn of_ball(ball: Vec2) -> Self {
        Self { focus: ball.extend(0.0), azimuth: 0.0, elevation: 0.4, distance: 3.2 }
    }

    /// A view from behind a robot, over its shoulders.
    pub fn behind(robot: Pose) -> Self {
        let focus = robot.transform_point(Vec2::new(0.5, 0.0)).extend(0.3);
        Self { focus, azimuth: robot.heading - FRAC_PI_2, elevation: 0.35, distance: 2.4 }
    }

    /// The view for robots of this height, m: farther away and aimed higher for tall ones.
    pub fn for_height(self, height_m: f32) -> Self {
        /// The height of the robots for which views are made, m: a NAO.
        const NAO_M: f32 = 0.58;
        let factor = (height_m / NAO_M).max(1.0);
        Self { focus: self.focus * Vec3::new(1.0, 1.0, factor), distance: factor * self.distance, ..self }
    }

    /// A view of a position on the pitch from the same direction, with this distance around it in view, m.
    pub fn at(self, place: Vec2, reach_m: f32) -> Self {
        let nearest = (1.2 * reach_m / ops::tan(FIELD_OF_VIEW / 2.0)).min(DISTANCES[1]);
        Self { focus: place.extend(0.0), distance: self.distance.clamp(nearest, nearest.max(3.5)), ..self }
    }

    /// Interpolates between two viewpoints.
    pub fn eased(self, to: Viewpoint, share: f32) -> Viewpoint {
        Viewpoint {
            focus: self.focus.lerp(to.focus, share),
            azimuth: self.azimuth.lerp(to.azimuth, share),
            elevation: self.elevation.lerp(to.elevation, share),
            distance: self.distance.lerp(to.distance, share),
        }
    }

    /// Turns the viewpoint by a drag of this many pixels.
    pub fn turned(mut self, pixels: Vec2) -> Self {
        self.azimuth -= pixels.x * TURN_PER_PIXEL;
        self.elevation = (self.elevation + pixels.y * TURN_PER_PIXEL).clamp(FLATTEST, STEEPEST);
        self
    }

    /// Moves the viewpoint along the ground by a drag of this many pixels in an area of this height.
    pub fn shifted(mut self, pixels: Vec2, height: f32) -> Self {
        let metres = pixels * self.metres_per_pixel(height);
        let (sin, cos) = ops::sin_cos(self.azimuth);
        let right = Vec2::new(cos, sin);
        let moved = metres.y * right.perp() - metres.x * right;
        self.focus += moved.extend(0.0);
        self
    }

    /// Moves closer by this many notches of the wheel.
    pub fn zoomed(self, notches: f32) -> Self {
        self.farther(ops::exp(-ZOOM_PER_NOTCH * notches))
    }

    /// Multiplies the distance by `factor`.
    pub fn farther(mut self, factor: f32) -> Self {
        self.distance = (self.distance * factor).clamp(DISTANCES[0], DISTANCES[1]);
        self
    }

    /// The size of a pixel at the focus in an area of this height, m.
    fn metres_per_pixel(&self, height: f32) -> f32 {
        2.0 * self.distance * ops::tan(FIELD_OF_VIEW / 2.0) / height
    }

    /// Looks around from the same position by a drag of this many pixels.
    pub fn looked(self, pixels: Vec2) -> Self {
        let eye = self.eye();
        let mut looked = self;
        looked.azimuth -= pixels.x * TURN_PER_PIXEL;
        looked.elevation = (self.elevation + pixels.y * TURN_PER_PIXEL).clamp(HIGHEST_LOOK, STEEPEST);
        looked.focus = eye - looked.distance * looked.direction();
        looked
    }

    /// Flies forward by this many notches of the wheel.
    pub fn flown(self, notches: f32) -> Self {
        let way = -FLIGHT_PER_NOTCH * notches * self.direction();
        self.lifted_to_flight(self.focus + way)
    }

    /// Flies sideways and up by a drag of this many pixels in an area of this height.
    pub fn drifted(self, pixels: Vec2, height: f32) -> Self {
        let metres = 2.0 * FLIGHT_PER_NOTCH * 10.0 * pixels / height;
        let (sin, cos) = ops::sin_cos(self.azimuth);
        self.lifted_to_flight(self.focus - metres.x * Vec3::new(cos, sin, 0.0) + metres.y * Vec3::Z)
    }

    /// Sets the focus, but keeps the camera above the ground.
    fn lifted_to_flight(self, focus: Vec3) -> Self {
        let moved = Self { focus, ..self };
        let lift = (LOWEST_FLIGHT - moved.eye().z).max(0.0);
        Self { focus: focus + lift * Vec3::Z, ..moved }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tall_robots_are_seen_from_farther_away() {
        let view = Viewpoint::behind(Pose::default());
        assert_eq!((view.for_height(0.58), view.for_height(0.4)), (view, view));
        let far = view.for_height(1.16);
        assert_eq!((far.distance, far.focus.z), (2.0 * view.distance, 2.0 * view.focus.z));
    }

    #[test]
    fn a_broadcast_has_the_yellow_goal_on_the_right() {
        let view = Viewpoint::of_pitch(Overview::Broadcast, &Pitch::default(), 1.6);
        let transform = view.transform();
        assert!(transform.translation.y < -3.0 && transform.translation.z > 2.0);
        assert!(transform.right().abs_diff_eq(Vec3::X, 1e-5));
    }

    #[test]
    fn a_view_of_a_place_is_a_close_up_and_one_of_play_is_none() {
        let pitch = Pitch::default();
        let whole = Viewpoint::of_pitch(Overview::Broadcast, &pitch, 1.6);
        assert!(!whole.is_close_up(&pitch) && !Viewpoint::of_play(Vec2::ONE, &pitch, 1.6).is_close_up(&pitch));
        assert!(whole.at(Vec2::ONE, 0.5).is_close_up(&pitch) && Viewpoint::of_ball(Vec2::ONE).is_close_up(&pitch));
    }

    #[test]
    fn from_above_up_is_plus_y() {
        let view = Viewpoint::of_pitch(Overview::TopDown, &Pitch::default(), 1.6);
        assert!(view.transform().up().abs_diff_eq(Vec3::Y, 0.01));
    }

    #[test]
    fn the_whole_pitch_is_in_view() {
        let pitch = Pitch::default();
        for (preset, aspect) in [Overview::Broadcast, Overview::TopDown]
            .into_iter()
            .flat_map(|preset| [0.5, 1.0, 1.6, 16.0 / 9.0, 3.0].map(|aspect| (preset, aspect)))
        {
            let camera_from_pitch = Viewpoint::of_pitch(preset, &pitch, aspect).transform().to_matrix().inverse();
            for corner in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let point = Vec3::new(corner.0 * pitch.half_length(), corner.1 * pitch.half_width(), 0.0);
                let seen = camera_from_pitch.transform_point3(point);
                let half_height = -seen.z * ops::tan(FIELD_OF_VIEW / 2.0);
                assert!(seen.x.abs() < aspect * half_height, "{preset:?} {aspect} {seen}");
                assert!(seen.y.abs() < half_height, "{preset:?} {aspect} {seen}");
            }
        }
    }

    #[test]
    fn the_pitch_fills_what_is_left_of_the_window() {
        let pitch = Pitch::default();
        let far = |aspect| Viewpoint::of_pitch(Overview::TopDown, &pitch, aspect).distance;
        let per_distance = 2.0 * ops::tan(FIELD_OF_VIEW / 2.0);
        // In a wide area the width of the carpet fills the height. Robots are nearer to the camera than the ground is.
        let height = pitch.width_m + pitch.border_m;
        assert!((far(5.0) - (height / per_distance + 0.6)).abs() < 0.01, "{}", far(5.0));
        // In a narrow area the length of the carpet fills the width.
        assert!((far(0.5) - 0.6) * per_distance * 0.5 >= pitch.length_m, "{}", far(0.5));
        assert!(far(0.25) > 1.9 * far(0.5));
    }

    #[test]
    fn who_follows_play_sees_the_ball_wherever_it_is() {
        let pitch = Pitch::default();
        for aspect in [1.0, 16.0 / 9.0] {
            for ball in [Vec2::ZERO, Vec2::new(3.0, 2.0), Vec2::new(-3.0, -2.0), Vec2::new(3.2, 0.0)] {
                let view = Viewpoint::of_play(ball, &pitch, aspect);
                let seen = view.transform().to_matrix().inverse().transform_point3(ball.extend(0.0));
                let half_height = -seen.z * ops::tan(FIELD_OF_VIEW / 2.0);
                let share = Vec2::new(seen.x / aspect, seen.y) / half_height;
                assert!(share.abs().max_element() < 0.9, "the ball at {ball} is seen at {share}");
                assert!(view.distance < Viewpoint::of_pitch(Overview::Broadcast, &pitch, aspect).distance);
            }
        }
    }

    #[test]
    fn the_ground_goes_along_with_the_mouse() {
        let view = Viewpoint::of_pitch(Overview::TopDown, &Pitch::default(), 1.6);
        // A drag to the right by half the window's height moves the focus as far to the left.
        let shifted = view.shifted(Vec2::new(50.0, 0.0), 100.0);
        let expected = -view.distance * ops::tan(FIELD_OF_VIEW / 2.0);
        assert!((shifted.focus.x - expected).abs() < 1e-4);
        assert!(view.shifted(Vec2::new(0.0, 50.0), 100.0).focus.y > 0.0);
    }

    #[test]
    fn the_camera_stays_above_the_ground() {
        let view = Viewpoint::of_pitch(Overview::Broadcast, &Pitch::default(), 1.6);
        assert_eq!(view.turned(Vec2::new(0.0, -1e4)).elevation, FLATTEST);
        assert_eq!(view.turned(Vec2::new(0.0, 1e4)).elevation, STEEPEST);
        assert_eq!(view.zoomed(1e3).distance, DISTANCES[0]);
    }

    #[test]
    fn a_view_from_behind_looks_where_the_robot_looks() {
        for heading in [0.0, 1.0, -2.5] {
            let robot = Pose::new(1.0, 0.5, heading);
            let forward = Viewpoint::behind(robot).transform().forward().truncate().normalize();
            assert!(forward.abs_diff_eq(robot.forward(), 1e-5), "{heading}: {forward}");
        }
    }

    #[test]
    fn who_looks_around_stays_where_it_is_and_who_flies_goes_where_it_looks() {
        let view = Viewpoint::of_pitch(Overview::Broadcast, &Pitch::default(), 1.6);
        let looked = view.looked(Vec2::new(120.0, -60.0));
        assert!(looked.eye().abs_diff_eq(view.eye(), 1e-4));
        assert!(!looked.transform().forward().abs_diff_eq(*view.transform().forward(), 0.1));
        let way = looked.flown(2.0).eye() - looked.eye();
        assert!(way.abs_diff_eq(2.0 * FLIGHT_PER_NOTCH * looked.transform().forward(), 1e-4));
        assert!(looked.flown(1e3).eye().z >= LOWEST_FLIGHT - 1e-3);
    }
}
