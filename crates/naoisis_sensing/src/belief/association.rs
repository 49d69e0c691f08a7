//! Data association for both Kalman filters of the pose: finds the landmark that a sighting belongs to.

use bevy::prelude::*;

use super::camera_error::{CameraError, CameraMotion, CameraTotal};
use super::innovation::{Innovation, Measured};
use super::line_sighting::{PitchLine, SeenLine};
use super::pose_estimate::PoseEstimate;
use super::sighting::Sighting;
use super::unscented::SigmaPoints;
use crate::belief::localisation_method::KalmanFilter;
use naoisis_core::geometry::unrotate;

/// Least difference of squared Mahalanobis distances between the nearest landmark and every other one at which a sighting is assigned.
const AMBIGUITY: f32 = 6.0;

/// The expectation of a pose estimate, against which sightings are compared.
pub(super) struct Expectation<'a> {
    estimate: &'a PoseEstimate,
    /// The unit vector along which the robot faces, team frame.
    pub(super) forward: Vec2,
    /// The sigma points, for the unscented filter.
    points: Option<SigmaPoints>,
    camera: Option<(&'a CameraError, &'a CameraMotion, CameraTotal)>,
}

impl<'a> Expectation<'a> {
    /// The expectation of `estimate` for this `filter`, with the estimated error of the cameras if there is one.
    pub(super) fn of(
        estimate: &'a PoseEstimate,
        filter: KalmanFilter,
        camera: Option<(&'a CameraError, &'a CameraMotion)>,
    ) -> Self {
        let points = (filter == KalmanFilter::Unscented).then(|| SigmaPoints::of(estimate));
        let camera = camera.map(|(error, motion)| (error, motion, error.total()));
        Self { estimate, forward: estimate.pose.forward(), points, camera }
    }

    /// The innovation of a sighting of the landmark at `place`, m, team frame.
    pub(super) fn of_point(&self, place: Vec2, sighting: &Sighting) -> Innovation {
        let measured = self.measured_point(place, sighting);
        match &self.camera {
            None => measured.innovation(),
            Some((error, motion, _)) => error.measured(measured, self.slopes_of_point(place, motion)).innovation(),
        }
    }

    /// The squared Mahalanobis distance of a sighting of the landmark at `place`, m, team frame.
    pub(super) fn distance_of_point(&self, place: Vec2, sighting: &Sighting) -> f32 {
        let measured = self.measured_point(place, sighting);
        match &self.camera {
            None => measured.distance_squared(),
            Some((_, motion, total)) => total.distance_squared(&measured, self.slopes_of_point(place, motion)),
        }
    }

    #[inline(always)]
    fn measured_point(&self, place: Vec2, sighting: &Sighting) -> Measured {
        match &self.points {
            None => self.estimate.measured_point(self.forward, place, sighting),
            Some(points) => points.measured(|pose| sighting.residual(unrotate(pose.forward(), place - pose.position))),
        }
    }

    #[inline(always)]
    fn slopes_of_point(&self, place: Vec2, motion: &CameraMotion) -> [Vec2; 2] {
        motion.slopes(unrotate(self.forward, place - self.estimate.pose.position))
    }

    /// The innovation of a seen segment of `line`.
    pub(super) fn of_line(&self, line: &PitchLine, seen: &SeenLine) -> Innovation {
        let measured = self.measured_line(line, seen);
        match &self.camera {
            None => measured.innovation(),
            Some((error, motion, _)) => {
                error.measured(measured, seen.camera_slopes(line, self.forward, motion)).innovation()
            }
        }
    }

    /// The squared Mahalanobis distance of a seen segment of `line`.
    pub(super) fn distance_of_line(&self, line: &PitchLine, seen: &SeenLine) -> f32 {
        let measured = self.measured_line(line, seen);
        match &self.camera {
            None => measured.distance_squared(),
            Some((_, motion, total)) => {
                total.distance_squared(&measured, seen.camera_slopes(line, self.forward, motion))
            }
        }
    }

    #[inline(always)]
    fn measured_line(&self, line: &PitchLine, seen: &SeenLine) -> Measured {
        match &self.points {
            None => self.estimate.measured_line(self.forward, line, seen),
            Some(points) => points.measured(|pose| seen.residual(line, pose.position, pose.forward())),
        }
    }
}

/// The innovation of the nearest candidate, if every other candidate is clearly further away.
pub(super) fn clearly_nearest<Candidate: Copy>(
    candidates: impl Iterator<Item = Candidate>,
    distance_squared: impl Fn(Candidate) -> f32,
    innovation: impl Fn(Candidate) -> Innovation,
) -> Option<Innovation> {
    let mut best: Option<(Candidate, f32)> = None;
    let mut second = f32::MAX;
    for candidate in candidates {
        // The innovation is computed only for the nearest candidate.
        let distance_squared = distance_squared(candidate);
        match best {
            Some((_, least)) if least <= distance_squared => second = second.min(distance_squared),
            nearest => {
                second = nearest.map_or(second, |(_, least)| least);
                best = Some((candidate, distance_squared));
            }
        }
    }
    best.filter(|(_, least)| second - least > AMBIGUITY).map(|(candidate, _)| innovation(candidate))
}
