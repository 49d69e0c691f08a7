//! Localisation by goals: corrects the pose by both posts of a goal, resets the pose of a lost robot that sees a goal, and finds the end of
//! the pitch by the posts' colours.

use bevy::prelude::*;

use super::{KalmanLocaliser, LOST_SD};
use crate::belief::landmarks::{PitchObservation, sighting_of_post};
use crate::belief::pose_estimate::{PoseEstimate, pose_from_two};
use crate::belief::sighting::Sighting;
use crate::sensing::vision::GoalPostPercept;

/// The evidence with which a robot decides which end of the pitch it is at: difference of squared Mahalanobis distances.
const SIDE_DECISION: f32 = 25.0;

impl KalmanLocaliser {
    /// Corrects the pose by both posts of a goal.
    pub(super) fn see_goal(&mut self, [left, right]: [&GoalPostPercept; 2], observation: &PitchObservation) {
        let model = observation.model;
        let sightings = [left, right].map(|post| sighting_of_post(post, observation.image, model));
        let expectation = self.expectation(observation);
        // If both goals have the same colour, the likelier one is taken.
        let nearest = observation
            .landmarks
            .goals(left.colour, observation.own_end)
            .map(|goal| {
                let goal = goal.seen_from(self.estimate.pose.position);
                let distance = expectation.distance_of_point(goal.left_post, &sightings[0])
                    + expectation.distance_of_point(goal.right_post, &sightings[1]);
                (distance, goal)
            })
            .min_by(|(first, _), (second, _)| first.total_cmp(second));
        let Some((distance, goal)) = nearest else { return };
        let places = [goal.left_post, goal.right_post];
        if distance > 2.0 * model.gate {
            self.contradictions = self.contradictions.saturating_add(1);
            // With the errors of real cameras, two posts are not enough for a pose: the robot searches.
            if self.contradictions > model.contradictions && observation.camera.is_none() {
                self.start_from_goal(places, sightings.map(|sighting| sighting.place), observation);
            }
            return;
        }
        for (place, sighting) in places.into_iter().zip(&sightings) {
            let innovation = self.expectation(observation).of_point(place, sighting);
            self.judge(Some(innovation), model);
        }
    }

    /// Resets the pose of a lost robot that sees a goal with cameras without lasting errors.
    fn start_from_goal(&mut self, posts: [Vec2; 2], seen: [Vec2; 2], observation: &PitchObservation) {
        let pose = pose_from_two(posts, seen);
        if observation.landmarks.is_on_carpet(pose.position) {
            self.contradictions = 0;
            self.start_at(PoseEstimate::new(pose, LOST_SD[0], LOST_SD[1]));
        }
    }

    /// Compares the pose with the pose rotated by half a turn.
    pub(super) fn choose_side(&mut self, observation: &PitchObservation) {
        let Some(mut evidence) = self.sides else { return };
        let pose = self.estimate.pose;
        for post in &observation.percepts.goal_posts {
            let seen = Sighting::new(post.position_m, observation.model.goal_post_angle_sd)
                .from_height(observation.model.lens_height_m);
            let sighting = match self.camera.zip(observation.camera) {
                Some((camera, motion)) => camera.corrected(&seen, &motion),
                None => seen,
            };
            for (pose, sum) in [pose, pose.turned_half()].into_iter().zip(&mut evidence) {
                let estimate = PoseEstimate { pose, ..self.estimate };
                let forward = pose.forward();
                *sum += observation
                    .landmarks
                    .posts(post.colour, observation.own_end)
                    .map(|place| estimate.innovation(forward, place, &sighting).distance_squared)
                    .fold(SIDE_DECISION, f32::min);
            }
        }
        self.sides = Some(evidence);
        let [this, other] = evidence;
        if (this - other).abs() > SIDE_DECISION {
            self.sides = None;
            self.contradictions = 0;
            if other < this {
                self.start_at(PoseEstimate { pose: pose.turned_half(), ..self.estimate });
            }
        }
    }
}
