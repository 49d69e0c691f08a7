//! What reads bytes of others returns, whatever they are: the fuzz targets of `fuzz/`, with damaged seeds.
//!
//! `NAOISIS_MUTATIONS` is how many times as many damages are tried as by default.

use naoisis::random::RandomStream;
use rand::RngExt;
use std::path::Path;

#[path = "../../fuzz/src/lib.rs"]
mod targets;

/// Damages of each seed.
const DAMAGES: usize = 40;
/// Damages of one copy of a seed, at most.
const MOST: usize = 4;

#[test]
fn damaged_seeds_are_read_to_an_end() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let times = std::env::var("NAOISIS_MUTATIONS").map_or(1, |times| times.parse().unwrap());
    for target in targets::TARGETS {
        let seeds = (target.seeds)(&assets);
        assert!(!seeds.is_empty(), "{} has no seeds", target.name);
        let mut random = RandomStream::for_match(1, target.name);
        for seed in &seeds {
            (target.read)(seed);
            for _ in 0..DAMAGES * times {
                let mut bytes = seed.clone();
                for _ in 0..random.random_range(1..=MOST) {
                    damage(&mut bytes, &seeds, &mut random);
                }
                (target.read)(&bytes);
            }
        }
    }
}

/// Changes, removes, repeats or inserts something.
fn damage(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut RandomStream) {
    if bytes.is_empty() {
        return;
    }
    let at = random.random_range(0..bytes.len());
    let end = (at + random.random_range(1..64)).min(bytes.len());
    match random.random_range(0..6) {
        0 => bytes[at] = random.random(),
        1 => bytes[at] ^= 1 << random.random_range(0..8),
        2 => drop(bytes.drain(at..end)),
        3 => bytes.truncate(at),
        4 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        _ => {
            let other = &seeds[random.random_range(0..seeds.len())];
            let from = random.random_range(0..other.len());
            bytes.splice(at..end, other[from..(from + 64).min(other.len())].iter().copied());
        }
    }
}
