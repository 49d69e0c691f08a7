//! Keyframes: the whole match is stored every few seconds, so that any moment can be rebuilt.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use naoisis_core::behaviour::Remote;
use naoisis_core::cycle::CycleClock;
use naoisis_record::whatif::Moment;

/// The time between two keyframes, s.
pub const INTERVAL_S: f64 = 5.0;
/// Why a match cannot be stored.
const PROGRAMS: &str = "robots of this match are played by programs, whose state cannot be stored";
/// The size from which every other keyframe is dropped, bytes.
const MOST_BYTES: usize = 200 << 20;

/// A function that makes an app with everything that the program's matches need.
pub type MakeApp = &'static (dyn Fn() -> App + Sync);

/// Makes the apps in which the match is replayed, one for each thread. Without it, nothing is replayed.
#[derive(Resource, Clone, Copy)]
pub struct Simulator(pub MakeApp);

/// The keyframes of the match that is shown, by the cycle that had just ended. Threads that replay the match share
/// them.
#[derive(Resource, Clone, Debug, Default)]
pub struct Keyframes(Arc<Mutex<Kept>>);

/// The name of a match. It does not keep the keyframes of the match.
#[derive(Clone, Debug)]
pub(super) struct KeyframesName(Weak<Mutex<Kept>>);

impl KeyframesName {
    /// Returns whether it is the name of the match of these keyframes.
    pub fn is_of(&self, keyframes: &Keyframes) -> bool {
        self.0.as_ptr() == Arc::as_ptr(&keyframes.0)
    }

    /// Returns whether something keeps the keyframes of the match.
    pub fn is_kept(&self) -> bool {
        self.0.strong_count() > 0
    }
}

#[derive(Clone, Debug, Default)]
struct Kept {
    moments: BTreeMap<u64, Moment>,
    bytes: usize,
    /// Whether an action since the last keyframe would be missing in a replay.
    is_changed: bool,
    /// Why there are no keyframes.
    fault: Option<String>,
}

impl Keyframes {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        // No thread panics while it holds the lock. Even then the keyframes would be complete.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether both are keyframes of the same match.
    pub fn is_same(&self, other: &Keyframes) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Returns whether something else has these keyframes, too.
    pub(super) fn is_shared(&self) -> bool {
        Arc::strong_count(&self.0) > 1
    }

    /// Returns a name of the match of these keyframes, which does not keep them.
    pub(super) fn name(&self) -> KeyframesName {
        KeyframesName(Arc::downgrade(&self.0))
    }

    /// Adds a keyframe.
    pub fn keep(&self, cycle: u64, moment: Moment) {
        let mut kept = self.kept();
        kept.bytes += moment.size_bytes();
        if let Some(before) = kept.moments.insert(cycle, moment) {
            kept.bytes -= before.size_bytes();
        }
        if kept.bytes > MOST_BYTES {
            let mut index = 0;
            // The first keyframe is never removed: the beginning would be lost without it.
            kept.moments.retain(|_, _| {
                index += 1;
                index % 2 == 1
            });
            kept.bytes = kept.moments.values().map(Moment::size_bytes).sum();
        }
    }

    /// Returns the last keyframe that is not after `cycle`.
    pub fn before(&self, cycle: u64) -> Option<(u64, Moment)> {
        self.kept().moments.range(..=cycle).next_back().map(|(kept, moment)| (*kept, moment.clone()))
    }

    /// Returns the cycle of the last keyframe.
    pub fn last(&self) -> Option<u64> {
        self.kept().moments.keys().next_back().copied()
    }

    /// Returns the cycles of the keyframes for which `is_meant` holds, in order.
    pub fn cycles(&self, is_meant: impl Fn(&Moment) -> bool) -> Vec<u64> {
        let kept = self.kept();
        kept.moments.iter().filter(|(_, moment)| is_meant(moment)).map(|(cycle, _)| *cycle).collect()
    }

    /// Notes that an action by hand happened in the current cycle: a keyframe is added after it.
    pub fn note_change(&self) {
        self.kept().is_changed = true;
    }

    /// Why there are no keyframes, if so.
    pub fn fault(&self) -> Option<String> {
        self.kept().fault.clone()
    }

    /// Returns the keyframes until `cycle`, for a branch of the match.
    pub fn until(&self, cycle: u64) -> Keyframes {
        let mut kept = self.kept().clone();
        kept.moments.retain(|kept, _| *kept <= cycle);
        kept.bytes = kept.moments.values().map(Moment::size_bytes).sum();
        Keyframes(Arc::new(Mutex::new(kept)))
    }
}

/// Adds a keyframe of `world` if one is due, or after an action that a replay would miss.
pub fn keep_if_due(world: &mut World) {
    let Some(keyframes) = world.get_resource::<Keyframes>().cloned() else { return };
    let clock = *world.resource::<CycleClock>();
    let since = keyframes.last().map(|last| (clock.cycle.saturating_sub(last)) as f64 * clock.period_s);
    let is_changed = core::mem::take(&mut keyframes.kept().is_changed);
    if keyframes.fault().is_some() || (!is_changed && since.is_some_and(|since_s| since_s < INTERVAL_S - 1e-9)) {
        return;
    }
    let is_played_by_programs = world.query::<&Remote>().iter(world).next().is_some();
    let moment = if is_played_by_programs {
        Err(PROGRAMS.to_owned())
    } else {
        Moment::of(world).map_err(|error| error.to_string())
    };
    match moment {
        Ok(moment) => keyframes.keep(clock.cycle, moment),
        Err(fault) => keyframes.kept().fault = Some(fault),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn the_match_is_kept_every_few_seconds_and_goes_on_from_there_as_it_was() {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins).init_resource::<Keyframes>();
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        keep_if_due(app.world_mut());
        for _ in 0..320 {
            app.run_cycles(1);
            keep_if_due(app.world_mut());
        }
        let keyframes = app.world().resource::<Keyframes>().clone();
        assert_eq!((keyframes.last(), keyframes.before(299).map(|(cycle, _)| cycle)), (Some(300), Some(150)));
        let expected = app.ball();
        keyframes.before(310).unwrap().1.put_back(app.world_mut()).unwrap();
        assert_eq!((app.cycle(), app.run_cycles(20).ball()), (300, expected));
        // After a change by hand, a keyframe is stored at once.
        app.world().resource::<Keyframes>().note_change();
        keep_if_due(app.world_mut());
        assert_eq!(keyframes.last(), Some(320));
        assert_eq!((keyframes.until(200).last(), keyframes.last()), (Some(150), Some(320)));
    }
}
