//! Limits the speed at which a match is played.

use core::time::Duration;
use std::thread;
use std::time::Instant;

/// Greatest delay that a match catches up, real time.
const LATEST: Duration = Duration::from_millis(250);
/// The longest single sleep, so that interrupts are noticed.
const LONGEST_SLEEP: Duration = Duration::from_millis(50);

/// Keeps a match from running faster than a multiple of real time. It does not influence the match.
#[derive(Debug)]
pub struct Pace {
    /// Real time of a cycle.
    cycle: Duration,
    /// Time at which the next cycle may start.
    next: Instant,
}

impl Pace {
    /// Limits the speed to `times_real_time` for cycles of `period_s`, s.
    pub fn new(times_real_time: f64, period_s: f64) -> Self {
        Self { cycle: Duration::from_secs_f64(period_s / times_real_time), next: Instant::now() }
    }

    /// Waits until the next cycle may start, or until `is_stopped` returns true.
    pub fn wait(&mut self, is_stopped: impl Fn() -> bool) {
        loop {
            let now = Instant::now();
            if now >= self.next || is_stopped() {
                self.next = self.next_after(now);
                return;
            }
            thread::sleep((self.next - now).min(LONGEST_SLEEP));
        }
    }

    /// Returns the time at which the cycle after one that starts at `now` may start.
    fn next_after(&self, now: Instant) -> Instant {
        let is_late = now.saturating_duration_since(self.next) > LATEST;
        if is_late { now + self.cycle } else { self.next + self.cycle }
    }
}

/// Parses a multiple of real time.
pub fn times_real_time(word: &str) -> Result<f64, String> {
    let times = word.parse::<f64>().ok().filter(|times| (1e-3..=1e6).contains(times));
    times.ok_or_else(|| "expected a multiple of real time, such as 1 or 0.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_match_that_was_late_is_on_time_again_soon_and_one_that_was_very_late_goes_on_from_there() {
        let pace = Pace::new(2.0, 0.1);
        assert_eq!(pace.cycle, Duration::from_millis(50));
        let late = pace.next + Duration::from_millis(200);
        assert_eq!(pace.next_after(late), pace.next + pace.cycle);
        let very_late = pace.next + Duration::from_secs(3);
        assert_eq!(pace.next_after(very_late), very_late + pace.cycle);
    }

    #[test]
    fn a_pace_is_a_positive_number() {
        assert_eq!(times_real_time("0.5"), Ok(0.5));
        for word in ["0", "-1", "nan", "inf", "fast", ""] {
            assert!(times_real_time(word).is_err(), "{word}");
        }
    }
}
