//! Localisation with percepts computed for known poses.

use super::*;
use crate::sensing::vision::{GoalPostPercept, Percepts};
use approx::assert_abs_diff_eq;
use naoisis_core::camera_model::CameraName;
use naoisis_core::pitch::{End, GoalColour, JunctionShape, Pitch};

const IMAGE: Vec2 = Vec2::new(320.0, 240.0);

fn post(from: Pose, colour: GoalColour, place: Vec2) -> GoalPostPercept {
    GoalPostPercept::new(CameraName::TOP, colour, IMAGE / 2.0, from.inverse_transform_point(place))
}

fn mark(from: Pose, kind: LandmarkKind, place: Vec2) -> LandmarkPercept {
    LandmarkPercept::new(CameraName::BOTTOM, kind, IMAGE / 2.0, from.inverse_transform_point(place))
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
    // A pink player in the first half defends the yellow goal at +x: in its team frame the goal is at -x.
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
    // From behind, left and right post are exchanged.
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
        let kind = LandmarkKind::Line { end_pixel: Vec2::ZERO, end_position_m };
        LandmarkPercept::new(CameraName::BOTTOM, kind, IMAGE / 2.0, place)
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
    // Half-way between the two crossings of the circle with the halfway line, with y unknown.
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
