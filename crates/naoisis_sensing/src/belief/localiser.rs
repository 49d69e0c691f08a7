//! Estimator of the robot's own pose by the filter of its settings: one of two Kalman filters, or a particle filter.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::camera_error::CameraError;
use super::kalman_localiser::{KalmanLocaliser, PLACED_SD, RETURNED_SD};
use super::landmarks::{Landmarks, PitchObservation, halfway_pose, waiting_poses};
use super::localisation_method::LocalisationMethod;
use super::particle_filter::{EQUALLY_LIKELY, LIKELIER, ParticleFilter};
use super::pose_estimate::{PoseEstimate, StepError};
use crate::belief::localisation_method::KalmanFilter;
use naoisis_core::geometry::Pose;
use naoisis_core::team::RobotId;

impl From<KalmanFilter> for LocalisationMethod {
    fn from(filter: KalmanFilter) -> Self {
        match filter {
            KalmanFilter::Extended => LocalisationMethod::Kalman,
            KalmanFilter::Unscented => LocalisationMethod::Unscented,
        }
    }
}

/// The greatest believed distance from the centre mark, m: the square of a greater one might overflow in a sum.
const FARTHEST_M: f32 = 1e6;

/// A filter of any kind.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub enum Localiser {
    /// [`LocalisationMethod::Kalman`] and [`LocalisationMethod::Unscented`].
    Kalman(KalmanLocaliser),
    /// [`LocalisationMethod::Kalman`] and [`LocalisationMethod::Unscented`] while the robot does not know its pose: the search, and the
    /// Kalman filter that continues from the pose that is found.
    Searching(ParticleFilter, KalmanLocaliser),
    /// [`LocalisationMethod::Particles`].
    Particles(ParticleFilter),
}

impl Default for Localiser {
    fn default() -> Self {
        Localiser::Kalman(KalmanLocaliser::default())
    }
}

impl Localiser {
    /// A localiser for a robot that was placed at `pose`, team frame.
    pub fn placed(kind: LocalisationMethod, robot: RobotId, pose: Pose) -> Self {
        match kind {
            LocalisationMethod::Kalman => Localiser::Kalman(KalmanLocaliser::placed(KalmanFilter::Extended, pose)),
            LocalisationMethod::Unscented => Localiser::Kalman(KalmanLocaliser::placed(KalmanFilter::Unscented, pose)),
            LocalisationMethod::Particles => {
                Localiser::Particles(ParticleFilter::around(robot, pose, PLACED_SD[0], PLACED_SD[1]))
            }
        }
    }

    /// Resets a filter that is not finite any more to the pose `last`, team frame. This happens after impossible measurements, or in a
    /// saved match that was edited by hand.
    pub fn keep_finite(&mut self, robot: RobotId, last: Pose) {
        let (is_finite, kind) = match self {
            Localiser::Kalman(own) => (own.estimate.is_finite(), own.filter.into()),
            Localiser::Searching(filter, kalman) => (filter.is_finite(), kalman.filter.into()),
            Localiser::Particles(filter) => (filter.is_finite(), LocalisationMethod::Particles),
        };
        let is_near = |pose: Pose| pose.is_finite() && pose.position.abs().max_element() < FARTHEST_M;
        if !(is_finite && is_near(self.estimate().pose)) {
            *self = Localiser::placed(kind, robot, if is_near(last) { last } else { Pose::default() });
        }
    }

    /// Places the robot at `pose`, team frame.
    pub fn place(&mut self, pose: Pose) {
        match self {
            Localiser::Kalman(own) | Localiser::Searching(_, own) => {
                *self = Localiser::Kalman(KalmanLocaliser::placed(own.filter, pose).keeping_cameras_of(own));
            }
            Localiser::Particles(filter) => filter.gather_around(pose, PLACED_SD[0], PLACED_SD[1]),
        }
    }

    /// Sets the pose for the return from a penalty at an end of the halfway line: the end away from the ball (m, team frame), if its
    /// position is known.
    pub fn come_back_at_halfway_line(&mut self, landmarks: &Landmarks, ball: Option<Vec2>) {
        match self {
            Localiser::Kalman(own) | Localiser::Searching(_, own) => {
                let returned = KalmanLocaliser::returned(own.filter, landmarks, ball).keeping_cameras_of(own);
                *self = Localiser::Kalman(returned);
            }
            Localiser::Particles(filter) => {
                let pose = halfway_pose(landmarks, ball);
                filter.gather_around_either([pose, pose.turned_half()], EQUALLY_LIKELY, RETURNED_SD);
            }
        }
    }

    /// Begins a search for the return from a penalty at the waiting position beyond a side line: the one that was nearer when the robot was
    /// removed, as far as the robot knew its position.
    pub fn come_back_where_it_waited(&mut self, robot: RobotId, landmarks: &Landmarks) {
        let poses = waiting_poses(landmarks, self.estimate().pose.position.y);
        match self {
            Localiser::Kalman(own) | Localiser::Searching(_, own) => {
                *self = Localiser::Searching(ParticleFilter::returned(robot, poses, landmarks), *own);
            }
            Localiser::Particles(filter) => filter.gather_around_either(poses, LIKELIER, RETURNED_SD),
        }
    }

    /// Moves the pose to the other end of a symmetric pitch.
    pub fn change_ends(&mut self) {
        match self {
            Localiser::Kalman(own) => own.change_ends(),
            Localiser::Searching(filter, _) | Localiser::Particles(filter) => filter.change_ends(),
        }
    }

    /// Predicts the pose after a measured `step` (in the robot frame before it), `duration` seconds later.
    pub fn move_by(&mut self, step: Pose, duration: f32, error: &StepError) {
        match self {
            Localiser::Kalman(own) => *own = own.moved_by(step, duration, error),
            Localiser::Searching(filter, _) | Localiser::Particles(filter) => filter.move_by(step, duration, error),
        }
    }

    /// Corrects the pose by the sightings of a cycle.
    pub fn correct(&mut self, robot: RobotId, observation: &PitchObservation) {
        if matches!(self, Localiser::Kalman(_)) || observation.camera.is_none() {
            return self.correct_by(robot, observation);
        }
        // The particle filter does not estimate the error of the cameras, so its sightings are less certain.
        let model =
            observation.camera.map_or(*observation.model, |camera| observation.model.with_camera_error(&camera));
        self.correct_by(robot, &PitchObservation { model: &model, ..*observation });
    }

    fn correct_by(&mut self, robot: RobotId, observation: &PitchObservation) {
        match self {
            Localiser::Kalman(own) => {
                if own.correct(observation) {
                    let pose = own.estimate.pose;
                    let search = ParticleFilter::search(robot, pose, observation.landmarks);
                    *self = Localiser::Searching(search, KalmanLocaliser::placed(own.filter, pose));
                }
            }
            Localiser::Searching(filter, kalman) => {
                filter.correct(observation);
                if filter.is_sure() {
                    *self = Localiser::Kalman(kalman.found_at(*filter.estimate()));
                }
            }
            Localiser::Particles(filter) => filter.correct(observation),
        }
    }

    /// The error of the cameras, if it is estimated.
    pub fn camera(&self) -> Option<&CameraError> {
        match self {
            Localiser::Kalman(own) => own.camera(),
            Localiser::Searching(..) | Localiser::Particles(_) => None,
        }
    }

    /// The estimate of the pose.
    pub fn estimate(&self) -> &PoseEstimate {
        match self {
            Localiser::Kalman(own) => &own.estimate,
            Localiser::Searching(filter, _) | Localiser::Particles(filter) => filter.estimate(),
        }
    }

    /// The time since a landmark confirmed the pose, s.
    pub fn age_s(&self) -> f32 {
        match self {
            Localiser::Kalman(own) => own.age_s,
            Localiser::Searching(filter, _) | Localiser::Particles(filter) => filter.age_s(),
        }
    }
}
