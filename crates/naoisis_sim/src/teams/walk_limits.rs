//! Limits of steps: a player brakes before a circle or an area that it may not enter.

use bevy::prelude::*;

use super::player::Player;
use naoisis_core::robot::motion::WalkCommand;

/// Returns `walk` without the part that leads deeper into an area: a player at the edge walks along it, and brakes before the edge. `depth_m`
/// returns how deep a place (team frame) is in the area, m; it is negative outside.
pub(super) fn kept_out(player: &Player, walk: WalkCommand, depth_m: impl Fn(Vec2) -> f32) -> WalkCommand {
    let here = player.position();
    let inwards_m = depth_m(after(player, &walk)) - depth_m(here);
    let walk = slowed(player, walk, inwards_m, -depth_m(here));
    let is_allowed = |step: Vec2| {
        let then = depth_m(here + step);
        then <= 0.0 || then <= depth_m(here)
    };
    let step = player.forward.rotate(walk.translation());
    if is_allowed(step) {
        return walk;
    }
    let along = [step * Vec2::Y, step * Vec2::X].into_iter().find(|step| is_allowed(*step)).unwrap_or_default();
    let Vec2 { x: dx, y: dy } = Vec2::new(player.forward.x, -player.forward.y).rotate(along);
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
    let towards_m = -player.forward.rotate(walk.translation()).dot(away.normalize_or_zero());
    slowed(player, walk, towards_m, away.length() - radius)
}

/// The step `walk` that leads `towards_m` nearer to a place, slower so that the player can stop within `distance_m`, m.
pub(super) fn slowed(player: &Player, walk: WalkCommand, towards_m: f32, distance_m: f32) -> WalkCommand {
    let (towards_mps, most_mps) = (towards_m / player.period, player.speed_to_stop_within_mps(distance_m));
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
