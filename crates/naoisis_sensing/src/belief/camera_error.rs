//! The estimate of the error of the camera directions, which follow from the joint angles and the assumption of an upright body.
//!
//! All sightings in an image have the same error, and those of the following images nearly the same. A filter that treated it as an
//! independent error of each sighting would become certain of a wrong pose. So the error is estimated along with the pose: a bias and a
//! Gauss-Markov process of first order, in yaw and pitch each, with the robot's own [`GazeNoise`].

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::covariance::inverse;
use super::innovation::{CameraShare, Innovation, Measured};
use super::sighting::Sighting;
use crate::sensing::vision::GazeNoise;

/// The quantities of a cycle that the error of the cameras depends on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct CameraMotion {
    /// The noise of the camera directions.
    pub noise: GazeNoise,
    /// Whether the robot walks.
    pub is_walking: bool,
    /// The direction of the head: a unit vector, robot frame.
    pub head_forward: Vec2,
    /// The height of the cameras, m.
    pub lens_height_m: f32,
    /// The share of the drift that remains a cycle later.
    pub decay: f32,
}

impl CameraMotion {
    /// Standard deviation of the sum of bias and drift, for yaw and pitch each, radians.
    pub(super) fn total_sd(&self) -> f32 {
        let drift = drift_sd(self);
        (self.noise.bias_sd * self.noise.bias_sd + drift * drift).sqrt()
    }

    /// The derivatives of the measured position of a point on the ground at `place` (m, robot frame) with respect to the errors in yaw and
    /// pitch, m.
    ///
    /// If the cameras look further to the left than measured, objects appear further to the right. If they look further down, objects
    /// appear higher in the image, so further away: by h + x² / h along the head's axis, with the height h and the distance x along that
    /// axis, and by x y / h across it.
    pub(super) fn slopes(&self, place: Vec2) -> [Vec2; 2] {
        let axis = self.head_forward;
        let height_m = self.lens_height_m;
        [-place.perp(), axis * height_m + place * (place.dot(axis) / height_m)]
    }
}

/// The estimated sum of bias and drift, yaw and pitch.
pub(super) struct CameraTotal {
    /// Radians.
    mean: Vec2,
    /// Its covariance, rad².
    covariance: Mat2,
    /// The covariance between x, y (m) and heading (radians) of the pose, a row each, and the error.
    with_pose: [Vec2; 3],
}

impl CameraTotal {
    /// The covariance that the error of the cameras adds to the measured position (m, robot frame) of a sighting, m².
    pub(super) fn covariance_at(&self, place: Vec2, motion: &CameraMotion) -> Mat2 {
        let [yaw, pitch] = motion.slopes(place);
        let (x, y) = (Vec2::new(yaw.x, pitch.x), Vec2::new(yaw.y, pitch.y));
        let (cross_x, cross_y) = (self.covariance * x, self.covariance * y);
        let mixed = x.dot(cross_y);
        Mat2::from_cols(Vec2::new(x.dot(cross_x), mixed), Vec2::new(mixed, y.dot(cross_y)))
    }

    /// The squared Mahalanobis distance of a measurement, given its derivatives with respect to yaw and pitch. Equal to that of
    /// [`CameraError::measured`], but faster, as it is computed for many landmarks.
    // Inlined, as arguments passed in memory would be read back at once, which takes longer than the rest.
    #[inline(always)]
    pub(super) fn distance_squared(&self, measured: &Measured, [yaw, pitch]: [Vec2; 2]) -> f32 {
        let rows = [Vec2::new(yaw.x, pitch.x), Vec2::new(yaw.y, pitch.y)];
        let [x, y, heading] = self.with_pose;
        let of_pose = |row: Vec3| x * row.x + y * row.y + heading * row.z;
        let of_pose = [of_pose(measured.rows[0]), of_pose(measured.rows[1])];
        let of_camera = [self.covariance * rows[0], self.covariance * rows[1]];
        let added = |one: usize, other: usize| {
            rows[one].dot(of_pose[other]) + rows[other].dot(of_pose[one]) + rows[one].dot(of_camera[other])
        };
        let mixed = added(0, 1);
        let spread = measured.spread + Mat2::from_cols(Vec2::new(added(0, 0), mixed), Vec2::new(mixed, added(1, 1)));
        let difference = measured.difference - yaw * self.mean.x - pitch * self.mean.y;
        difference.dot(inverse(spread) * difference)
    }
}

/// The estimate of the error of the cameras, and its covariance with the pose.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(crate) struct CameraError {
    /// Yaw and pitch of the bias, then yaw and pitch of the drift, radians.
    mean: Vec4,
    /// Its covariance, rad².
    covariance: Mat4,
    /// The covariance between x, y (m) and heading (radians) of the pose, a row each, and the error.
    with_pose: [Vec4; 3],
}

impl CameraError {
    /// The estimate before any sighting.
    pub(crate) fn unknown(motion: &CameraMotion) -> Self {
        let [bias, drift] = [motion.noise.bias_sd, drift_sd(motion)].map(|sd| sd * sd);
        let covariance = Mat4::from_diagonal(Vec4::new(bias, bias, drift, drift));
        Self { mean: Vec4::ZERO, covariance, with_pose: [Vec4::ZERO; 3] }
    }

    /// Removes the covariance with the pose, for a pose that was set or found by other means.
    #[must_use]
    pub(crate) fn beside_another_pose(self) -> Self {
        Self { with_pose: [Vec4::ZERO; 3], ..self }
    }

    /// Predicts the error a cycle later.
    #[must_use]
    pub(crate) fn advanced(self, motion: &CameraMotion) -> Self {
        let decay = motion.decay;
        let kept = Vec4::new(1.0, 1.0, decay, decay);
        let drift = drift_sd(motion);
        let added = drift * drift * (1.0 - decay * decay);
        let scale = Mat4::from_diagonal(kept);
        Self {
            mean: self.mean * kept,
            covariance: scale * self.covariance * scale + Mat4::from_diagonal(Vec4::new(0.0, 0.0, added, added)),
            with_pose: self.with_pose.map(|row| row * kept),
        }
    }

    /// Updates the covariance after a step `way` of the robot (m, team frame), which turns an error of the heading into one of the
    /// position.
    #[must_use]
    pub(crate) fn after_step(self, way: Vec2) -> Self {
        let [x, y, heading] = self.with_pose;
        Self { with_pose: [x - heading * way.y, y + heading * way.x, heading], ..self }
    }

    /// Whether every number in the estimate is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.mean.is_finite() && self.covariance.is_finite() && self.with_pose.iter().all(|row| row.is_finite())
    }

    /// The sum of bias and drift. An image shows nothing but this sum.
    pub(super) fn total(&self) -> CameraTotal {
        let sum = |parts: Vec4| Vec2::new(parts.x + parts.z, parts.y + parts.w);
        let [yaw, pitch, drift_yaw, drift_pitch] = [0, 1, 2, 3].map(|part| sum(self.covariance.col(part)));
        let [x, y, heading] = self.with_pose;
        CameraTotal {
            mean: sum(self.mean),
            covariance: Mat2::from_cols(yaw + drift_yaw, pitch + drift_pitch),
            with_pose: [sum(x), sum(y), sum(heading)],
        }
    }

    /// Corrects the measured position of a sighting, m, robot frame.
    pub(crate) fn corrected_place(&self, place: Vec2, motion: &CameraMotion) -> Vec2 {
        let [yaw, pitch] = motion.slopes(place);
        let error = self.total().mean;
        // Near the horizon, a small pitch error means an infinite distance.
        let further = (pitch * error.y).clamp_length_max(place.length() / 2.0);
        place - yaw * error.x - further
    }

    /// Corrects a sighting by the estimated error, and adds its uncertainty.
    pub(crate) fn corrected(&self, sighting: &Sighting, motion: &CameraMotion) -> Sighting {
        let across = self.variance(0);
        let along = self.variance(1);
        let base = sighting.angle_sd * sighting.angle_sd;
        let factor = sighting.distance_factor * sighting.distance_factor;
        let angle_variance = base + across;
        Sighting {
            place: self.corrected_place(sighting.place, motion),
            angle_sd: angle_variance.sqrt(),
            distance_factor: ((base * factor + along) / angle_variance).sqrt(),
            lens_height_m: sighting.lens_height_m,
        }
    }

    /// Adds the error of the cameras to a measurement, given its derivatives with respect to yaw and pitch.
    pub(super) fn measured(&self, measured: Measured, slopes: [Vec2; 2]) -> Measured {
        let Measured { difference, rows: pose_rows, cross, spread, .. } = measured;
        let camera_rows = rows(slopes);
        let [x, y, heading] = self.with_pose;
        // Written without `map`, as mapped arrays are slow.
        let of_pose = |row: Vec4| Vec3::new(x.dot(row), y.dot(row), heading.dot(row));
        let of_pose = [of_pose(camera_rows[0]), of_pose(camera_rows[1])];
        let of_camera = |row: Vec3, camera: Vec4| x * row.x + y * row.y + heading * row.z + self.covariance * camera;
        let camera_cross = [of_camera(pose_rows[0], camera_rows[0]), of_camera(pose_rows[1], camera_rows[1])];
        let added =
            |one: usize, other: usize| pose_rows[one].dot(of_pose[other]) + camera_rows[one].dot(camera_cross[other]);
        let mixed = added(0, 1);
        let known = Vec2::new(camera_rows[0].dot(self.mean), camera_rows[1].dot(self.mean));
        Measured {
            difference: difference - known,
            rows: pose_rows,
            cross: [cross[0] + of_pose[0], cross[1] + of_pose[1]],
            spread: spread + Mat2::from_cols(Vec2::new(added(0, 0), mixed), Vec2::new(mixed, added(1, 1))),
            camera_cross: Some(camera_cross),
        }
    }

    /// Corrects the error by an accepted measurement.
    #[must_use]
    pub(super) fn after(&self, innovation: &Innovation) -> Self {
        let Some(CameraShare { gain, cross }) = innovation.camera else { return *self };
        let difference = innovation.difference;
        let column = |index: usize| self.covariance.col(index) - gain[0] * cross[0][index] - gain[1] * cross[1][index];
        let covariance = Mat4::from_cols(column(0), column(1), column(2), column(3));
        let row = |index: usize| {
            self.with_pose[index] - cross[0] * innovation.gain[0][index] - cross[1] * innovation.gain[1][index]
        };
        Self {
            mean: self.mean + gain[0] * difference.x + gain[1] * difference.y,
            // Removes the asymmetry of rounding.
            covariance: (covariance + covariance.transpose()) * 0.5,
            with_pose: [row(0), row(1), row(2)],
        }
    }

    /// The variance of the yaw (0) or the pitch (1), rad².
    fn variance(&self, axis: usize) -> f32 {
        let column = self.covariance.col(axis);
        column[axis] + 2.0 * column[axis + 2] + self.covariance.col(axis + 2)[axis + 2]
    }
}

fn drift_sd(motion: &CameraMotion) -> f32 {
    if motion.is_walking { motion.noise.walking_sd } else { motion.noise.standing_sd }
}

/// The derivatives of x and y with respect to the four parts of the error, from those with respect to yaw and pitch.
fn rows([yaw, pitch]: [Vec2; 2]) -> [Vec4; 2] {
    [Vec4::new(yaw.x, pitch.x, yaw.x, pitch.x), Vec4::new(yaw.y, pitch.y, yaw.y, pitch.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::covariance::ELLIPSOID_95;
    use crate::belief::kalman_localiser::KalmanLocaliser;
    use crate::belief::landmarks::{LandmarkModel, Landmarks, PitchObservation};
    use crate::belief::localisation_method::KalmanFilter;
    use crate::belief::pose_estimate::PoseEstimate;
    use crate::belief::sighting::LENS_HEIGHT_M;
    use crate::sensing::vision::{GazeDecay, GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts};
    use approx::assert_abs_diff_eq;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::geometry::{Pose, unit, unrotate};
    use naoisis_core::pitch::{End, GoalColour, JunctionShape, Pitch};
    use naoisis_core::random::RandomStream;

    const NOISE: GazeNoise = GazeNoise { bias_sd: 0.016, standing_sd: 0.012, walking_sd: 0.037, correlation_s: 0.4 };

    fn motion(is_walking: bool, head_yaw: f32) -> CameraMotion {
        let head_forward = unit(head_yaw);
        let decay = GazeDecay::default().after(1.0 / 30.0, &NOISE);
        CameraMotion { noise: NOISE, is_walking, head_forward, lens_height_m: LENS_HEIGHT_M, decay }
    }

    /// The apparent position of an object at `place` for cameras that look further to the left and down than measured.
    fn seen(place: Vec2, head_yaw: f32, [yaw, pitch]: [f32; 2]) -> Vec2 {
        let to_camera = Quat::from_rotation_z(-(head_yaw + yaw)) * place.extend(-LENS_HEIGHT_M);
        // In a camera that looks further down by `pitch`, about its y axis, the rest of the world is turned up.
        let level = Quat::from_rotation_y(-pitch) * to_camera;
        let ground = level.truncate() * (-LENS_HEIGHT_M / level.z);
        unit(head_yaw).rotate(ground)
    }

    #[test]
    fn slopes_are_what_a_turned_camera_makes_of_a_place() {
        let step = 1e-3;
        for (place, head_yaw) in [(Vec2::new(2.0, 0.0), 0.0), (Vec2::new(1.0, 1.2), 0.7), (Vec2::new(0.3, -0.4), -1.0)]
        {
            let [yaw, pitch] = motion(false, head_yaw).slopes(place);
            for (slope, error) in [(yaw, [step, 0.0]), (pitch, [0.0, step])] {
                let change = (seen(place, head_yaw, error) - place) / step;
                assert_abs_diff_eq!(slope, change, epsilon = 0.02 * slope.length());
            }
        }
    }

    #[test]
    fn the_distance_is_the_same_by_the_whole_error_as_by_its_parts() {
        let motion = motion(true, 0.3);
        let mut error = CameraError::unknown(&motion);
        error.mean = Vec4::new(0.01, -0.02, 0.03, 0.005);
        error.with_pose = [Vec4::new(1e-4, -2e-4, 3e-4, 1e-4), Vec4::new(2e-4, 1e-4, 0.0, -1e-4), Vec4::splat(1e-4)];
        let estimate = PoseEstimate::new(Pose::new(0.5, -0.3, 0.2), 0.1, 0.05);
        for place in [Vec2::new(2.975, 0.7), Vec2::new(0.8, -0.6), Vec2::new(0.0, 2.0)] {
            let measured = estimate.measured_point(unit(0.2), place, &Sighting::new(Vec2::new(1.0, 0.4), 0.01));
            let slopes = motion.slopes(unrotate(unit(0.2), place - estimate.pose.position));
            let distance_squared = error.measured(measured, slopes).distance_squared();
            let found = error.total().distance_squared(&measured, slopes);
            assert_abs_diff_eq!(found, distance_squared, epsilon = 1e-3 * distance_squared);
        }
    }

    #[test]
    fn what_changes_is_forgotten_and_what_does_not_is_kept() {
        let motion = motion(true, 0.0);
        let mut error = CameraError::unknown(&motion);
        error.mean = Vec4::splat(0.02);
        for _ in 0..120 {
            error = error.advanced(&motion);
        }
        // 4 s are ten times the correlation.
        assert_abs_diff_eq!(error.mean, Vec4::new(0.02, 0.02, 0.0, 0.0), epsilon = 1e-4);
        let variance = motion.total_sd() * motion.total_sd();
        assert_abs_diff_eq!(error.variance(0), variance, epsilon = 0.01 * variance);
    }

    /// The shares of cycles in which the error of the pose was within the 95 % of its covariance, with the cameras' error
    /// estimated and not: a robot that walks on the spot sees a goal and two junctions, sixty times.
    fn shares_within() -> [f32; 2] {
        let truth = Pose::new(0.5, -0.3, 0.2);
        let landmarks = Landmarks::of(&Pitch::default());
        let posts = [Vec2::new(2.975, 0.7), Vec2::new(2.975, -0.7)];
        let crossings = [Vec2::new(0.0, 0.6), Vec2::new(0.0, -0.6)];
        let mut stream = RandomStream::for_match(7, "camera error test");
        let mut within = [0u32; 2];
        let model = LandmarkModel::default();
        let (matches, cycles) = (60, 60);
        let motion = motion(true, 0.0);
        let decay = motion.decay;
        for _ in 0..matches {
            let start = PoseEstimate::new(
                Pose::new(
                    truth.position.x + stream.gaussian(0.1),
                    truth.position.y + stream.gaussian(0.1),
                    truth.heading + stream.gaussian(0.05),
                ),
                0.1,
                0.05,
            );
            let mut filters = [KalmanLocaliser::placed(KalmanFilter::Extended, start.pose); 2];
            filters.iter_mut().for_each(|filter| filter.estimate = start);
            let bias = [stream.gaussian(NOISE.bias_sd), stream.gaussian(NOISE.bias_sd)];
            let mut drift = [stream.gaussian(NOISE.walking_sd), stream.gaussian(NOISE.walking_sd)];
            for turn in 0..cycles {
                let added = NOISE.walking_sd * (1.0 - decay * decay).sqrt();
                drift = drift.map(|drift| decay * drift + stream.gaussian(added));
                let error = [bias[0] + drift[0], bias[1] + drift[1]];
                let mut place = |landmark: Vec2| {
                    let exact = truth.inverse_transform_point(landmark);
                    let noise = [stream.gaussian(0.005), stream.gaussian(0.005)];
                    seen(exact, 0.0, [error[0] + noise[0], error[1] + noise[1]])
                };
                let pixel = Vec2::splat(100.0);
                let percepts = Percepts {
                    goal_posts: posts
                        .map(|post| GoalPostPercept::new(CameraName::TOP, GoalColour::Yellow, pixel, place(post)))
                        .to_vec(),
                    landmarks: crossings
                        .map(|crossing| {
                            let kind = LandmarkKind::Junction { shape: JunctionShape::X };
                            LandmarkPercept::new(CameraName::BOTTOM, kind, pixel, place(crossing))
                        })
                        .to_vec(),
                    ..default()
                };
                for (filter, camera) in filters.iter_mut().zip([Some(motion), None]) {
                    let observation = PitchObservation {
                        percepts: &percepts,
                        landmarks: &landmarks,
                        own_end: End::NegativeX,
                        image: Vec2::new(320.0, 240.0),
                        turn,
                        model: &model,
                        camera,
                    };
                    filter.correct(&observation);
                }
                for (filter, within) in filters.iter().zip(&mut within) {
                    let off = (filter.estimate.pose.position - truth.position)
                        .extend(filter.estimate.pose.heading - truth.heading);
                    let nees = off.dot(filter.estimate.covariance.inverse() * off);
                    *within += u32::from(nees <= ELLIPSOID_95);
                }
            }
        }
        within.map(|count| count as f32 / (matches * cycles as u32) as f32)
    }

    #[test]
    fn a_robot_that_reckons_with_its_cameras_error_knows_how_well_it_knows_where_it_is() {
        let [estimated, ignored] = shares_within();
        // 95 % of a calibrated filter's are within; sixty robots, each of two seconds with five independent errors: four standard
        // errors of 300 draws are 3.6 %.
        assert!(estimated > 0.90, "{estimated}");
        assert!(ignored < 0.5, "{ignored}");
    }
}
