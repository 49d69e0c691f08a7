//! The value of a kick, from the places of the robots and from the reach, the spread and the speed of the player's own robot, so that
//! it holds for any robot.
//!
//! Values are in goals: 1 is a certain goal for the own team, -1 one against it.

use bevy::math::ops;
use bevy::prelude::*;

use super::kick_plan::AIMED_SHARE;
use super::player::Player;
use super::talking::pause_between_messages_s;
use naoisis_sensing::belief::RobotBelief;

/// Standard deviation of the aim, in addition to that of the kick itself, radians.
const AIMING_SD: f32 = 0.05;
/// The factor on the probability of a goal for each further kick over the whole reach that is needed.
const LEFT_AFTER_A_KICK: f32 = 0.4;
/// The value of a ball from which the team could score, as a share of a goal: opponents come back meanwhile.
const STANDING: f32 = 0.35;
/// The weight of which team has the ball next, from 0 to 1, compared with where the ball lies: possession changes often. Measured against
/// `roles`: with a greater weight a team keeps more balls, and above this value it wins fewer matches.
const POSSESSION: f32 = 0.57;
/// The same for slow robots with kicks that can be aimed, which need not walk around the ball first.
const POSSESSION_OF_AIMED: f32 = 0.45;
/// The same for fast robots with kicks that can be aimed: opponents are soon at any ball.
const POSSESSION_OF_FAST: f32 = 0.18;
/// The same for slow robots with unlimited messages, on a pitch that is large for their kicks.
const POSSESSION_OF_SLOW: f32 = 0.41;
/// Added in a small team of slow robots, in which no player is left to win back a lost ball.
const POSSESSION_OF_FEW: f32 = 0.1;
/// The greatest size of a small team, keeper included.
const FEW: u8 = 4;
/// A pitch is small if kicks reach over more than this share of it.
const SMALL_PITCH_SHARE: f32 = 0.75;
/// The robot that is sooner at the ball by this, and the time for [`RACE_M`], gets it in nearly three of four cases, s.
const RACE_S: f32 = 0.5;
/// The distance that a robot walks at the ball before it controls it, m: slow robots need longer for it.
const RACE_M: f32 = 0.12;
/// A robot is slow if it takes longer than this to walk as far as it kicks, s.
const SLOW_S: f32 = 16.0;
/// Messages count as unlimited if a player can send one this often, s.
const TALKS_FREELY_S: f32 = 1.0;
/// The reaction time of an opponent to a rolling ball, s.
const REACTION_S: f32 = 0.7;
/// Standard deviation of the believed place of an opponent, m.
const PLACE_SD_M: f32 = 0.04;
/// A robot has reached a place within this distance, m.
const AT_PLACE_M: f32 = 0.2;
/// Opponents come nearer to the ball by this share of the distance that they could walk while the foot swings.
const COMING_SHARE: f32 = 0.8;
/// The probability that the team that shot gets the ball after a miss.
const OURS_AFTER_A_MISS: f32 = 0.2;
/// The value of a second, in goals: a team that takes longer for each kick makes fewer of them.
const GOALS_PER_S: f32 = 0.005;

/// The other players that a kick depends on.
#[derive(Clone, Copy, Debug)]
pub struct Company<'a> {
    /// The known field players of the own team: jersey numbers and places, m, team frame.
    pub mates: &'a [(u8, Vec2)],
    /// The known opponents.
    pub opponents: &'a [RobotBelief],
}

impl Company<'_> {
    /// Returns the time that the nearest opponent takes to walk to `place`, s, at the player's own speed.
    pub fn opponents_walk_s(&self, player: &Player, place: Vec2) -> f32 {
        walking_s(player, self.opponents.iter().map(|other| other.position_m), place)
    }
}

/// Returns the greatest reach of the player's kicks, m.
pub fn reach_m(player: &Player) -> f32 {
    player.kicks.types().map(|kick| player.kicks.max_distance_m(kick)).fold(0.1, f32::max)
}

/// The time until the foot meets the ball, s, of the kick with the greatest reach.
pub(super) fn wind_up_s(player: &Player) -> f32 {
    player.kicks.strongest().map_or(player.kicks.wind_up_s, |kick| player.kicks.wind_up_of_s(kick))
}

/// Standard deviation of the direction of the kick with the greatest reach, radians.
fn direction_sd(player: &Player) -> f32 {
    player.kicks.strongest().map_or(player.kicks.direction_sd, |kick| player.kicks.direction_sd_of(kick))
}

/// The greatest angle from straight ahead for which a kick is prepared, radians.
pub(super) fn aims_within(player: &Player) -> f32 {
    let kicks = player.kicks.types().filter_map(|kick| player.kicks.geometry(kick));
    AIMED_SHARE * kicks.map(|kick| kick.aims_within()).fold(0.0, f32::max)
}

/// Returns the probability that a team with the ball at `place` scores with no opponent in the way: within reach it follows from the angle
/// of the goal and the spread of a kick, from further away it is less.
pub fn threat(player: &Player, place: Vec2) -> f32 {
    let way = player.opponent_goal() - place;
    let distance = way.length().max(0.3);
    let reach = reach_m(player);
    let beyond = (distance - reach).max(0.0) / reach;
    let opening = 0.5 * player.pitch.goal.width_m * (way.x / distance).max(0.1) / distance.min(reach);
    let spread = direction_sd(player) + AIMING_SD;
    let hits = opening * opening / (opening * opening + spread * spread);
    hits * ops::powf(LEFT_AFTER_A_KICK, beyond)
}

/// Whether the player can shoot from nearly everywhere.
fn is_pitch_small(player: &Player) -> bool {
    reach_m(player) > SMALL_PITCH_SHARE * player.pitch.length_m
}

/// Whether the player is slow for the reach of its kicks.
pub(super) fn is_slow(player: &Player) -> bool {
    reach_m(player) > SLOW_S * player.motion.max_linear_mps
}

/// The weight of which team has the ball next, from 0 to 1.
fn possession(player: &Player) -> f32 {
    let talks_freely = pause_between_messages_s(player) < TALKS_FREELY_S;
    let of_many = if aims_within(player) > 0.0 {
        if is_slow(player) { POSSESSION_OF_AIMED } else { POSSESSION_OF_FAST }
    } else if is_slow(player) && talks_freely && !is_pitch_small(player) {
        POSSESSION_OF_SLOW
    } else {
        POSSESSION
    };
    if player.rules.team_size <= FEW && is_slow(player) { of_many + POSSESSION_OF_FEW } else { of_many }
}

/// The value of a ball at `place` that the own team gets first with the probability `ours`: the probability that it scores less that of
/// the opponents, for whom the place is mirrored.
pub(super) fn standing(player: &Player, place: Vec2, ours: f32) -> f32 {
    let ours = 0.5 + possession(player) * (ours - 0.5);
    STANDING * (ours * threat(player, place) - (1.0 - ours) * threat(player, -place))
}

/// The probability that a ball kicked in `direction` goes between the posts.
fn hits(player: &Player, ball: Vec2, direction: Vec2) -> f32 {
    let spread = direction_sd(player) + AIMING_SD;
    let half_goal = 0.5 * player.pitch.goal.width_m - player.ball_radius_m;
    let inside = |side: f32| {
        let post = player.opponent_goal() + Vec2::Y * side * half_goal - ball;
        // The sine of the angle between the way and the post is near enough to the angle.
        let angle = side * direction.perp_dot(post) / post.length().max(0.1);
        logistic(1.7 * angle / spread)
    };
    (inside(1.0) + inside(-1.0) - 1.0).max(0.0)
}

/// The value of a shot in `direction`: a goal, a ball before the goal, or one at the feet of the opponent that stops it.
pub(super) fn shot_worth(player: &Player, company: Company, ball: Vec2, direction: Vec2) -> f32 {
    /// A ball that misses stops this far before the goal line, m.
    const BEFORE_GOAL: Vec2 = Vec2::X;
    let distance = (player.opponent_goal().x - ball.x) / direction.x.max(0.1);
    let end = ball + direction * distance;
    let course = course(player, company, ball, end, 1.0);
    let scores = hits(player, ball, direction) * course.arrives;
    scores
        + (course.arrives - scores) * standing(player, end - BEFORE_GOAL, OURS_AFTER_A_MISS)
        + (1.0 - course.arrives) * standing(player, course.stopped_at, 0.0)
}

/// The value of the time until a kick, in goals. Robots that walk without steps are soon at any place, and those without kicks can only
/// dribble.
pub(super) fn time_worth(player: &Player, ready_s: f32) -> f32 {
    let counts = player.walks_in_steps() && player.kicks.types().next().is_some();
    if counts { GOALS_PER_S * ready_s } else { 0.0 }
}

/// Returns the value of a pass from `ball` to a player that waits at `place`.
pub fn pass_worth(player: &Player, company: Company, ball: Vec2, place: Vec2) -> f32 {
    let share = (ball.distance(place) / reach_m(player)).min(1.0);
    let theirs_s = company.opponents_walk_s(player, place);
    let arrives = course(player, company, ball, place, share).arrives;
    let race_s = race_s(player);
    arrives * logistic((theirs_s - race_s) / race_s) * threat(player, place)
}

/// The value of a kick to `place`, and the team-mate that gets the ball if the own team does; `None` for the player itself.
pub(super) fn kick_worth(player: &Player, company: Company, ball: Vec2, place: Vec2) -> (f32, Option<u8>) {
    let recovery_s = player.kicks.strongest().map_or(player.kicks.recovery_s, |kick| player.kicks.recovery_of_s(kick));
    let own_s = wind_up_s(player) + recovery_s + walking_s(player, [player.position()], place);
    worth_at(player, company, ball, place, own_s)
}

/// Returns the value of a touch that pushes the ball from one place to another, where the player follows it within `follows_s` seconds.
pub(super) fn dribble_worth(player: &Player, company: Company, [ball, place]: [Vec2; 2], follows_s: f32) -> f32 {
    worth_at(player, company, ball, place, follows_s).0
}

/// The value of a ball that is played to `place`, where the player itself arrives after `own_s` seconds, and the team-mate that gets it if
/// the own team does; `None` for the player itself.
fn worth_at(player: &Player, company: Company, ball: Vec2, place: Vec2, own_s: f32) -> (f32, Option<u8>) {
    let (ours_s, receiver) = company
        .mates
        .iter()
        .map(|(number, mate)| (walking_s(player, [*mate], place), Some(*number)))
        .fold((own_s, None), |best, next| if next.0 < best.0 { next } else { best });
    let theirs_s = company.opponents_walk_s(player, place);
    let ours = is_first(player, ours_s, theirs_s) * stays_inside(player, ball, place);
    let share = (ball.distance(place) / reach_m(player)).min(1.0);
    let course = course(player, company, ball, place, share);
    let worth = course.arrives * standing(player, place, ours)
        + (1.0 - course.arrives) * standing(player, course.stopped_at, 0.0);
    (worth, receiver)
}

/// The probability that a ball kicked to `place` stays on the pitch.
fn stays_inside(player: &Player, ball: Vec2, place: Vec2) -> f32 {
    let room = Vec2::new(player.pitch.half_length(), player.pitch.half_width()) - place.abs();
    let spread = (direction_sd(player) + AIMING_SD) * ball.distance(place);
    logistic(1.7 * room.min_element() / spread.max(1e-3))
}

/// The expected course of a ball among opponents.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Course {
    /// The probability that no opponent stops it.
    arrives: f32,
    /// The mean place where it is stopped, if it is, m, team frame.
    stopped_at: Vec2,
}

/// The course of a ball that is kicked to `place`. `share`: the distance that it would roll, as a share of the reach.
fn course(player: &Player, company: Company, ball: Vec2, place: Vec2, share: f32) -> Course {
    let way = place - ball;
    let distance = way.length().max(0.05);
    let direction = way / distance;
    let launch_mps = player.rolling.speed_for_distance(share * reach_m(player)).max(0.1);
    let half_width = player.own_body.base.half_width_m + player.ball_radius_m;
    let direction_sd = direction_sd(player);
    let comes_m = COMING_SHARE * wind_up_s(player) * player.motion.max_linear_mps;
    // If no opponent can stop it, there is no such place: use the middle.
    let (mut arrives, mut stops, mut stopped_m) = (1.0, 1e-3, 0.5e-3 * distance);
    for other in company.opponents {
        let offset = come_nearer(other.position_m - ball, comes_m);
        let along = direction.dot(offset);
        if along < 0.0 || along > distance {
            continue;
        }
        // The ball slows down, so its mean speed is lower than the initial one.
        let steps_aside = (along / (0.75 * launch_mps) - REACTION_S).max(0.0) * player.motion.max_linear_mps;
        let room = direction.perp_dot(offset).abs() - half_width - steps_aside.min(0.5 * along);
        let passes = logistic(2.0 * room / (direction_sd * along + PLACE_SD_M));
        arrives *= passes;
        stops += 1.0 - passes;
        stopped_m += (1.0 - passes) * along;
    }
    Course { arrives, stopped_at: ball + direction * (stopped_m / stops) }
}

/// The `offset` of a robot from the ball after it has come nearer by `by_m`, or as near as possible.
fn come_nearer(offset: Vec2, by_m: f32) -> Vec2 {
    let distance = offset.length().max(1e-3);
    offset * (1.0 - by_m.min((distance - AT_PLACE_M).max(0.0)) / distance)
}

/// Whether a kick in `direction` is futile: on a small pitch, if the opponents at the ball would probably stop it. On a larger pitch the
/// place of the ball matters more, and trying is better.
pub(super) fn is_futile(player: &Player, company: Company, ball: Vec2, direction: Vec2) -> bool {
    /// Opponents further away than this do not stop the ball at once, m.
    const AT_ONCE_M: f32 = 0.5;
    /// The least probability with which the ball must pass them.
    const LEAST: f32 = 0.6;
    is_pitch_small(player) && course(player, company, ball, ball + direction * AT_ONCE_M, 1.0).arrives < LEAST
}

/// Returns the time that the nearest of the places `from` is away from `place`, s, at the player's own speed.
pub fn walking_s(player: &Player, from: impl IntoIterator<Item = Vec2>, place: Vec2) -> f32 {
    let nearest = from.into_iter().map(|other| other.distance_squared(place)).fold(1e6, f32::min).sqrt();
    (nearest - AT_PLACE_M).max(0.0) / player.motion.max_linear_mps.max(1e-3)
}

/// The advantage in time with which a robot gets the ball in nearly three of four cases, s.
fn race_s(player: &Player) -> f32 {
    RACE_S + RACE_M / player.motion.max_linear_mps.max(1e-2)
}

/// The probability that a robot that takes `own_s` is sooner than one that takes `theirs_s`.
pub(super) fn is_first(player: &Player, own_s: f32, theirs_s: f32) -> f32 {
    logistic((theirs_s - own_s) / race_s(player))
}

/// The logistic function: 1/2 at zero.
fn logistic(evidence: f32) -> f32 {
    1.0 / (1.0 + ops::exp(-evidence.clamp(-20.0, 20.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::{Pose, unit};
    use naoisis_core::kick_geometry::{KickDirection, KickGeometry, KickType};
    use naoisis_core::robot::kick::KickModel;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s: 0.0 }
    }

    fn behind(ball: Vec2) -> PlayerFixture {
        PlayerFixture::new(Pose { position: ball - Vec2::new(0.2, 0.0), heading: 0.0 }, ball)
    }

    #[test]
    fn what_an_opponent_on_the_way_would_stop_is_worth_less_the_nearer_it_is_to_the_way() {
        let situation = behind(Vec2::ZERO);
        let worth = |y: f32| {
            let opponents = [opponent(0.8, y)];
            pass_worth(
                &situation.player(),
                Company { mates: &[], opponents: &opponents },
                Vec2::ZERO,
                Vec2::new(1.6, 0.0),
            )
        };
        assert!(worth(0.0) < worth(0.4) && worth(0.4) < worth(1.2));
    }

    #[test]
    fn a_goal_threatens_from_near_more_than_from_far_and_from_the_middle_more_than_from_beside() {
        let situation = behind(Vec2::ZERO);
        let threat = |x, y| threat(&situation.player(), Vec2::new(x, y));
        assert!(threat(2.0, 0.0) > threat(0.0, 0.0) && threat(0.0, 0.0) > threat(-2.5, 0.0));
        assert!(threat(2.5, 0.0) > threat(2.5, 1.8));
    }

    #[test]
    fn a_stopped_ball_lies_at_the_robot_that_stops_it() {
        let situation = behind(Vec2::ZERO);
        let course = |opponents: &[RobotBelief]| {
            let company = Company { mates: &[], opponents };
            course(&situation.player(), company, Vec2::ZERO, Vec2::new(2.0, 0.0), 0.5)
        };
        let stopped = course(&[opponent(0.6, 0.0)]);
        assert!(stopped.arrives < 0.2 && stopped.stopped_at.distance(Vec2::new(0.6, 0.0)) < 0.01, "{stopped:?}");
        // An opponent beside the way or behind the ball lets it pass.
        let passes = course(&[opponent(0.6, 1.0), opponent(-0.5, 0.0)]);
        assert!(passes.arrives > 0.99, "{passes:?}");
        // Two opponents that may stop the ball are equally likely to do so.
        let either = course(&[opponent(0.5, 0.0), opponent(1.0, 0.0)]);
        assert!((either.stopped_at.x - 0.75).abs() < 0.05, "{either:?}");
    }

    #[test]
    fn while_the_foot_swings_an_opponent_comes_into_the_way() {
        let mut situation = behind(Vec2::ZERO);
        let opponents = [opponent(0.25, 0.2)];
        let company = Company { mates: &[], opponents: &opponents };
        let way = Vec2::new(2.0, 0.0);
        let arrives =
            |situation: &PlayerFixture, way: Vec2| course(&situation.player(), company, Vec2::ZERO, way, 0.5).arrives;
        assert!(arrives(&situation, way) > 0.6);
        situation.kicks.wind_up_s = 1.5;
        // 0.8 * 1.5 s of its way nearer, but no nearer than 0.2 m: to (0.16, 0.12), and 0.15 m to either side are blocked.
        assert!(arrives(&situation, way) < 0.6);
        assert!(arrives(&situation, 2.0 * unit(-1.2)) > 0.99, "to the other side it is free");
    }

    #[test]
    fn a_kick_that_may_leave_the_pitch_is_worth_less() {
        let mut situation = behind(Vec2::ZERO);
        situation.kicks.direction_sd = 0.1;
        let inside = |place| stays_inside(&situation.player(), Vec2::ZERO, place);
        // Half-way to the line that is 2 m away: 1 m of room, (0.1 + 0.05) * 1 m of spread.
        assert!(inside(Vec2::new(0.0, 1.0)) > 0.99);
        // On the line it is as likely in as out.
        assert!((inside(Vec2::new(0.0, 2.0)) - 0.5).abs() < 1e-3);
    }

    #[test]
    fn on_a_small_pitch_players_do_not_kick_into_feet() {
        let mut situation = behind(Vec2::ZERO);
        let opponents = [opponent(0.25, 0.0)];
        let company = Company { mates: &[], opponents: &opponents };
        // A NAO of the paper reaches 4 of 6 m.
        assert!(!is_futile(&situation.player(), company, Vec2::ZERO, Vec2::X), "it is tried");
        situation.kicks.left_straight = KickModel::of(6.0);
        assert!(is_futile(&situation.player(), company, Vec2::ZERO, Vec2::X));
        assert!(!is_futile(&situation.player(), company, Vec2::ZERO, Vec2::Y), "nobody is there");
    }

    #[test]
    fn possession_counts_less_for_slow_robots_with_unlimited_messages_and_more_for_few_of_them() {
        let mut situation = behind(Vec2::ZERO);
        situation.rules.team_size = 5;
        // A NAO of the paper takes 20 s for the 4 m that it kicks.
        assert!(is_slow(&situation.player()));
        assert_eq!(possession(&situation.player()), POSSESSION_OF_SLOW);
        situation.rules.team_size = 3;
        assert_eq!(possession(&situation.player()), POSSESSION_OF_SLOW + POSSESSION_OF_FEW);
        situation.rules.team_size = 5;
        situation.status.messages_left = Some(300);
        assert_eq!(possession(&situation.player()), POSSESSION, "it is silent for seconds");
        situation.status.messages_left = None;
        situation.kicks.left_straight = KickModel::of(6.0);
        assert_eq!(possession(&situation.player()), POSSESSION, "the pitch is small");
        situation.kicks.left_straight = KickModel::of(4.0);
        situation.motion.max_linear_mps = 0.6;
        assert!(!is_slow(&situation.player()));
        assert_eq!(possession(&situation.player()), POSSESSION);
        let of_paper = KickGeometry::of_paper(KickType::LeftStraight).unwrap();
        let aimed = KickGeometry { direction: KickDirection::Chosen { most: 0.7 }, ..of_paper };
        situation.kicks.left_straight.region = Some(aimed);
        assert_eq!(possession(&situation.player()), POSSESSION_OF_FAST, "it is fast and aims");
        situation.motion.max_linear_mps = 0.2;
        assert_eq!(possession(&situation.player()), POSSESSION_OF_AIMED, "it is slow and aims");
    }

    #[test]
    fn a_lead_of_half_a_second_and_a_step_wins_the_ball_nearly_three_times_of_four() {
        let mut situation = behind(Vec2::ZERO);
        for speed_mps in [0.2, 1.0] {
            situation.motion.max_linear_mps = speed_mps;
            let lead_s = RACE_S + RACE_M / speed_mps;
            // 1 / (1 + 1 / e)
            assert!((is_first(&situation.player(), 2.0, 2.0 + lead_s) - 0.731).abs() < 1e-3);
            assert!((is_first(&situation.player(), 2.0, 2.0) - 0.5).abs() < 1e-6);
        }
    }
}
