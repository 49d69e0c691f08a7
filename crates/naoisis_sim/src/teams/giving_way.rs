//! Not walking into opponents: the referee penalises the robot that runs into another, not the one that stands.

use bevy::prelude::*;

use super::obstacles::OBSTACLE_MEMORY_S;
use super::player::Player;
use super::walking::walks_sideways;
use naoisis_core::geometry::unrotate;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_sensing::belief::RobotBelief;

/// A robot without a gait does not walk towards an opponent nearer than this, m: they touch at about 0.3 m.
const GIVE_WAY_M: f32 = 0.45;
/// A robot with a gait brakes so that it comes no nearer to an opponent than this, m.
const STOP_M: f32 = 0.4;
/// The share of the free distance to an opponent within which a robot with a gait can stop: the opponent may come nearer, too.
const OWN_SHARE: f32 = 0.6;
/// The greatest speed towards an opponent that is harmless, m/s: the referee overlooks less than 0.05.
pub(super) const HARMLESS_MPS: f32 = 0.03;
/// Two robots that face each other may fight for a ball within this distance of the line between them, m.
const FIGHT_M: f32 = 0.2;
/// The ball is between them up to this share of the way to the opponent: an opponent right at the ball does not face the player.
const BETWEEN: f32 = 0.75;

/// Removes from a step what would run into an opponent.
pub fn give_way(player: &Player, walk: WalkCommand, opponents: &[RobotBelief]) -> WalkCommand {
    let mut step = player.forward.rotate(walk.translation());
    let wider_m = 2.0 * player.wider_than_nao_m();
    let seen = opponents
        .iter()
        .filter(|other| other.age_s < OBSTACLE_MEMORY_S)
        .map(|other| other.position_m - player.position());
    for way in seen.chain(player.echoes().map(|(_, way)| way)) {
        let distance = way.length();
        let Some(line) = way.try_normalize() else { continue };
        let most_mps = match &player.motion.gait {
            Some(_) => {
                let free_m = OWN_SHARE * (distance - STOP_M - wider_m);
                player.speed_to_stop_within_mps(free_m).max(HARMLESS_MPS)
            }
            None if distance > GIVE_WAY_M + wider_m => continue,
            None => HARMLESS_MPS,
        };
        let towards = step.dot(line);
        let most = most_mps * player.period;
        if towards <= most || fights(player, line, distance) {
            continue;
        }
        step -= line * (towards - most);
    }
    let step = unrotate(player.forward, step);
    let dy = if walks_sideways(player.motion) { step.y } else { 0.0 };
    WalkCommand { dx: step.x, dy, dtheta: walk.dtheta }
}

/// Whether the player faces an opponent in the direction `line` at `distance`, m, with the ball between them.
fn fights(player: &Player, line: Vec2, distance: f32) -> bool {
    let Some(ball) = player.ball() else { return false };
    let along = line.dot(ball.position_m - player.position());
    let aside = ball.position_m.distance(player.position() + line * along.max(0.0));
    along < BETWEEN * distance && aside < FIGHT_M && player.forward.dot(line) > 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::gait::Gait;

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s: 0.0 }
    }

    #[test]
    fn a_player_walks_at_an_opponent_only_for_the_ball_between_them() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.0, 2.0));
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        let dx = |situation: &PlayerFixture, x: f32| give_way(&situation.player(), ahead, &[opponent(x, 0.0)]).dx;
        assert_eq!([dx(&situation, 0.5), dx(&situation, -0.35)], [0.006; 2]);
        // 0.03 m/s are 1 mm a cycle.
        assert!((dx(&situation, 0.35) - 0.001).abs() < 1e-6);
        // The way past the opponent is free: only the part of the step towards the opponent is removed.
        let given = give_way(&situation.player(), ahead, &[opponent(0.35, 0.15)]);
        assert!(given.dx < ahead.dx && given.dy < 0.0 && given.dtheta == ahead.dtheta, "{given:?}");
        assert_eq!(give_way(&situation.player(), ahead, &[opponent(0.0, 0.35)]), ahead);
        situation.motion.gait = Some(Gait::default());
        // A robot that cannot stop at once brakes in time.
        assert!(dx(&situation, 0.45) < 0.005 && dx(&situation, 0.9) == 0.006);
        situation.belief.ball.as_mut().unwrap().position_m = Vec2::new(0.2, 0.0);
        assert_eq!(dx(&situation, 0.35), 0.006);
        // The ball is beside the opponent, not between the two: the player would run into the opponent's side.
        situation.belief.ball.as_mut().unwrap().position_m = Vec2::new(0.3, 0.15);
        assert!(dx(&situation, 0.35) < 0.002);
    }

    #[test]
    fn a_player_does_not_walk_at_what_only_its_sonars_detect() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.0, 2.0));
        situation.motion.gait = Some(Gait::default());
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        let given = |situation: &PlayerFixture, walk: WalkCommand| give_way(&situation.player(), walk, &[]);
        assert_eq!(given(&situation, ahead), ahead);
        situation.sonar.left = Some(0.3);
        assert!(given(&situation, ahead).dx < 0.003);
        let back = WalkCommand::new(-0.003, 0.0, 0.0);
        assert_eq!(given(&situation, back), back);
    }
}
