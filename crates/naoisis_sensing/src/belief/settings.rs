//! The settings of the simple estimator, and what of them a robot knows of itself.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Belief;
use super::ball::BallModel;
use super::landmarks::LandmarkModel;
use super::localisation_method::LocalisationMethod;
use super::pose_estimate::StepError;
use super::robots::{SonarModel, TrackModel};
use super::team_ball::TeamBallModel;
use crate::sensing::camera::field_of_view::FieldOfView;
use crate::sensing::odometry::OdometrySettings;
use crate::sensing::vision::GazeNoise;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::motion_limits::MotionLimits;

/// The settings of the simple estimator; it keeps the belief of robots that have them.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[require(Belief)]
#[reflect(Component, @Knowledge::Belief)]
#[serde(default, deny_unknown_fields)]
pub struct SimpleBelief {
    /// How the robot localises itself. Read when the match starts.
    pub localisation: LocalisationMethod,
    /// How much walking adds to the uncertainty of the pose.
    pub step_error: StepError,
    /// How landmarks are used.
    pub landmarks: LandmarkModel,
    /// Expected error of the angles at which the ball is seen: standard deviation, radians.
    pub ball_angle_sd: f32,
    /// The same for robots, radians.
    pub robot_angle_sd: f32,
    /// How the ball is expected to behave.
    pub ball: BallModel,
    /// A ball not seen for so long is forgotten, s.
    pub ball_forget_s: f32,
    /// A ball not seen where it should be for so long is forgotten, s.
    pub ball_missing_s: f32,
    /// A ball not seen for so long is where team-mates see it, s.
    pub ball_trust_s: f32,
    /// How robots are tracked.
    pub robots: TrackModel,
    /// What sonars say of robots.
    pub sonar: SonarModel,
    /// How what team-mates say of the ball is put together.
    pub team_ball: TeamBallModel,
    /// What a team-mate said is forgotten after this time, s: where messages are limited, each speaks every seven seconds or so.
    pub message_forget_s: f32,
}

impl Default for SimpleBelief {
    fn default() -> Self {
        Self {
            localisation: LocalisationMethod::default(),
            step_error: StepError::default(),
            landmarks: LandmarkModel::default(),
            ball_angle_sd: 0.005,
            robot_angle_sd: 0.01,
            ball: BallModel::default(),
            ball_forget_s: 6.0,
            ball_missing_s: 1.0,
            ball_trust_s: 1.0,
            robots: TrackModel::default(),
            sonar: SonarModel::default(),
            team_ball: TeamBallModel::default(),
            message_forget_s: 6.0,
        }
    }
}

impl SimpleBelief {
    /// The same for a robot that knows how it walks, what it has in view, and how its cameras err.
    pub(super) fn with_known(
        self,
        (limits, odometry): (&MotionLimits, &OdometrySettings),
        view: &FieldOfView,
        gaze: GazeNoise,
    ) -> Self {
        let landmarks = LandmarkModel { lens_height_m: view.lens_height_m, ..self.landmarks };
        let landmarks = if gaze == GazeNoise::default() { landmarks } else { landmarks.of_rocking_cameras() };
        Self { step_error: self.step_error.with_known(limits.gait.as_ref(), &odometry.noise), landmarks, ..self }
    }
}
