//! The belief of a robot: one typed [`Belief`], which behaviours read and write.
//!
//! Positions are in the *team frame*: the pitch frame, rotated by half a turn for the team that defends +x, so that the own goal is always
//! at -x. Convert with [`team_from_pitch`], [`pitch_from_team`] and their variants for points.
//!
//! The [`simple`] estimator updates the belief of the robots of the built-in teams. Like every behaviour it reads only the sensors, and is
//! registered through the same [barrier](naoisis_core::behaviour::barrier).

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::End;
use naoisis_core::team::RobotId;

mod association;
pub mod ball;
pub mod camera_error;
pub mod covariance;
pub mod error;
mod innovation;
mod kalman_localiser;
mod landmarks;
mod line_sighting;
pub mod localisation_method;
mod localiser;
mod moments;
pub mod particle_filter;
mod particle_set;
mod particle_sightings;
pub mod pose_estimate;
pub mod robots;
mod settings;
pub mod sighting;
pub mod simple;
pub mod team_ball;
pub mod unscented;
mod wrong_end;

pub use landmarks::LandmarkModel;
pub use settings::SimpleBelief;
pub use simple::SimpleBeliefPlugin;

/// The covariance of a position, m²: the entries xx, xy, yy of the symmetric matrix.
pub type PlaceCovariance = [f32; 3];

/// The covariance of a pose, m and radians: the entries xx, xy, yy, xθ, yθ, θθ of the symmetric matrix.
pub type PoseCovariance = [f32; 6];

/// The believed positions of the robot itself, the ball and the other robots, in the team frame.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Belief)]
#[serde(default, deny_unknown_fields)]
pub struct Belief {
    /// The robot's own pose: `[x m, y m, heading deg]` in files.
    #[serde(with = "file_units::pose")]
    #[schemars(with = "[f32; 3]")]
    pub pose: Pose,
    /// The covariance of the pose, m and radians: xx, xy, yy, xθ, yθ, θθ.
    pub pose_covariance: PoseCovariance,
    /// The time since a landmark confirmed the pose, s.
    pub pose_age_s: f32,
    /// The ball, if its position is known.
    pub ball: Option<BallBelief>,
    /// Team-mates: first those with a known number, in its order.
    pub team_mates: Vec<RobotBelief>,
    /// Opponents; their numbers are not known.
    pub opponents: Vec<RobotBelief>,
}

/// The believed ball.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BallBelief {
    /// Position, m, team frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
    /// Velocity, m/s, team frame.
    #[serde(default)]
    #[schemars(with = "[f32; 2]")]
    pub velocity_mps: Vec2,
    /// The covariance of the position, m²: xx, xy, yy.
    #[serde(default)]
    pub position_covariance: PlaceCovariance,
    /// The covariance of the velocity, (m/s)²: xx, xy, yy.
    #[serde(default)]
    pub velocity_covariance: PlaceCovariance,
    /// The time since the ball was seen, s: by the robot itself, or by the team-mate that reported it.
    #[serde(default)]
    pub age_s: f32,
    /// The team-mate that reported the ball; `None` if the robot has seen it itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heard_from: Option<RobotId>,
}

/// Another robot, as believed.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotBelief {
    /// The robot's id; `None` if it was only seen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<RobotId>,
    /// Position, m, team frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
    /// The covariance of the position, m²: xx, xy, yy.
    #[serde(default)]
    pub covariance: PlaceCovariance,
    /// The time since the robot was seen or reported, s.
    #[serde(default)]
    pub age_s: f32,
}

impl BallBelief {
    /// Whether every number in the belief is finite.
    pub fn is_finite(&self) -> bool {
        let Self { position_m, velocity_mps, position_covariance, velocity_covariance, age_s, heard_from: _ } = self;
        let covariances = position_covariance.iter().chain(velocity_covariance);
        position_m.is_finite() && velocity_mps.is_finite() && covariances.chain([age_s]).all(|entry| entry.is_finite())
    }
}

impl RobotBelief {
    /// Whether every number in the belief is finite.
    pub fn is_finite(&self) -> bool {
        let Self { id: _, position_m, covariance, age_s } = self;
        position_m.is_finite() && covariance.iter().chain([age_s]).all(|entry| entry.is_finite())
    }
}

impl Belief {
    /// Whether every number in the belief is finite.
    pub fn is_finite(&self) -> bool {
        let Self { pose, pose_covariance, pose_age_s, ball, team_mates, opponents } = self;
        pose.is_finite()
            && pose_covariance.iter().chain([pose_age_s]).all(|entry| entry.is_finite())
            && ball.is_none_or(|ball| ball.is_finite())
            && team_mates.iter().chain(opponents).all(RobotBelief::is_finite)
    }

    /// The belief of a robot that knows only its pose, team frame.
    pub fn at(pose: Pose) -> Self {
        Self { pose, ..default() }
    }

    /// The position of the ball in the robot's own frame, m.
    pub fn ball_in_robot(&self) -> Option<Vec2> {
        self.ball.map(|ball| self.pose.inverse_transform_point(ball.position_m))
    }

    /// The robot's own pose in the pitch frame, for a team that defends `own_end`.
    pub fn pose_in_pitch(&self, own_end: End) -> Pose {
        pitch_from_team(self.pose, own_end)
    }
}

/// Transforms a pose from the pitch frame to the frame of the team that defends `own_end`.
pub fn team_from_pitch(pose: Pose, own_end: End) -> Pose {
    match own_end {
        End::NegativeX => pose,
        End::PositiveX => pose.turned_half(),
    }
}

/// Transforms a pose from the frame of the team that defends `own_end` to the pitch frame.
pub fn pitch_from_team(pose: Pose, own_end: End) -> Pose {
    // Half a turn is its own inverse.
    team_from_pitch(pose, own_end)
}

/// Transforms a point or vector, m, from the pitch frame to the frame of the team that defends `own_end`.
pub fn point_team_from_pitch(point: Vec2, own_end: End) -> Vec2 {
    match own_end {
        End::NegativeX => point,
        End::PositiveX => -point,
    }
}

/// Transforms a point or vector, m, from the frame of the team that defends `own_end` to the pitch frame.
pub fn point_pitch_from_team(point: Vec2, own_end: End) -> Vec2 {
    point_team_from_pitch(point, own_end)
}

/// The entries of the covariance matrix of a position.
fn place_covariance(matrix: Mat2) -> PlaceCovariance {
    [matrix.x_axis.x, matrix.y_axis.x, matrix.y_axis.y]
}

/// The entries of the covariance matrix of a pose.
fn pose_covariance(matrix: Mat3) -> PoseCovariance {
    let [x, y, heading] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    [x.x, y.x, y.y, heading.x, heading.y, heading.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn the_own_goal_is_at_negative_x_for_both_teams() {
        let in_pitch = Pose::new(-2.0, 1.0, FRAC_PI_2);
        assert_eq!(team_from_pitch(in_pitch, End::NegativeX), in_pitch);
        let turned = team_from_pitch(in_pitch, End::PositiveX);
        assert_eq!(turned.position, Vec2::new(2.0, -1.0));
        assert_abs_diff_eq!(turned.heading, -FRAC_PI_2, epsilon = 1e-6);
        let back = pitch_from_team(turned, End::PositiveX);
        assert_eq!(back.position, in_pitch.position);
        assert_abs_diff_eq!(back.heading, in_pitch.heading, epsilon = 1e-6);
        assert_eq!(point_pitch_from_team(Vec2::new(1.0, 2.0), End::PositiveX), Vec2::new(-1.0, -2.0));
    }

    #[test]
    fn the_ball_in_the_robots_frame_follows_from_both_places() {
        let belief = Belief {
            ball: Some(BallBelief { position_m: Vec2::new(0.0, 1.0), ..default() }),
            ..Belief::at(Pose::new(1.0, 1.0, PI))
        };
        let ball = belief.ball_in_robot().unwrap();
        assert_abs_diff_eq!(ball, Vec2::new(1.0, 0.0), epsilon = 1e-6);
    }

    #[test]
    fn files_have_poses_in_degrees_and_ages_in_seconds() {
        let belief = Belief {
            pose_age_s: 0.5,
            ball: Some(BallBelief { position_m: Vec2::new(1.0, 2.0), age_s: 0.25, ..default() }),
            opponents: vec![RobotBelief { id: None, position_m: Vec2::X, covariance: [0.25, 0.0, 0.25], age_s: 1.0 }],
            ..Belief::at(Pose::new(-1.0, 0.5, FRAC_PI_2))
        };
        let json = serde_json::to_value(&belief).unwrap();
        assert_eq!(json["pose"], serde_json::json!([-1.0, 0.5, 90.0]));
        assert_eq!(json["pose_covariance"].as_array().unwrap().len(), 6);
        assert_eq!(json["ball"]["position_m"], serde_json::json!([1.0, 2.0]));
        assert_eq!(json["ball"]["age_s"], 0.25);
        assert_eq!(json["opponents"][0]["covariance"], serde_json::json!([0.25, 0.0, 0.25]));
        assert_eq!(serde_json::from_value::<Belief>(json).unwrap(), belief);
    }
}
