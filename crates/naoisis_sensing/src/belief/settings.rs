//! The settings of the simple estimator.

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
use naoisis_core::robot::motion_settings::MotionSettings;

/// The settings of the simple estimator, which updates the belief of robots with this component.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[require(Belief)]
#[reflect(Component, @Knowledge::Belief)]
#[serde(default, deny_unknown_fields)]
pub struct SimpleBelief {
    /// The localisation method. Read when the match starts.
    pub localisation: LocalisationMethod,
    /// The growth of the uncertainty of the pose by walking.
    pub step_error: StepError,
    /// The measurement model of landmarks.
    pub landmarks: LandmarkModel,
    /// Standard deviation of the angles to the ball, radians.
    pub ball_angle_sd: f32,
    /// Standard deviation of the angles to robots, radians.
    pub robot_angle_sd: f32,
    /// The model of the ball's motion.
    pub ball: BallModel,
    /// The time without a sighting after which the ball is removed, s.
    pub ball_forget_s: f32,
    /// The time after which the ball is removed if it is not seen although it should be in view, s.
    pub ball_missing_s: f32,
    /// The time without a sighting after which the ball that team-mates report is believed, s.
    pub ball_trust_s: f32,
    /// The model of tracking robots.
    pub robots: TrackModel,
    /// The measurement model of sonars.
    pub sonar: SonarModel,
    /// The fusion of the balls that team-mates report.
    pub team_ball: TeamBallModel,
    /// The time after which messages are forgotten, s. Under a limit, each player sends one about every seven seconds.
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
    /// Adapts the settings to the robot's gait, odometry, cameras and gaze noise.
    pub(super) fn with_known(
        self,
        (motion, odometry): (&MotionSettings, &OdometrySettings),
        view: &FieldOfView,
        gaze: GazeNoise,
    ) -> Self {
        let landmarks = LandmarkModel { lens_height_m: view.lens_height_m, ..self.landmarks };
        let landmarks = if gaze == GazeNoise::default() { landmarks } else { landmarks.of_rocking_cameras() };
        Self { step_error: self.step_error.with_known(motion.gait.as_ref(), &odometry.noise), landmarks, ..self }
    }
}
