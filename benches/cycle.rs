//! How long a cycle of a match takes, with everything that plays in it, and how many times faster than real time a
//! match therefore runs on one core.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use naoisis::cycle::run_cycle;
use naoisis::prelude::*;
use naoisis::record::trace::TraceRecorder;
use naoisis::record::{RecordPlugin, recorder};
use std::time::Instant;

/// Cycles before anything is measured: the teams have walked to the ball.
const WARM_UP_CYCLES: usize = 600;
/// Cycles over which the real-time factor is taken: ten simulated minutes at 30 cycles a second.
const FACTOR_CYCLES: u32 = 18_000;

fn app_for(scenario: &str, trace: bool) -> App {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, RecordPlugin));
    app.start_match(&Scenario::named(scenario).unwrap()).unwrap();
    if trace {
        recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::plain("sink", std::io::sink()))]);
    }
    app.run_cycles(WARM_UP_CYCLES);
    app
}

fn cycles(criterion: &mut Criterion) {
    for scenario in ["match3v3", "match7v7"] {
        for trace in [false, true] {
            let name = if trace { format!("{scenario} with trace") } else { scenario.to_owned() };
            let mut app = app_for(scenario, trace);
            criterion.bench_function(&format!("cycle of {name}"), |bencher| {
                bencher.iter(|| run_cycle(app.world_mut()));
            });
            let mut app = app_for(scenario, trace);
            let started = Instant::now();
            for _ in 0..FACTOR_CYCLES {
                run_cycle(app.world_mut());
            }
            let wall_s = started.elapsed().as_secs_f64();
            let simulated_s = f64::from(FACTOR_CYCLES) * app.world().resource::<CycleClock>().period_s;
            println!("{name}: {:.0} times real time over {simulated_s:.0} s of play", simulated_s / wall_s);
        }
    }
}

criterion_group!(benches, cycles);
criterion_main!(benches);
