//! Not walking into opponents: who runs into another is sent off for a time, and who stands is not.

use bevy::prelude::*;

use super::player::Player;
use super::walking::{OBSTACLE_MEMORY_S, walks_sideways};
use naoisis_core::geometry::{unit, unrotate};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_sensing::belief::RobotBelief;

/// Nearer to an opponent than this, a player does not walk at it, m: they touch at some 0.3 m.
const GIVE_WAY_M: f32 = 0.45;
/// Who walks step by step comes no nearer to an opponent than this, m, and brakes in time.
const STOP_M: f32 = 0.4;
/// What gives an echo is nearer than its middle by this, m.
const ECHO_DEPTH_M: f32 = 0.05;
/// What is not walking at an opponent, m/s: the referee overlooks less than 0.05.
pub(super) const HARMLESS_MPS: f32 = 0.03;
/// Two who face each other with the ball so near to the line between them may fight for it, m.
const FIGHT_M: f32 = 0.2;
/// The ball is between them up to this share of the way to the opponent: who stands right at the ball does not face who comes.
const BETWEEN: f32 = 0.75;

/// The step without what would run into an opponent.
pub fn give_way(player: &Player, walk: WalkCommand, opponents: &[RobotBelief]) -> WalkCommand {
    let mut step = player.forward.rotate(walk.translation());
    let wider_m = 2.0 * player.wider_than_nao_m();
    let seen = opponents
        .iter()
        .filter(|other| other.age_s < OBSTACLE_MEMORY_S)
        .map(|other| other.position_m - player.position());
    for way in seen.chain(heard(player)) {
        let distance = way.length();
        let Some(line) = way.try_normalize() else { continue };
        let most_mps = match &player.limits.gait {
            Some(gait) => gait.braking_speed(distance - STOP_M - wider_m).max(HARMLESS_MPS),
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
    let dy = if walks_sideways(player.limits) { step.y } else { 0.0 };
    WalkCommand { dx: step.x, dy, dtheta: walk.dtheta }
}

/// The ways to what its sonars hear before it, m, team frame.
fn heard<'a>(player: &'a Player) -> impl Iterator<Item = Vec2> + use<'a> {
    let echoes = [(player.sonar.left, 1.0), (player.sonar.right, -1.0)];
    echoes.into_iter().filter_map(|(distance, side)| {
        let direction = || player.forward.rotate(unit(side * player.sonar_settings.heading));
        distance.map(|distance| direction() * (distance + ECHO_DEPTH_M))
    })
}

/// Whether the player faces an opponent in this direction and at this distance with the ball between them.
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
    fn nobody_walks_at_an_opponent_unless_for_the_ball_between_them() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.0, 2.0));
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        let dx = |situation: &PlayerFixture, x: f32| give_way(&situation.player(), ahead, &[opponent(x, 0.0)]).dx;
        assert_eq!([dx(&situation, 0.5), dx(&situation, -0.35)], [0.006; 2]);
        // 0.03 m/s are 1 mm a cycle.
        assert!((dx(&situation, 0.35) - 0.001).abs() < 1e-6);
        // Past it is free: what leads to it is taken from the step, and what leads past it stays.
        let given = give_way(&situation.player(), ahead, &[opponent(0.35, 0.15)]);
        assert!(given.dx < ahead.dx && given.dy < 0.0 && given.dtheta == ahead.dtheta, "{given:?}");
        assert_eq!(give_way(&situation.player(), ahead, &[opponent(0.0, 0.35)]), ahead);
        situation.limits.gait = Some(Gait::default());
        // Who cannot stop at once brakes before.
        assert!(dx(&situation, 0.45) < 0.005 && dx(&situation, 0.9) == 0.006);
        situation.belief.ball.as_mut().unwrap().position_m = Vec2::new(0.2, 0.0);
        assert_eq!(dx(&situation, 0.35), 0.006);
        // It stands at the opponent's side: that does not face the ball, and is run into from the side.
        situation.belief.ball.as_mut().unwrap().position_m = Vec2::new(0.3, 0.15);
        assert!(dx(&situation, 0.35) < 0.002);
    }

    #[test]
    fn nobody_walks_at_what_it_only_hears() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.0, 2.0));
        situation.limits.gait = Some(Gait::default());
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        let given = |situation: &PlayerFixture, walk: WalkCommand| give_way(&situation.player(), walk, &[]);
        assert_eq!(given(&situation, ahead), ahead);
        situation.sonar.left = Some(0.3);
        assert!(given(&situation, ahead).dx < 0.003);
        let back = WalkCommand::new(-0.003, 0.0, 0.0);
        assert_eq!(given(&situation, back), back);
    }
}
