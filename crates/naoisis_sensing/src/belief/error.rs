//! The error of a belief, for evaluation; a robot never knows it.
//!
//! | measure | of | meaning |
//! |---|---|---|
//! | error | pose, ball, its velocity, opponents | distance between belief and truth |
//! | NEES | pose, ball, opponents | normalised estimation error squared, eᵀ P⁻¹ e: the squared error relative to the robot's own covariance |
//! | false tracks | opponents | believed opponents without a true one within [`MATCH_M`] |
//! | time to detect | ball, opponents | the time for which an object on the pitch is unknown to the robot |
//!
//! The NEES (Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001) is at most
//! [`ELLIPSOID_95`](super::covariance::ELLIPSOID_95) or [`ELLIPSE_95`] if the truth lies within the robot's 95 % ellipse, as in 95 of 100
//! cases for a calibrated belief.
//!
//! A belief refers to the time of the measurements, the start of a cycle. It is compared with the truth at that time, not at the end of the
//! cycle.

use bevy::prelude::*;

use super::covariance::ELLIPSE_95;
use super::{Belief, PlaceCovariance, PoseCovariance, RobotBelief};
use naoisis_core::geometry::{Pose, wrap_angle};

/// The greatest distance between a believed robot and the true one, m.
pub const MATCH_M: f32 = 0.5;

/// The truth that a belief is compared with, in the team frame.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Truth {
    /// The robot's pose.
    pub pose: Pose,
    /// Position (m) and velocity (m/s) of the ball, if there is one.
    pub ball: Option<[Vec2; 2]>,
    /// The opponents on the pitch, m.
    pub opponents: Vec<Vec2>,
}

/// The error of one robot's belief in one cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct BeliefError {
    /// The error of the robot's own position, m.
    pub position_m: f32,
    /// The error of its heading, radians, not negative.
    pub heading: f32,
    /// The NEES of its pose; `None` if the covariance is singular.
    pub pose_nees: Option<f32>,
    /// The error of the believed ball, if there is one.
    pub ball: Option<BallError>,
    /// The number of opponents on the pitch.
    pub opponents: u32,
    /// The number of opponents on the pitch that are believed.
    pub opponents_known: u32,
    /// The number of believed opponents within the 95 % ellipse of their belief.
    pub opponents_within: u32,
    /// The mean position error of the believed opponents, m.
    pub opponent_m: Option<f32>,
    /// The number of believed opponents without a true one within [`MATCH_M`].
    pub false_tracks: u32,
}

/// The error of the believed ball.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct BallError {
    /// The error of the position, m.
    pub position_m: f32,
    /// The error of the velocity, m/s.
    pub velocity_mps: f32,
    /// The NEES of the position; `None` if the covariance is singular.
    pub nees: Option<f32>,
}

impl BeliefError {
    /// Compares a belief with the truth. Calls `known` with the index of each true opponent that is believed.
    pub fn of(belief: &Belief, truth: &Truth, mut known: impl FnMut(usize)) -> Self {
        let difference = truth.pose.position - belief.pose.position;
        let turned = wrap_angle(truth.pose.heading - belief.pose.heading);
        let ball = belief.ball.zip(truth.ball).map(|(believed, [place, velocity])| {
            let difference = place - believed.position_m;
            BallError {
                position_m: difference.length(),
                velocity_mps: velocity.distance(believed.velocity_mps),
                nees: place_nees(difference, believed.position_covariance),
            }
        });
        let matches = matches(belief, truth);
        let mut opponents_within = 0;
        for Match { index, believed, .. } in &matches {
            known(*index);
            let RobotBelief { position_m, covariance, .. } = belief.opponents[*believed];
            let nees = place_nees(truth.opponents[*index] - position_m, covariance);
            opponents_within += u32::from(nees.is_some_and(|nees| nees <= ELLIPSE_95));
        }
        let summed_m: f32 = matches.iter().map(|found| found.distance_m).sum();
        Self {
            position_m: difference.length(),
            heading: turned.abs(),
            pose_nees: pose_nees(difference, turned, belief.pose_covariance),
            ball,
            opponents: truth.opponents.len() as u32,
            opponents_known: matches.len() as u32,
            opponents_within,
            opponent_m: (!matches.is_empty()).then(|| summed_m / matches.len() as f32),
            false_tracks: (belief.opponents.len() - matches.len()) as u32,
        }
    }
}

/// A true opponent matched with a believed one.
struct Match {
    distance_m: f32,
    /// The index of the true opponent.
    index: usize,
    /// The index of the believed opponent.
    believed: usize,
}

/// Matches true and believed opponents: the nearest pairs first, each robot once.
fn matches(belief: &Belief, truth: &Truth) -> Vec<Match> {
    let mut pairs: Vec<Match> = Vec::new();
    for (believed, opponent) in belief.opponents.iter().enumerate() {
        for (index, place) in truth.opponents.iter().enumerate() {
            let distance_m = opponent.position_m.distance(*place);
            if distance_m <= MATCH_M {
                pairs.push(Match { distance_m, index, believed });
            }
        }
    }
    let order = |pair: &Match| (pair.index, pair.believed);
    pairs
        .sort_by(|first, second| first.distance_m.total_cmp(&second.distance_m).then(order(first).cmp(&order(second))));
    let mut taken: Vec<Match> = Vec::new();
    for pair in pairs {
        if taken.iter().all(|other| other.index != pair.index && other.believed != pair.believed) {
            taken.push(pair);
        }
    }
    taken
}

fn pose_nees(difference: Vec2, turned: f32, [xx, xy, yy, xt, yt, tt]: PoseCovariance) -> Option<f32> {
    let covariance = Mat3::from_cols(Vec3::new(xx, xy, xt), Vec3::new(xy, yy, yt), Vec3::new(xt, yt, tt));
    let error = difference.extend(turned);
    let nees = error.dot(covariance.inverse() * error);
    (covariance.determinant() > 0.0 && nees.is_finite()).then_some(nees)
}

fn place_nees(difference: Vec2, [xx, xy, yy]: PlaceCovariance) -> Option<f32> {
    let covariance = Mat2::from_cols(Vec2::new(xx, xy), Vec2::new(xy, yy));
    let nees = difference.dot(covariance.inverse() * difference);
    (covariance.determinant() > 0.0 && nees.is_finite()).then_some(nees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::BallBelief;
    use approx::assert_abs_diff_eq;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.01, 0.0, 0.01], age_s: 0.0 }
    }

    #[test]
    fn errors_and_nees_by_hand() {
        // 0.3 m along x with a variance of 0.04, 0.2 rad with 0.01: NEES = 0.09 / 0.04 + 0.04 / 0.01 = 6.25.
        let belief = Belief {
            pose: Pose::new(1.0, 0.5, 3.1),
            pose_covariance: [0.04, 0.0, 0.04, 0.0, 0.0, 0.01],
            ball: Some(BallBelief {
                position_m: Vec2::new(1.0, 1.0),
                velocity_mps: Vec2::X,
                position_covariance: [0.02, 0.0, 0.01],
                ..default()
            }),
            ..default()
        };
        // Across the seam of the angles.
        let truth = Truth {
            pose: Pose { position: Vec2::new(1.3, 0.5), heading: wrap_angle(3.3) },
            ball: Some([Vec2::new(1.2, 1.1), Vec2::new(1.0, 0.5)]),
            ..default()
        };
        let error = BeliefError::of(&belief, &truth, |_| {});
        assert_abs_diff_eq!(error.position_m, 0.3, epsilon = 1e-6);
        assert_abs_diff_eq!(error.heading, 0.2, epsilon = 1e-5);
        assert_abs_diff_eq!(error.pose_nees.unwrap(), 6.25, epsilon = 1e-3);
        let ball = error.ball.unwrap();
        // 0.2² / 0.02 + 0.1² / 0.01 = 3.
        assert_abs_diff_eq!(ball.nees.unwrap(), 3.0, epsilon = 1e-4);
        assert_abs_diff_eq!(ball.velocity_mps, 0.5, epsilon = 1e-6);
        assert_abs_diff_eq!(ball.position_m, 0.05_f32.sqrt(), epsilon = 1e-6);
        assert_eq!(BeliefError::of(&Belief::default(), &truth, |_| {}).pose_nees, None, "certain, and wrong");
    }

    #[test]
    fn opponents_are_matched_to_the_nearest_and_the_rest_are_false_tracks() {
        let belief =
            Belief { opponents: vec![opponent(1.0, 0.0), opponent(1.2, 0.0), opponent(-2.0, 0.0)], ..default() };
        let truth =
            Truth { opponents: vec![Vec2::new(2.5, 0.0), Vec2::new(1.1, 0.05), Vec2::new(1.4, 0.0)], ..default() };
        let mut known = Vec::new();
        let error = BeliefError::of(&belief, &truth, |index| known.push(index));
        known.sort_unstable();
        assert_eq!(known, [1, 2]);
        assert_eq!((error.opponents, error.opponents_known, error.false_tracks), (3, 2, 1));
        // (0.1² + 0.05²) / 0.01 = 1.25 is within 5.991, 0.2² / 0.01 = 4 too, and 0.3² / 0.01 = 9 would not be.
        assert_eq!(error.opponents_within, 2);
        let further = Truth { opponents: vec![Vec2::new(-2.3, 0.0)], ..default() };
        let error = BeliefError::of(&belief, &further, |_| {});
        assert_eq!((error.opponents_known, error.opponents_within), (1, 0));
    }
}
