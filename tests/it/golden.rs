//! Every built-in scenario plays as it did before: the digests in `tests/golden/digests.txt`.
//!
//! A change that is meant to alter matches, or what traces say of them, writes that file again, in a commit of its own that
//! says why: `NAOISIS_WRITE_GOLDEN=1 cargo test --no-default-features --test it golden`. A change of the trace's words alone
//! leaves the column of the truth as it is.

use bevy::prelude::*;
use core::fmt::Write;
use naoisis::prelude::*;
use naoisis::scenario::LIBRARY;
use naoisis::simulation::play_in_order;
use std::sync::atomic::AtomicBool;

use crate::support::{begin_trace, headless_app};

const RECORDED: &str = include_str!("../golden/digests.txt");
const SEEDS: [u64; 3] = [1, 2, 3];
/// Longer scenarios are played for so long, s.
const LONGEST_S: f64 = 20.0;
/// Those in which robots walk in before they play, s.
const LONGEST_WITH_WALK_IN_S: f64 = 60.0;
/// Those whose robots see by rendered images, s.
const LONGEST_WITH_IMAGES_S: f64 = 2.0;

#[test]
fn built_in_scenarios_play_as_they_did() {
    let matches: Vec<Scenario> = LIBRARY
        .iter()
        .map(|entry| Scenario::named(entry.name).unwrap())
        .flat_map(|scenario| SEEDS.map(|seed| Scenario { seed, ..scenario.clone() }))
        .collect();
    let mut played = String::from("# scenario, seed, lines of the trace, digest of the trace, digest of the truth\n");
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let line = |(): &mut (), index: usize| digest_line(&matches[index]);
    play_in_order(0..matches.len(), threads, &AtomicBool::new(false), || (), line, |line| writeln!(played, "{line}"))
        .unwrap();
    if std::env::var_os("NAOISIS_WRITE_GOLDEN").is_some() {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/digests.txt"), &played).unwrap();
        return;
    }
    let changed: Vec<String> = RECORDED
        .lines()
        .zip(played.lines())
        .filter(|(recorded, played)| recorded != played)
        .map(|(recorded, played)| format!("- {recorded}\n+ {played}"))
        .collect();
    assert!(
        changed.is_empty() && RECORDED.lines().count() == played.lines().count(),
        "matches are not what they were. If that is meant, write tests/golden/digests.txt again, as tests/it/golden.rs \
         says, in a commit that says why:\n{}",
        changed.join("\n")
    );
}

fn digest_line(scenario: &Scenario) -> String {
    let longest_s = match scenario {
        with_images if with_images.name.contains("images") => LONGEST_WITH_IMAGES_S,
        walk_in if walk_in.rules.walk_in => LONGEST_WITH_WALK_IN_S,
        _ => LONGEST_S,
    };
    let duration_s = scenario.duration_s.map_or(longest_s, |duration_s| f64::from(duration_s).min(longest_s));
    let cycles = (duration_s / scenario.cycle_s).round() as usize;
    let (trace, truth) = trace_and_truth_of(scenario, cycles);
    let mut digest = Digest::default();
    digest.add(&trace);
    let lines = trace.iter().filter(|byte| **byte == b'\n').count();
    assert_eq!(lines, cycles + 2);
    format!("{} {} {lines} {:016x} {:016x}", scenario.name, scenario.seed, digest.0, truth.0)
}

/// The trace, and what is true after each cycle: where everything is and how it moves, and the score.
fn trace_and_truth_of(scenario: &Scenario, cycles: usize) -> (Vec<u8>, Digest) {
    let mut app = headless_app();
    app.start_match(scenario).unwrap();
    let trace = begin_trace(&mut app);
    let mut robots = app.world_mut().query::<(&RobotId, &Pose, &HeadAngles)>();
    let mut digest = Digest::default();
    for _ in 0..cycles {
        app.run_cycles(1);
        let mut places: Vec<_> = robots.iter(app.world()).map(|(id, pose, head)| (*id, *pose, *head)).collect();
        places.sort_by_key(|(id, ..)| *id);
        for (_, pose, head) in places {
            digest.add_numbers([pose.position.x, pose.position.y, pose.heading, head.yaw, head.pitch]);
        }
        if let (Some(pose), Some(velocity)) = (app.ball(), app.ball_velocity()) {
            digest.add_numbers([pose.position.x, pose.position.y, velocity.x, velocity.y]);
        }
        let score = app.game().score;
        digest.add(&[score.blue, score.pink].map(u32::to_le_bytes).concat());
    }
    drop(app);
    (trace.written(), digest)
}

/// The 64 bits of Fowler, Noll and Vo's hash, FNV-1a.
struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn add_numbers<const N: usize>(&mut self, numbers: [f32; N]) {
        for number in numbers {
            self.add(&number.to_bits().to_le_bytes());
        }
    }
}
