//! A custom sensor: a robot that hears, with settings in the scenario, a reading for behaviours, and a value in the
//! trace.
//!
//! The referee whistles at the side line when play begins. Robots wait for the whistle; a robot that is too far away
//! does not hear it and stays.
//!
//! Run with `cargo run --release --no-default-features --example robot_that_hears`. With `-- run ears.json --trace -`
//! and a scenario of your own, its traces have `"sensors": { "whistle_ear": { "heard": true } }` for each robot.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

use bevy::prelude::*;
use naoisis::pitch::Pitch;
use naoisis::prelude::*;
use naoisis::random::RandomStreams;
use serde::{Deserialize, Serialize};
use std::process::ExitCode;

/// The settings. A scenario changes them under `"sensors": { "whistle_ear": { ... } }`, for all robots or for one.
#[derive(Component, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
struct WhistleEar {
    /// The range, m.
    range_m: f32,
    /// The probability that a whistle is missed.
    miss_probability: f32,
}

impl Default for WhistleEar {
    fn default() -> Self {
        Self { range_m: 6.0, miss_probability: 0.1 }
    }
}

/// The reading, which behaviours may read but not write.
#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
struct Whistle {
    /// Whether a whistle was heard in this cycle.
    heard: bool,
}

/// The system of the sensor is part of the simulation: it may read the poses of robots and the events.
fn hear(
    mut events: MessageReader<StampedEvent>,
    pitch: Res<Pitch>,
    mut robots: Query<(&Pose, &WhistleEar, &mut Whistle, &mut RandomStreams)>,
) {
    let referee = Vec2::new(0.0, -pitch.half_width());
    let play_begins = MatchEvent::StateChanged { state: GameState::Playing };
    let whistled = events.read().any(|stamped| stamped.event == play_begins);
    for (pose, ear, mut whistle, mut streams) in &mut robots {
        let is_near = pose.position.distance(referee) < ear.range_m;
        // Random numbers of its own, so the noise of other sensors does not change.
        whistle.heard = whistled && is_near && !streams.own("whistle_ear").chance(ear.miss_probability);
    }
}

/// Walks once it has heard the whistle.
#[derive(Component, Default)]
struct Listener {
    has_heard: bool,
}

fn walk_when_whistled(clock: Res<CycleClock>, mut robots: Query<(&Whistle, &mut Listener, &mut WalkCommand)>) {
    for (whistle, mut listener, mut walk) in &mut robots {
        listener.has_heard |= whistle.heard;
        let speed_mps = if listener.has_heard { 0.15 } else { 0.0 };
        *walk = WalkCommand::at_velocity(speed_mps, 0.0, 0.0, &clock);
    }
}

fn add_ears(app: &mut App) {
    app.add_sensor::<WhistleEar, Whistle, _>("whistle_ear", hear);
    app.add_behaviour::<Listener, _>("listener", walk_when_whistled);
}

const SCENARIO: &str = r#"{ "rules": "naoisis", "sensors": { "whistle_ear": { "miss_probability": 0 } }, "robots": [
    { "number": 1, "pose": [-1, 0, 0], "behaviour": "listener" },
    { "number": 2, "pose": [-1, 1, 0], "behaviour": "listener", "sensors": { "whistle_ear": { "range_m": 0.5 } } }] }"#;

fn main() -> Result<ExitCode, Box<dyn core::error::Error>> {
    if std::env::args().len() > 1 {
        return Ok(naoisis::cli::run(add_ears));
    }
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_ears(&mut app);
    app.start_match(&Scenario::from_json(SCENARIO)?)?.run_cycles(1);
    let place =
        |app: &App, number| app.robot_pose(RobotId::new(Team::Blue, number)).map_or(Vec2::ZERO, |pose| pose.position);
    let starts = [1, 2].map(|number| place(&app, number));
    app.run_cycles(60);
    let [hearing, deaf] = [1, 2].map(|number| place(&app, number).distance(starts[number as usize - 1]));
    println!(
        "two seconds after the whistle, the robot that heard it has walked {hearing:.2} m, the other one {deaf:.2} m"
    );
    assert!(hearing > 0.25 && deaf == 0.0);
    Ok(ExitCode::SUCCESS)
}
