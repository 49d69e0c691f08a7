//! Localisation by a Kalman filter: odometry, landmarks, placement by the referee, and loss of the pose.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::association::{Expectation, clearly_nearest};
use super::camera_error::CameraError;
use super::innovation::Innovation;
use super::landmarks::{
    LandmarkModel, Landmarks, PitchObservation, halfway_pose, seen_goal, sighting_of_mark, sighting_of_post,
    waiting_pose,
};
use super::line_sighting::SeenLine;
use super::localisation_method::KalmanFilter;
use super::pose_estimate::{PoseEstimate, StepError, pose_from_two};
use super::sighting::Sighting;
use super::unscented;
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept};
use naoisis_core::geometry::Pose;

/// Standard deviations of the pose of a robot that was placed for a kick-off, m and radians.
pub(super) const PLACED_SD: [f32; 2] = [0.03, 0.02];
/// The same for a robot that returns from a penalty, and may have been put down nearby.
pub(super) const RETURNED_SD: [f32; 2] = [0.4, 0.1];
/// Standard deviations that are added when sightings contradict the pose, m and radians.
const LOST_SD: [f32; 2] = [0.3, 0.2];
/// The greatest distance of a mark from the place where it is seen, m.
const CANDIDATE_RANGE_M: f32 = 1.5;
/// The greatest number of marks that are used in a cycle.
const MARKS_PER_CYCLE: usize = 3;
/// The greatest distance of a goal from which a lost robot with camera errors finds its pose, m: there 3 pixels at a post's foot are 0.2 m of
/// distance.
const GOAL_RANGE_M: f32 = 3.0;
/// The greatest number of line segments that are used in a cycle.
const LINES_PER_CYCLE: usize = 2;
/// The evidence with which a robot decides at which end of the pitch it is: difference of squared Mahalanobis distances.
const SIDE_DECISION: f32 = 25.0;

/// The robot's own pose by a Kalman filter.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct KalmanLocaliser {
    /// The kind of filter.
    pub filter: KalmanFilter,
    /// The estimate of the pose, team frame.
    pub estimate: PoseEstimate,
    /// The time since a landmark confirmed it, s.
    pub age_s: f32,
    /// The evidence of goal posts against the pose and against the pose turned by half a turn, while both are possible.
    sides: Option<[f32; 2]>,
    /// The number of landmarks out of place, less those in place.
    contradictions: u32,
    /// The estimated error of the cameras; `None` if they have none.
    camera: Option<CameraError>,
}

impl KalmanLocaliser {
    /// For a robot that was placed at `pose`, team frame.
    pub fn placed(filter: KalmanFilter, pose: Pose) -> Self {
        Self { filter, estimate: PoseEstimate::new(pose, PLACED_SD[0], PLACED_SD[1]), ..default() }
    }

    /// For a robot that has found its pose.
    pub fn found(filter: KalmanFilter, estimate: PoseEstimate) -> Self {
        Self { filter, estimate, ..default() }
    }

    /// For a robot that returns from a penalty at an end of the halfway line: the one away from the `ball` (m, team frame) if its place is
    /// known, facing the pitch (2010 rule book, section 4). Sightings decide at which end it is.
    pub fn returned(filter: KalmanFilter, landmarks: &Landmarks, ball: Option<Vec2>) -> Self {
        let estimate = PoseEstimate::new(halfway_pose(landmarks, ball), RETURNED_SD[0], RETURNED_SD[1]);
        Self { filter, estimate, sides: Some([0.0; 2]), ..default() }
    }

    /// For a robot that returns from outside the pitch: beyond the side line that was nearer when it was removed at `y`, level with its own
    /// penalty mark, facing the pitch (2025 rule book).
    pub fn waiting(filter: KalmanFilter, landmarks: &Landmarks, y: f32) -> Self {
        let estimate = PoseEstimate::new(waiting_pose(landmarks, y), RETURNED_SD[0], RETURNED_SD[1]);
        Self { filter, estimate, ..default() }
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

    /// The estimated error of the cameras; `None` if they have none.
    pub fn camera(&self) -> Option<&CameraError> {
        self.camera.as_ref()
    }

    /// Turns the pose by half a turn about the centre mark.
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

    /// Corrects the pose by the sightings of a cycle. Returns whether the robot is lost: more landmarks were out of place than in place for a
    /// while.
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

    fn see_goal(&mut self, [left, right]: [&GoalPostPercept; 2], observation: &PitchObservation) {
        let model = observation.model;
        let sightings = [left, right].map(|post| sighting_of_post(post, observation.image, model));
        let expectation = self.expectation(observation);
        // If both goals have the same colour, it is the likelier one.
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
            self.contradictions += 1;
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
        // From far away, the distances of the posts and so the direction of the goal are too uncertain: search instead.
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

    /// Corrects the pose by a line segment, if the line that it belongs to is clear. An unlikely one is no evidence against the pose, as there
    /// are many lines.
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

    /// The innovation of a sighting of one of the `candidates` (m, team frame), if it is clear which one.
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
            self.contradictions += 1;
        }
    }

    /// Compares the pose with the pose turned by half a turn.
    fn choose_side(&mut self, observation: &PitchObservation) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::vision::Percepts;
    use approx::assert_abs_diff_eq;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::pitch::{End, GoalColour, JunctionShape, Pitch};

    const IMAGE: Vec2 = Vec2::new(320.0, 240.0);

    fn post(from: Pose, colour: GoalColour, place: Vec2) -> GoalPostPercept {
        GoalPostPercept {
            camera: CameraName::TOP,
            colour,
            pixel: IMAGE / 2.0,
            position_m: from.inverse_transform_point(place),
        }
    }

    fn mark(from: Pose, kind: LandmarkKind, place: Vec2) -> LandmarkPercept {
        LandmarkPercept {
            camera: CameraName::BOTTOM,
            kind,
            pixel: IMAGE / 2.0,
            position_m: from.inverse_transform_point(place),
        }
    }

    fn oriented(start: KalmanLocaliser, percepts: &Percepts, own_end: End, cycles: usize) -> KalmanLocaliser {
        let landmarks = Landmarks::of(&Pitch::default());
        let mut own = start;
        let model = LandmarkModel::default();
        for turn in 0..cycles {
            own.correct(&PitchObservation {
                percepts,
                landmarks: &landmarks,
                own_end,
                image: IMAGE,
                turn,
                model: &model,
                camera: None,
            });
        }
        own
    }

    fn assert_near(own: &KalmanLocaliser, truth: Pose) {
        assert_abs_diff_eq!(own.estimate.pose.position, truth.position, epsilon = 0.05);
        assert_abs_diff_eq!(own.estimate.pose.heading, truth.heading, epsilon = 0.03);
    }

    #[test]
    fn the_goal_of_the_own_colour_corrects_a_wrong_pose() {
        // A pink player of the first half defends the yellow goal at +x: in its frame that is at -x.
        let truth = Pose::new(-1.0, 0.5, core::f32::consts::PI - 0.2);
        let percepts = Percepts {
            goal_posts: vec![
                post(truth, GoalColour::Yellow, Vec2::new(-2.975, -0.7)),
                post(truth, GoalColour::Yellow, Vec2::new(-2.975, 0.7)),
            ],
            ..default()
        };
        let start = KalmanLocaliser { estimate: PoseEstimate::new(Pose::new(-0.8, 0.3, 3.0), 0.3, 0.2), ..default() };
        assert_near(&oriented(start, &percepts, End::PositiveX, 20), truth);
    }

    #[test]
    fn a_robot_behind_the_goal_is_not_turned_around_by_it() {
        // From there the posts are the other way round.
        let truth = Pose::new(3.4, 0.2, core::f32::consts::PI - 0.1);
        let percepts = Percepts {
            goal_posts: vec![
                post(truth, GoalColour::Yellow, Vec2::new(2.975, -0.7)),
                post(truth, GoalColour::Yellow, Vec2::new(2.975, 0.7)),
            ],
            ..default()
        };
        let start = KalmanLocaliser { estimate: PoseEstimate::new(Pose::new(3.35, 0.15, 3.0), 0.1, 0.1), ..default() };
        let own = oriented(start, &percepts, End::NegativeX, 20);
        assert_near(&own, truth);
        assert_eq!(own.contradictions, 0);
    }

    #[test]
    fn marks_correct_the_pose_and_confirm_it() {
        let truth = Pose::new(-0.5, 0.1, 0.3);
        let junction = |shape, x, y| mark(truth, LandmarkKind::Junction { shape }, Vec2::new(x, y));
        let percepts = Percepts {
            landmarks: vec![
                junction(JunctionShape::X, 0.0, 0.6),
                junction(JunctionShape::X, 0.0, -0.6),
                mark(truth, LandmarkKind::PenaltyCross, Vec2::new(1.2, 0.0)),
            ],
            ..default()
        };
        let start = KalmanLocaliser {
            estimate: PoseEstimate::new(Pose::new(-0.6, 0.15, 0.35), 0.1, 0.05),
            age_s: 3.0,
            ..default()
        };
        let own = oriented(start, &percepts, End::NegativeX, 20);
        assert_near(&own, truth);
        assert_eq!(own.age_s, 0.0);
    }

    #[test]
    fn lines_alone_keep_a_pose_from_drifting() {
        // The corner of the pitch: two lines at a right angle.
        let truth = Pose::new(-2.0, 1.2, 2.4);
        let seen = |from: Vec2, to: Vec2| {
            let [place, end_position_m] = [from, to].map(|end| truth.inverse_transform_point(end));
            LandmarkPercept {
                camera: CameraName::BOTTOM,
                kind: LandmarkKind::Line { end_pixel: Vec2::ZERO, end_position_m },
                pixel: IMAGE / 2.0,
                position_m: place,
            }
        };
        let pitch = Pitch::default();
        let (x, y) = (-pitch.half_length(), pitch.half_width());
        let lines = vec![seen(Vec2::new(x, y), Vec2::new(x, y - 0.6)), seen(Vec2::new(x, y), Vec2::new(x + 0.8, y))];
        let percepts = Percepts { landmarks: lines, ..default() };
        for filter in [KalmanFilter::Extended, KalmanFilter::Unscented] {
            let estimate = PoseEstimate::new(Pose::new(-1.9, 1.1, 2.35), 0.1, 0.1);
            let start = KalmanLocaliser { filter, estimate, ..default() };
            assert_near(&oriented(start, &percepts, End::NegativeX, 20), truth);
        }
    }

    #[test]
    fn what_could_be_either_of_two_marks_says_nothing() {
        // Half-way between the two crossings of the circle with the halfway line, and y unknown.
        let truth = Pose::new(-1.0, 0.0, 0.0);
        let kind = LandmarkKind::Junction { shape: JunctionShape::X };
        let percepts = Percepts { landmarks: vec![mark(truth, kind, Vec2::ZERO)], ..default() };
        let start = KalmanLocaliser { estimate: PoseEstimate::new(truth, 0.6, 0.3), age_s: 3.0, ..default() };
        assert_eq!(oriented(start, &percepts, End::NegativeX, 1), start);
    }

    #[test]
    fn a_robot_put_elsewhere_finds_itself_by_a_goal() {
        let truth = Pose::new(1.0, -1.0, 0.4);
        let percepts = Percepts {
            goal_posts: vec![
                post(truth, GoalColour::Yellow, Vec2::new(2.975, 0.7)),
                post(truth, GoalColour::Yellow, Vec2::new(2.975, -0.7)),
            ],
            ..default()
        };
        let start = KalmanLocaliser::placed(KalmanFilter::Extended, Pose::new(-2.0, 1.0, 2.5));
        assert_near(&oriented(start, &percepts, End::NegativeX, 60), truth);
    }

    #[test]
    fn a_robot_that_comes_back_sees_on_which_side_it_is() {
        // Seen from the right end of the halfway line, the opponents' goal is on the right.
        let landmarks = Landmarks::of(&Pitch::default());
        let truth = Pose::new(0.0, -2.0, core::f32::consts::FRAC_PI_2);
        let percepts = Percepts {
            goal_posts: vec![
                post(truth, GoalColour::Yellow, Vec2::new(2.975, 0.7)),
                post(truth, GoalColour::Yellow, Vec2::new(2.975, -0.7)),
            ],
            ..default()
        };
        for ball in [None, Some(Vec2::new(0.0, 1.0)), Some(Vec2::new(0.0, -1.0))] {
            let own = oriented(
                KalmanLocaliser::returned(KalmanFilter::Unscented, &landmarks, ball),
                &percepts,
                End::NegativeX,
                30,
            );
            assert_near(&own, truth);
        }
    }
}
