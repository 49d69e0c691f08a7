//! Lanes: the whole match on one panel, one lane per robot with its intentions, the source of its ball estimate, its
//! kicks, falls, penalties and mistakes; and jumps to the next event of a kind.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use std::io;
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

mod looks;
mod mistake_list;
mod panel;
pub mod tracks;

use super::display_settings::DisplaySettings;
use super::event_filter::{EventFilter, ListedEvents};
use super::event_log::{EventJump, LogEntry};
use super::keyframes::{Keyframes, KeyframesName};
use super::layout::LayoutSystems;
use super::shared::{FindEvent, Notice, Playback, RobotsWorld, Selection, TimelineCommand};
use super::time_axis::ShownPart;
use super::timeline::Timeline;
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::{Mark, MarkKind};
use naoisis_record::record::mistakes::{Mistake, MistakeKind};
use naoisis_sim::interface::gather::{CurrentRecord, RecordSystems};
use naoisis_sim::scenario::Scenario;
use tracks::{BallSource, Condition, LaneTrack, Span, Tracks};

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
            .add_systems(Update, (read_records, mistake_list::tell_mistakes, find_event).chain())
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

/// The kinds of events to jump to.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum EventKind {
    /// Events of the list.
    #[default]
    Listed,
    /// Goals.
    Goal,
    /// Balls that left the pitch.
    Out,
    /// Penalties.
    Penalty,
    /// Kicks.
    Kick,
    /// Falls.
    Fall,
    /// A robot lost the ball from its belief.
    BallLost,
    /// A robot changed its intention.
    NewIntention,
    /// Mistakes.
    Mistake,
}

impl EventKind {
    /// All kinds with their names.
    pub const ALL: [(EventKind, &str); 9] = [
        (EventKind::Listed, "listed event"),
        (EventKind::Goal, "goal"),
        (EventKind::Out, "ball out"),
        (EventKind::Penalty, "penalty"),
        (EventKind::Kick, "kick"),
        (EventKind::Fall, "fall"),
        (EventKind::BallLost, "ball lost"),
        (EventKind::NewIntention, "new intention"),
        (EventKind::Mistake, "mistake"),
    ];

    /// Returns the name in the window.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
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

fn find_event(
    mut wanted: MessageReader<FindEvent>,
    mut lanes: ResMut<Lanes>,
    history: Res<History>,
    mut selection: ResMut<Selection>,
    (timeline, clock, listed): (Res<Timeline>, Res<CycleClock>, Option<Res<ListedEvents>>),
    world: Option<Res<RobotsWorld>>,
    mut playback: ResMut<Playback>,
    mut notice: ResMut<Notice>,
    (mut moments, mut jumps): (MessageWriter<TimelineCommand>, MessageWriter<EventJump>),
) {
    // A believed world that is shown stays that of its robot.
    let selects = !world.is_some_and(|world| world.0);
    for wanted in wanted.read() {
        let now = timeline.cursor().map_or(clock.cycle, |cursor| cursor.ceil() as u64);
        if let (EventKind::Listed, Some(listed)) = (lanes.kind, &listed) {
            match neighbour(&listed.entries, *wanted, now, clock.period_s) {
                Some(entry) => {
                    jumps.write(EventJump(Some(entry.clone())));
                    moments.write(TimelineCommand::GoTo(entry.shown_cycle(clock.period_s)));
                    playback.paused = true;
                    notice.tell(&entry.text);
                    if entry.robot.is_some() && selects {
                        (selection.0, lanes.followed) = (entry.robot, entry.robot);
                    }
                }
                None => notice.tell(format!("No listed event {} this moment", side_of(*wanted))),
            }
            continue;
        }
        lanes.is_wanted = true;
        if lanes.tracks.last_cycle().unwrap_or_default() + FEW < history.last_cycle().unwrap_or_default() {
            notice.tell("The match is still being read: please try again");
            continue;
        }
        // Only a robot that the user chose counts, not the robot of the last event.
        let chosen = selection.0.filter(|id| lanes.followed != Some(*id));
        let cycles = cycles_of(&lanes, &history, chosen, clock.period_s);
        let found = match wanted {
            FindEvent::Next => cycles.iter().find(|(cycle, _)| *cycle > now),
            FindEvent::Previous => cycles.iter().rev().find(|(cycle, _)| *cycle < now),
        };
        match found {
            Some((cycle, robot)) => {
                moments.write(TimelineCommand::GoTo(*cycle));
                playback.paused = true;
                if chosen.is_none() && robot.is_some() && selects {
                    (selection.0, lanes.followed) = (*robot, *robot);
                }
                let is_there = |mistake: &&Mistake| cycle_of(mistake, clock.period_s) == *cycle;
                let of_kind = lanes.tracks.mistakes().iter().filter(|_| lanes.kind == EventKind::Mistake);
                let mistake = of_kind.filter(|mistake| is_of(mistake, *robot)).find(is_there);
                let goals = mistake_list::goals_of(&history, clock.period_s);
                jumps.write(EventJump(mistake.map(|mistake| mistake_list::entry_of(mistake, &goals))));
                let of_robot = || robot.map_or_else(String::new, |robot| format!("{robot}: "));
                notice.tell(mistake.map_or_else(|| format!("{}{}", of_robot(), lanes.kind.name()), mistake_words));
            }
            None => {
                let whose = chosen.map_or_else(String::new, |id| format!(" of {id}"));
                notice.tell(format!("No {}{whose} {} this moment", lanes.kind.name(), side_of(*wanted)));
            }
        }
    }
}

fn side_of(wanted: FindEvent) -> &'static str {
    if wanted == FindEvent::Next { "after" } else { "before" }
}

/// The next or previous entry of a list (oldest first) relative to a cycle.
fn neighbour(entries: &[LogEntry], wanted: FindEvent, now: u64, period_s: f64) -> Option<&LogEntry> {
    let cycle = |entry: &LogEntry| entry.shown_cycle(period_s);
    match wanted {
        FindEvent::Next => entries.get(entries.partition_point(|entry| cycle(entry) <= now)),
        FindEvent::Previous => entries[..entries.partition_point(|entry| cycle(entry) < now)].last(),
    }
}

/// The cycles of the events of the chosen kind, in order, with their robots; only of `robot` if the kind is about
/// robots and one is selected.
fn cycles_of(lanes: &Lanes, history: &History, robot: Option<RobotId>, period_s: f64) -> Vec<(u64, Option<RobotId>)> {
    // In the cycle of a goal, ball and robots already stand at their places for the kick-off.
    let shown = |mark: &Mark| mark.cycle.saturating_sub(u64::from(mark.kind == MarkKind::Goal));
    let marks =
        |kind| history.marks().iter().filter(move |mark| mark.kind == kind).map(move |mark| (shown(mark), None));
    let is_meant = |id: RobotId| robot.is_none_or(|robot| robot == id);
    let of_tracks = |cycles: fn(&LaneTrack) -> Vec<u64>| {
        let tracks = lanes.tracks.robots().filter(|(id, _)| is_meant(*id));
        tracks.flat_map(move |(id, track)| cycles(track).into_iter().map(move |cycle| (cycle, Some(id)))).collect()
    };
    let mut cycles: Vec<(u64, Option<RobotId>)> = match lanes.kind {
        EventKind::Listed => Vec::new(),
        EventKind::Goal => marks(MarkKind::Goal).collect(),
        EventKind::Out => marks(MarkKind::Out).collect(),
        EventKind::Penalty => of_tracks(|track| begins(&track.conditions, &Condition::Penalised).collect()),
        EventKind::Fall => of_tracks(|track| begins(&track.conditions, &Condition::Down).collect()),
        EventKind::BallLost => of_tracks(|track| begins(&track.ball, &BallSource::Lost).collect()),
        EventKind::Kick => of_tracks(|track| track.kicks.iter().map(|(cycle, _)| *cycle).collect()),
        EventKind::NewIntention => of_tracks(|track| track.intentions.iter().skip(1).map(|span| span.first).collect()),
        EventKind::Mistake => {
            let of_robot = lanes.tracks.mistakes().iter().filter(|mistake| is_of(mistake, robot));
            of_robot.map(|mistake| (cycle_of(mistake, period_s), Some(mistake.robot))).collect()
        }
    };
    cycles.sort_unstable();
    // Of several events in one cycle, the first is kept.
    cycles.dedup_by_key(|(cycle, _)| *cycle);
    cycles
}

/// Whether a mistake is of `robot`, or `robot` is `None`.
fn is_of(mistake: &Mistake, robot: Option<RobotId>) -> bool {
    robot.is_none_or(|robot| mistake.robot == robot)
}

/// The cycle in which a mistake began.
fn cycle_of(mistake: &Mistake, period_s: f64) -> u64 {
    (mistake.from_s / period_s).round() as u64
}

/// A mistake in a line.
fn mistake_words(mistake: &Mistake) -> String {
    let joins = if mistake.kind == MistakeKind::BallGivenAway { "to" } else { "with" };
    let other = mistake.other.map_or_else(String::new, |other| format!(" {joins} {other}"));
    // The time of a pass to the other team says nothing about the mistake.
    let length_s = if mistake.kind == MistakeKind::BallGivenAway { 0.0 } else { mistake.until_s - mistake.from_s };
    let at_most = if length_s > 0.0 { "up to " } else { "" };
    let worst = mistake.worst.map_or_else(String::new, |worst| format!(", {at_most}{worst:.2} {}", mistake.unit()));
    let length = if length_s > 0.0 { format!(", for {length_s:.1} s") } else { String::new() };
    format!("{}: {}{other}{worst}{length}", mistake.robot, mistake.kind)
}

/// The cycles at which spans of `what` start.
fn begins<T: PartialEq>(spans: &[Span<T>], what: &T) -> impl Iterator<Item = u64> {
    spans.iter().filter(move |span| span.what == *what).map(|span| span.first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::game::PenaltyReason;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::{CycleRecord, GameRecord, PenaltyRecord, RobotRecord};

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);
    const PINK: RobotId = RobotId::new(Team::Pink, 1);

    #[test]
    fn the_next_listed_event_is_not_that_of_now() {
        let entry = |second: u32| LogEntry { time_s: f64::from(second), ..default() };
        let entries = [1, 2, 3].map(entry);
        let found = |wanted, now| neighbour(&entries, wanted, now, 0.1).map(|entry| entry.time_s);
        assert_eq!((found(FindEvent::Next, 20), found(FindEvent::Previous, 20)), (Some(3.0), Some(1.0)));
        assert_eq!((found(FindEvent::Next, 30), found(FindEvent::Previous, 10)), (None, None));
        assert_eq!((found(FindEvent::Next, 0), found(FindEvent::Previous, 99)), (Some(1.0), Some(3.0)));
    }

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

    #[test]
    fn events_are_found_by_kind_and_robot() {
        let (mut lanes, mut history) = (Lanes { kind: EventKind::Goal, ..default() }, History::default());
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
        assert_eq!(
            cycles_of(&lanes, &history, Some(PINK), 0.1),
            [(19, None)],
            "a goal is nobody's own, and shown before the kick-off"
        );
        lanes.kind = EventKind::Penalty;
        assert_eq!(cycles_of(&lanes, &history, None, 0.1), [(40, Some(BLUE)), (70, Some(PINK))]);
        assert_eq!(cycles_of(&lanes, &history, Some(PINK), 0.1), [(70, Some(PINK))]);
    }

    #[test]
    fn mistakes_are_found_and_said() {
        let scenario = Scenario::named("match3v3").unwrap();
        let (mut lanes, history) = (Lanes { tracks: Tracks::new(&scenario), ..default() }, History::default());
        lanes.kind = EventKind::Mistake;
        for cycle in 0..90_u64 {
            let missed = MatchEvent::Kick {
                robot: PINK,
                kick_type: naoisis_core::kick_geometry::KickType::LeftStraight,
                speed: Some(1.0),
                result: naoisis_core::events::KickResult::Missed,
                reason: Some(naoisis_core::events::KickMiss::OutOfReach),
                direction: None,
                launch_speed_mps: None,
            };
            let events = if cycle == 50 { vec![missed] } else { Vec::new() };
            let game = GameRecord { state: naoisis_core::game::GameState::Playing, ..default() };
            let time_s = cycle as f64 * 0.1;
            lanes.tracks.note(&CycleRecord { cycle, time_s, events, game, ..default() });
        }
        assert_eq!(cycles_of(&lanes, &history, Some(PINK), 0.1), [(50, Some(PINK))]);
        assert_eq!(cycles_of(&lanes, &history, Some(BLUE), 0.1), []);
        let mistake = lanes.tracks.mistakes()[0];
        assert_eq!(mistake_words(&mistake), "pink1: kick missed");
        let given_away = Mistake { kind: MistakeKind::BallGivenAway, other: Some(BLUE), ..mistake };
        assert_eq!(mistake_words(&given_away), "pink1: ball given away to blue1");
        let lost = |until_s| Mistake { kind: MistakeKind::BallMisplaced, worst: Some(0.6), until_s, ..mistake };
        let words = [mistake.from_s, mistake.from_s + 2.0].map(|until_s| mistake_words(&lost(until_s)));
        assert!(words[0].ends_with(", 0.60 m") && words[1].ends_with(", up to 0.60 m, for 2.0 s"), "{words:?}");
    }
}
