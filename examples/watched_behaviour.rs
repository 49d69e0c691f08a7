//! A behaviour in the window: it walks to the ball, kicks it and draws what it thinks, and the viewer shows its state.
//!
//! `cargo run --release --example watched_behaviour`

use bevy::prelude::*;
use naoisis::behaviour::drawings::{DrawColour, Frame};
use naoisis::prelude::*;
use naoisis::viewer::ViewerPlugins;

/// The number of its kicks. The panel shows it because it derives `Reflect`.
#[derive(Component, Default, Reflect)]
#[reflect(Component)]
struct Kicks(u32);

#[derive(Component, Default)]
#[require(Kicks)]
struct Rusher;

type Senses<'a> = (&'a Percepts, &'a mut Kicks, &'a mut Drawings);
type Commands<'a> = (&'a mut HeadCommand, &'a mut WalkCommand, &'a mut KickCommand);

fn rush(clock: Res<CycleClock>, mut robots: Query<(Senses, Commands), With<Rusher>>) {
    for ((percepts, mut kicks, mut drawings), (mut head, mut walk, mut kick)) in &mut robots {
        head.pitch = 0.25;
        let Some(ball) = percepts.ball else {
            *walk = WalkCommand::at_velocity(0.0, 0.0, 1.5, &clock);
            drawings.text(Frame::Robot, Vec2::ZERO, "where is it?", DrawColour::White);
            continue;
        };
        // Walks to where the ball lies in front of the right foot.
        let towards = ball.position_m - Vec2::new(0.17, -0.05);
        drawings.target(Frame::Robot, towards, "rush", DrawColour::White);
        drawings.circle(Frame::Robot, ball.position_m, 0.1, DrawColour::Yellow);
        if KickType::RightStraight.admits(ball.position_m) {
            kick.0 = Some(KickRequest::new(KickType::RightStraight, 1.0));
            kicks.0 += 1;
        } else {
            *walk = WalkCommand::new(towards.x, towards.y, 0.1 * ball.bearing());
        }
    }
}

fn main() -> Result {
    let mut app = App::new();
    app.add_plugins((ViewerPlugins, NaoisisPlugins)).register_type::<Kicks>();
    app.add_behaviour::<Rusher, _>("rusher", rush);
    app.start_match(&Scenario::from_json(
        r#"{ "name": "rushers", "robots": [
            { "team": "blue", "number": 1, "pose": [-0.6, 0.0, 0.0], "behaviour": "rusher" },
            { "team": "blue", "number": 2, "pose": [-1.5, 0.8, 0.0], "behaviour": "rusher" },
            { "team": "pink", "number": 1, "pose": [2.7, 0.0, 180.0], "behaviour": "keeper" },
            { "team": "pink", "number": 2, "pose": [1.2, 0.3, 180.0], "behaviour": "chaser" }] }"#,
    )?)?;
    app.run();
    Ok(())
}
