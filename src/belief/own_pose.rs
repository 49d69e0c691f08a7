//! Where the robot is: odometry and landmarks put together, being placed by the referee, and being lost.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::localisation::{Innovation, PoseEstimate, StepError, pose_from_two};
use super::point_team_from_pitch;
use super::sighting::Sighting;
use crate::geometry::Pose;
use crate::pitch::{End, GoalColour, JunctionShape, Pitch};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts};

/// The doubt about the pose of a robot that was placed for a kick-off, m and radians.
pub(super) const PLACED_SD: [f32; 2] = [0.03, 0.02];
/// The doubt about the pose of a robot that comes back from a penalty: it may have been put down a little elsewhere.
pub(super) const RETURNED_SD: [f32; 2] = [0.4, 0.1];
/// Distance of a waiting robot from the side line, m (2025 rule book).
const WAITING_DISTANCE_M: f32 = 0.5;
/// The doubt that is added when what is seen contradicts the pose.
const LOST_SD: [f32; 2] = [0.3, 0.2];
/// A post whose foot is not in the image is measured by its top or its width, so much worse.
const HIDDEN_FOOT_FACTOR: f32 = 4.0;
/// Marks of the right kind further away from where one is seen than this do not come into question, m.
const CANDIDATE_RANGE_M: f32 = 1.5;
/// What is seen is taken for a landmark only if every other is less likely by so much: squared Mahalanobis distance.
const AMBIGUITY: f32 = 6.0;
/// Marks on the ground that are used in a cycle.
const MARKS_PER_CYCLE: usize = 3;
/// The weight of evidence at which a robot decides which end of the pitch it sees: squared Mahalanobis distance.
const SIDE_DECISION: f32 = 25.0;

/// How landmarks are used.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkModel {
    /// Expected error of the angles at which a goal post's foot, or the centre circle's middle, is seen: standard
    /// deviation, radians. 3 pixels at 361 pixels of focal length are 0.0083.
    pub goal_post_angle_sd: f32,
    /// The same for junctions and crosses, radians.
    pub mark_angle_sd: f32,
    /// What is seen further from the expectation than this is not the landmark that it is taken for: squared
    /// Mahalanobis distance.
    pub gate: f32,
    /// After so many landmarks more out of place than in place, the robot doubts its pose.
    pub contradictions: u32,
}

impl Default for LandmarkModel {
    fn default() -> Self {
        Self { goal_post_angle_sd: 0.01, mark_angle_sd: 0.005, gate: 12.0, contradictions: 10 }
    }
}

/// A goal, seen from inside the pitch.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Goal {
    colour: GoalColour,
    left_post: Vec2,
    right_post: Vec2,
}

/// The places of all landmarks, in the frame of the team that defends -x. Marks on the ground have the same places for
/// the other team, as the pitch looks the same from both ends.
#[derive(Clone, PartialEq, Debug)]
pub struct Landmarks {
    junctions: Vec<(JunctionShape, Vec2)>,
    crosses: [Vec2; 2],
    goals: [Goal; 2],
    carpet_half_extents: Vec2,
    half_width: f32,
}

impl Landmarks {
    /// Those of a pitch.
    pub fn of(pitch: &Pitch) -> Self {
        let [negative_cross, positive_cross, _] = pitch.marks();
        let goal = |end: End| {
            let [x, y] = [end.sign() * pitch.goal_post_x(), end.sign() * pitch.goal.width_m / 2.0];
            Goal { colour: pitch.goal_colour(end), left_post: Vec2::new(x, y), right_post: Vec2::new(x, -y) }
        };
        Self {
            junctions: pitch.line_junctions().iter().map(|junction| (junction.shape, junction.position)).collect(),
            crosses: [negative_cross, positive_cross],
            goals: End::BOTH.map(goal),
            carpet_half_extents: pitch.carpet_half_extents(),
            half_width: pitch.half_width(),
        }
    }

    /// The left and the right post of the goal of this colour, in the frame of the team that defends `own_end`, m. None
    /// where both goals have it.
    pub(super) fn goal(&self, colour: GoalColour, own_end: End) -> Option<[Vec2; 2]> {
        let mut goals = self.goals(colour, own_end);
        let goal = goals.next()?;
        goals.next().is_none().then_some([goal.left_post, goal.right_post])
    }

    /// The posts of this colour, in the frame of the team that defends `own_end`, m.
    pub(super) fn posts(&self, colour: GoalColour, own_end: End) -> impl Iterator<Item = Vec2> {
        self.goals(colour, own_end).flat_map(|goal| [goal.left_post, goal.right_post])
    }

    /// The junctions of this shape, m.
    pub(super) fn junctions(&self, shape: JunctionShape) -> impl Iterator<Item = Vec2> {
        self.junctions.iter().filter(move |(other, _)| *other == shape).map(|(_, place)| *place)
    }

    /// The penalty crosses, m.
    pub(super) fn crosses(&self) -> impl Iterator<Item = Vec2> {
        self.crosses.into_iter()
    }

    /// Whether a robot could stand at a place, m.
    pub(super) fn is_on_carpet(&self, place: Vec2) -> bool {
        place.abs().cmplt(self.carpet_half_extents).all()
    }

    /// The goals of this colour, in the frame of the team that defends `own_end`.
    fn goals(&self, colour: GoalColour, own_end: End) -> impl Iterator<Item = Goal> {
        let in_team = move |place| point_team_from_pitch(place, own_end);
        self.goals.into_iter().filter(move |goal| goal.colour == colour).map(move |goal| Goal {
            left_post: in_team(goal.left_post),
            right_post: in_team(goal.right_post),
            ..goal
        })
    }
}

/// Where the robot thinks that it is.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct OwnPose {
    /// The pose, team frame, and how certain it is.
    pub estimate: PoseEstimate,
    /// Since a landmark confirmed it, s.
    pub age_s: f32,
    /// How much goal posts contradict the pose and the pose turned by half a turn, while the robot does not know which
    /// of the two it has.
    sides: Option<[f32; 2]>,
    /// Landmarks seen out of place, less those seen in place.
    contradictions: u32,
}

impl OwnPose {
    /// That of a robot that was told its place, team frame.
    pub fn placed(pose: Pose) -> Self {
        Self { estimate: PoseEstimate::new(pose, PLACED_SD[0], PLACED_SD[1]), ..default() }
    }

    /// That of a robot that comes back from a penalty: at an end of the halfway line, that away from the ball (m, team
    /// frame) if the robot knows where that is, facing the other side (2010 rule book, section 4). Which end it really is
    /// must be seen.
    pub fn returned(landmarks: &Landmarks, ball: Option<Vec2>) -> Self {
        let pose = halfway_pose(landmarks, ball);
        Self { estimate: PoseEstimate::new(pose, RETURNED_SD[0], RETURNED_SD[1]), sides: Some([0.0; 2]), ..default() }
    }

    /// That of a robot that comes back from where it waited: beyond the side line that it was nearer to when it was
    /// removed from `y`, level with its own penalty mark, facing the pitch (2025 rule book).
    pub fn waiting(landmarks: &Landmarks, y: f32) -> Self {
        let pose = waiting_pose(landmarks, y);
        Self { estimate: PoseEstimate::new(pose, RETURNED_SD[0], RETURNED_SD[1]), ..default() }
    }

    /// A measured step (in the robot's frame before it) and `duration` seconds later.
    pub fn moved_by(&self, step: Pose, duration: f32, error: &StepError) -> Self {
        Self { estimate: self.estimate.moved_by(step, error), age_s: self.age_s + duration, ..*self }
    }

    /// Corrects the pose by what is seen of the pitch in images of this size, pixels. `turn` changes from cycle to cycle,
    /// so that all marks get theirs.
    pub fn orient(
        &mut self,
        percepts: &Percepts,
        landmarks: &Landmarks,
        own_end: End,
        image: Vec2,
        turn: usize,
        model: &LandmarkModel,
    ) {
        let posts = &percepts.goal_posts;
        if self.sides.is_some() {
            self.choose_side(posts, landmarks, own_end, model);
        }
        match posts.as_slice() {
            [first, second] if first.colour == second.colour => {
                self.see_goal(first, second, landmarks, own_end, image, model);
            }
            posts => {
                for post in posts {
                    let candidates =
                        landmarks.goals(post.colour, own_end).flat_map(|goal| [goal.left_post, goal.right_post]);
                    let sighting = sighting_of_post(post, image, model);
                    let association = self.associate(&sighting, candidates);
                    self.judge(association, model);
                }
            }
        }
        let marks = percepts.landmarks.iter().filter(|mark| !matches!(mark.kind, LandmarkKind::Line { .. }));
        let count = marks.clone().count();
        for mark in marks.cycle().skip(turn % count.max(1)).take(count.min(MARKS_PER_CYCLE)) {
            self.see_mark(mark, landmarks, model);
        }
        if self.contradictions > model.contradictions {
            self.contradictions = 0;
            self.estimate = self.estimate.doubted(LOST_SD[0], LOST_SD[1]);
        }
    }

    /// Two posts of one colour are a goal: which of them is the left one is beyond doubt.
    fn see_goal(
        &mut self,
        first: &GoalPostPercept,
        second: &GoalPostPercept,
        landmarks: &Landmarks,
        own_end: End,
        image: Vec2,
        model: &LandmarkModel,
    ) {
        let is_first_left = first.position_m.perp_dot(second.position_m) < 0.0;
        let [left, right] = if is_first_left { [first, second] } else { [second, first] };
        let sightings = [left, right].map(|post| sighting_of_post(post, image, model));
        let forward = self.estimate.pose.forward();
        // Where both goals have the same colour, it is the likelier one.
        let nearest = landmarks
            .goals(left.colour, own_end)
            .map(|goal| {
                let distance = self.estimate.innovation(forward, goal.left_post, &sightings[0]).distance_squared
                    + self.estimate.innovation(forward, goal.right_post, &sightings[1]).distance_squared;
                (distance, goal)
            })
            .min_by(|(first, _), (second, _)| first.total_cmp(second));
        let Some((distance, goal)) = nearest else { return };
        let places = [goal.left_post, goal.right_post];
        if distance > 2.0 * model.gate {
            self.contradictions += 1;
            if self.contradictions > model.contradictions {
                self.start_from_goal(places, [left.position_m, right.position_m], landmarks);
            }
            return;
        }
        for (place, sighting) in places.into_iter().zip(&sightings) {
            let innovation = self.estimate.innovation(self.estimate.pose.forward(), place, sighting);
            self.judge(Some(innovation), model);
        }
    }

    /// A lost robot that sees a goal knows where it is.
    fn start_from_goal(&mut self, posts: [Vec2; 2], seen: [Vec2; 2], landmarks: &Landmarks) {
        let pose = pose_from_two(posts, seen);
        if pose.position.abs().cmplt(landmarks.carpet_half_extents).all() {
            self.contradictions = 0;
            self.estimate = PoseEstimate::new(pose, LOST_SD[0], LOST_SD[1]);
        }
    }

    fn see_mark(&mut self, mark: &LandmarkPercept, landmarks: &Landmarks, model: &LandmarkModel) {
        let seen = self.estimate.pose.transform_point(mark.position_m);
        let near = |place: &Vec2| place.distance_squared(seen) < CANDIDATE_RANGE_M * CANDIDATE_RANGE_M;
        let sighting = Sighting::new(mark.position_m, model.mark_angle_sd);
        let association = match mark.kind {
            LandmarkKind::Junction { shape } => {
                let alike = landmarks.junctions.iter().filter(|(other, _)| *other == shape);
                self.associate(&sighting, alike.map(|(_, place)| *place).filter(near))
            }
            LandmarkKind::PenaltyCross => self.associate(&sighting, landmarks.crosses.into_iter().filter(near)),
            LandmarkKind::CentreCircle => {
                let sighting = Sighting::new(mark.position_m, model.goal_post_angle_sd);
                self.associate(&sighting, [Vec2::ZERO])
            }
            LandmarkKind::Line { .. } => None,
        };
        self.judge(association, model);
    }

    /// The landmark among `candidates` (m, team frame) that is seen, if it is clear which one.
    fn associate(&self, sighting: &Sighting, candidates: impl IntoIterator<Item = Vec2>) -> Option<Innovation> {
        let forward = self.estimate.pose.forward();
        let mut best: Option<Innovation> = None;
        let mut second = f32::MAX;
        for candidate in candidates {
            let innovation = self.estimate.innovation(forward, candidate, sighting);
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

    /// Takes over what a landmark says, unless it is too unlikely.
    fn judge(&mut self, innovation: Option<Innovation>, model: &LandmarkModel) {
        let Some(innovation) = innovation else { return };
        if innovation.distance_squared < model.gate {
            self.estimate = self.estimate.corrected(&innovation);
            self.age_s = 0.0;
            self.contradictions = self.contradictions.saturating_sub(1);
        } else {
            self.contradictions += 1;
        }
    }

    /// Weighs the pose against the pose turned by half a turn.
    fn choose_side(&mut self, seen: &[GoalPostPercept], landmarks: &Landmarks, own_end: End, model: &LandmarkModel) {
        let Some(mut evidence) = self.sides else { return };
        let pose = self.estimate.pose;
        for post in seen {
            let sighting = Sighting::new(post.position_m, model.goal_post_angle_sd);
            for (pose, sum) in [pose, pose.turned_half()].into_iter().zip(&mut evidence) {
                let estimate = PoseEstimate { pose, ..self.estimate };
                let forward = pose.forward();
                *sum += landmarks
                    .goals(post.colour, own_end)
                    .flat_map(|goal| [goal.left_post, goal.right_post])
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
                self.estimate.pose = pose.turned_half();
            }
        }
    }
}

/// Where a penalised robot comes back on the halfway line: at the end away from the ball (m, team frame).
pub(super) fn halfway_pose(landmarks: &Landmarks, ball: Option<Vec2>) -> Pose {
    let side = if ball.is_some_and(|ball| ball.y > 0.0) { -1.0 } else { 1.0 };
    Pose::new(0.0, side * landmarks.half_width, -side * core::f32::consts::FRAC_PI_2)
}

/// Where a robot that was removed from `y` waits, beyond the side line.
pub(super) fn waiting_pose(landmarks: &Landmarks, y: f32) -> Pose {
    let side = if y < 0.0 { -1.0 } else { 1.0 };
    let x = -landmarks.crosses[1].x.abs();
    let beyond = WAITING_DISTANCE_M.min(landmarks.carpet_half_extents.y - landmarks.half_width);
    Pose::new(x, side * (landmarks.half_width + beyond), -side * core::f32::consts::FRAC_PI_2)
}

/// What the measured place of a post is worth.
pub(super) fn sighting_of_post(post: &GoalPostPercept, image: Vec2, model: &LandmarkModel) -> Sighting {
    let foot_in_image = post.pixel.cmpge(Vec2::ZERO).all() && post.pixel.cmple(image).all();
    let distance_factor = if foot_in_image { 1.0 } else { HIDDEN_FOOT_FACTOR };
    Sighting { distance_factor, ..Sighting::new(post.position_m, model.goal_post_angle_sd) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::camera::CameraSide;
    use approx::assert_abs_diff_eq;

    const IMAGE: Vec2 = Vec2::new(320.0, 240.0);

    fn post(from: Pose, colour: GoalColour, place: Vec2) -> GoalPostPercept {
        GoalPostPercept {
            camera: CameraSide::Top,
            colour,
            pixel: IMAGE / 2.0,
            position_m: from.inverse_transform_point(place),
        }
    }

    fn mark(from: Pose, kind: LandmarkKind, place: Vec2) -> LandmarkPercept {
        LandmarkPercept {
            camera: CameraSide::Bottom,
            kind,
            pixel: IMAGE / 2.0,
            position_m: from.inverse_transform_point(place),
        }
    }

    fn oriented(start: OwnPose, percepts: &Percepts, own_end: End, cycles: usize) -> OwnPose {
        let landmarks = Landmarks::of(&Pitch::default());
        let mut own = start;
        for turn in 0..cycles {
            own.orient(percepts, &landmarks, own_end, IMAGE, turn, &LandmarkModel::default());
        }
        own
    }

    fn assert_near(own: &OwnPose, truth: Pose) {
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
        let start = OwnPose { estimate: PoseEstimate::new(Pose::new(-0.8, 0.3, 3.0), 0.3, 0.2), ..default() };
        assert_near(&oriented(start, &percepts, End::PositiveX, 20), truth);
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
        let start =
            OwnPose { estimate: PoseEstimate::new(Pose::new(-0.6, 0.15, 0.35), 0.1, 0.05), age_s: 3.0, ..default() };
        let own = oriented(start, &percepts, End::NegativeX, 20);
        assert_near(&own, truth);
        assert_eq!(own.age_s, 0.0);
    }

    #[test]
    fn what_could_be_either_of_two_marks_says_nothing() {
        // Half-way between the two crossings of the circle with the halfway line, and no idea of y.
        let truth = Pose::new(-1.0, 0.0, 0.0);
        let kind = LandmarkKind::Junction { shape: JunctionShape::X };
        let percepts = Percepts { landmarks: vec![mark(truth, kind, Vec2::ZERO)], ..default() };
        let start = OwnPose { estimate: PoseEstimate::new(truth, 0.6, 0.3), age_s: 3.0, ..default() };
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
        let start = OwnPose::placed(Pose::new(-2.0, 1.0, 2.5));
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
            let own = oriented(OwnPose::returned(&landmarks, ball), &percepts, End::NegativeX, 30);
            assert_near(&own, truth);
        }
    }
}
