//! Computes the value of a quantity of an expectation.

use crate::record::match_counts::MatchCounts;
use naoisis_sim::scenario::{BallQuantity, Quantity, RobotQuantity, TeamQuantity};

/// Returns the value of `quantity` by the [definitions](crate::record::match_counts) of `counts`. `None` if there was nothing to
/// measure, and for mistakes, which are not among the counts.
pub fn value(counts: &MatchCounts, quantity: Quantity) -> Option<f64> {
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    Some(match quantity {
        Quantity::OfTeam(team, quantity) => match quantity {
            TeamQuantity::Goals => counts.goals[team].into(),
            TeamQuantity::OwnGoals => counts.own_goals[team].into(),
            TeamQuantity::Wins => f64::from(u8::from(counts.winner == Some(team))),
            TeamQuantity::ShootOutGoals => counts.shoot_out_goals[team].into(),
            TeamQuantity::Kicks => counts.team(team).kicks.into(),
            TeamQuantity::PassesCompleted => counts.team(team).passes_completed.into(),
            TeamQuantity::Shots => counts.team(team).shots.into(),
            TeamQuantity::ShotsOnTarget => counts.team(team).shots_on_target.into(),
            TeamQuantity::Saves => counts.team(team).saves.into(),
            TeamQuantity::DuelsWon => counts.duels_won[team].into(),
            TeamQuantity::Penalties => counts.team(team).penalty_count().into(),
            TeamQuantity::Falls => counts.team(team).falls.into(),
            TeamQuantity::Outs => counts.outs_of[team].into(),
            TeamQuantity::PossessionPercent => return percent(counts.possession(team)),
            TeamQuantity::ProgramsLost => counts.team(team).programs_lost.into(),
            TeamQuantity::Mistakes(_) => return None,
        },
        Quantity::OfBall(quantity) => {
            let [from_centre, from_left, from_right] = counts.ball_distances_m()?;
            f64::from(match quantity {
                BallQuantity::FromCentreM => from_centre,
                BallQuantity::FromLeftCornerM => from_left,
                BallQuantity::FromRightCornerM => from_right,
            })
        }
        Quantity::OfRobot(robot, quantity) => {
            let own = counts.robots.get(&robot)?;
            match quantity {
                RobotQuantity::Kicks => own.kicks.into(),
                RobotQuantity::Penalties => own.penalty_count().into(),
                RobotQuantity::Falls => own.falls.into(),
                RobotQuantity::PathM => own.distance_m,
                RobotQuantity::BallSeenPercent => return percent(own.ball_seen()),
                RobotQuantity::PoseErrorM => return own.pose_errors.mean_m(),
                RobotQuantity::BallErrorM => return own.ball_errors.mean_m(),
                RobotQuantity::Mistakes(_) => return None,
            }
        }
    })
}
