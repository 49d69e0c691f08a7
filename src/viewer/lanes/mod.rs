//! Lanes: the whole match at a glance, a lane for each robot: what it meant to do, from what it knew of the ball, its kicks, falls
//! and penalties; a number of all robots as curves; and the way to the next event of a kind.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use std::io;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

mod panel;
pub mod tracks;

use super::camera::Covered;
use super::display_settings::DisplaySettings;
use super::keyframes::Keyframes;
use super::shared::{FindEvent, Notice, Playback, Selection, TimelineCommand};
use super::theme::ThemeSystems;
use super::timeline::Timeline;
use crate::cycle::{Cycle, CycleClock};
use crate::record::gather::{CurrentRecord, RecordSystems};
use crate::record::history::{History, MarkKind};
use crate::team::RobotId;
use tracks::{BallSource, Condition, Number, Span, Tracks};

/// The part of a frame in which the few records are read that came while a thread read the others.
const BUDGET: Duration = Duration::from_millis(2);
/// More cycles than this are read by a thread.
const FEW: u64 = 60;

/// Keeps and shows the [`Lanes`].
pub struct LanesPlugin;

impl Plugin for LanesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Lanes>()
            .add_message::<FindEvent>()
            .add_systems(Cycle, note_cycle.in_set(RecordSystems::Keep))
            .add_systems(Update, (read_records, find_event).chain())
            .add_systems(
                EguiPrimaryContextPass,
                (panel::show.run_if(is_open), uncover.run_if(not(is_open))).after(ThemeSystems),
            );
    }
}

fn is_open(display: Res<DisplaySettings>) -> bool {
    display.lanes
}

fn uncover(mut covered: ResMut<Covered>) {
    if covered.below != 0.0 {
        covered.below = 0.0;
    }
}

/// What is known of the whole match, and which part of it is looked at.
#[derive(Resource, Debug, Default)]
pub struct Lanes {
    /// What robots did.
    pub tracks: Tracks,
    /// The match that it is of.
    keyframes: Keyframes,
    /// What a thread has read, when it has.
    read: Option<Mutex<Receiver<Tracks>>>,
    /// The first and the last cycle that is shown; the whole match without.
    pub part: Option<[f64; 2]>,
    /// The number that is plotted, if one is.
    pub number: Option<Number>,
    /// The kind of events that is gone to.
    pub kind: EventKind,
}

/// What one may want to find in a match.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum EventKind {
    /// A goal.
    #[default]
    Goal,
    /// The ball left the pitch.
    Out,
    /// A robot was penalised.
    Penalty,
    /// A robot kicked.
    Kick,
    /// A robot fell.
    Fall,
    /// A robot no longer knew where the ball was.
    BallLost,
    /// A robot meant to do something else than before.
    NewIntention,
}

impl EventKind {
    /// All of them, each with its name.
    pub const ALL: [(EventKind, &str); 7] = [
        (EventKind::Goal, "goal"),
        (EventKind::Out, "ball out"),
        (EventKind::Penalty, "penalty"),
        (EventKind::Kick, "kick"),
        (EventKind::Fall, "fall"),
        (EventKind::BallLost, "ball lost"),
        (EventKind::NewIntention, "new intention"),
    ];

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }
}

/// What is played is taken in as it is.
fn note_cycle(mut lanes: ResMut<Lanes>, current: Res<CurrentRecord>) {
    let cycle = current.record.cycle;
    // Where something is missing before it, records are read first.
    if lanes.tracks.last_cycle().map_or(0, |last| last + 1) == cycle {
        lanes.tracks.note(&current.record);
    }
}

/// Records of what nobody has taken in are read while they are looked at: many by a thread, a few here.
fn read_records(
    mut lanes: ResMut<Lanes>,
    mut history: ResMut<History>,
    keyframes: Res<Keyframes>,
    display: Res<DisplaySettings>,
) {
    if !lanes.keyframes.is_same(&keyframes) {
        let (number, kind) = (lanes.number, lanes.kind);
        *lanes = Lanes { keyframes: keyframes.clone(), number, kind, ..default() };
    }
    let Some(last) = history.last_cycle().filter(|_| display.lanes) else { return };
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
        let _nobody_waits = sender.send(tracks);
    })?;
    Ok(receiver)
}

fn find_event(
    mut wanted: MessageReader<FindEvent>,
    lanes: Res<Lanes>,
    history: Res<History>,
    selection: Res<Selection>,
    timeline: Res<Timeline>,
    clock: Res<CycleClock>,
    mut playback: ResMut<Playback>,
    mut notice: ResMut<Notice>,
    mut moments: MessageWriter<TimelineCommand>,
) {
    for wanted in wanted.read() {
        let cycles = cycles_of(&lanes, &history, selection.0);
        let now = timeline.cursor().map_or(clock.cycle, |cursor| cursor.ceil() as u64);
        let found = match wanted {
            FindEvent::Next => cycles.iter().find(|cycle| **cycle > now),
            FindEvent::Previous => cycles.iter().rev().find(|cycle| **cycle < now),
        };
        match found {
            Some(cycle) => {
                moments.write(TimelineCommand::GoTo(*cycle));
                playback.paused = true;
            }
            None => {
                let whose = selection.0.map_or_else(String::new, |id| format!(" of {id}"));
                let side = if *wanted == FindEvent::Next { "after" } else { "before" };
                notice.tell(format!("No {}{whose} {side} this moment", lanes.kind.name()));
            }
        }
    }
}

/// The cycles of the events of the chosen kind, in order: of a robot, if one is selected and the kind is about robots.
fn cycles_of(lanes: &Lanes, history: &History, robot: Option<RobotId>) -> Vec<u64> {
    let marks = |kind| history.marks().iter().filter(move |mark| mark.kind == kind).map(|mark| mark.cycle);
    let tracks =
        || lanes.tracks.robots().filter(|(id, _)| robot.is_none_or(|robot| robot == *id)).map(|(_, track)| track);
    let mut cycles: Vec<u64> = match lanes.kind {
        EventKind::Goal => marks(MarkKind::Goal).collect(),
        EventKind::Out => marks(MarkKind::Out).collect(),
        EventKind::Penalty => tracks().flat_map(|track| begins(&track.conditions, &Condition::Penalised)).collect(),
        EventKind::Fall => tracks().flat_map(|track| begins(&track.conditions, &Condition::Down)).collect(),
        EventKind::BallLost => tracks().flat_map(|track| begins(&track.ball, &BallSource::Lost)).collect(),
        EventKind::Kick => tracks().flat_map(|track| track.kicks.iter().map(|(cycle, _)| *cycle)).collect(),
        EventKind::NewIntention => {
            tracks().flat_map(|track| track.intentions.iter().skip(1).map(|span| span.first)).collect()
        }
    };
    cycles.sort_unstable();
    cycles.dedup();
    cycles
}

/// When something began to be so.
fn begins<T: PartialEq>(spans: &[Span<T>], what: &T) -> impl Iterator<Item = u64> {
    spans.iter().filter(move |span| span.what == *what).map(|span| span.first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::MatchEvent;
    use crate::game::PenaltyReason;
    use crate::record::cycle_record::{CycleRecord, PenaltyRecord, RobotRecord};
    use crate::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);
    const PINK: RobotId = RobotId::new(Team::Pink, 1);

    #[test]
    fn events_are_found_by_kind_and_robot() {
        let (mut lanes, mut history) = (Lanes::default(), History::default());
        for cycle in 0..=100 {
            let penalised = |since: u64| {
                (cycle >= since).then_some(PenaltyRecord { reason: PenaltyReason::Manual, time_left_s: 1.0 })
            };
            let robots = vec![
                RobotRecord { penalised: penalised(40), ..RobotRecord::new(BLUE) },
                RobotRecord { penalised: penalised(70), ..RobotRecord::new(PINK) },
            ];
            let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
            let events = if cycle == 20 { vec![goal] } else { Vec::new() };
            let record = CycleRecord { cycle, robots, events, ..default() };
            history.push(&record).unwrap();
            lanes.tracks.note(&record);
        }
        assert_eq!(cycles_of(&lanes, &history, Some(PINK)), [20], "a goal is nobody's own");
        lanes.kind = EventKind::Penalty;
        assert_eq!(cycles_of(&lanes, &history, None), [40, 70]);
        assert_eq!(cycles_of(&lanes, &history, Some(PINK)), [70]);
    }
}
