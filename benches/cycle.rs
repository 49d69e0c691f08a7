//! How long a cycle of a match takes, with everything that plays in it, and how many times faster than real time a
//! match therefore runs on one core.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

use bevy::prelude::*;
use criterion::{Criterion, criterion_group, criterion_main};
use naoisis::cycle::run_cycle;
use naoisis::prelude::*;
use naoisis::record::trace::TraceRecorder;
use naoisis::record::{RecordPlugin, recorder};
use naoisis::scenario::{Realism, RealismSettings};
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

/// Cycles of each match whose realism is compared: two simulated minutes, of which the whole has every part of a match.
const REALISM_CYCLES: u32 = 3_600;
/// Matches of each realism: some have more to do than others.
const REALISM_MATCHES: u64 = 8;

/// What a realism costs, beside ideal robots: the mean of the same seeds, taken in turn.
fn realism(_: &mut Criterion) {
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    for name in ["match3v3", "match7v7", "hsl2026_middle"] {
        let scenario = Scenario::named(name).unwrap();
        let words = [Realism::Ideal, Realism::Paper, Realism::Realistic];
        let mut seconds = [0.0; 3];
        for seed in 1..=REALISM_MATCHES {
            for (word, seconds) in words.into_iter().zip(&mut seconds) {
                let mut app = App::new();
                app.add_plugins((NaoisisPlugins, RecordPlugin));
                app.start_match(&Scenario { seed, ..scenario.clone() }.with_realism(RealismSettings::all(word)))
                    .unwrap();
                let started = Instant::now();
                for _ in 0..REALISM_CYCLES {
                    run_cycle(app.world_mut());
                }
                *seconds += started.elapsed().as_secs_f64();
            }
        }
        let [ideal, paper, realistic] =
            seconds.map(|total| total * 1e6 / (REALISM_MATCHES as f64 * f64::from(REALISM_CYCLES)));
        let over = |other: f64| 100.0 * (other / ideal - 1.0);
        println!(
            "{name}: {ideal:.1} us a cycle ideal, {paper:.1} paper ({:+.0} %), {realistic:.1} realistic ({:+.0} %)",
            over(paper),
            over(realistic)
        );
    }
}

criterion_group!(benches, cycles, realism);
criterion_main!(benches);
