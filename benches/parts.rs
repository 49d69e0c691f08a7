//! What the parts of a cycle cost, what saving a match costs, how much memory a match needs, and what a second thread
//! brings to a batch.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

mod common;

use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use common::fastest;
use core::sync::atomic::AtomicBool;
use naoisis::batch::{Batch, run_batch};
use naoisis::prelude::*;
use naoisis::simulation::Snapshot;
use std::time::Instant;

/// Cycles before anything is measured: the teams have walked to the ball.
const WARM_UP_CYCLES: usize = 600;
/// Cycles of a measurement.
const CYCLES: usize = 6000;
/// Measurements of each figure; the best counts.
const ROUNDS: usize = 3;
/// Times that a match is saved and restored in a measurement.
const SNAPSHOTS: usize = 100;
/// Matches that are in memory at the same time.
const MATCHES_IN_MEMORY: usize = 16;
/// Matches of a batch, and how long each is, s.
const BATCH_MATCHES: usize = 16;
const BATCH_MATCH_S: f64 = 120.0;

/// The parts of a cycle, by the sets after which the clock is read.
const PARTS: [(&str, CycleSystems); 10] = [
    ("sense", CycleSystems::Sense),
    ("communicate", CycleSystems::Communicate),
    ("decide", CycleSystems::Decide),
    ("act", CycleSystems::Act),
    ("move", CycleSystems::Move),
    ("kick", CycleSystems::Kick),
    ("roll the ball", CycleSystems::RollBall),
    ("collide", CycleSystems::Collide),
    ("officiate", CycleSystems::Officiate),
    ("check invariants", CycleSystems::CheckInvariants),
];

/// Time spent in each part, s, and when the last one ended.
#[derive(Resource)]
struct Spent {
    parts: [f64; PARTS.len()],
    last: Instant,
}

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

fn read_clock(part: usize) -> impl Fn(ResMut<Spent>) {
    move |mut spent: ResMut<Spent>| {
        let now = Instant::now();
        let elapsed = (now - spent.last).as_secs_f64();
        spent.parts[part] += elapsed;
        spent.last = now;
    }
}

fn start_clock(mut spent: ResMut<Spent>) {
    spent.last = Instant::now();
}

fn after_part(part: usize) -> impl IntoScheduleConfigs<ScheduleSystem, ()> {
    let next = PARTS.get(part + 1).map_or(CycleSystems::Record, |(_, set)| *set);
    read_clock(part).after(PARTS[part].1).before(next)
}

fn parts_of_a_cycle(name: &str) {
    let mut app = simulator();
    app.insert_resource(Spent { parts: default(), last: Instant::now() });
    app.add_systems(Cycle, start_clock.after(CycleSystems::First).before(CycleSystems::Sense));
    for part in 0..PARTS.len() {
        app.add_systems(Cycle, after_part(part));
    }
    let mut scenario = Scenario::named(name).unwrap();
    scenario.rules.clock = false;
    app.start_match(&scenario).unwrap().run_cycles(WARM_UP_CYCLES);
    let mut best = [f64::INFINITY; PARTS.len()];
    for _ in 0..ROUNDS {
        app.world_mut().resource_mut::<Spent>().parts = default();
        app.run_cycles(CYCLES);
        for (best, spent) in best.iter_mut().zip(app.world().resource::<Spent>().parts) {
            *best = best.min(spent);
        }
    }
    for ((part, _), spent) in PARTS.iter().zip(best) {
        println!("{name}, {part}: {:.2} us a cycle", spent * 1e6 / CYCLES as f64);
    }
}

fn real_time_factor(name: &str) {
    let mut app = simulator();
    let mut scenario = Scenario::named(name).unwrap();
    scenario.rules.clock = false;
    app.start_match(&scenario).unwrap().run_cycles(WARM_UP_CYCLES);
    let fastest = fastest(ROUNDS, || {
        app.run_cycles(CYCLES);
    });
    let cycle_us = fastest * 1e6 / CYCLES as f64;
    println!("{name}, all: {cycle_us:.2} us a cycle, {:.0} times real time", scenario.cycle_s * 1e6 / cycle_us);
}

fn snapshots(name: &str) {
    let mut app = simulator();
    app.start_match(&Scenario::named(name).unwrap()).unwrap().run_cycles(WARM_UP_CYCLES);
    let (mut saving, mut restoring, mut size) = (f64::INFINITY, f64::INFINITY, 0);
    for _ in 0..SNAPSHOTS {
        let started = Instant::now();
        let bytes = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
        saving = saving.min(started.elapsed().as_secs_f64());
        let started = Instant::now();
        Snapshot::from_bytes(&bytes, app.world()).unwrap().restore(app.world_mut()).unwrap();
        restoring = restoring.min(started.elapsed().as_secs_f64());
        size = bytes.len();
        app.run_cycles(1);
    }
    let (saving, restoring) = (saving * 1e3, restoring * 1e3);
    println!("{name}, snapshot of {} kB: {saving:.2} ms to save, {restoring:.2} ms to restore", size / 1000);
}

/// The memory that this process has, bytes, where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<f64>().ok().map(|kilobytes| 1024.0 * kilobytes)
}

fn memory_of_a_match(name: &str) {
    let scenario = Scenario::named(name).unwrap();
    let start = || {
        let mut app = simulator();
        app.start_match(&scenario).unwrap().run_cycles(WARM_UP_CYCLES);
        app
    };
    // What all matches share is there from the first on.
    let first = start();
    let before = memory();
    let matches: Vec<App> = (0..MATCHES_IN_MEMORY).map(|_| start()).collect();
    let each = before.zip(memory()).map(|(before, after)| (after - before) / matches.len() as f64 / 1e6);
    drop(first);
    match each {
        Some(megabytes) => println!("{name}, memory: {megabytes:.2} MB a match"),
        None => println!("{name}, memory: this system does not tell"),
    }
}

fn scaling_of_a_batch(name: &str) {
    let scenario = Scenario { duration_s: Some(BATCH_MATCH_S as f32), ..Scenario::named(name).unwrap() };
    let seconds = |threads: usize| {
        let batch = Batch { variants: vec![scenario.clone()], matches: BATCH_MATCHES, first_seed: 1, threads };
        fastest(ROUNDS, || run_batch(&batch, 0, simulator, &AtomicBool::new(false), |_| {}))
    };
    let (one, two) = (seconds(1), seconds(2));
    let factor = BATCH_MATCHES as f64 * BATCH_MATCH_S / one;
    println!(
        "{name}, batch: {factor:.0} times real time on one thread, {:.0} on two; {:.0} % of twice",
        BATCH_MATCHES as f64 * BATCH_MATCH_S / two,
        100.0 * one / (2.0 * two)
    );
}

fn main() {
    // Cargo asks every benchmark binary for its tests too.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    // Memory first: what others have used and given back would hide what a match needs.
    for name in ["match3v3", "match7v7"] {
        memory_of_a_match(name);
    }
    for name in ["match3v3", "match7v7"] {
        parts_of_a_cycle(name);
        real_time_factor(name);
        snapshots(name);
        scaling_of_a_batch(name);
    }
}
