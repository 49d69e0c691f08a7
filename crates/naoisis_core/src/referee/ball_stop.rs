//! The end of a half during an attack: the half continues while the attackers' ball rolls towards the opponents' goal (2025 rule
//! book, section 3.18), until it stops, leaves the pitch, or is played again.

use super::snapshot::MatchSnapshot;

/// Speed below which the ball has stopped, m/s.
const STOPPED_MPS: f32 = 0.05;

/// Whether a half whose time is over continues after this cycle.
pub(crate) fn attack_goes_on(snapshot: &MatchSnapshot) -> bool {
    let (Some(ball), Some(touch)) = (&snapshot.ball, snapshot.last_touch) else { return false };
    let attacker = touch.robot.team;
    let time_was_over = snapshot.game.cycles_left == Some(0);
    let played_again = snapshot.touches.iter().any(|(robot, kick)| *kick || robot.team == attacker);
    let forward = -snapshot.game.own_end(attacker).sign() * ball.velocity.x;
    snapshot.rules.half_ends_when_ball_stops
        && snapshot.game.set_play.is_none()
        && ball.velocity.length() >= STOPPED_MPS
        && forward > 0.0
        && !(time_was_over && played_again)
}
