//! Penalty kicks and shots of a shoot-out: where players wait, and where they must not go until the ball is played.

use bevy::prelude::*;

use super::player::{Decision, Player};
use naoisis_core::game::{SetPlayKind, ShootOutProcedure};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::referee::formation;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::team::Team;

/// The distance behind the ball at which the kicker waits, m.
const BEHIND_BALL_M: f32 = 0.45;
/// Players whose distances from the mark differ by less than this are about as near, m.
const ABOUT_AS_NEAR_M: f32 = 0.8;
/// A ball believed farther than this from its mark counts as played, m.
const PLAYED_M: f32 = 0.4;
/// The distance that players keep from where they must not be, such as the penalty area, m.
const MARGIN_M: f32 = 0.3;

/// The team whose penalty kick is being prepared or under way; `Some(None)` if the player does not know the team.
fn penalty_kick(player: &Player) -> Option<Option<Team>> {
    player.status.set_play.filter(|set_play| set_play.kind == SetPlayKind::PenaltyKick).map(|set_play| set_play.team)
}

/// The penalty mark of a penalty kick for the own team, or against it, m, team frame.
fn mark(player: &Player, is_ours: bool) -> Vec2 {
    let x = player.pitch.half_length() - player.pitch.penalty_mark_distance_m;
    Vec2::new(if is_ours { x } else { -x }, 0.0)
}

/// The distance of a place from the goal line of a penalty kick for the own team, or against it, m.
fn from_line_m(player: &Player, place: Vec2, is_ours: bool) -> f32 {
    player.pitch.half_length() - if is_ours { place.x } else { -place.x }
}

/// Whether `place` is where only the goalkeeper and the kicker may be, or within the margin of it: in the penalty area, and if the rules say
/// so, ahead of the mark or within the distance of a free kick from it.
fn is_in_the_way(player: &Player, place: Vec2, is_ours: bool) -> bool {
    let area = player.pitch.penalty_area;
    let from_line_m = from_line_m(player, place, is_ours);
    let in_area = from_line_m < area.depth_m + MARGIN_M && place.y.abs() < area.width_m / 2.0 + MARGIN_M;
    let radius_m = player.rules.free_kick_radius_m(player.pitch);
    let near_mark = from_line_m < player.pitch.penalty_mark_distance_m + MARGIN_M
        || place.distance(mark(player, is_ours)) < radius_m + MARGIN_M;
    in_area || (player.rules.penalty_kick_behind_mark && near_mark)
}

/// Returns the nearest place to `place` on a line to the other end that is out of the way of a penalty kick.
fn out_of_the_way(player: &Player, place: Vec2, is_ours: bool) -> Vec2 {
    if !is_in_the_way(player, place, is_ours) {
        return place;
    }
    let pitch = player.pitch;
    let beyond_m = pitch.penalty_mark_distance_m + player.rules.free_kick_radius_m(pitch);
    let from_line_m = pitch.penalty_area.depth_m.max(beyond_m) + MARGIN_M;
    let x = pitch.half_length() - from_line_m;
    Vec2::new(if is_ours { x } else { -x }, place.y)
}

/// Whether the player takes its team's penalty kick: among the field players that it knows of, it is the nearest to the mark. Of
/// players that are about as near it is the one with the lowest number, so that errors of their places do not make two kickers; a player
/// of unknown number must be clearly nearer.
fn is_kicker(player: &Player) -> bool {
    let mark = mark(player, true);
    let own = player.position().distance(mark);
    let mates = player.belief.team_mates.iter().map(|mate| (mate.id, mate.position_m.distance(mark)));
    let is_keeper = player.is_goalkeeper(player.id) && player.rules.team_size > 1;
    !is_keeper
        && mates.filter(|(mate, _)| !mate.is_some_and(|mate| player.is_goalkeeper(mate))).all(|(mate, distance)| {
            let about_as_near = (own - distance).abs() < ABOUT_AS_NEAR_M;
            if about_as_near { mate.is_none_or(|mate| player.id.number < mate.number) } else { own < distance }
        })
}

/// Returns the player's place for a penalty kick, team frame; `None` without a penalty kick.
pub fn place(player: &Player) -> Option<Pose> {
    let team = penalty_kick(player)?;
    let is_ours = team == Some(player.id.team);
    Some(if is_ours && is_kicker(player) {
        Pose { position: mark(player, true) - Vec2::new(BEHIND_BALL_M, 0.0), heading: 0.0 }
    } else if player.is_goalkeeper(player.id) {
        Pose { position: player.own_goal(), heading: 0.0 }
    } else {
        let place =
            formation(player.pitch, player.rules.team_size, player.role_number(player.id), End::NegativeX, false);
        Pose { position: out_of_the_way(player, place.position, is_ours), ..place }
    })
}

/// Limits a decision to what the rules of a penalty kick, or of a shoot-out, allow.
pub fn apply(player: &Player, decision: Decision) -> Decision {
    let opponents = player.id.team.opponent();
    let in_shoot_out =
        player.rules.shoot_out_procedure == ShootOutProcedure::Spl2025 && player.status.shoot_out == Some(opponents);
    let kick = penalty_kick(player);
    let is_ours = kick.flatten() == Some(player.id.team);
    let lies = player.ball().is_none_or(|ball| ball.position_m.distance(mark(player, is_ours)) < PLAYED_M);
    if !lies || (kick.is_none() && !in_shoot_out) {
        return decision;
    }
    if player.is_goalkeeper(player.id) && !is_ours || in_shoot_out {
        return Decision { walk: WalkCommand::default(), kick: None, posture: None, ..decision };
    }
    // A player that is in the way may walk out of it.
    let enters = |step: &WalkCommand| {
        let (now, then) = (player.position(), player.position() + player.forward.rotate(step.translation()));
        let leaves = from_line_m(player, then, is_ours) > from_line_m(player, now, is_ours);
        is_in_the_way(player, then, is_ours) && !(is_in_the_way(player, now, is_ours) && leaves)
    };
    if !(is_ours && is_kicker(player)) && enters(&decision.walk) {
        return Decision { walk: WalkCommand { dtheta: decision.walk.dtheta, ..default() }, kick: None, ..decision };
    }
    decision
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::game::Rules;
    use naoisis_core::referee::SetPlayStatus;
    use naoisis_core::team::RobotId;
    use naoisis_sensing::belief::RobotBelief;

    fn at_penalty_kick(team: Option<Team>, pose: Pose, ball: Vec2) -> PlayerFixture {
        let mut situation = PlayerFixture::new(pose, ball);
        situation.status.set_play = Some(SetPlayStatus { kind: SetPlayKind::PenaltyKick, team });
        situation
    }

    fn walk(situation: &PlayerFixture) -> WalkCommand {
        apply(&situation.player(), Decision { walk: WalkCommand::new(0.005, 0.0, 0.0), ..default() }).walk
    }

    #[test]
    fn the_nearest_field_player_takes_it_and_the_others_wait_in_their_formation() {
        let mut situation = at_penalty_kick(Some(Team::Blue), Pose::new(0.0, 0.0, 0.0), Vec2::new(1.2, 0.0));
        // The mark is at x = 3 - 1.8 = 1.2 m.
        assert_eq!(place(&situation.player()).unwrap().position, Vec2::new(1.2 - BEHIND_BALL_M, 0.0));
        let mate = |x| RobotBelief {
            id: Some(RobotId::new(Team::Blue, 3)),
            position_m: Vec2::new(x, 0.0),
            covariance: [0.0; 3],
            age_s: 0.0,
        };
        situation.belief.team_mates = vec![mate(-1.0)];
        assert!(place(&situation.player()).unwrap().position.x > 0.0);
        situation.belief.team_mates = vec![mate(1.0)];
        assert!(place(&situation.player()).unwrap().position.x < 0.0);
        // About as near as number 3: the lower number takes it.
        situation.belief.team_mates = vec![mate(0.3)];
        assert!(place(&situation.player()).unwrap().position.x > 0.0);
        // Of a mate whose number is unknown only its place counts.
        situation.belief.team_mates[0].id = None;
        assert!(place(&situation.player()).unwrap().position.x > 0.0);
        situation.belief.team_mates[0].position_m.x = 1.0;
        assert!(place(&situation.player()).unwrap().position.x < 0.0);
        situation.id.number = 1;
        assert_eq!(place(&situation.player()).unwrap().position, Vec2::new(-3.0, 0.0));
    }

    #[test]
    fn until_the_ball_is_played_the_keeper_stands_and_the_others_stay_out_of_the_area() {
        let keeper = |ball| {
            let mut situation = at_penalty_kick(Some(Team::Pink), Pose::new(-3.0, 0.0, 0.0), ball);
            situation.id.number = 1;
            situation
        };
        assert!(walk(&keeper(Vec2::new(-1.2, 0.1))).is_null());
        assert!(!walk(&keeper(Vec2::new(-2.0, 0.1))).is_null());
        // The area begins at x = -2.4.
        let defender =
            |x| at_penalty_kick(Some(Team::Pink), Pose::new(x, 1.0, core::f32::consts::PI), Vec2::new(-1.2, 0.0));
        assert!(walk(&defender(-2.11)).is_null());
        assert!(!walk(&defender(-2.0)).is_null());
    }

    #[test]
    fn where_the_rules_say_so_they_wait_behind_the_mark_at_a_distance() {
        let mut situation = at_penalty_kick(Some(Team::Pink), Pose::new(-2.0, 1.5, 0.0), Vec2::new(-1.2, 0.0));
        let formation = place(&situation.player()).unwrap().position;
        situation.rules.penalty_kick_behind_mark = true;
        let mark = Vec2::new(-1.2, 0.0);
        for number in 2..=5 {
            situation.id.number = number;
            let place = place(&situation.player()).unwrap().position;
            assert!(place.x > mark.x && place.distance(mark) > 0.75, "{number} at {place}");
        }
        assert!(formation.x < mark.x, "without the rule the formation does: {formation}");
        // The player is ahead of the mark, and may walk out, but not along the mark's line.
        assert!(walk(&situation).dx > 0.0);
        situation.belief.pose = Pose::new(-2.0, 1.5, core::f32::consts::FRAC_PI_2);
        assert!(walk(&situation).is_null());
    }

    #[test]
    fn a_player_in_the_area_may_walk_out_of_it() {
        // It faces away from its own goal.
        let inside = at_penalty_kick(Some(Team::Pink), Pose::new(-2.7, 1.0, 0.0), Vec2::new(-1.2, 0.0));
        assert!(walk(&inside).dx > 0.0);
    }

    #[test]
    fn in_a_shoot_out_of_2025_the_keeper_waits_for_the_shot() {
        let mut situation = PlayerFixture::new(Pose::new(-3.0, 0.0, 0.0), Vec2::new(-1.2, 0.0));
        situation.status.shoot_out = Some(Team::Pink);
        assert!(!walk(&situation).is_null());
        situation.rules = Rules { shoot_out_procedure: ShootOutProcedure::Spl2025, ..Rules::default() };
        assert!(walk(&situation).is_null());
        situation.status.shoot_out = Some(Team::Blue);
        assert!(!walk(&situation).is_null());
    }
}
