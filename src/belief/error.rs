//! How far a belief is from the truth: for whoever runs the match, never for a robot.
//!
//! | measure | of | meaning |
//! |---|---|---|
//! | error | pose, ball, its velocity, opponents | distance between belief and truth |
//! | NEES | pose, ball | normalised estimation error squared, eᵀ P⁻¹ e: by how much the error exceeds the robot's own covariance. Of a calibrated belief it lies within [`NEES_95_POSE`] or [`NEES_95_PLACE`] 95 times out of 100 (Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001) |
//! | false tracks | opponents | believed where none is within [`MATCH_M`] |
//! | time to detect | ball, opponents | how long the robot knew nothing of one that was on the pitch |

use bevy::prelude::*;

use super::{Belief, PlaceCovariance, PoseCovariance};
use crate::geometry::{Pose, wrap_angle};

/// A believed and a true robot further apart than this are not the same, m.
pub const MATCH_M: f32 = 0.5;
/// The interval in which the NEES of a pose lies with 95 %: χ² with three degrees of freedom.
pub const NEES_95_POSE: [f32; 2] = [0.216, 9.348];
/// The interval in which the NEES of a place lies with 95 %: χ² with two degrees of freedom.
pub const NEES_95_PLACE: [f32; 2] = [0.051, 7.378];

/// What is true of what a robot believes, in its team's frame.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Truth {
    /// The robot's pose.
    pub pose: Pose,
    /// Place (m) and velocity (m/s) of the ball, if there is one.
    pub ball: Option<[Vec2; 2]>,
    /// The opponents on the pitch, m.
    pub opponents: Vec<Vec2>,
}

/// The error of one robot's belief in one cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct BeliefError {
    /// Of the robot's own place, m.
    pub position_m: f32,
    /// Of its heading, radians, not negative.
    pub heading: f32,
    /// NEES of its pose. None where the covariance has no inverse.
    pub pose_nees: Option<f32>,
    /// Of the ball, where the robot believes that there is one.
    pub ball: Option<BallError>,
    /// Opponents that are on the pitch.
    pub opponents: u32,
    /// Those of them that the robot knows of.
    pub opponents_known: u32,
    /// The mean error of the places of those, m.
    pub opponent_m: Option<f32>,
    /// Believed opponents that are none.
    pub false_tracks: u32,
}

/// The error of what a robot believes of the ball.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct BallError {
    /// Of its place, m.
    pub position_m: f32,
    /// Of its velocity, m/s.
    pub velocity_mps: f32,
    /// NEES of its place. None where the covariance has no inverse.
    pub nees: Option<f32>,
}

impl BeliefError {
    /// Compares a belief with the truth. `known` is told the index of every true opponent that the robot knows of.
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
        let distances: Vec<f32> = matches.iter().map(|(_, distance)| *distance).collect();
        for (index, _) in &matches {
            known(*index);
        }
        Self {
            position_m: difference.length(),
            heading: turned.abs(),
            pose_nees: pose_nees(difference, turned, belief.pose_covariance),
            ball,
            opponents: truth.opponents.len() as u32,
            opponents_known: matches.len() as u32,
            opponent_m: (!distances.is_empty()).then(|| distances.iter().sum::<f32>() / distances.len() as f32),
            false_tracks: (belief.opponents.len() - matches.len()) as u32,
        }
    }
}

/// True opponents and how far from them they are believed: nearest pairs first, each only once.
fn matches(belief: &Belief, truth: &Truth) -> Vec<(usize, f32)> {
    let mut pairs: Vec<(f32, usize, usize)> = Vec::new();
    for (believed, opponent) in belief.opponents.iter().enumerate() {
        for (index, place) in truth.opponents.iter().enumerate() {
            let distance = opponent.position_m.distance(*place);
            if distance <= MATCH_M {
                pairs.push((distance, index, believed));
            }
        }
    }
    pairs.sort_by(|first, second| first.0.total_cmp(&second.0).then((first.1, first.2).cmp(&(second.1, second.2))));
    let mut taken: Vec<(usize, usize, f32)> = Vec::new();
    for (distance, index, believed) in pairs {
        if taken.iter().all(|(other, track, _)| *other != index && *track != believed) {
            taken.push((index, believed, distance));
        }
    }
    taken.into_iter().map(|(index, _, distance)| (index, distance)).collect()
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
    use crate::belief::{BallBelief, RobotBelief};
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
    }
}
