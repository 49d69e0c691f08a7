//! Pause, steps and speed of a match that is played, as viewers ask for them.

use bevy::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Requests of viewers to the program that plays the match. Clones share the requests.
#[derive(Resource, Clone, Default)]
pub struct LiveControl(Arc<Mutex<Requests>>);

#[derive(Default)]
struct Requests {
    is_paused: bool,
    /// Cycles to be played in spite of the pause.
    steps: u64,
    /// The new speed, as a multiple of real time.
    times_real_time: Option<f64>,
}

impl LiveControl {
    /// Pauses the match, or lets it go on.
    pub fn pause(&self, is_paused: bool) {
        let mut requests = self.requests();
        (requests.is_paused, requests.steps) = (is_paused, 0);
    }

    /// Returns whether the match is paused.
    pub fn is_paused(&self) -> bool {
        self.requests().is_paused
    }

    /// Pauses the match, and lets it play `cycles` cycles.
    pub fn step(&self, cycles: u64) {
        let mut requests = self.requests();
        requests.is_paused = true;
        requests.steps = requests.steps.saturating_add(cycles);
    }

    /// Sets the speed, as a multiple of real time.
    pub fn set_speed(&self, times_real_time: f64) {
        self.requests().times_real_time = Some(times_real_time);
    }

    /// Returns whether the next cycle may be played. In a pause, it takes a step that was asked for.
    pub fn may_play(&self) -> bool {
        let mut requests = self.requests();
        if requests.is_paused && requests.steps == 0 {
            return false;
        }
        requests.steps = requests.steps.saturating_sub(1);
        true
    }

    /// Returns the speed that was asked for since the last call, as a multiple of real time.
    pub fn take_speed(&self) -> Option<f64> {
        self.requests().times_real_time.take()
    }

    fn requests(&self) -> MutexGuard<'_, Requests> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_paused_match_plays_the_steps_that_are_asked_for() {
        let control = LiveControl::default();
        assert!(control.may_play() && control.may_play());
        control.pause(true);
        assert!(!control.may_play());
        control.step(2);
        assert!(control.may_play() && control.may_play() && !control.may_play());
        control.step(5);
        control.pause(false);
        assert!(control.may_play());
        control.set_speed(2.0);
        assert_eq!((control.take_speed(), control.take_speed()), (Some(2.0), None));
    }
}
