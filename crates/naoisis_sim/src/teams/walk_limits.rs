//! Limits of steps: a player brakes before a circle or an area that it may not enter.

use bevy::prelude::*;

use super::player::Player;
use naoisis_core::robot::motion::WalkCommand;

/// Returns `walk` without the part that leads deeper into an area, which is slower before the edge, so that the player can stop there: a player
/// at the edge walks along it. `depth_m` returns how deep a place (team frame) is in the area, m; it is negative outside.
pub(super) fn kept_out(player: &Player, walk: WalkCommand, depth_m: impl Fn(Vec2) -> f32) -> WalkCommand {
    let here = player.position();
    let depth_after_m = |step: Vec2| depth_m(here + step);
    let is_allowed = |step: Vec2| depth_after_m(step) <= depth_m(here).max(0.0);
    let step = player.forward.rotate(walk.translation());
    let inwards_mps = (depth_after_m(step) - depth_m(here)) / player.period;
    let most_mps = player.speed_to_stop_within_mps(-depth_m(here));
    if is_allowed(step) && inwards_mps <= most_mps {
        return walk;
    }
    let parts = [step * Vec2::Y, step * Vec2::X];
    let slower = if inwards_mps > most_mps {
        // The part along the edge is the one that leads less deep.
        let [y, x] = parts.map(depth_after_m);
        let along = if y <= x { parts[0] } else { parts[1] };
        along + (step - along) * (most_mps / inwards_mps)
    } else {
        step
    };
    let allowed = [slower, parts[0], parts[1]].into_iter().find(|step| is_allowed(*step)).unwrap_or_default();
    let Vec2 { x: dx, y: dy } = Vec2::new(player.forward.x, -player.forward.y).rotate(allowed);
    WalkCommand { dx, dy, dtheta: walk.dtheta }
}

/// The place after a step, m, team frame.
pub(super) fn after(player: &Player, walk: &WalkCommand) -> Vec2 {
    player.position() + player.forward.rotate(walk.translation())
}

/// The step `walk`, slower so that the player can stop before it is nearer to `centre` than `radius`, m.
pub(super) fn braked(player: &Player, walk: WalkCommand, centre: Vec2, radius: f32) -> WalkCommand {
    if leads_into(player, &walk, centre, radius) {
        return WalkCommand { dtheta: walk.dtheta, ..default() };
    }
    let away = player.position() - centre;
    let towards_mps = -player.forward.rotate(walk.translation()).dot(away.normalize_or_zero()) / player.period;
    let most_mps = player.speed_to_stop_within_mps(away.length() - radius);
    if towards_mps <= most_mps {
        return walk;
    }
    let slower = walk.translation() * (most_mps / towards_mps);
    WalkCommand { dx: slower.x, dy: slower.y, dtheta: walk.dtheta }
}

/// Whether a step leads nearer to `centre`, to a place within `radius` of it, m.
pub(super) fn leads_into(player: &Player, walk: &WalkCommand, centre: Vec2, radius: f32) -> bool {
    let (now, then) = (player.position().distance_squared(centre), after(player, walk).distance_squared(centre));
    then < radius * radius && then < now
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::gait::Gait;

    #[test]
    fn a_player_with_a_gait_brakes_before_an_area_and_walks_along_its_edge() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::X);
        situation.motion.gait = Some(Gait { acceleration_mps2: 0.5, step_s: 0.25, ..Gait::default() });
        // The area begins at x = 0; a step of 0.02 m is 0.6 m/s.
        let mut kept = |x: f32, walk: [f32; 2]| {
            situation.belief.pose.position.x = x;
            let walk = WalkCommand::new(walk[0], walk[1], 0.0);
            let WalkCommand { dx, dy, .. } = kept_out(&situation.player(), walk, |place| place.x);
            Vec2::new(dx, dy)
        };
        assert_eq!(kept(-2.0, [0.02, 0.01]), Vec2::new(0.02, 0.01));
        let near = kept(-0.1, [0.02, 0.01]);
        assert!(near.x > 0.0 && near.x < 0.012 && (near.y - 0.01).abs() < 1e-6, "{near}");
        assert!(kept(0.0, [0.02, 0.01]).distance(Vec2::new(0.0, 0.01)) < 1e-6);
        assert_eq!(kept(-0.1, [-0.02, 0.0]), Vec2::new(-0.02, 0.0));
        // Inside, it may leave.
        assert_eq!(kept(0.1, [-0.02, 0.01]), Vec2::new(-0.02, 0.01));
    }
}
