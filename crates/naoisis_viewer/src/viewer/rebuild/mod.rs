//! Rebuilds the whole state at any moment of the match by replaying it in the background.
//!
//! Records contain poses, perceptions, beliefs and commands, but not the memory of behaviours and the random numbers.
//! [`Keyframes`] have the whole state every few seconds, for matches and for traces. A thread replays the cycles from a
//! keyframe to the moment that is shown. The records show whether the replay is the same match; if it is not, because
//! behaviours have changed since, the window says so.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;

mod worker;

use super::behaviour_state::{BehaviourState, state_of};
use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::overlays::OverlaySystems;
use super::shared::{Playback, Selection};
use super::theme::tenths;
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::whatif::Moment;
use naoisis_sensing::sensing::vision::MissedObject;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::gather::CurrentRecord;
use naoisis_sim::scenario::Scenario;

/// Rebuilds moments in the background.
pub struct RebuildPlugin;

impl Plugin for RebuildPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Keyframes>()
            .init_resource::<Rebuilt>()
            .init_resource::<ShownState>()
            .add_systems(Update, (begin, add_records, ask, listen).chain().in_set(RebuildSystems))
            .add_systems(PostUpdate, read_state.before(OverlaySystems));
    }
}

/// The systems that request moments and receive them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RebuildSystems;

/// How far the match of a trace has been replayed.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum RebuildProgress {
    /// There is no trace to replay.
    #[default]
    Nothing,
    /// Until the end of this cycle; it is the same match.
    Until(u64),
    /// The match differs from this cycle on.
    Differs(u64),
    /// The match cannot be replayed, for this reason.
    Failed(String),
}

/// The whole state at a moment.
pub struct RebuiltMoment {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// The behaviour states of all robots.
    pub states: BTreeMap<RobotId, BehaviourState>,
    /// The objects that each robot did not recognise, as far as this is known.
    pub unrecognised: BTreeMap<RobotId, Vec<MissedObject>>,
    /// The match, to play on from.
    pub moment: Moment,
    /// The moment as a scenario, or why there is none.
    pub situation: Result<Scenario, String>,
    /// Whether all poses agree with the record of the cycle.
    pub is_same: bool,
    /// The keyframes that it was rebuilt from; these identify the match.
    keyframes: Keyframes,
}

/// The results of replays.
#[derive(Resource, Default)]
pub struct Rebuilt {
    /// How far the match of a trace has been replayed.
    pub progress: RebuildProgress,
    /// Whether the present is rebuilt, too, as the past is.
    pub wants_present: bool,
    latest: Option<RebuiltMoment>,
    thread: Option<Thread>,
    /// The match of the results.
    of: Keyframes,
    /// The cycle of the last request.
    asked: Option<u64>,
    /// The last cycle of the records of a trace that the thread has.
    records_until: Option<u64>,
}

impl Rebuilt {
    /// Returns the state after a cycle of the match that is shown, if it has been rebuilt.
    pub fn moment(&self, cycle: u64, keyframes: &Keyframes) -> Option<&RebuiltMoment> {
        let moment = self.latest.as_ref()?;
        (moment.cycle == cycle && moment.keyframes.is_same(keyframes)).then_some(moment)
    }

    /// Returns the behaviour states of the moment that was rebuilt last.
    pub fn latest_states(&self) -> impl Iterator<Item = &BehaviourState> {
        self.latest.iter().flat_map(|moment| moment.states.values())
    }
}

impl Rebuilt {
    /// Returns the reason if the state at a time of the match will not be rebuilt.
    pub fn why_not(&self, clock: &CycleClock, keyframes: &Keyframes) -> Option<String> {
        if let Some(fault) = keyframes.fault() {
            return Some(format!("Not known: {fault}."));
        }
        match &self.progress {
            RebuildProgress::Failed(message) => Some(format!("Not known: {message}.")),
            RebuildProgress::Differs(from) if clock.cycle >= *from => Some(format!(
                "Played again, the match is another one from {} on: its behaviours or the program have changed since, \
                 or something was done to it by hand. Shown is what the trace has.",
                time_of(*from, clock)
            )),
            _ => None,
        }
    }
}

/// The behaviour state of the selected robot at the moment that is shown, or why it is not known.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct ShownState(pub Result<BehaviourState, String>);

impl Default for ShownState {
    fn default() -> Self {
        Self(Ok(BehaviourState::default()))
    }
}

/// The thread that replays matches until its channel is dropped.
struct Thread {
    requests: Sender<Request>,
    replies: Mutex<Receiver<Reply>>,
}

/// A request to the thread.
enum Request {
    /// Replay the match of a trace, in place of any other.
    Play(Box<PlayAgain>),
    /// Replay the match of the trace further: these are all its records so far.
    More(History),
    /// Rebuild a moment, in place of any other.
    Rebuild(Box<Wanted>),
    /// Cancel everything.
    Forget,
}

/// The match of a trace.
struct PlayAgain {
    scenario: Scenario,
    records: History,
    fields: Fields,
    keyframes: Keyframes,
}

/// A moment of a match.
struct Wanted {
    cycle: u64,
    /// The record of its cycle.
    record: CycleRecord,
    fields: Fields,
    keyframes: Keyframes,
}

/// A reply of the thread.
enum Reply {
    /// The match of the trace has been replayed until the end of this cycle.
    PlayedAgain(u64),
    /// The replay differs from this cycle on.
    Differs(u64),
    /// A moment has been rebuilt.
    Moment(Box<RebuiltMoment>),
    /// Rebuilding failed, and why.
    Failed(String),
}

impl Thread {
    fn begin(simulator: &Simulator) -> std::io::Result<Self> {
        let ((requests, asked), (said, replies)) = (mpsc::channel(), mpsc::channel());
        let make = simulator.0;
        thread::Builder::new().name("rebuild".to_owned()).spawn(move || worker::serve(make, &asked, &said))?;
        Ok(Self { requests, replies: Mutex::new(replies) })
    }
}

impl Rebuilt {
    fn ask(&mut self, simulator: &Simulator, request: Request) {
        if self.thread.is_none() {
            match Thread::begin(simulator) {
                Ok(thread) => self.thread = Some(thread),
                Err(error) => self.progress = RebuildProgress::Failed(error.to_string()),
            }
        }
        if let Some(thread) = &self.thread
            && thread.requests.send(request).is_err()
        {
            self.progress = RebuildProgress::Failed("the match could not be replayed".to_owned());
        }
    }
}

/// Drops results of another match, and starts replaying the match of a trace.
fn begin(
    timeline: Res<Timeline>,
    keyframes: Res<Keyframes>,
    history: Res<History>,
    simulator: Option<Res<Simulator>>,
    mut rebuilt: ResMut<Rebuilt>,
) {
    let Some(simulator) = simulator.filter(|_| !rebuilt.of.is_same(&keyframes)) else { return };
    rebuilt.of = keyframes.clone();
    rebuilt.asked = None;
    rebuilt.records_until = history.last_cycle();
    rebuilt.progress = RebuildProgress::Nothing;
    if let Some(scenario) = timeline.trace_scenario() {
        rebuilt.progress = RebuildProgress::Until(0);
        let play = PlayAgain {
            scenario: scenario.clone(),
            records: history.clone(),
            fields: timeline.fields().clone(),
            keyframes: keyframes.clone(),
        };
        rebuilt.ask(&simulator, Request::Play(Box::new(play)));
    } else if rebuilt.thread.is_some() {
        rebuilt.ask(&simulator, Request::Forget);
    }
}

/// Passes on the records of a trace that have been read since, while the others are shown.
fn add_records(timeline: Res<Timeline>, history: Res<History>, mut rebuilt: ResMut<Rebuilt>) {
    let is_more = history.last_cycle() > rebuilt.records_until;
    if is_more && timeline.is_replay() && matches!(rebuilt.progress, RebuildProgress::Until(_)) {
        rebuilt.records_until = history.last_cycle();
        if let Some(thread) = &rebuilt.thread {
            // If the thread has ended, its last reply says why.
            let _nobody_listens = thread.requests.send(Request::More(history.clone()));
        }
    }
}

/// Requests the moment that is shown, if it is in the past or the present is wanted.
fn ask(
    timeline: Res<Timeline>,
    keyframes: Res<Keyframes>,
    clock: Res<CycleClock>,
    current: Res<CurrentRecord>,
    simulator: Option<Res<Simulator>>,
    mut rebuilt: ResMut<Rebuilt>,
) {
    let Some(simulator) = simulator.filter(|_| timeline.is_past() || rebuilt.wants_present) else { return };
    let cycle = clock.cycle;
    let is_asked = rebuilt.asked == Some(cycle);
    let is_beyond = matches!(rebuilt.progress, RebuildProgress::Differs(from) if cycle >= from);
    if is_asked || is_beyond || keyframes.fault().is_some() || matches!(rebuilt.progress, RebuildProgress::Failed(_)) {
        return;
    }
    rebuilt.asked = Some(cycle);
    let record = current.record.clone();
    let wanted = Wanted { cycle, record, fields: timeline.fields().clone(), keyframes: keyframes.clone() };
    rebuilt.ask(&simulator, Request::Rebuild(Box::new(wanted)));
}

fn listen(mut rebuilt: ResMut<Rebuilt>) {
    let Some(thread) = &rebuilt.thread else { return };
    let replies: Vec<Reply> = thread.replies.lock().unwrap_or_else(PoisonError::into_inner).try_iter().collect();
    for reply in replies {
        match reply {
            Reply::PlayedAgain(cycle) => rebuilt.progress = RebuildProgress::Until(cycle),
            Reply::Differs(cycle) => rebuilt.progress = RebuildProgress::Differs(cycle),
            Reply::Failed(message) => rebuilt.progress = RebuildProgress::Failed(message),
            Reply::Moment(moment) => rebuilt.latest = Some(*moment),
        }
    }
}

/// Reads the behaviour state of the selected robot: of the present from the world, of the past from the rebuilt moment.
fn read_state(world: &mut World) {
    let shown = world.resource::<DisplaySettings>().robot;
    let Some(id) = world.resource::<Selection>().0.filter(|_| shown) else { return };
    let timeline = world.resource::<Timeline>();
    let state = if timeline.is_past() {
        let (rebuilt, keyframes) = (world.resource::<Rebuilt>(), world.resource::<Keyframes>());
        let clock = world.resource::<CycleClock>();
        let moment = rebuilt.moment(clock.cycle, keyframes);
        // While the past is being played, the last rebuilt moment is near enough.
        let moment = if world.resource::<Playback>().paused { moment } else { moment.or(rebuilt.latest.as_ref()) };
        match moment {
            Some(moment) if moment.is_same => Ok(moment.states.get(&id).cloned().unwrap_or_default()),
            Some(_) => Err(OTHER_MATCH.to_owned()),
            None => Err(why_unknown(rebuilt, clock, keyframes, world.contains_resource::<Simulator>())),
        }
    } else {
        let robot = world.resource::<Roster>().get(id);
        Ok(robot.map(|robot| state_of(world, robot)).unwrap_or_default())
    };
    world.resource_mut::<ShownState>().set_if_neq(ShownState(state));
}

/// Why the state of a moment is not known, if a match was changed by hand.
pub(super) const OTHER_MATCH: &str = "The replayed match differs here: it was changed by hand, or a robot was driven.";

/// Why the state of a moment is not known.
pub(super) fn why_unknown(rebuilt: &Rebuilt, clock: &CycleClock, keyframes: &Keyframes, can_play: bool) -> String {
    if !can_play {
        return "This program cannot replay the match.".to_owned();
    }
    rebuilt.why_not(clock, keyframes).unwrap_or_else(|| match &rebuilt.progress {
        RebuildProgress::Until(until) if clock.cycle > *until => {
            format!("Replaying the match up to here: at {}…", time_of(*until, clock))
        }
        _ => "Rebuilding this moment…".to_owned(),
    })
}

/// The time at the end of a cycle, as the clock shows it.
fn time_of(cycle: u64, clock: &CycleClock) -> String {
    tenths(CycleClock { cycle, ..*clock }.end_time_s())
}

#[cfg(test)]
mod tests;
