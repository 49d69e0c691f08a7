//! Batches of matches.

use bevy::prelude::*;
use naoisis::batch::{Batch, MatchOutcome, run_batch};
use naoisis::prelude::*;
use std::sync::atomic::AtomicBool;

use crate::support::headless_app;

#[test]
fn a_match_that_panics_or_cannot_start_is_a_row_and_the_others_go_on() {
    #[derive(Component, Default)]
    struct Careless;

    fn stumbles(clock: Res<CycleClock>, robots: Query<&WalkCommand, With<Careless>>) {
        assert!(clock.cycle < 10 || robots.is_empty(), "stumbled over its own feet");
    }
    let careless_simulator = || {
        let mut app = headless_app();
        app.add_behaviour::<Careless, _>("careless", stumbles);
        app
    };
    let scenario = |behaviour: &str| {
        let json = format!(r#"{{ "duration_s": 1, "robots": [{{ "behaviour": "{behaviour}" }}] }}"#);
        Scenario::from_json(&json).unwrap()
    };
    let variants = ["careless", "idle", "unknown"].map(scenario).to_vec();
    let batch = Batch { variants, matches: 1, first_seed: 1, threads: 2 };
    let mut rows = Vec::new();
    run_batch(&batch, 0, careless_simulator, &AtomicBool::new(false), |row| rows.push(row));
    let outcomes: Vec<MatchOutcome> = rows.iter().map(|row| row.outcome).collect();
    assert_eq!(outcomes, [MatchOutcome::Panicked, MatchOutcome::Duration, MatchOutcome::Refused]);
    assert!(rows[0].note.contains("stumbled over its own feet"), "{}", rows[0].note);
    assert!(rows[2].note.contains("there is no behaviour `unknown`"), "{}", rows[2].note);
}
