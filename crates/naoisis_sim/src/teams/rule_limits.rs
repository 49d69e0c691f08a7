//! What the rules require of every player while the ball is in play, whatever its role: distances to the ball, areas to stay out of, and
//! getting up after a fall.

use bevy::prelude::*;

use super::player::{Decision, Player, PlayerMemory};
use super::walk_limits::{braked, kept_out, leads_into};
use super::{kick_off, penalty_kicks};
use naoisis_core::game::{DefenderLimit, SetPlayKind};
use naoisis_core::pitch::AreaDimensions;
use naoisis_core::referee::SetPlayStatus;
use naoisis_core::robot::posture::PostureRequest;
use naoisis_sensing::sensing::status::BodyStatus;

/// The margin to the distance that the rules require at the opponents' free kick, m: the believed places of the player and of the ball
/// are not exact.
const DISTANCE_MARGIN_M: f32 = 0.35;
/// The distance that a field player keeps from its own penalty area, m.
const AREA_MARGIN_M: f32 = 0.05;
/// A field player leaves when it is nearer than [`AREA_MARGIN_M`] by this, m: as much as a standing player sways.
const AREA_SWAY_M: f32 = 0.03;
/// The distance that a player keeps from the opponents' penalty area when it has to be clear, m: its body and the error of its place.
const CLEARED_MARGIN_M: f32 = 0.5;
/// The greatest age of the place of a team-mate that counts, s.
const FRESH_S: f32 = 3.0;
/// A team-mate this near to the own goal area may be about to enter it, m.
const ENTERING_M: f32 = 0.5;
/// Robots whose depths in the own goal area differ by less than this are about as deep, m: places are as old as messages.
const ABOUT_AS_DEEP_M: f32 = 0.3;

/// Limits a decision to what the rules allow.
pub fn apply(player: &Player, memory: &PlayerMemory, decision: Decision) -> Decision {
    let decision = kick_off::apply(player, memory, decision);
    let decision = stay_out_of_the_cleared_area(player, keep_off_the_free_kick(player, decision));
    let decision = penalty_kicks::apply(player, decision);
    stay_out_of_the_own_area(player, decision)
}

/// Gets up when the player has fallen.
pub fn posture(player: &Player) -> Option<PostureRequest> {
    (player.body == BodyStatus::Fallen && !player.status.stopped).then_some(PostureRequest::GetUp)
}

/// Returns whether only the keeper may go for a ball at `place`, m, team frame.
pub fn is_for_the_keeper_only(player: &Player, place: Vec2) -> bool {
    player.is_own_area_for_keeper_only()
        && !player.is_goalkeeper(player.id)
        && own_area_depth_m(player, player.pitch.penalty_area, place, 0.0) > 0.0
}

/// Keeps the required distance from the opponents' free kick: the player walks away if it is too near.
fn keep_off_the_free_kick(player: &Player, decision: Decision) -> Decision {
    let not_ours = set_play(player).filter(|set_play| set_play.team != Some(player.id.team));
    let Some(set_play) = not_ours else { return decision };
    let Some(ball) = ball_of_set_play(player, set_play) else { return decision };
    let (away, distance) =
        (player.position() - ball, player.rules.free_kick_radius_m(player.pitch) + DISTANCE_MARGIN_M);
    let decision = Decision { kick: None, ..decision };
    // While it is not known whose it is, it is enough not to come nearer.
    if set_play.team.is_some() && away.length_squared() < (distance - 0.1) * (distance - 0.1) {
        // Towards the own goal, past the ball if necessary: that way is free more often than at the side line.
        let home = player.own_goal() - ball;
        let outwards = (away.normalize_or(-Vec2::X) + 0.5 * home.normalize_or(-Vec2::X)).normalize_or(-Vec2::X);
        let place = ball + outwards * distance;
        let walk = player.walk_to(place, -outwards, &player.obstacles());
        return Decision { walk, target: Some(place), ..decision };
    }
    if leads_into(player, &decision.walk, ball, distance) {
        let facing = (ball - player.position()).normalize_or(Vec2::X);
        return Decision { walk: player.walk_to(player.position(), facing, &default()), ..decision };
    }
    Decision { walk: braked(player, decision.walk, ball, distance), ..decision }
}

/// Returns the free kick or kick-off under way. A goal kick or a corner kick is the one of the team at whose end the ball is, or at whose
/// opponents' end, before the referee shows whose it is.
fn set_play(player: &Player) -> Option<SetPlayStatus> {
    let set_play = player.status.set_play?;
    let (own, opponents) = (player.id.team, player.id.team.opponent());
    let by_its_place = player.ball().filter(|_| player.walks_in_steps()).and_then(|ball| match set_play.kind {
        SetPlayKind::GoalKick => Some(if ball.position_m.x < 0.0 { own } else { opponents }),
        SetPlayKind::CornerKick => Some(if ball.position_m.x < 0.0 { opponents } else { own }),
        _ => None,
    });
    Some(SetPlayStatus { team: set_play.team.or(by_its_place), ..set_play })
}

/// Returns the place of the ball in a free kick, m, team frame: where the referee puts it in the opponents' goal kicks and corner kicks, on
/// the side on which the ball was, or else where the player believes it.
fn ball_of_set_play(player: &Player, set_play: SetPlayStatus) -> Option<Vec2> {
    let ball = player.ball()?.position_m;
    let area = player.pitch.goal_area.unwrap_or(player.pitch.penalty_area);
    let corner = Vec2::new(player.pitch.half_length(), player.pitch.half_width());
    match set_play.kind {
        SetPlayKind::GoalKick if set_play.team.is_some() => {
            Some(Vec2::new(corner.x - area.depth_m, (area.width_m / 2.0).copysign(ball.y)))
        }
        SetPlayKind::CornerKick if set_play.team.is_some() => Some(Vec2::new(-corner.x, corner.y.copysign(ball.y))),
        _ => Some(ball),
    }
}

/// Keeps the player out of the opponents' penalty area at their goal kick, and at their free kick inside this area, where the rules say so.
fn stay_out_of_the_cleared_area(player: &Player, decision: Decision) -> Decision {
    let theirs = set_play(player).filter(|set_play| set_play.team == Some(player.id.team.opponent()));
    let Some(set_play) = theirs.filter(|_| player.rules.goal_kick_clears_area) else { return decision };
    let area = player.pitch.penalty_area;
    let edge = player.pitch.half_length() - area.depth_m;
    let depth_m = |place: Vec2, margin: f32| (place.x - edge + margin).min(area.width_m / 2.0 + margin - place.y.abs());
    let is_inside = |place: Vec2, margin: f32| depth_m(place, margin) > 0.0;
    let is_cleared = match set_play.kind {
        SetPlayKind::KickOff | SetPlayKind::PenaltyKick => false,
        SetPlayKind::GoalKick => true,
        _ => player.ball().is_some_and(|ball| is_inside(ball.position_m, 0.0)),
    };
    if !is_cleared {
        return decision;
    }
    let decision = Decision { kick: None, ..decision };
    if is_inside(player.position(), CLEARED_MARGIN_M - AREA_SWAY_M) {
        let out = Vec2::new(edge - CLEARED_MARGIN_M, player.position().y);
        // Backwards, with the ball in view, and around the ball: no nearer to it than the player is, as far as it has to stay away.
        let mut obstacles = player.obstacles();
        if let Some(ball) = ball_of_set_play(player, set_play) {
            let away_m = player.position().distance(ball).min(player.rules.free_kick_radius_m(player.pitch));
            obstacles.add(ball, away_m.max(player.ball_clearance_m()));
        }
        let walk = player.walk_to(out, Vec2::X, &obstacles);
        return Decision { walk, target: Some(out), ..decision };
    }
    Decision { walk: kept_out(player, decision.walk, |place| depth_m(place, CLEARED_MARGIN_M)), ..decision }
}

/// Keeps a field player out of the area at its own goal that the rules forbid it, and makes it leave.
fn stay_out_of_the_own_area(player: &Player, decision: Decision) -> Decision {
    let Some((area, margin_m)) = forbidden_area(player) else { return decision };
    let depth_m = |margin: f32| move |place: Vec2| own_area_depth_m(player, area, place, margin);
    if depth_m(margin_m - AREA_SWAY_M)(player.position()) > 0.0 {
        let x = -player.pitch.half_length() + area.depth_m + margin_m + 0.35;
        let out = Vec2::new(x, player.position().y);
        let walk = player.walk_to(out, player.forward, &player.obstacles());
        return Decision { walk, target: Some(out), ..decision };
    }
    Decision { walk: kept_out(player, decision.walk, depth_m(margin_m)), ..decision }
}

/// Returns the area at the own goal that the player may not enter at present, and the distance that it keeps from this area, m: the penalty
/// area where only the keeper may be in it, or the goal area with as many team-mates as the rules allow.
fn forbidden_area(player: &Player) -> Option<(AreaDimensions, f32)> {
    if !player.rules.illegal_defender || player.is_goalkeeper(player.id) {
        return None;
    }
    match player.rules.defender_limit {
        DefenderLimit::AtMost(most) => {
            let area = player.pitch.goal_area.unwrap_or(player.pitch.penalty_area);
            // A robot that touches the area is in it.
            let margin_m = AREA_MARGIN_M + player.own_body.base.reach();
            // The last robots to enter are penalised: those that are deeper are likely to have come, or to come, before. The keeper is there,
            // seen or not. Of two robots that are about as deep, the one with the lower number may enter.
            let depth_m = |place: Vec2| own_area_depth_m(player, area, place, margin_m + ENTERING_M);
            let own_m = depth_m(player.position());
            let before = player.belief.team_mates.iter().filter(|mate| {
                let is_keeper = mate.id.is_some_and(|id| player.is_goalkeeper(id));
                let is_lower = mate.id.is_some_and(|id| id.number < player.id.number);
                let least_m = own_m + if is_lower { -ABOUT_AS_DEEP_M } else { ABOUT_AS_DEEP_M };
                mate.age_s < FRESH_S && !is_keeper && depth_m(mate.position_m) > least_m.max(0.0)
            });
            (1 + before.count() >= usize::from(most)).then_some((area, margin_m))
        }
        _ => Some((player.pitch.penalty_area, AREA_MARGIN_M)),
    }
}

/// Returns how deep `place` (team frame) is in this area at the own goal with `margin` m around it, m. Negative: it is outside.
fn own_area_depth_m(player: &Player, area: AreaDimensions, place: Vec2, margin: f32) -> f32 {
    let edge = -player.pitch.half_length() + area.depth_m;
    (edge + margin - place.x).min(area.width_m / 2.0 + margin - place.y.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use crate::teams::walk_limits::after;
    use naoisis_core::game::Rules;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::motion::WalkCommand;
    use naoisis_core::team::Team;
    use naoisis_sensing::belief::Belief;

    fn walking(dx: f32, dy: f32) -> Decision {
        Decision { walk: WalkCommand { dx, dy, dtheta: 0.01 }, ..default() }
    }

    fn moved(situation: &PlayerFixture, decision: Decision) -> Vec2 {
        after(&situation.player(), &apply(&situation.player(), &PlayerMemory::default(), decision).walk)
    }

    #[test]
    fn players_keep_away_from_the_opponents_free_kick_and_leave_if_they_are_near() {
        let mut situation = PlayerFixture::new(Pose::new(-1.2, 0.0, 0.0), Vec2::ZERO);
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::KickIn, team: Some(Team::Pink) });
        // 0.75 m and the margin of 0.35 m: at 1.2 m a step may still lead nearer, at 1.1 m none may.
        assert!(moved(&situation, walking(0.006, 0.0)).x > -1.2);
        situation.belief.pose.position.x = -1.1;
        assert_eq!(moved(&situation, walking(0.006, 0.0)).x, -1.1);
        assert!(moved(&situation, walking(-0.006, 0.0)).x < -1.1);
        situation.belief.pose.position.x = -0.5;
        assert!(moved(&situation, walking(0.006, 0.0)).x < -0.5);
        // The own free kick is there to be taken.
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::KickIn, team: Some(Team::Blue) });
        assert!(moved(&situation, walking(0.006, 0.0)).x > -0.5);
    }

    #[test]
    fn players_leave_the_place_of_a_goal_kick_wherever_the_ball_has_rolled() {
        // The corner of the goal area is at (2.4, 1.1); the ball was last seen beyond the goal line.
        let mut situation = PlayerFixture::new(Pose::new(2.2, 1.0, 0.0), Vec2::new(3.4, 0.9));
        situation.pitch.goal_area = Some(AreaDimensions { depth_m: 0.6, width_m: 2.2 });
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::GoalKick, team: Some(Team::Pink) });
        let place = Vec2::new(2.4, 1.1);
        let from_m = situation.belief.pose.position.distance(place);
        assert!(moved(&situation, walking(0.0, 0.0)).distance(place) > from_m);
        // Robots know by the end of the pitch whose goal kick it is, before the referee shows it.
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::GoalKick, team: None });
        situation.motion.gait = Some(naoisis_core::robot::gait::Gait::default());
        assert!(moved(&situation, walking(0.0, 0.0)).distance(place) > from_m);
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::KickIn, team: None });
        assert_eq!(moved(&situation, walking(0.0, 0.0)).distance(place), from_m);
    }

    #[test]
    fn players_leave_the_opponents_area_at_their_goal_kick_where_the_rules_say_so() {
        // The area of the pitch of 2010 begins at x = 2.4; the ball is put 2 m away from the player.
        let mut situation = PlayerFixture::new(Pose::new(2.5, -0.9, 0.0), Vec2::new(2.4, 1.1));
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::GoalKick, team: Some(Team::Pink) });
        assert!(moved(&situation, walking(0.006, 0.0)).x > 2.5);
        situation.rules.goal_kick_clears_area = true;
        assert!(moved(&situation, walking(0.006, 0.0)).x < 2.5);
        situation.belief.pose.position.x = 1.89;
        assert!(moved(&situation, walking(0.006, 0.0)).x > 1.89);
        situation.belief.pose.position.x = 1.896;
        assert_eq!(moved(&situation, walking(0.006, 0.0)).x, 1.896);
        // A free kick before the area clears nothing.
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::PushingFreeKick, team: Some(Team::Pink) });
        situation.belief = Belief { ball: None, ..situation.belief };
        assert!(moved(&situation, walking(0.006, 0.0)).x > 1.896);
    }

    #[test]
    fn only_the_keeper_goes_into_the_own_penalty_area_where_the_rules_say_so() {
        let rules = Rules { illegal_defender: true, ..Rules::default() };
        // The area of the pitch of 2010 is 0.6 m deep: to x = -2.4.
        let mut situation = PlayerFixture::new(Pose::new(-2.347, 0.5, core::f32::consts::PI), Vec2::new(-2.7, 0.5));
        let forward = walking(0.006, 0.0);
        assert!(moved(&situation, forward).x < -2.35);
        situation.rules = rules;
        assert_eq!(moved(&situation, forward).x, -2.347);
        // It walks along the edge, and away from it.
        let aside = moved(&situation, walking(0.006, 0.004));
        assert!(aside.x == -2.347 && (aside.y - 0.496).abs() < 1e-5, "{aside}");
        assert!(moved(&situation, walking(-0.001, 0.0)).x > -2.347);
        situation.belief.pose.position.x = -2.6;
        assert!(moved(&situation, forward).x > -2.6);
        situation.id.number = 1;
        assert!(moved(&situation, forward).x < -2.6);
    }

    #[test]
    fn a_player_stays_out_of_the_own_goal_area_if_it_is_full() {
        use naoisis_sensing::belief::RobotBelief;

        // The goal area of the pitch reaches to x = -2.4.
        let mut situation = PlayerFixture::new(Pose::new(-2.0, 0.5, core::f32::consts::PI), Vec2::new(-2.7, 0.5));
        situation.rules =
            Rules { illegal_defender: true, defender_limit: DefenderLimit::AtMost(3), ..Rules::default() };
        situation.pitch.goal_area = Some(AreaDimensions { depth_m: 0.6, width_m: 2.2 });
        let mate = |number: u8, x: f32| RobotBelief {
            id: Some(naoisis_core::team::RobotId::new(Team::Blue, number)),
            position_m: Vec2::new(x, 0.2),
            covariance: [0.0; 3],
            age_s: 0.1,
        };
        let place = |situation: &mut PlayerFixture, x: f32, mates: &[(u8, f32)]| {
            situation.belief.pose.position.x = x;
            situation.belief.team_mates = mates.iter().map(|(number, x)| mate(*number, *x)).collect();
            moved(situation, walking(0.006, 0.0)).x - x
        };
        let edge = -2.4 + AREA_MARGIN_M + situation.own_body.base.reach() + 0.003;
        // The keeper and one more: the player may enter. With two more it stays outside, and leaves if it came later.
        assert!(place(&mut situation, edge, &[(1, -2.9), (4, -2.6)]) < 0.0);
        let full = [(1, -2.95), (4, -2.85), (5, -2.9)];
        assert_eq!(place(&mut situation, edge, &full), 0.0);
        assert!(place(&mut situation, -2.5, &full) > 0.0);
        // The keeper counts without being seen.
        assert_eq!(place(&mut situation, edge, &full[1..]), 0.0);
        // Of robots that are about as deep, the one with the highest number leaves.
        assert!(place(&mut situation, -2.8, &full) < 0.0);
        situation.id.number = 6;
        assert!(place(&mut situation, -2.8, &full) > 0.0);
        // Two that are about to enter count, too.
        let near = [(4, -2.1), (5, -2.0)];
        assert_eq!(place(&mut situation, edge, &near), 0.0);
    }

    #[test]
    fn a_fallen_player_gets_up() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::ZERO);
        assert_eq!(posture(&situation.player()), None);
        situation.body = BodyStatus::Fallen;
        assert_eq!(posture(&situation.player()), Some(PostureRequest::GetUp));
    }
}
