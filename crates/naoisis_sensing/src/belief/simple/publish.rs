//! Publishes the estimates as a [`Belief`] in the team frame.

use bevy::prelude::*;

use super::SimpleBeliefMemory;
use crate::belief::camera_error::{CameraError, CameraMotion};
use crate::belief::robots::add_seen_mate;
use crate::belief::team_ball::{HeardBall, team_ball};
use crate::belief::{BallBelief, Belief, RobotBelief, SimpleBelief, place_covariance, pose_covariance};
use naoisis_core::team::Team;

impl SimpleBeliefMemory {
    /// Writes the estimates into the robot's belief.
    pub(super) fn publish(
        &self,
        belief: &mut Belief,
        team: Team,
        motion: Option<&CameraMotion>,
        settings: &SimpleBelief,
    ) {
        let estimate = self.own.estimate();
        let pose = estimate.pose;
        let forward = pose.forward();
        let turn = Mat2::from_cols(forward, forward.perp());
        let turned = |covariance: Mat2| turn * covariance * turn.transpose();
        let to_team = |place: Vec2| pose.position + forward.rotate(place);
        // The uncertainty of the own pose and of the camera directions is added to that of all other positions.
        let camera = self.own.camera().map(CameraError::total).zip(motion);
        let in_team = |place: Vec2, covariance: Mat2| {
            let camera = camera.as_ref();
            let covariance =
                covariance + camera.map_or(Mat2::ZERO, |(total, motion)| total.covariance_at(place, motion));
            place_covariance(turned(covariance) + estimate.covariance_at(forward.rotate(place)))
        };
        belief.pose = pose;
        belief.pose_covariance = pose_covariance(estimate.covariance);
        belief.pose_age_s = self.own.age_s();
        let seen = self.ball.map(|ball| BallBelief {
            position_m: to_team(ball.position),
            velocity_mps: forward.rotate(ball.credible_velocity(&settings.ball)),
            position_covariance: in_team(ball.position, ball.position_covariance),
            velocity_covariance: place_covariance(turned(ball.velocity_covariance)),
            age_s: ball.age_s,
            heard_from: None,
        });
        // The covariance of a ball that is believed extremely far away may overflow.
        let seen = seen.filter(BallBelief::is_finite);
        belief.ball = match seen {
            Some(ball) if ball.age_s < settings.ball_trust_s => seen,
            _ => self.heard_ball(settings).filter(BallBelief::is_finite).or(seen),
        };
        belief.team_mates.clear();
        belief.opponents.clear();
        belief.team_mates.extend(self.heard.iter().filter_map(|heard| {
            Some(RobotBelief {
                id: Some(heard.from),
                position_m: heard.position?,
                covariance: [0.04, 0.0, 0.04],
                age_s: heard.age_s,
            })
        }));
        let heard_count = belief.team_mates.len();
        for track in self.tracks.iter().filter(|track| track.sightings > 1) {
            let robot = RobotBelief {
                id: None,
                position_m: to_team(track.position),
                covariance: in_team(track.position, track.covariance),
                age_s: track.age_s,
            };
            if !robot.is_finite() {
                continue;
            }
            if track.team == team {
                add_seen_mate(&mut belief.team_mates, heard_count, robot);
            } else {
                belief.opponents.push(robot);
            }
        }
    }

    /// The ball that team-mates report.
    fn heard_ball(&self, settings: &SimpleBelief) -> Option<BallBelief> {
        let heard = self.heard.iter().filter(|heard| heard.age_s < settings.ball_trust_s).filter_map(|heard| {
            Some(HeardBall {
                from: heard.from,
                seen_from: heard.position?,
                place: heard.ball?,
                age_s: heard.age_s,
                moved_mps: heard.ball_moved_mps,
            })
        });
        team_ball(heard, &settings.team_ball)
    }
}
