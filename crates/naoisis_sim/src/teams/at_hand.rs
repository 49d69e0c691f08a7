//! The kicks that a player can make at once, with the ball as it lies at its feet. When opponents are about to take the ball, a fair
//! kick now is better than a good one later.

use super::aiming::Aim;
use super::kicking::{BallAtFeet, LEAST_KICK_M, room_inside};
use super::options::{AHEAD_ANGLES, AHEAD_SHARES, BEYOND, KickOption};
use super::player::Player;
use super::worth::{Company, aims_within, is_first, kick_worth, reach_m, shot_worth, standing};
use naoisis_core::geometry::unit;
use naoisis_core::robot::kick::KickRequest;

/// Returns the best kick that can be made at once, with its value. `may_shoot`: whether a goal would count; `is_ours`: whether opponents
/// must keep away from the ball.
pub fn best_at_hand(
    player: &Player,
    company: Company,
    at_feet: BallAtFeet,
    may_shoot: bool,
    is_ours: bool,
) -> Option<(KickRequest, KickOption)> {
    let ball = at_feet.place;
    let theirs_s = company.opponents_walk_s(player, ball);
    let ready = |kick: &KickRequest| {
        if is_ours { 1.0 } else { is_first(player, player.kicks.wind_up_of_s(kick.kick_type), theirs_s) }
    };
    let contested = standing(player, ball, 0.5);
    // Kicks that cannot be aimed have one direction each.
    let angles: &[f32] = if aims_within(player) > 0.0 { &AHEAD_ANGLES } else { &[0.0] };
    let kicks = angles.iter().flat_map(|angle| at_feet.kicks(player.kicks, unit(*angle).rotate(at_feet.forward)));
    let options = kicks.flat_map(|(kick, direction)| {
        let furthest_m = player.kicks.max_distance_m(kick.kick_type);
        let to_goal_m = (player.opponent_goal().x - ball.x) / direction.x.max(0.1);
        let shoots = may_shoot && direction.x > 0.1 && furthest_m > BEYOND * to_goal_m;
        let shot = shoots.then(|| {
            let place = ball + direction * to_goal_m;
            let aim = Aim { is_shot: true, ..Aim::at(ball, place) };
            (kick, aim, place, (shot_worth(player, company, ball, direction), None))
        });
        let least_m = LEAST_KICK_M.max(player.kicks.min_distance_m(kick.kick_type));
        let most_m = furthest_m.min(room_inside(ball, direction, player.pitch));
        let distances = AHEAD_SHARES.into_iter().map(move |share| (share * reach_m(player)).min(most_m));
        let others = distances.filter(move |distance_m| *distance_m >= least_m).map(move |distance_m| {
            let place = ball + direction * distance_m;
            let kick = KickRequest { speed: player.rolling.speed_share(distance_m, furthest_m), ..kick };
            (kick, Aim::at(ball, place), place, kick_worth(player, company, ball, place))
        });
        shot.into_iter().chain(others)
    });
    let valued = options.map(|(kick, aim, place, (worth, receiver))| {
        let ready = ready(&kick);
        let value = ready * worth + (1.0 - ready) * contested;
        (kick, KickOption { aim, place, receiver, value })
    });
    // The first of equal kicks is chosen.
    valued.reduce(|best, next| if next.1.value > best.1.value { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use bevy::prelude::*;
    use naoisis_core::geometry::Pose;
    use naoisis_core::kick_geometry::KickType;
    use naoisis_sensing::belief::RobotBelief;

    /// Returns the kick that a player at (0, 0), facing the opponents' goal, makes at once with a ball at `ball`, robot frame.
    fn made(ball: Vec2, opponents: &[RobotBelief], mates: &[(u8, Vec2)]) -> Option<(KickRequest, KickOption)> {
        let situation = PlayerFixture::new(Pose::default(), ball);
        let at_feet = BallAtFeet { place: ball, in_robot: ball, forward: Vec2::X, ..default() };
        best_at_hand(&situation.player(), Company { mates, opponents }, at_feet, true, false)
    }

    #[test]
    fn a_ball_out_of_reach_of_the_feet_is_kicked_by_no_kick() {
        assert_eq!(made(Vec2::new(0.4, 0.0), &[], &[]), None);
    }

    #[test]
    fn with_an_opponent_before_the_ball_it_leaves_to_the_side_towards_a_team_mate() {
        // It reaches the rectangles of the left foot's straight kick and of the right foot's side kick, to the left.
        let ball = Vec2::new(0.16, 0.08);
        let mates = [(3, Vec2::new(0.6, 1.2))];
        let (kick, _) = made(ball, &[], &[]).unwrap();
        assert_eq!(kick.kick_type, KickType::LeftStraight);
        let opponent = RobotBelief { id: None, position_m: Vec2::new(0.45, 0.2), covariance: [0.0; 3], age_s: 0.0 };
        let (kick, option) = made(ball, &[opponent], &mates).unwrap();
        assert_eq!(kick.kick_type, KickType::RightSide);
        assert!(option.aim.direction.y > 0.8 && option.receiver == Some(3), "{option:?}");
    }
}
