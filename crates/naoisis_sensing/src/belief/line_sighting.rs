//! Sightings of line segments.
//!
//! The position of a segment along its line is unknown, but both of its ends are on the line. So the measurement consists of the distances
//! of the two ends from the line, which are expected to be 0.

use bevy::prelude::*;

use super::camera_error::CameraMotion;
use super::sighting::{Residual, Sighting};
use naoisis_core::geometry::unrotate;
use naoisis_core::pitch::LineSegment;

/// The greatest length by which a segment extends beyond the end of the line because of measurement errors, m.
const BEYOND_M: f32 = 0.4;
/// The least length of a useful segment, m.
const LEAST_LENGTH_M: f32 = 0.3;

/// A line segment in view.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SeenLine {
    /// Its measured ends, m, robot frame.
    ends: [Vec2; 2],
    /// The covariance of their measurement, m², robot frame.
    noise: [Mat2; 2],
}

impl SeenLine {
    /// A segment between these `ends`, m, robot frame, measured from the height `lens_height_m` by angles with a standard deviation of
    /// `angle_sd`, radians.
    pub fn new(ends: [Vec2; 2], angle_sd: f32, lens_height_m: f32) -> Self {
        let sighting = |end| Sighting::new(end, angle_sd).from_height(lens_height_m);
        Self { ends, noise: ends.map(|end| sighting(end).noise_at(end)) }
    }

    /// Whether the segment is long enough to be useful.
    pub fn is_useful(&self) -> bool {
        self.ends[0].distance_squared(self.ends[1]) > LEAST_LENGTH_M * LEAST_LENGTH_M
    }

    /// Whether the segment can belong to `line` (m, team frame), for a robot at about `position` that faces along the unit vector
    /// `forward`.
    pub fn can_be_of(&self, line: &PitchLine, position: Vec2, forward: Vec2) -> bool {
        self.ends.iter().all(|end| {
            let along = line.direction.dot(position + forward.rotate(*end) - line.start);
            (-BEYOND_M..line.length_m + BEYOND_M).contains(&along)
        })
    }

    /// Measured minus expected distances of both ends from `line` (m, team frame), for a robot at `position` that faces along the unit vector
    /// `forward`.
    pub fn residual(&self, line: &PitchLine, position: Vec2, forward: Vec2) -> Residual {
        let normal = line.direction.perp();
        let place = position - line.start;
        // Written without `map`, as mapped arrays are slow.
        let [first, second] = self.ends;
        let away = Vec2::new(normal.dot(place + forward.rotate(first)), normal.dot(place + forward.rotate(second)));
        // The error of an end across the line.
        let across = unrotate(forward, normal);
        let [first, second] = self.noise;
        let variances = Vec2::new(across.dot(first * across), across.dot(second * across));
        Residual { difference: -away, noise: Mat2::from_diagonal(variances) }
    }

    /// The derivatives of the expected distances with respect to x, y and heading of the pose, a row for each end.
    pub(super) fn slopes(&self, line: &PitchLine, forward: Vec2) -> [Vec3; 2] {
        let normal = line.direction.perp();
        let [first, second] = self.ends;
        let slope = |end: Vec2| normal.extend(normal.dot(forward.rotate(end).perp()));
        [slope(first), slope(second)]
    }

    /// The derivatives of the expected distances with respect to yaw and pitch of the cameras' error: columns of (first end, second end).
    pub(super) fn camera_slopes(&self, line: &PitchLine, forward: Vec2, camera: &CameraMotion) -> [Vec2; 2] {
        // The true end is on the line; the measured one is displaced by the error of the cameras.
        let across = unrotate(forward, line.direction.perp());
        let [first, second] = self.ends;
        let ([first_yaw, first_pitch], [second_yaw, second_pitch]) = (camera.slopes(first), camera.slopes(second));
        let change = |first: Vec2, second: Vec2| -Vec2::new(across.dot(first), across.dot(second));
        [change(first_yaw, second_yaw), change(first_pitch, second_pitch)]
    }
}

/// A straight line of the pitch, m, team frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PitchLine {
    /// The start of the line.
    start: Vec2,
    /// The direction from the start, a unit vector.
    direction: Vec2,
    length_m: f32,
}

impl From<LineSegment> for PitchLine {
    fn from(LineSegment { start, end }: LineSegment) -> Self {
        let along = end - start;
        let length_m = along.length();
        Self { start, direction: along / length_m.max(f32::MIN_POSITIVE), length_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::geometry::Pose;

    /// The line x = 3.
    const LINE: PitchLine = PitchLine { start: Vec2::new(3.0, -2.0), direction: Vec2::Y, length_m: 4.0 };

    fn residual(seen: &SeenLine, pose: Pose) -> Residual {
        seen.residual(&LINE, pose.position, pose.forward())
    }

    fn seen_from(pose: Pose) -> SeenLine {
        let ends = [Vec2::new(3.0, -0.5), Vec2::new(3.0, 1.0)].map(|end| pose.inverse_transform_point(end));
        SeenLine::new(ends, 0.01, 0.5)
    }

    #[test]
    fn a_line_tells_how_far_away_it_is_and_nothing_along_it() {
        let seen = seen_from(Pose::new(1.0, 0.0, 0.0));
        // Half a metre to the side the line looks the same; 0.2 m ahead of the true position it should be 0.2 m nearer.
        assert_abs_diff_eq!(residual(&seen, Pose::new(1.0, 0.5, 0.0)).difference.length(), 0.0, epsilon = 1e-6);
        let ahead = residual(&seen, Pose::new(1.2, 0.0, 0.0)).difference;
        assert_abs_diff_eq!(ahead.abs(), Vec2::splat(0.2), epsilon = 1e-6);
    }

    #[test]
    fn slopes_are_the_changes_of_what_is_expected() {
        let seen = seen_from(Pose::new(0.8, 0.3, 0.4));
        let pose = Pose::new(1.0, -0.2, 0.3);
        let expected = |pose: Pose| -residual(&seen, pose).difference;
        let step = 1e-3;
        for (axis, moved) in [
            Pose::new(pose.position.x + step, pose.position.y, pose.heading),
            Pose::new(pose.position.x, pose.position.y + step, pose.heading),
            Pose::new(pose.position.x, pose.position.y, pose.heading + step),
        ]
        .into_iter()
        .enumerate()
        {
            let change = (expected(moved) - expected(pose)) / step;
            let slopes = seen.slopes(&LINE, pose.forward());
            assert_abs_diff_eq!(Vec2::new(slopes[0][axis], slopes[1][axis]), change, epsilon = 5e-3);
        }
    }

    #[test]
    fn what_goes_on_beyond_the_end_is_another_line() {
        let seen = seen_from(Pose::new(1.0, 0.0, 0.0));
        assert!(seen.can_be_of(&LINE, Vec2::new(1.0, 0.0), Vec2::X));
        assert!(!seen.can_be_of(&LINE, Vec2::new(1.0, 1.5), Vec2::X));
    }
}
