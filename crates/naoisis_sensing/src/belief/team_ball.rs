//! The team ball: the fusion of the balls that several team-mates report.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::BallBelief;
use super::covariance::inverse;
use super::sighting::Sighting;
use naoisis_core::team::RobotId;

/// The model of the fusion.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TeamBallModel {
    /// Standard deviation of the angles at which team-mates see the ball, radians.
    pub angle_sd: f32,
    /// Standard deviation of the ball's position caused by the errors of the team-mates' own poses, m.
    pub pose_sd: f32,
    /// Standard deviation of the velocity of a reported ball, m/s.
    pub speed_sd: f32,
    /// Standard deviation of the velocity of a ball that was reported only once, and may roll, m/s.
    pub unknown_speed_sd: f32,
    /// Standard deviation of the velocity of a rolling ball, as a share of its speed.
    pub rolling_speed_sd: f32,
    /// The time from a sighting to its report, s.
    pub told_late_s: f32,
    /// The speed below which a ball counts as at rest, m/s.
    pub rest_speed_mps: f32,
    /// The greatest speed of a ball between two reports, m/s; if it seems faster, one of them was a false detection.
    pub fastest_mps: f32,
    /// The greatest distance between a report and the best one, m.
    pub agreement_m: f32,
}

impl Default for TeamBallModel {
    fn default() -> Self {
        Self {
            angle_sd: 0.01,
            pose_sd: 0.1,
            speed_sd: 0.5,
            unknown_speed_sd: 1.0,
            rolling_speed_sd: 0.5,
            told_late_s: 0.2,
            rest_speed_mps: 0.3,
            fastest_mps: 5.0,
            agreement_m: 0.8,
        }
    }
}

/// The report of a team-mate about the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HeardBall {
    /// The team-mate.
    pub from: RobotId,
    /// The position of the team-mate, m, team frame.
    pub seen_from: Vec2,
    /// The position of the ball, m, team frame.
    pub place: Vec2,
    /// The age of the report, s.
    pub age_s: f32,
    /// The velocity of the ball between the last two reports, m/s, team frame; `None` after the first one.
    pub moved_mps: Option<Vec2>,
}

impl HeardBall {
    /// The covariance of the ball's position, m².
    fn covariance(&self, model: &TeamBallModel) -> Mat2 {
        let kicked_sd = if self.moved_mps.is_some() { model.speed_sd } else { model.unknown_speed_sd } * self.age_s;
        let rolling_sd = model.rolling_speed_sd * self.rolls_mps(model).length() * (self.age_s + model.told_late_s);
        let more = model.pose_sd * model.pose_sd + kicked_sd * kicked_sd + rolling_sd * rolling_sd;
        Sighting::new(self.place - self.seen_from, model.angle_sd).noise_at(self.place - self.seen_from)
            + Mat2::from_diagonal(Vec2::splat(more))
    }

    /// The velocity of the ball, m/s, team frame.
    fn rolls_mps(&self, model: &TeamBallModel) -> Vec2 {
        let is_rolling = |moved: &Vec2| (model.rest_speed_mps..model.fastest_mps).contains(&moved.length());
        self.moved_mps.filter(is_rolling).unwrap_or_default()
    }

    /// Predicts the position of the ball at the present time.
    fn by_now(self, model: &TeamBallModel) -> Self {
        Self { place: self.place + self.rolls_mps(model) * self.age_s, ..self }
    }
}

/// The fusion of the reports that agree with the best one, weighted by their covariances; `None` without a report.
pub fn team_ball(heard: impl Iterator<Item = HeardBall> + Clone, model: &TeamBallModel) -> Option<BallBelief> {
    let heard = heard.map(|witness| witness.by_now(model));
    let best = heard
        .clone()
        .map(|witness| (witness.covariance(model).determinant(), witness))
        .min_by(|(first, _), (second, _)| first.total_cmp(second))?
        .1;
    let (mut information, mut weighed) = (Mat2::ZERO, Vec2::ZERO);
    for witness in heard.filter(|witness| witness.place.distance(best.place) <= model.agreement_m) {
        let inverse = inverse(witness.covariance(model));
        information += inverse;
        weighed += inverse * witness.place;
    }
    let covariance = inverse(information);
    Some(BallBelief {
        position_m: covariance * weighed,
        velocity_mps: best.rolls_mps(model),
        position_covariance: super::place_covariance(covariance),
        velocity_covariance: [model.speed_sd * model.speed_sd, 0.0, model.speed_sd * model.speed_sd],
        age_s: best.age_s,
        heard_from: Some(best.from),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_core::team::Team;

    fn heard(number: u8, seen_from: [f32; 2], place: [f32; 2]) -> HeardBall {
        let from = RobotId::new(Team::Blue, number);
        HeardBall { from, seen_from: seen_from.into(), place: place.into(), age_s: 0.0, moved_mps: None }
    }

    #[test]
    fn two_robots_on_different_sides_know_more_than_each_of_them() {
        // Each errs along its own line of sight: the one along x, the other along y.
        let witnesses = [heard(2, [-3.0, 0.0], [0.4, 0.0]), heard(3, [0.0, -3.0], [0.0, 0.4])];
        let ball = team_ball(witnesses.into_iter(), &TeamBallModel::default()).unwrap();
        assert!(ball.position_m.length() < 0.15, "{}", ball.position_m);
        assert!(ball.position_covariance[0] < witnesses[0].covariance(&TeamBallModel::default()).x_axis.x);
    }

    #[test]
    fn equally_good_reports_are_averaged_and_a_distant_one_is_ignored() {
        let witnesses =
            [heard(2, [-1.0, 0.0], [0.0, 0.1]), heard(3, [1.0, 0.0], [0.0, -0.1]), heard(4, [-4.0, 0.0], [3.0, 1.0])];
        let ball = team_ball(witnesses.into_iter(), &TeamBallModel::default()).unwrap();
        assert_abs_diff_eq!(ball.position_m, Vec2::ZERO, epsilon = 1e-5);
        assert_eq!(team_ball(core::iter::empty(), &TeamBallModel::default()), None);
    }

    #[test]
    fn a_ball_that_rolled_between_two_messages_has_rolled_on_and_where_to_is_less_certain() {
        let model = TeamBallModel::default();
        let told = |moved_mps| {
            let witness = HeardBall { age_s: 0.4, moved_mps, ..heard(2, [-1.0, 0.0], [0.0, 0.0]) };
            team_ball([witness].into_iter(), &model).unwrap()
        };
        let [rolling, still, jumped] = [Some(Vec2::X), Some(Vec2::X * 0.1), Some(Vec2::X * 9.0)].map(told);
        // 1 m/s for 0.4 s.
        assert_abs_diff_eq!(rolling.position_m, Vec2::new(0.4, 0.0), epsilon = 1e-5);
        assert_eq!((rolling.velocity_mps, still.velocity_mps), (Vec2::X, Vec2::ZERO));
        assert_eq!((still.position_m, jumped.position_m), (Vec2::ZERO, Vec2::ZERO));
        assert!(rolling.position_covariance[2] > still.position_covariance[2]);
        assert!(told(None).position_covariance[2] > still.position_covariance[2]);
    }
}
