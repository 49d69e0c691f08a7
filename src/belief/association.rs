//! Which landmark it is that a robot sees, for an estimate of its pose by a Kalman filter of either kind.

use bevy::prelude::*;

use super::line_sighting::SeenLine;
use super::pose_estimate::{Innovation, PoseEstimate};
use super::sighting::Sighting;
use super::unscented::SigmaPoints;
use crate::belief::localisation_method::KalmanFilter;
use crate::geometry::unrotate;
use crate::pitch::LineSegment;

/// What is seen is taken for a landmark only if every other is less likely by so much: squared Mahalanobis distance.
const AMBIGUITY: f32 = 6.0;

/// What things that are seen say about an estimate.
pub(super) enum Innovations {
    Extended(PoseEstimate, Vec2),
    Unscented(SigmaPoints),
}

impl Innovations {
    /// For a filter of this kind.
    pub(super) fn about(estimate: &PoseEstimate, filter: KalmanFilter) -> Self {
        match filter {
            KalmanFilter::Extended => Innovations::Extended(*estimate, estimate.pose.forward()),
            KalmanFilter::Unscented => Innovations::Unscented(SigmaPoints::of(estimate)),
        }
    }

    /// What a sighting says if it is of the landmark at a place, m, team frame.
    pub(super) fn of_point(&self, place: Vec2, sighting: &Sighting) -> Innovation {
        match self {
            Innovations::Extended(estimate, forward) => estimate.innovation(*forward, place, sighting),
            Innovations::Unscented(points) => {
                points.innovation(|pose| sighting.residual(unrotate(pose.forward(), place - pose.position)))
            }
        }
    }

    /// What a stretch of a line says if it is of this line.
    pub(super) fn of_line(&self, line: &LineSegment, seen: &SeenLine) -> Innovation {
        match self {
            Innovations::Extended(estimate, forward) => estimate.innovation_of_line(*forward, line, seen),
            Innovations::Unscented(points) => points.innovation(|pose| seen.residual(line, pose)),
        }
    }
}

/// The likeliest explanation of what is seen, if every other is clearly less likely.
pub(super) fn clearly_nearest(explanations: impl Iterator<Item = Innovation>) -> Option<Innovation> {
    let mut best: Option<Innovation> = None;
    let mut second = f32::MAX;
    for innovation in explanations {
        match &best {
            Some(nearest) if nearest.distance_squared <= innovation.distance_squared => {
                second = second.min(innovation.distance_squared);
            }
            nearest => {
                second = nearest.as_ref().map_or(second, |nearest| nearest.distance_squared);
                best = Some(innovation);
            }
        }
    }
    best.filter(|best| second - best.distance_squared > AMBIGUITY)
}
