//! What each sensor costs in a cycle of a match: the time of a whole cycle, less that of one without the sensor.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

use bevy::prelude::*;
use naoisis::communication::MessageSettings;
use naoisis::prelude::*;
use naoisis::scenario::RobotSettings;
use naoisis::sensing::fidelity::{Fidelity, SensorFidelity};
use naoisis::sensing::scene::SensingSystems;
use std::time::Instant;

/// Cycles before anything is measured: the teams have walked to the ball.
const WARM_UP_CYCLES: usize = 600;
/// Cycles of one measurement.
const CYCLES: usize = 6000;
/// Measurements of each variant; the shortest counts.
const ROUNDS: usize = 5;

fn match_app(scenario: &Scenario) -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app.start_match(scenario).unwrap();
    app
}

/// Microseconds a cycle.
fn microseconds(mut make: impl FnMut() -> App) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let mut app = make();
            app.run_cycles(WARM_UP_CYCLES);
            let started = Instant::now();
            app.run_cycles(CYCLES);
            started.elapsed().as_secs_f64() * 1e6 / CYCLES as f64
        })
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    // Cargo asks every benchmark binary for its tests too.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    for name in ["match3v3", "match7v7"] {
        // A sensor that is switched off keeps its last reading, so that the behaviours go on.
        let mut scenario = Scenario::named(name).unwrap();
        scenario.rules.clock = false;
        let full = microseconds(|| match_app(&scenario));
        println!("{name}: {full:.2} us a cycle with everything");
        println!("{name}: {:.0} times real time", scenario.cycle_s * 1e6 / full);
        for (sensor, set) in [
            ("vision", SensingSystems::Vision),
            ("sonar", SensingSystems::Sonar),
            ("odometry", SensingSystems::Odometry),
        ] {
            let cost = full
                - microseconds(|| {
                    let mut app = match_app(&scenario);
                    app.configure_sets(Cycle, set.run_if(|clock: Res<CycleClock>| clock.cycle < WARM_UP_CYCLES as u64));
                    app
                });
            println!("{name}: {cost:.2} us a cycle of it are the {sensor}");
        }
        let vision = scenario.settings.vision.clone().with_fidelity(Fidelity::Ideal);
        let ideal = Scenario {
            settings: RobotSettings { vision, ..scenario.settings.clone() },
            messages: MessageSettings { loss: 1.0, ..MessageSettings::default() },
            ..scenario.clone()
        };
        println!("{name}: {:.2} us a cycle with ideal vision and no messages", microseconds(|| match_app(&ideal)));
    }
}
