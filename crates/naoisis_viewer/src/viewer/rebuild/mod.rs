//! Any moment of the match that is shown, whole: what its records leave out is played again in the background.
//!
//! Records say where everybody was, what robots perceived, believed and wanted. What their behaviours kept in mind, and chance,
//! they do not. Of a match that is played here, and of one that a trace was written of, every few seconds is kept whole
//! ([`Keyframes`]), and the cycles from there to the moment that is looked at are played again, in a thread of its own. That it is
//! the same match is seen by its records; where it is another one, because behaviours have changed since, that is said.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;

mod worker;

pub(super) use worker::is_same;

use super::behaviour_state::{BehaviourState, state_of};
use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::overlays::OverlaySystems;
use super::shared::{Playback, Selection};
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::whatif::Moment;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::gather::CurrentRecord;
use naoisis_sim::scenario::Scenario;

/// Plays matches again.
pub struct RebuildPlugin;

impl Plugin for RebuildPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Keyframes>()
            .init_resource::<Rebuilt>()
            .init_resource::<ShownState>()
            .add_systems(Update, (begin, ask, listen).chain().in_set(RebuildSystems))
            .add_systems(PostUpdate, read_state.before(OverlaySystems));
    }
}

/// The systems that ask for moments and hear of them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RebuildSystems;

/// How far a trace's match has been played again.
#[derive(Clone, PartialEq, Debug, Default)]
pub enum RebuildProgress {
    /// There is nothing to play.
    #[default]
    Nothing,
    /// Until the end of this cycle; it is the same match.
    Until(u64),
    /// From this cycle on it is another match.
    Differs(u64),
    /// It cannot be, and why.
    Failed(String),
}

/// A moment of the match, whole.
pub struct RebuiltMoment {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// What all robots' behaviours kept in mind.
    pub states: BTreeMap<RobotId, BehaviourState>,
    /// The match, to go on from there.
    pub moment: Moment,
    /// The moment as a scenario, or why there is none.
    pub situation: Result<Scenario, String>,
    /// Whether everybody is where the record of that cycle says.
    pub is_same: bool,
    /// What it was played from: moments of another match have others.
    keyframes: Keyframes,
}

/// What is known of the match from playing it again.
#[derive(Resource, Default)]
pub struct Rebuilt {
    /// How far a trace's match has been played again.
    pub progress: RebuildProgress,
    latest: Option<RebuiltMoment>,
    thread: Option<Thread>,
    /// The match that this is known of, by what is kept of it.
    of: Keyframes,
    /// The cycle that was asked for last.
    asked: Option<u64>,
}

impl Rebuilt {
    /// The moment after a cycle of the match that is shown, if it has been rebuilt.
    pub fn moment(&self, cycle: u64, keyframes: &Keyframes) -> Option<&RebuiltMoment> {
        let moment = self.latest.as_ref()?;
        (moment.cycle == cycle && moment.keyframes.is_same(keyframes)).then_some(moment)
    }

    /// What behaviours kept in mind at the moment that was rebuilt last.
    pub fn latest_states(&self) -> impl Iterator<Item = &BehaviourState> {
        self.latest.iter().flat_map(|moment| moment.states.values())
    }
}

impl Rebuilt {
    /// Why the moment after a cycle of the match that is shown will not be rebuilt, if so.
    pub fn why_not(&self, cycle: u64, keyframes: &Keyframes) -> Option<String> {
        if let Some(fault) = keyframes.fault() {
            return Some(format!("Not known: {fault}."));
        }
        match &self.progress {
            RebuildProgress::Failed(message) => Some(format!("Not known: {message}.")),
            RebuildProgress::Differs(from) if cycle >= *from => Some(format!(
                "Played again, the match is another one from cycle {from} on: its behaviours or the program have changed since, \
                 or something was done to it by hand. Shown is what the trace has."
            )),
            _ => None,
        }
    }
}

/// The state of the selected robot's behaviour at the moment that is shown, or why it is not known.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct ShownState(pub Result<BehaviourState, String>);

impl Default for ShownState {
    fn default() -> Self {
        Self(Ok(BehaviourState::default()))
    }
}

/// A thread that plays matches again, for as long as it is listened to.
struct Thread {
    requests: Sender<Request>,
    replies: Mutex<Receiver<Reply>>,
}

/// What the thread is asked for.
enum Request {
    /// To play a trace's match again, in place of any other.
    Play(Box<PlayAgain>),
    /// A moment, in place of any other.
    Rebuild(Box<Wanted>),
    /// Nothing any more.
    Forget,
}

/// A match of which a trace was written.
struct PlayAgain {
    scenario: Scenario,
    records: History,
    fields: Fields,
    keyframes: Keyframes,
}

/// A moment of a match.
struct Wanted {
    cycle: u64,
    /// What the match was like then.
    record: CycleRecord,
    fields: Fields,
    keyframes: Keyframes,
}

/// What the thread says.
enum Reply {
    /// A trace's match has been played until the end of this cycle.
    PlayedAgain(u64),
    /// It is another match from this cycle on.
    Differs(u64),
    /// A moment that was asked for.
    Moment(Box<RebuiltMoment>),
    /// It cannot be, and why.
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
            self.progress = RebuildProgress::Failed("the match could not be played again".to_owned());
        }
    }
}

/// Of another match nothing is known; that of a trace is played again, from its start.
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

/// Asks for the moment that is shown, if it is past.
fn ask(
    timeline: Res<Timeline>,
    keyframes: Res<Keyframes>,
    clock: Res<CycleClock>,
    current: Res<CurrentRecord>,
    simulator: Option<Res<Simulator>>,
    mut rebuilt: ResMut<Rebuilt>,
) {
    let Some(simulator) = simulator.filter(|_| timeline.is_past()) else { return };
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

/// The state of the selected robot's behaviour: of the present from the world, of the past from its moment.
fn read_state(world: &mut World) {
    let shown = world.resource::<DisplaySettings>().robot;
    let Some(id) = world.resource::<Selection>().0.filter(|_| shown) else { return };
    let timeline = world.resource::<Timeline>();
    let state = if timeline.is_past() {
        let (rebuilt, keyframes) = (world.resource::<Rebuilt>(), world.resource::<Keyframes>());
        let cycle = world.resource::<CycleClock>().cycle;
        let moment = rebuilt.moment(cycle, keyframes);
        // While the past plays, that of a moment ago is near enough.
        let moment = if world.resource::<Playback>().paused { moment } else { moment.or(rebuilt.latest.as_ref()) };
        match moment {
            Some(moment) if moment.is_same => Ok(moment.states.get(&id).cloned().unwrap_or_default()),
            Some(_) => Err(OTHER_MATCH.to_owned()),
            None => Err(why_unknown(rebuilt, cycle, keyframes, world.contains_resource::<Simulator>())),
        }
    } else {
        let robot = world.resource::<Roster>().get(id);
        Ok(robot.map(|robot| state_of(world, robot)).unwrap_or_default())
    };
    world.resource_mut::<ShownState>().set_if_neq(ShownState(state));
}

const OTHER_MATCH: &str = "Played again, the match is another one here: it was changed by hand, or a robot was driven.";

/// Why the state of a moment is not known.
fn why_unknown(rebuilt: &Rebuilt, cycle: u64, keyframes: &Keyframes, can_play: bool) -> String {
    if !can_play {
        return "This program cannot play the match again.".to_owned();
    }
    rebuilt.why_not(cycle, keyframes).unwrap_or_else(|| match &rebuilt.progress {
        RebuildProgress::Until(until) if cycle > *until => {
            format!("The match is played again to here: at cycle {until}…")
        }
        _ => "This moment is played again…".to_owned(),
    })
}

#[cfg(test)]
mod tests;
