//! What can be done with the ball, and what each of it is worth: simple geometry of who is where, with the reach and the spread of
//! the robot's own kicks and its own speed, so that it holds for any robot.
//!
//! Worth is counted in goals: 1 is a sure goal for the own team, -1 one against it.

use bevy::math::ops;
use bevy::prelude::*;
use std::borrow::Cow;

use super::aiming::Aim;
use super::kicking::AIMED_SHARE;
use super::player::Player;
use crate::behaviour::reasons::Choice;
use crate::belief::RobotBelief;
use crate::geometry::{angle_of, unit, unrotate};

/// How exactly the ball is aimed beside the spread of the kick itself, radians.
const AIMING_SD: f32 = 0.05;
/// What is left of a chance for each further kick over the whole reach that it takes to get there.
const LEFT_AFTER_A_KICK: f32 = 0.4;
/// What a ball where one could score is worth, of the goal: opponents come back meanwhile.
const STANDING: f32 = 0.35;
/// How much it matters who has the ball next, of 1, beside where it lies: it changes sides often.
const POSSESSION: f32 = 0.3;
/// The difference in time to the ball of which the sooner one gets it nearly three times of four, s.
const RACE_S: f32 = 1.0;
/// How long an opponent takes to see where a ball rolls, s.
const REACTION_S: f32 = 0.7;
/// How exactly an opponent's place is known, m.
const PLACE_SD_M: f32 = 0.04;
/// A place that is reached is so far from a robot's own at most, m.
const AT_PLACE_M: f32 = 0.2;
/// Kicks ahead that are considered: their angles, radians, and their shares of the greatest reach.
pub(super) const AHEAD_ANGLES: [f32; 7] = [0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2];
pub(super) const AHEAD_SHARES: [f32; 3] = [0.3, 0.55, 0.85];
/// How far ahead of a team-mate a pass leads, as a share of the reach.
const LEAD_SHARE: f32 = 0.06;
/// A ball that is passed stays this far from the lines, m.
const LINE_MARGIN_M: f32 = 0.4;
/// What the option of the cycle before is better by, so that small differences do not change it.
const PREFERENCE: f32 = 0.04;
/// Options whose directions are nearer to each other than this are the same: the cosine.
const SAME_DIRECTION: f32 = 0.97;

/// Who plays with, and against, whoever has the ball.
#[derive(Clone, Copy, Debug)]
pub struct Company<'a> {
    /// The field players of the own team that are known: numbers and places, m, team frame.
    pub mates: &'a [(u8, Vec2)],
    /// The opponents that are known.
    pub opponents: &'a [RobotBelief],
}

/// Something that could be done with the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct KickOption {
    /// Where the ball should go.
    pub aim: Aim,
    /// Where it ends, m, team frame.
    pub place: Vec2,
    /// Who of the team-mates would get it; none for a shot, or a ball that the player runs after itself.
    pub receiver: Option<u8>,
    /// What it is worth, in goals.
    pub value: f32,
}

impl KickOption {
    /// For people: what it is, what it is worth, and where the ball ends.
    pub fn choice(&self) -> Choice {
        let name = match (self.aim.is_shot, self.receiver) {
            (true, _) => Cow::Borrowed("shoot"),
            (false, Some(to)) => Cow::Owned(format!("pass to {to}")),
            (false, None) => Cow::Borrowed("ahead"),
        };
        Choice::new(name, self.value, format!("to ({:.1}, {:.1}) m", self.place.x, self.place.y))
    }
}

/// The greatest reach of the player's kicks, m.
pub fn reach_m(player: &Player) -> f32 {
    player.kicks.types().map(|kick| player.kicks.max_distance_m(kick)).fold(0.1, f32::max)
}

/// How long the kick that reaches furthest takes until the foot meets the ball, s.
pub(super) fn wind_up_s(player: &Player) -> f32 {
    player.kicks.strongest().map_or(player.kicks.wind_up_s, |kick| player.kicks.wind_up_of_s(kick))
}

/// How exact the kick that reaches furthest is: standard deviation of its direction, radians.
fn direction_sd(player: &Player) -> f32 {
    player.kicks.strongest().map_or(player.kicks.direction_sd, |kick| player.kicks.direction_sd_of(kick))
}

/// What can be done with a ball at `ball`: `shot`, which is where a shot or else the way ahead leads, none where there may be none,
/// passes to team-mates, and kicks ahead. What goes in the direction of `previous` is worth a little more. `is_ours`: opponents must
/// keep off until the ball is kicked.
pub fn options(
    player: &Player,
    company: Company,
    ball: Vec2,
    shot: Option<Aim>,
    previous: Option<Vec2>,
    is_ours: bool,
) -> Vec<KickOption> {
    let reach = reach_m(player);
    let theirs_s = walking_s(player, company.opponents.iter().map(|other| other.position_m), ball);
    let contested = standing(player, ball, 0.5);
    let aims_within = aims_within(player);
    let option = |aim: Aim, place: Vec2| {
        let (worth, receiver) = if aim.is_shot {
            (shot_worth(player, company, ball, aim.direction), None)
        } else {
            kick_worth(player, company, ball, place)
        };
        let is_previous = previous.is_some_and(|previous| previous.dot(aim.direction) > SAME_DIRECTION);
        let ready_s = preparation_s(player, ball, aim.direction, aims_within);
        let ready = if is_ours { 1.0 } else { is_first(ready_s, theirs_s) };
        let value = ready * worth + (1.0 - ready) * contested + if is_previous { PREFERENCE } else { 0.0 };
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
    first.into_iter().chain(shots).chain(passes.map(|place| option(Aim::at(ball, place), place))).collect()
}

/// The best of them, the first of equals.
pub fn best(options: &[KickOption]) -> Option<&KickOption> {
    let (first, others) = options.split_first()?;
    Some(others.iter().fold(first, |best, next| if next.value > best.value { next } else { best }))
}

/// How likely a team with the ball at `place` scores, with nobody in its way: from within reach by how wide the goal looks beside
/// the spread of a kick, from further away less.
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

/// What a ball at `place` is worth that the own team gets first with this likelihood: how likely it is to score less how likely the
/// others are, who see the place mirrored.
pub(super) fn standing(player: &Player, place: Vec2, ours: f32) -> f32 {
    let ours = 0.5 + POSSESSION * (ours - 0.5);
    STANDING * (ours * threat(player, place) - (1.0 - ours) * threat(player, -place))
}

/// The shots that could be made: at places along the goal line, if a kick reaches them.
fn shots(player: &Player, ball: Vec2) -> impl Iterator<Item = Aim> {
    /// Places along the goal line, as shares of half the goal.
    const AIMS: [f32; 5] = [0.0, 0.3, -0.3, 0.6, -0.6];
    /// A kick must reach further than the goal by this factor.
    const BEYOND: f32 = 1.15;
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
        })
    })
}

/// How likely a ball that is kicked in this direction goes between the posts.
fn hits(player: &Player, ball: Vec2, direction: Vec2) -> f32 {
    let spread = direction_sd(player) + AIMING_SD;
    let half_goal = 0.5 * player.pitch.goal.width_m - player.ball_radius_m;
    let inside = |side: f32| {
        let post = player.opponent_goal() + Vec2::Y * side * half_goal - ball;
        // The sine of the angle between the way and the post is near enough to the angle.
        let angle = side * direction.perp_dot(post) / post.length().max(0.1);
        likely(1.7 * angle / spread)
    };
    (inside(1.0) + inside(-1.0) - 1.0).max(0.0)
}

/// What a shot in this direction is worth: a goal, or else a ball before the goal.
pub(super) fn shot_worth(player: &Player, company: Company, ball: Vec2, direction: Vec2) -> f32 {
    /// What is not a goal ends so far before the goal line, m.
    const BEFORE_GOAL: Vec2 = Vec2::X;
    let distance = (player.opponent_goal().x - ball.x) / direction.x.max(0.1);
    let end = ball + direction * distance;
    let scores = hits(player, ball, direction) * arrives(player, company, ball, end, 1.0);
    scores + (1.0 - scores) * standing(player, end - BEFORE_GOAL, 0.5)
}

/// What a pass from `ball` would be worth to a player that waits for it at `place`.
pub fn pass_worth(player: &Player, company: Company, ball: Vec2, place: Vec2) -> f32 {
    let share = (ball.distance(place) / reach_m(player)).min(1.0);
    let theirs_s = walking_s(player, company.opponents.iter().map(|other| other.position_m), place);
    arrives(player, company, ball, place, share) * likely((theirs_s - RACE_S) / RACE_S) * threat(player, place)
}

/// What it is worth to kick the ball to `place`, and who of the team-mates gets it if the team does.
pub(super) fn kick_worth(player: &Player, company: Company, ball: Vec2, place: Vec2) -> (f32, Option<u8>) {
    let reach = reach_m(player);
    let recovery_s = player.kicks.strongest().map_or(player.kicks.recovery_s, |kick| player.kicks.recovery_of_s(kick));
    let own_s = wind_up_s(player) + recovery_s + walking_s(player, [player.position()], place);
    let (ours_s, receiver) = company
        .mates
        .iter()
        .map(|(number, mate)| (walking_s(player, [*mate], place), Some(*number)))
        .fold((own_s, None), |best, next| if next.0 < best.0 { next } else { best });
    let theirs_s = walking_s(player, company.opponents.iter().map(|other| other.position_m), place);
    let ours = is_first(ours_s, theirs_s);
    let share = (ball.distance(place) / reach).min(1.0);
    let arrives = arrives(player, company, ball, place, share);
    let worth = arrives * standing(player, place, ours) + (1.0 - arrives) * standing(player, ball.midpoint(place), 0.0);
    (worth, receiver)
}

/// How likely a ball that is kicked to `place` is not stopped on the way. `share`: how far it would roll, of the reach.
fn arrives(player: &Player, company: Company, ball: Vec2, place: Vec2, share: f32) -> f32 {
    let way = place - ball;
    let distance = way.length().max(0.05);
    let direction = way / distance;
    let launch_mps = player.rolling.speed_for_distance(share * reach_m(player)).max(0.1);
    let half_width = player.own_body.base.half_width_m + player.ball_radius_m;
    let direction_sd = direction_sd(player);
    let passes = |other: &RobotBelief| {
        let offset = other.position_m - ball;
        let along = direction.dot(offset);
        if along < 0.0 || along > distance {
            return 1.0;
        }
        // It slows down: the mean of the way is slower than the start.
        let steps_aside = (along / (0.75 * launch_mps) - REACTION_S).max(0.0) * player.limits.max_linear_mps;
        let room = direction.perp_dot(offset).abs() - half_width - steps_aside.min(0.5 * along);
        likely(2.0 * room / (direction_sd * along + PLACE_SD_M))
    };
    company.opponents.iter().map(passes).product()
}

/// How far to either side of straight ahead the player's kicks can be aimed, radians.
pub(super) fn aims_within(player: &Player) -> f32 {
    let kicks = player.kicks.types().filter_map(|kick| player.kicks.geometry(kick));
    AIMED_SHARE * kicks.map(|kick| kick.aims_within()).fold(0.0, f32::max)
}

/// How long the player takes to stand behind the ball, and to face so that it can kick it this way, s: a kick that can be aimed by so
/// many radians needs not be faced.
fn preparation_s(player: &Player, ball: Vec2, direction: Vec2, aims_within: f32) -> f32 {
    let aimed = angle_of(unrotate(ball - player.position(), direction)).clamp(-aims_within, aims_within);
    let facing = unrotate(unit(aimed), direction);
    let behind = ball - facing * player.ball_clearance_m();
    let way = behind - player.position();
    let turn = angle_of(unrotate(player.forward, facing)).abs();
    way.length() / player.limits.max_linear_mps.max(1e-3)
        + 0.5 * turn / player.limits.max_angular.max(0.1)
        + wind_up_s(player)
}

/// How long the nearest of some takes to `place`, s, at the player's own speed.
pub fn walking_s(player: &Player, from: impl IntoIterator<Item = Vec2>, place: Vec2) -> f32 {
    let nearest = from.into_iter().map(|other| other.distance_squared(place)).fold(1e6, f32::min).sqrt();
    (nearest - AT_PLACE_M).max(0.0) / player.limits.max_linear_mps.max(1e-3)
}

/// How likely who takes so long is somewhere sooner than others, s.
pub(super) fn is_first(own_s: f32, theirs_s: f32) -> f32 {
    likely((theirs_s - own_s) / RACE_S)
}

/// A number from 0 to 1 for what speaks for and against: 1/2 for nought.
fn likely(evidence: f32) -> f32 {
    1.0 / (1.0 + ops::exp(-evidence.clamp(-20.0, 20.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::robot::kick::KickModel;
    use crate::teams::player::tests::PlayerFixture;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s: 0.0 }
    }

    /// The best that a player behind the ball can do with it.
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
    fn before_an_open_goal_one_shoots_whoever_else_is_there() {
        let option = chosen(&behind(Vec2::new(1.5, 0.0)), &[(3, Vec2::new(2.0, 1.0))], &[]);
        assert!(option.aim.is_shot && option.value > 0.8, "{option:?}");
    }

    #[test]
    fn from_as_far_as_the_robot_kicks_it_shoots_and_from_further_away_the_ball_goes_ahead() {
        // 4 m to the goal: a NAO's 4 m do not get there with any speed left, and 6 m do.
        let mut situation = behind(Vec2::new(-1.0, 0.0));
        let option = chosen(&situation, &[], &[]);
        assert!(!option.aim.is_shot && option.place.x > 0.5, "{option:?}");
        situation.kicks.left_straight = KickModel::of(6.0);
        assert!(chosen(&situation, &[], &[]).aim.is_shot);
    }

    #[test]
    fn a_shot_into_a_wall_is_worth_little_and_a_ball_is_for_who_gets_it_first() {
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
    fn a_kick_that_can_be_aimed_is_soon_prepared() {
        let situation = behind(Vec2::ZERO);
        let time_s =
            |angle: f32, aims_within: f32| preparation_s(&situation.player(), Vec2::ZERO, unit(angle), aims_within);
        // From straight behind the ball, whatever is within the kick's angle takes as long as straight ahead.
        assert!((time_s(0.5, 0.6) - time_s(0.0, 0.0)).abs() < 1e-5);
        assert!(time_s(0.5, 0.0) > time_s(0.0, 0.0) + 0.5);
        assert!((time_s(0.8, 0.5) - time_s(0.3, 0.0)).abs() < 1e-5, "what the kick cannot do is left to walk");
    }

    #[test]
    fn a_goal_threatens_from_near_more_than_from_far_and_from_the_middle_more_than_from_beside() {
        let situation = behind(Vec2::ZERO);
        let threat = |x, y| threat(&situation.player(), Vec2::new(x, y));
        assert!(threat(2.0, 0.0) > threat(0.0, 0.0) && threat(0.0, 0.0) > threat(-2.5, 0.0));
        assert!(threat(2.5, 0.0) > threat(2.5, 1.8));
    }
}
