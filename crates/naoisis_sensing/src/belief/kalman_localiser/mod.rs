//! Localisation by a Kalman filter: handles odometry, landmarks, placement by the referee, and loss of the pose.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::association::{Expectation, clearly_nearest};
use super::camera_error::CameraError;
use super::innovation::Innovation;
use super::landmarks::{
    LandmarkModel, Landmarks, PitchObservation, halfway_pose, seen_goal, sighting_of_mark, sighting_of_post,
};
use super::line_sighting::SeenLine;
use super::localisation_method::KalmanFilter;
use super::pose_estimate::{PoseEstimate, StepError};
use super::sighting::Sighting;
use super::unscented;
use crate::sensing::vision::{LandmarkKind, LandmarkPercept};
use naoisis_core::geometry::Pose;

mod goals;

/// Standard deviations of the pose of a robot that was placed for a kick-off, m and radians.
pub(super) const PLACED_SD: [f32; 2] = [0.03, 0.02];
/// Standard deviations of the pose of a robot that returns from a penalty, m and radians: it may have been put down nearby.
pub(super) const RETURNED_SD: [f32; 2] = [0.4, 0.1];
/// Standard deviations that are added to a pose that was found by a search, m and radians: particles are sparse, so that the best of them may
/// be off by more than their spread.
const FOUND_SD: [f32; 2] = [0.15, 0.06];
/// Standard deviations that are added when sightings contradict the pose, m and radians.
const LOST_SD: [f32; 2] = [0.3, 0.2];
/// The greatest distance of a mark from the position at which it is seen, m.
const CANDIDATE_RANGE_M: f32 = 1.5;
/// The greatest number of marks that are used in a cycle.
const MARKS_PER_CYCLE: usize = 3;
/// The greatest number of line segments that are used in a cycle.
const LINES_PER_CYCLE: usize = 2;
/// Estimator of the robot's own pose by a Kalman filter.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct KalmanLocaliser {
    /// The kind of filter.
    pub filter: KalmanFilter,
    /// The estimate of the pose, team frame.
    pub estimate: PoseEstimate,
    /// The time since a landmark confirmed the pose, s.
    pub age_s: f32,
    /// The evidence of goal posts against the pose and against the pose rotated by half a turn, while both are possible.
    sides: Option<[f32; 2]>,
    /// The number of landmarks out of place, minus those in place.
    contradictions: u32,
    /// The estimated error of the cameras; `None` if the cameras have no lasting error.
    camera: Option<CameraError>,
}

impl KalmanLocaliser {
    /// A localiser for a robot that was placed at `pose`, team frame.
    pub fn placed(filter: KalmanFilter, pose: Pose) -> Self {
        Self { filter, estimate: PoseEstimate::new(pose, PLACED_SD[0], PLACED_SD[1]), ..default() }
    }

    /// The localiser for a robot that searched for its pose and found it. The estimated error of the cameras is kept.
    #[must_use]
    pub fn found_at(&self, estimate: PoseEstimate) -> Self {
        let estimate = estimate.inflated(FOUND_SD[0], FOUND_SD[1]);
        Self { filter: self.filter, estimate, ..default() }.keeping_cameras_of(self)
    }

    /// A localiser for a robot that returns from a penalty at an end of the halfway line: the end away from the `ball` (m, team frame) if
    /// its position is known, facing the pitch (2010 rule book, section 4). Sightings decide at which end it is.
    pub fn returned(filter: KalmanFilter, landmarks: &Landmarks, ball: Option<Vec2>) -> Self {
        let estimate = PoseEstimate::new(halfway_pose(landmarks, ball), RETURNED_SD[0], RETURNED_SD[1]);
        Self { filter, estimate, sides: Some([0.0; 2]), ..default() }
    }

    /// Predicts the pose after a measured `step` (in the robot frame before it), `duration` seconds later.
    pub fn moved_by(&self, step: Pose, duration: f32, error: &StepError) -> Self {
        let estimate = match self.filter {
            KalmanFilter::Extended => self.estimate.moved_by(step, error),
            KalmanFilter::Unscented => unscented::moved_by(&self.estimate, step, error),
        };
        let way = estimate.pose.position - self.estimate.pose.position;
        let camera = self.camera.map(|camera| camera.after_step(way));
        Self { estimate, camera, age_s: self.age_s + duration, ..*self }
    }

    /// Keeps the estimated error of the cameras of `before`, for a robot that was placed elsewhere.
    #[must_use]
    pub fn keeping_cameras_of(self, before: &Self) -> Self {
        Self { camera: before.camera.map(CameraError::beside_another_pose), ..self }
    }

    /// The estimated error of the cameras; `None` if the cameras have no lasting error.
    pub fn camera(&self) -> Option<&CameraError> {
        self.camera.as_ref()
    }

    /// Rotates the pose by half a turn about the centre mark.
    pub fn change_ends(&mut self) {
        self.sides = None;
        self.contradictions = 0;
        self.start_at(self.estimate.turned_half());
    }

    fn expectation<'a>(&'a self, observation: &'a PitchObservation) -> Expectation<'a> {
        Expectation::of(&self.estimate, self.filter, self.camera.as_ref().zip(observation.camera.as_ref()))
    }

    /// Corrects the pose and the error of the cameras by a sighting.
    fn believe(&mut self, innovation: &Innovation) {
        self.estimate = self.estimate.corrected(innovation);
        self.camera = self.camera.map(|camera| camera.after(innovation));
    }

    /// Resets the pose.
    fn start_at(&mut self, estimate: PoseEstimate) {
        self.estimate = estimate;
        self.camera = self.camera.map(CameraError::beside_another_pose);
    }

    /// Corrects the pose by the sightings of a cycle. Returns whether the robot is lost: for a while, more landmarks were out of place than
    /// in place.
    pub fn correct(&mut self, observation: &PitchObservation) -> bool {
        let posts = &observation.percepts.goal_posts;
        let model = observation.model;
        self.camera = observation.camera.map(|motion| match self.camera {
            Some(camera) if camera.is_finite() => camera.advanced(&motion),
            _ => CameraError::unknown(&motion),
        });
        if self.sides.is_some() {
            self.choose_side(observation);
        }
        match seen_goal(posts) {
            Some(goal) => self.see_goal(goal, observation),
            None => {
                for post in posts {
                    let candidates = observation.landmarks.posts(post.colour, observation.own_end);
                    let sighting = sighting_of_post(post, observation.image, model);
                    let association = self.associate(&sighting, candidates, observation);
                    self.judge(association, model);
                }
            }
        }
        for mark in observation.marks(MARKS_PER_CYCLE) {
            self.see_mark(mark, observation);
        }
        for line in observation.lines(LINES_PER_CYCLE).filter(SeenLine::is_useful) {
            self.see_line(&line, observation);
        }
        let lost = self.contradictions > model.contradictions;
        if lost {
            self.contradictions = 0;
            self.estimate = self.estimate.inflated(LOST_SD[0], LOST_SD[1]);
        }
        lost
    }

    fn see_mark(&mut self, mark: &LandmarkPercept, observation: &PitchObservation) {
        let PitchObservation { landmarks, model, .. } = *observation;
        let seen = self.estimate.pose.transform_point(mark.position_m);
        let near = |place: &Vec2| place.distance_squared(seen) < CANDIDATE_RANGE_M * CANDIDATE_RANGE_M;
        let sighting = sighting_of_mark(mark, model);
        let association = match mark.kind {
            LandmarkKind::Junction { shape } => {
                self.associate(&sighting, landmarks.junctions(shape).filter(near), observation)
            }
            LandmarkKind::PenaltyCross => self.associate(&sighting, landmarks.crosses().filter(near), observation),
            LandmarkKind::CornerArc => self.associate(&sighting, landmarks.arcs().filter(near), observation),
            LandmarkKind::CentreCircle => self.associate(&sighting, [Vec2::ZERO], observation),
            LandmarkKind::Line { .. } => None,
        };
        self.judge(association, model);
    }

    /// Corrects the pose by a line segment, if it is clear which line the segment belongs to. An unlikely segment is not counted as
    /// evidence against the pose, as there are many lines.
    fn see_line(&mut self, seen: &SeenLine, observation: &PitchObservation) {
        let PitchObservation { landmarks, model, .. } = *observation;
        let expectation = self.expectation(observation);
        let Pose { position, .. } = self.estimate.pose;
        let candidates = landmarks.lines().iter().filter(|line| seen.can_be_of(line, position, expectation.forward));
        let association = clearly_nearest(
            candidates,
            |line| expectation.distance_of_line(line, seen),
            |line| expectation.of_line(line, seen),
        );
        if let Some(innovation) = association.filter(|innovation| innovation.distance_squared < model.gate) {
            self.believe(&innovation);
        }
    }

    /// The innovation of a sighting of one of the `candidates` (m, team frame), if it is clear which one was seen.
    fn associate(
        &self,
        sighting: &Sighting,
        candidates: impl IntoIterator<Item = Vec2>,
        observation: &PitchObservation,
    ) -> Option<Innovation> {
        let expectation = self.expectation(observation);
        clearly_nearest(
            candidates.into_iter(),
            |place| expectation.distance_of_point(place, sighting),
            |place| expectation.of_point(place, sighting),
        )
    }

    /// Corrects the pose by a sighting, or counts it as a contradiction if it is too unlikely.
    fn judge(&mut self, innovation: Option<Innovation>, model: &LandmarkModel) {
        let Some(innovation) = innovation else { return };
        if innovation.distance_squared < model.gate {
            self.believe(&innovation);
            self.age_s = 0.0;
            self.contradictions = self.contradictions.saturating_sub(1);
        } else {
            self.contradictions = self.contradictions.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests;
