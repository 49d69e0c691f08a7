//! What the benchmarks share.

use std::time::Instant;

/// The shortest time, s, that some work takes when it is done so many times over.
pub fn fastest(rounds: usize, mut work: impl FnMut()) -> f64 {
    (0..rounds)
        .map(|_| {
            let started = Instant::now();
            work();
            started.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}
