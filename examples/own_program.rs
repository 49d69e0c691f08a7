//! A program with its own team and all commands of naoisis: the window, batches, replays and the others know the team.
//!
//! Run with `cargo run --release --no-default-features --example own_program -- COMMAND`, such as
//!
//! - `list teams`, which has `rushers` among the built-in ones;
//! - `run match3v3 --set teams.blue=rushers --explain`;
//! - `batch match3v3 --matches 20 --pairs rushers,chasers`;
//! - `play`, or no command, for the window, in a build without `--no-default-features`.

use bevy::prelude::*;
use naoisis::prelude::*;
use std::process::ExitCode;

/// Ties robots to the behaviour.
#[derive(Component, Default)]
struct Rusher;

/// Looks down, walks at the ball, and kicks when it lies in front of the right foot.
fn rush(
    clock: Res<CycleClock>,
    mut robots: Query<(&Percepts, &mut HeadCommand, &mut WalkCommand, &mut KickCommand), With<Rusher>>,
) {
    for (percepts, mut head, mut walk, mut kick) in &mut robots {
        head.pitch = 0.25;
        let Some(ball) = percepts.ball else {
            // Turns by 86 degrees per second.
            *walk = WalkCommand::at_velocity(0.0, 0.0, 1.5, &clock);
            continue;
        };
        if KickType::RightStraight.admits(ball.position_m) {
            kick.0 = Some(KickRequest::new(KickType::RightStraight, 1.0));
        } else {
            let towards = ball.position_m - Vec2::new(0.17, -0.05);
            *walk = WalkCommand::new(towards.x, towards.y, 0.1 * ball.bearing());
        }
    }
}

fn main() -> ExitCode {
    naoisis::cli::run(|app| {
        app.add_behaviour::<Rusher, _>("rusher", rush);
        app.add_team("rushers", "Everybody rushes at the ball, and nobody knows which goal it is.", |_, _| "rusher");
    })
}
