//! A custom rule: a robot of the leading team may not stay at the ball without playing it.
//!
//! Run with `cargo run --release --no-default-features --example time_wasting`. With a command, such as `-- run
//! match3v3 --explain --set rules.own.time_wasting.limit_s=5`, the program has all commands of naoisis, and they know
//! the rule.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

use bevy::prelude::*;
use naoisis::game::Evidence;
use naoisis::prelude::*;
use naoisis::referee::report::report;
use serde::Deserialize;
use std::process::ExitCode;

/// The settings. A scenario switches the rule on by `"rules": { "own": { "time_wasting": { ... } } }`.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct TimeWasting {
    /// How long a robot may stay at the ball, s.
    limit_s: f32,
    /// The distance within which a robot is at the ball, m.
    radius_m: f32,
}

impl Default for TimeWasting {
    fn default() -> Self {
        Self { limit_s: 10.0, radius_m: 0.3 }
    }
}

impl CustomRule for TimeWasting {
    fn advance(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
        let (team, score) = (robot.id.team, seen.game.score);
        let leads = score[team] > score[team.opponent()];
        let at_ball = seen.ball.is_some_and(|ball| ball.position.distance(robot.pose.position) < self.radius_m);
        let kicks = seen.touches.iter().any(|(toucher, kick)| *toucher == robot.id && *kick);
        if leads && at_ball && !kicks { cycles + 1 } else { 0 }
    }

    fn judge(&self, cycles: u64, seen: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
        (cycles >= seen.cycles(self.limit_s)).then(|| {
            seen.evidence_against("A robot of the leading team may not stay at the ball without playing it.", robot)
                .with_measurement("s at the ball", seen.seconds(cycles), self.limit_s)
                .otherwise("It had to kick the ball, or leave it, in time.")
        })
    }
}

fn add_rule(app: &mut App) {
    app.add_rule::<TimeWasting>("time_wasting");
}

/// Blue leads by one goal, and its robot stands at the ball.
const SCENARIO: &str = r#"{ "rules": { "preset": "free", "own": { "time_wasting": { "limit_s": 3 } } },
    "interventions": [{ "at_s": 0, "do": { "set_score": { "blue": 1, "pink": 0 } } }],
    "robots": [{ "team": "blue", "number": 1, "pose": [-0.2, 0, 0] }, { "team": "pink", "number": 1, "pose": [0.2, 0, 180] }] }"#;

fn main() -> Result<ExitCode, Box<dyn core::error::Error>> {
    if std::env::args().len() > 1 {
        return Ok(naoisis::cli::run(add_rule));
    }
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_rule(&mut app);
    app.start_match(&Scenario::from_json(SCENARIO)?)?;
    let penalised = app.run_until(120, |app| app.events().iter().any(|event| event.kind() == "penalty time_wasting"));
    assert!(penalised);
    for event in app.events() {
        println!("{}", report(app.cycle() as f64 / 30.0, None, event).unwrap_or_default());
    }
    Ok(ExitCode::SUCCESS)
}
