//! Lanes: the whole match on one panel, one lane per robot with its intentions, the source of its ball estimate, its
//! kicks, falls, penalties and mistakes; and jumps to the next event of a kind.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use std::io;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

mod find_event;
mod looks;
mod mistake_list;
mod panel;
pub mod tracks;

use super::commands::FindEvent;
use super::display_settings::DisplaySettings;
use super::event_filter::EventFilter;
use super::keyframes::{Keyframes, KeyframesName};
use super::layout::LayoutSystems;
use super::time_axis::ShownPart;
pub use find_event::EventKind;
use naoisis_core::cycle::Cycle;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sim::interface::gather::{CurrentRecord, RecordSystems};
use naoisis_sim::scenario::Scenario;
use tracks::Tracks;

/// The part of a frame in which a few records are read that were added while a thread read the others.
const BUDGET: Duration = Duration::from_millis(2);
/// From this number of cycles on, records are read by a thread.
const FEW: u64 = 60;

/// Keeps and shows the [`Lanes`].
pub struct LanesPlugin;

impl Plugin for LanesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Lanes>()
            .init_resource::<ShownPart>()
            .add_message::<FindEvent>()
            .add_systems(Cycle, note_cycle.in_set(RecordSystems::Keep))
            .add_systems(Update, (read_records, mistake_list::tell_mistakes, find_event::find_event).chain())
            .add_systems(EguiPrimaryContextPass, panel::show.run_if(is_open).in_set(LayoutSystems::Lanes));
    }
}

fn is_open(display: Res<DisplaySettings>) -> bool {
    display.lanes
}

/// The data of the lanes.
#[derive(Resource, Debug, Default)]
pub struct Lanes {
    /// The activities of robots.
    pub tracks: Tracks,
    /// The match of the data.
    keyframes: Keyframes,
    /// The data of other matches that can be shown again: branches, and the match before.
    others: Vec<(KeyframesName, Tracks)>,
    /// The result of the thread, once it has finished.
    read: Option<Mutex<Receiver<Tracks>>>,
    /// Whether an event was asked for while the lanes were closed.
    is_wanted: bool,
    /// The kind of events to jump to.
    pub kind: EventKind,
    /// The robot that was selected by a jump to one of its events. The next event may be another robot's.
    followed: Option<RobotId>,
}

impl Lanes {
    /// Returns whether the match is still being read.
    pub fn is_reading(&self) -> bool {
        self.read.is_some()
    }

    /// Reads the match for its mistakes, also while the lanes are closed.
    pub fn want_mistakes(&mut self) {
        self.is_wanted = true;
    }

    /// Returns whether records until `last` have not been read: mistakes are missing.
    pub fn is_behind(&self, last: u64) -> bool {
        self.is_reading() || self.tracks.last_cycle().unwrap_or_default() + FEW < last
    }

    /// Takes the data of another match, if it was shown before, and keeps those of this one as long as it can be shown again.
    fn change_match(&mut self, keyframes: &Keyframes, scenario: &Scenario) {
        let tracks = core::mem::replace(&mut self.tracks, Tracks::new(scenario));
        if !self.is_reading() {
            self.others.push((self.keyframes.name(), tracks));
        }
        self.keyframes = keyframes.clone();
        self.others.retain(|(of, _)| of.is_kept());
        if let Some(index) = self.others.iter().position(|(of, _)| of.is_of(keyframes)) {
            self.tracks = self.others.swap_remove(index).1;
        }
        (self.read, self.is_wanted, self.followed) = (None, false, None);
    }
}

/// Adds each cycle as it is played.
fn note_cycle(mut lanes: ResMut<Lanes>, keyframes: Res<Keyframes>, current: Res<CurrentRecord>) {
    let cycle = current.record.cycle;
    // If earlier cycles are still missing, their records are read first.
    if lanes.keyframes.is_same(&keyframes) && lanes.tracks.last_cycle().map_or(0, |last| last + 1) == cycle {
        lanes.tracks.note(&current.record);
    }
}

/// Reads records that have not been added, while the lanes are shown: many by a thread, a few here.
fn read_records(
    mut lanes: ResMut<Lanes>,
    mut history: ResMut<History>,
    keyframes: Res<Keyframes>,
    scenario: Option<Res<Scenario>>,
    (display, filter): (Res<DisplaySettings>, Option<Res<EventFilter>>),
    mut part: ResMut<ShownPart>,
) {
    let Some(scenario) = scenario else { return };
    if !lanes.keyframes.is_same(&keyframes) {
        lanes.change_match(&keyframes, &scenario);
        part.0 = None;
    }
    let is_wanted =
        display.lanes || display.decided || lanes.is_wanted || filter.is_some_and(|filter| filter.has_mistakes());
    let Some(last) = history.last_cycle().filter(|_| is_wanted) else { return };
    let next = |tracks: &Tracks| tracks.last_cycle().map_or(0, |last| last + 1);
    if let Some(read) = &lanes.read {
        let tracks = read.lock().unwrap_or_else(PoisonError::into_inner).try_recv();
        match tracks {
            Ok(tracks) => (lanes.tracks, lanes.read) = (tracks, None),
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => lanes.read = None,
        }
    }
    if next(&lanes.tracks) + FEW <= last {
        lanes.read = read_by_thread(lanes.tracks.clone(), history.clone()).ok().map(Mutex::new);
        return;
    }
    let started = Instant::now();
    while next(&lanes.tracks) <= last && started.elapsed() < BUDGET {
        let Ok(Some(record)) = history.record(next(&lanes.tracks)) else { return };
        lanes.tracks.note(&record);
    }
}

fn read_by_thread(mut tracks: Tracks, mut history: History) -> io::Result<Receiver<Tracks>> {
    let (sender, receiver) = mpsc::channel();
    thread::Builder::new().name("lanes".to_owned()).spawn(move || {
        while let Ok(Some(record)) = history.record(tracks.last_cycle().map_or(0, |last| last + 1)) {
            tracks.note(&record);
        }
        tracks.gather_mistakes();
        let _nobody_waits = sender.send(tracks);
    })?;
    Ok(receiver)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::interface::cycle_record::CycleRecord;

    #[test]
    fn lanes_of_a_match_that_is_shown_again_need_not_be_read_again() {
        let scenario = Scenario::named("match3v3").unwrap();
        let (here, branch) = (Keyframes::default(), Keyframes::default());
        let mut lanes = Lanes { tracks: Tracks::new(&scenario), keyframes: here.clone(), ..default() };
        lanes.tracks.note(&CycleRecord { cycle: 500, ..default() });
        lanes.change_match(&branch, &scenario);
        assert_eq!((lanes.tracks.last_cycle(), lanes.is_behind(500)), (None, true));
        lanes.change_match(&here, &scenario);
        assert_eq!((lanes.tracks.last_cycle(), lanes.is_behind(500)), (Some(500), false));
        // Those of a match that nothing else keeps are forgotten.
        lanes.change_match(&branch, &scenario);
        drop(here);
        lanes.change_match(&Keyframes::default(), &scenario);
        assert_eq!(lanes.others.len(), 1, "the branch");
    }
}
