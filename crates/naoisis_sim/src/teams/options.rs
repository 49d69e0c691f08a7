//! What a player could do with the ball, with values: shots, passes, kicks ahead, and dribbling.

use bevy::prelude::*;
use std::borrow::Cow;

use super::aiming::Aim;
use super::dribbling::dribbles;
use super::kick_plan::stand_for;
use super::player::Player;
use super::worth::{Company, aims_within, is_first, kick_worth, reach_m, shot_worth, standing, time_worth, wind_up_s};
use naoisis_core::behaviour::reasons::Choice;
use naoisis_core::geometry::{angle_of, unit, unrotate};

/// A shot must reach this many times the distance of the goal.
pub(super) const BEYOND: f32 = 1.15;
/// Angles of the kicks ahead that are considered, radians.
pub(super) const AHEAD_ANGLES: [f32; 7] = [0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2];
/// Distances of the kicks ahead that are considered, as shares of the greatest reach.
pub(super) const AHEAD_SHARES: [f32; 3] = [0.3, 0.55, 0.85];
/// The distance of a pass ahead of the receiver, as a share of the reach.
const LEAD_SHARE: f32 = 0.06;
/// The distance of passes from the lines, m.
const LINE_MARGIN_M: f32 = 0.4;
/// The advantage of the option of the cycle before, so that small differences do not change the choice.
const PREFERENCE: f32 = 0.04;
/// Options whose directions differ by less than this angle are the same: its cosine.
const SAME_DIRECTION: f32 = 0.97;

/// A kick that could be prepared, or a direction to dribble in.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct KickOption {
    /// The aim of the kick.
    pub aim: Aim,
    /// The place where the ball stops, m, team frame.
    pub place: Vec2,
    /// The jersey number of the team-mate that would get the ball; `None` for a shot, or a ball that the player follows itself.
    pub receiver: Option<u8>,
    /// The value, in goals.
    pub value: f32,
}

impl KickOption {
    /// Returns the option for display: its name, its value, and where the ball stops.
    pub fn choice(&self) -> Choice {
        let name = match (self.aim.is_shot, self.receiver) {
            (true, _) => Cow::Borrowed("shoot"),
            (false, None) if self.aim.dribbles => Cow::Borrowed("dribble"),
            (false, Some(to)) => Cow::Owned(format!("pass to {to}")),
            (false, None) => Cow::Borrowed("ahead"),
        };
        Choice::new(name, self.value, format!("to ({:.1}, {:.1}) m", self.place.x, self.place.y))
    }
}

/// Returns the options for a ball at `ball`: `shot` and other shots (none if it is `None`), passes to team-mates, kicks ahead, and dribbling. An
/// option in the direction of `previous` is worth a little more. `is_ours`: whether opponents must keep away until the ball is kicked.
pub fn options(
    player: &Player,
    company: Company,
    ball: Vec2,
    shot: Option<Aim>,
    previous: Option<Vec2>,
    is_ours: bool,
) -> Vec<KickOption> {
    let reach = reach_m(player);
    let theirs_s = company.opponents_walk_s(player, ball);
    let contested = standing(player, ball, 0.5);
    let aims_within = aims_within(player);
    let option = |aim: Aim, place: Vec2| {
        let (worth, receiver) = if aim.is_shot {
            (shot_worth(player, company, ball, aim.direction), None)
        } else {
            kick_worth(player, company, ball, place)
        };
        let is_previous = previous.is_some_and(|previous| previous.dot(aim.direction) > SAME_DIRECTION);
        // A shot must arrive with some speed left.
        let rolls_m = if aim.is_shot { BEYOND * aim.distance_m } else { aim.distance_m };
        let ready_s = preparation_s(player, ball, aim.direction, rolls_m, aims_within);
        let ready = if is_ours { 1.0 } else { is_first(player, ready_s, theirs_s) };
        let value = ready * worth + (1.0 - ready) * contested + if is_previous { PREFERENCE } else { 0.0 };
        let value = value - if is_ours { 0.0 } else { time_worth(player, ready_s) };
        KickOption { aim, place, receiver, value }
    };
    let towards_goal = (player.opponent_goal() - ball).normalize_or(Vec2::X);
    let leads = company.mates.iter().map(|(_, mate)| {
        let ahead = (player.opponent_goal() - *mate).normalize_or(Vec2::X);
        *mate + ahead * LEAD_SHARE * reach
    });
    let ahead = AHEAD_SHARES.into_iter().flat_map(|share| {
        AHEAD_ANGLES.into_iter().map(move |angle| ball + unit(angle).rotate(towards_goal) * share * reach)
    });
    let half = Vec2::new(player.pitch.half_length(), player.pitch.half_width()) - LINE_MARGIN_M;
    let passes = leads.chain(ahead).filter(|place| {
        let distance = place.distance(ball);
        place.abs().cmple(half).all() && distance > 0.15 * reach && distance < 0.95 * reach
    });
    let first = shot.map(|shot| option(shot, ball + shot.direction * shot.distance_m.min(reach)));
    let shots =
        shots(player, ball).filter(|_| shot.is_some()).map(|aim| option(aim, ball + aim.direction * aim.distance_m));
    let passes = passes.map(|place| option(Aim::at(ball, place), place));
    // A player that takes a free kick must not touch the ball twice.
    let dribbles = dribbles(player, company, ball).filter(|_| !is_ours);
    let dribbles = dribbles.map(|(aim, place, value)| KickOption { aim, place, receiver: None, value });
    first.into_iter().chain(shots).chain(passes).chain(dribbles).collect()
}

/// Returns the option with the greatest value; the first of equals.
pub fn best(options: &[KickOption]) -> Option<&KickOption> {
    let (first, others) = options.split_first()?;
    Some(others.iter().fold(first, |best, next| if next.value > best.value { next } else { best }))
}

/// The shots at places along the goal line that a kick reaches.
fn shots(player: &Player, ball: Vec2) -> impl Iterator<Item = Aim> {
    /// Places along the goal line, as shares of half the goal.
    const AIMS: [f32; 5] = [0.0, 0.3, -0.3, 0.6, -0.6];
    let half_goal = 0.5 * player.pitch.goal.width_m;
    let goal = player.opponent_goal() + Vec2::X * player.pitch.line_width_m;
    let reach = reach_m(player);
    AIMS.into_iter().filter_map(move |share| {
        let way = goal + Vec2::Y * share * half_goal - ball;
        let distance_m = way.length();
        let direction = way.try_normalize()?;
        let tolerance = (0.8 * (1.0 - share.abs()) * half_goal * direction.x / distance_m).clamp(0.03, 0.3);
        (direction.x > 0.1 && BEYOND * distance_m < reach).then_some(Aim {
            direction,
            distance_m,
            tolerance,
            is_shot: true,
            dribbles: false,
        })
    })
}

/// The time until the player's foot meets the ball, s, to send it in `direction`: the way to stand and face behind the ball, or beside it
/// if a side kick reaches `distance_m`. The facing may differ from `direction` by `aims_within`, radians.
fn preparation_s(player: &Player, ball: Vec2, direction: Vec2, distance_m: f32, aims_within: f32) -> f32 {
    /// The extra time of a side kick, s: the foot is put before the ball first.
    const SIDE_KICK_S: f32 = 0.3;
    let stands_s = |(place, facing): (Vec2, Vec2)| {
        let turn = angle_of(unrotate(player.forward, facing)).abs();
        place.distance(player.position()) / player.motion.max_linear_mps.max(1e-3)
            + 0.5 * turn / player.motion.max_angular.max(0.1)
    };
    let aimed = angle_of(unrotate(ball - player.position(), direction)).clamp(-aims_within, aims_within);
    let facing = unrotate(unit(aimed), direction);
    let ahead_s = stands_s((ball - facing * player.ball_clearance_m(), facing));
    let side_kicks = player.kicks.types().filter(|kick| kick.is_side_kick());
    let beside_s = side_kicks.filter(|kick| distance_m <= player.kicks.max_distance_m(*kick)).filter_map(|kick| {
        Some(SIDE_KICK_S + stands_s(stand_for(&player.kicks.geometry(kick)?, ball, direction, player.position())))
    });
    beside_s.fold(ahead_s, f32::min) + wind_up_s(player)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::kick::KickModel;
    use naoisis_sensing::belief::RobotBelief;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s: 0.0 }
    }

    /// Returns the best kick of a player behind the ball.
    fn chosen(situation: &PlayerFixture, mates: &[(u8, Vec2)], opponents: &[RobotBelief]) -> KickOption {
        let player = situation.player();
        let ball = player.ball().unwrap().position_m;
        let shot = Aim::at(ball, ball + Vec2::X);
        let options = options(&player, Company { mates, opponents }, ball, Some(shot), None, false);
        *best(&options).unwrap()
    }

    fn behind(ball: Vec2) -> PlayerFixture {
        PlayerFixture::new(Pose { position: ball - Vec2::new(0.2, 0.0), heading: 0.0 }, ball)
    }

    #[test]
    fn at_an_open_goal_a_player_shoots_even_with_a_free_team_mate() {
        let option = chosen(&behind(Vec2::new(1.5, 0.0)), &[(3, Vec2::new(2.0, 1.0))], &[]);
        assert!(option.aim.is_shot && option.value > 0.8, "{option:?}");
    }

    #[test]
    fn from_as_far_as_the_robot_kicks_it_shoots_and_from_further_away_the_ball_goes_ahead() {
        // The goal is 4 m away: a NAO's kick of 4 m gets there without any speed left, a kick of 6 m with some.
        let mut situation = behind(Vec2::new(-1.0, 0.0));
        let option = chosen(&situation, &[], &[]);
        assert!(!option.aim.is_shot && option.place.x > 0.5, "{option:?}");
        situation.kicks.left_straight = KickModel::of(6.0);
        assert!(chosen(&situation, &[], &[]).aim.is_shot);
    }

    #[test]
    fn a_shot_into_a_wall_is_worth_little_and_a_ball_is_for_the_first_to_get_it() {
        let situation = behind(Vec2::new(0.8, 0.0));
        let wall: Vec<RobotBelief> = (-4..=4).map(|step| opponent(1.4, 0.15 * step as f32)).collect();
        let mates = [(3, Vec2::new(1.0, 1.6))];
        let (walled, free) = (chosen(&situation, &mates, &wall), chosen(&situation, &mates, &[]));
        assert!(walled.value < 0.3 && free.value > 0.7, "{walled:?} {free:?}");
        let player = situation.player();
        let company = Company { mates: &mates, opponents: &wall };
        let options = options(&player, company, Vec2::new(0.8, 0.0), Some(walled.aim), None, false);
        let pass = options.iter().find(|option| option.receiver == Some(3)).unwrap();
        assert_eq!(pass.choice().name, "pass to 3");
        assert!(pass.place.distance(mates[0].1) < pass.place.distance(player.position()), "{pass:?}");
    }

    #[test]
    fn a_ball_that_need_not_go_far_is_soon_sent_aside() {
        // The ball is where the right foot's side kick reaches it, and its straight kick does not.
        let situation = PlayerFixture::new(Pose::default(), Vec2::new(0.17, 0.07));
        let aside_s =
            |distance_m| preparation_s(&situation.player(), Vec2::new(0.17, 0.07), unit(1.0), distance_m, 0.0);
        // The side kick of the paper's NAO reaches 2 m: for more it walks around the ball.
        assert!(aside_s(1.0) + 0.3 < aside_s(3.0), "{} {}", aside_s(1.0), aside_s(3.0));
    }

    #[test]
    fn a_kick_that_can_be_aimed_is_soon_prepared() {
        let situation = behind(Vec2::ZERO);
        let time_s = |angle: f32, aims_within: f32| {
            preparation_s(&situation.player(), Vec2::ZERO, unit(angle), 3.0, aims_within)
        };
        // From straight behind the ball, any direction within the kick's angle takes as long as straight ahead.
        assert!((time_s(0.5, 0.6) - time_s(0.0, 0.0)).abs() < 1e-5);
        assert!(time_s(0.5, 0.0) > time_s(0.0, 0.0) + 0.5);
        assert!((time_s(0.8, 0.5) - time_s(0.3, 0.0)).abs() < 1e-5, "what the kick cannot do is left to walk");
    }
}
