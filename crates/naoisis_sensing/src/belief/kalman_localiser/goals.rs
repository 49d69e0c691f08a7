//! Localisation by goals: corrects the pose by both posts of a goal, resets the pose of a lost robot that sees a goal, and finds the end of
//! the pitch by the posts' colours.

use bevy::prelude::*;

use super::{KalmanLocaliser, LOST_SD};
use crate::belief::landmarks::{PitchObservation, sighting_of_post};
use crate::belief::pose_estimate::{PoseEstimate, pose_from_two};
use crate::belief::sighting::Sighting;
use crate::sensing::vision::GoalPostPercept;

/// The greatest distance of a goal from which a lost robot with camera errors determines its pose, m: there, 3 pixels at a post's foot are
/// 0.2 m of distance.
const GOAL_RANGE_M: f32 = 3.0;
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
            if self.contradictions > model.contradictions {
                self.start_from_goal(places, sightings.map(|sighting| sighting.place), observation);
            }
            return;
        }
        for (place, sighting) in places.into_iter().zip(&sightings) {
            let innovation = self.expectation(observation).of_point(place, sighting);
            self.judge(Some(innovation), model);
        }
    }

    /// Resets the pose of a lost robot that sees a goal.
    fn start_from_goal(&mut self, posts: [Vec2; 2], seen: [Vec2; 2], observation: &PitchObservation) {
        // From far away, the distances of the posts and thus the direction of the goal are too uncertain: the robot searches instead.
        let is_far = seen.iter().any(|place| place.length_squared() > GOAL_RANGE_M * GOAL_RANGE_M);
        if observation.camera.is_some() && is_far {
            return;
        }
        let mut place_sd = LOST_SD[0];
        let seen = seen.map(|place| match self.camera.zip(observation.camera) {
            Some((camera, motion)) => {
                let covariance = camera.total().covariance_at(place, &motion);
                place_sd = place_sd.max((covariance.x_axis.x + covariance.y_axis.y).sqrt());
                camera.corrected_place(place, &motion)
            }
            None => place,
        });
        let pose = pose_from_two(posts, seen);
        if observation.landmarks.is_on_carpet(pose.position) {
            self.contradictions = 0;
            self.start_at(PoseEstimate::new(pose, place_sd, LOST_SD[1]));
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
