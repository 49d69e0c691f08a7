//! Jumps to the next or previous event of a kind.

use bevy::prelude::*;

use super::mistake_list::{self, cycle_of, mistake_words};
use super::tracks::{BallSource, Condition, LaneTrack, Span};
use super::{FEW, Lanes};
use crate::viewer::commands::{FindEvent, TimelineCommand};
use crate::viewer::event_filter::ListedEvents;
use crate::viewer::event_log::{EventJump, LogEntry};
use crate::viewer::shared::{Notice, Playback, RobotsWorld, Selection};
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::{Mark, MarkKind};
use naoisis_record::record::mistakes::Mistake;

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

/// Goes to the event of the chosen kind that is next before or after the shown moment.
pub(super) fn find_event(
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

/// The cycles at which spans of `what` start.
fn begins<T: PartialEq>(spans: &[Span<T>], what: &T) -> impl Iterator<Item = u64> {
    spans.iter().filter(move |span| span.what == *what).map(|span| span.first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::lanes::tracks::Tracks;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::game::PenaltyReason;
    use naoisis_core::team::Team;
    use naoisis_record::record::mistakes::MistakeKind;
    use naoisis_sim::interface::cycle_record::{CycleRecord, GameRecord, PenaltyRecord, RobotRecord};
    use naoisis_sim::scenario::Scenario;

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
