//! The timeline: shows the past of a match or of a trace.
//!
//! A record of every cycle is kept ([`History`]). To show an earlier cycle, the match is paused, its present is stored,
//! and the record is put into the world; everything that shows the match then shows that cycle. Before the next cycle
//! runs, the present is restored bit for bit, so looking back changes nothing.
//!
//! A replay is a match without a present: its records come from a file, and its robots decide nothing.

use bevy::prelude::*;
use bevy::time::TimeSystems;

mod present;

use super::commands::TimelineCommand;
use super::event_log::EventLog;
use super::keyframes::Keyframes;
use super::shared::{DisplayFraction, Playback, replace_match};
use super::speed::Speed;
use naoisis_core::cycle::{Cycle, CycleClock, PendingHalf};
use naoisis_record::record::RecordPlugin;
use naoisis_record::record::history::{History, HistoryError};
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::gather::{CurrentRecord, RecordSystems, RecordedMatch};
use naoisis_sim::scenario::{BehaviourSpec, Scenario, ScenarioFault};
use naoisis_sim::simulation;
use present::{Present, put_record};

/// The factor to real time at which the past is shown at unlimited speed.
const FASTEST: f64 = 64.0;

/// Keeps the [`History`] and shows the past.
pub struct TimelinePlugin;

impl Plugin for TimelinePlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<RecordPlugin>() {
            app.add_plugins(RecordPlugin);
        }
        app.init_resource::<History>()
            .init_resource::<CurrentRecord>()
            .init_resource::<Timeline>()
            .init_resource::<Keyframes>()
            .add_message::<TimelineCommand>()
            .add_systems(Cycle, keep_cycle.in_set(RecordSystems::Keep))
            .add_systems(First, (keep_start, handle_timeline_commands).chain().before(TimeSystems))
            .add_systems(RunFixedMainLoop, play_past.in_set(TimelineSystems));
    }
}

/// The system that plays the past.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TimelineSystems;

/// The moment of the match that is shown.
#[derive(Resource, Default, Debug)]
pub struct Timeline {
    /// The moment in cycles since the start; `None` for the present.
    cursor: Option<f64>,
    /// The cycle whose record is in the world.
    shown: Option<u64>,
    /// The stored present.
    present: Option<Box<Present>>,
    /// The scenario of the trace that is shown, if any.
    trace_scenario: Option<Box<Scenario>>,
    /// The parts that the records contain.
    fields: Fields,
}

impl Timeline {
    /// Returns whether the past is shown.
    pub fn is_past(&self) -> bool {
        self.cursor.is_some()
    }

    /// Returns the moment that is shown, in cycles since the start; `None` for the present.
    pub fn cursor(&self) -> Option<f64> {
        self.cursor
    }

    /// Returns whether a trace is shown and no match is played.
    pub fn is_replay(&self) -> bool {
        self.trace_scenario.is_some()
    }

    /// Returns the scenario of the trace that is shown, if any.
    pub fn trace_scenario(&self) -> Option<&Scenario> {
        self.trace_scenario.as_deref()
    }

    /// Returns the parts that the records of the match contain.
    pub fn fields(&self) -> &Fields {
        &self.fields
    }
}

/// Forgets the match, for another.
pub fn forget(world: &mut World) {
    *world.resource_mut::<Timeline>() = Timeline::default();
    world.resource_mut::<History>().clear();
    world.insert_resource(Keyframes::default());
}

/// Shows a trace, in place of the current match.
///
/// # Errors
/// [`ScenarioFault`] when the scenario of the trace cannot be started here.
pub fn start_replay(world: &mut World, trace: ReadTrace) -> Result<(), ScenarioFault> {
    let mut log = EventLog::default();
    for (time_s, event) in &trace.events {
        log.note(*time_s, [event]);
    }
    let first = trace.history.cycles().map_or(0, |cycles| *cycles.start());
    let data = BranchData {
        history: trace.history,
        log,
        keyframes: Keyframes::default(),
        trace: Some((Box::new(trace.scenario), trace.fields)),
    };
    replace_match(world, |world| begin_trace(world, &data))?;
    data.put(world);
    go_to(world, first as f64);
    Ok(())
}

/// The stored data of a branch of the match.
#[derive(Clone, Debug, Default)]
pub struct BranchData {
    /// The records of its cycles.
    pub history: History,
    /// The log of events.
    pub log: EventLog,
    /// The keyframes.
    pub keyframes: Keyframes,
    /// For a trace: its scenario, and the parts that its records contain.
    pub trace: Option<(Box<Scenario>, Fields)>,
}

impl BranchData {
    /// Takes the data of the current branch out of the world.
    pub fn take(world: &mut World) -> BranchData {
        let timeline = core::mem::take(&mut *world.resource_mut::<Timeline>());
        BranchData {
            history: core::mem::take(&mut *world.resource_mut::<History>()),
            log: core::mem::take(&mut *world.resource_mut::<EventLog>()),
            keyframes: core::mem::take(&mut *world.resource_mut::<Keyframes>()),
            trace: timeline.trace_scenario.map(|scenario| (scenario, timeline.fields)),
        }
    }

    /// Puts the data into the world, in place of the current branch.
    pub fn put(self, world: &mut World) {
        let BranchData { history, log, keyframes, trace } = self;
        world.insert_resource(history);
        world.insert_resource(log);
        world.insert_resource(keyframes);
        let (trace_scenario, fields) = trace.map_or_else(default, |(scenario, fields)| (Some(scenario), fields));
        world.insert_resource(Timeline { trace_scenario, fields, ..default() });
    }

    /// Returns the data until the end of a cycle at `time_s`, for a branch that plays on from there.
    ///
    /// # Errors
    /// When the records of that cycle cannot be read.
    pub fn until(&self, cycle: u64, time_s: f64) -> Result<BranchData, HistoryError> {
        Ok(BranchData {
            history: self.history.until(cycle)?,
            log: self.log.cut(time_s),
            keyframes: self.keyframes.until(cycle),
            trace: None,
        })
    }
}

/// Shows the match of a trace without a present.
///
/// # Errors
/// [`ScenarioFault`] when its scenario cannot be started here.
pub fn show_trace(world: &mut World, data: BranchData) -> Result<(), ScenarioFault> {
    begin_trace(world, &data)?;
    data.put(world);
    Ok(())
}

/// Starts the match of a trace, with robots that decide nothing.
fn begin_trace(world: &mut World, data: &BranchData) -> Result<(), ScenarioFault> {
    if let Some((started_from, _)) = &data.trace {
        let as_played = simulation::resolved(world, started_from);
        let mut scenario = as_played.clone();
        for robot in &mut scenario.robots {
            robot.behaviour = BehaviourSpec::default();
        }
        scenario.interventions.clear();
        // The record sets every moment of the match, so it needs no start from another match.
        scenario.from = None;
        simulation::start_match(world, &scenario)?;
        // The robots have no behaviours now, but the scenario still tells the original ones.
        world.insert_resource(as_played);
    }
    Ok(())
}

/// Shows a moment, in cycles since the start. After its last cycle, a match shows the present.
pub fn go_to(world: &mut World, cursor: f64) {
    let Some(cycles) = world.resource::<History>().cycles() else { return };
    let (first, last) = (*cycles.start() as f64, *cycles.end() as f64);
    let timeline = world.resource::<Timeline>();
    if !timeline.is_replay() && (cursor >= last || !cursor.is_finite()) {
        return_to_present(world);
        return;
    }
    if timeline.present.is_none() && !timeline.is_replay() {
        let present = Present::put_aside(world);
        world.resource_mut::<Timeline>().present = Some(Box::new(present));
    }
    world.resource_mut::<Timeline>().cursor = Some(cursor.clamp(first, last));
    show_past(world);
}

/// Moves by a number of cycles.
pub fn step(world: &mut World, cycles: i64) {
    let now = match world.resource::<Timeline>().cursor {
        // A step back from between two cycles goes to the nearer one.
        Some(cursor) if cycles < 0 => cursor.ceil(),
        Some(cursor) => cursor.floor(),
        None => world.resource::<CycleClock>().cycle as f64,
    };
    go_to(world, now + cycles as f64);
}

/// Restores the present. In a replay, shows its end.
pub fn return_to_present(world: &mut World) {
    if world.resource::<Timeline>().is_replay() {
        if let Some(last) = world.resource::<History>().last_cycle() {
            go_to(world, last as f64);
        }
        return;
    }
    let mut timeline = world.resource_mut::<Timeline>();
    (timeline.cursor, timeline.shown) = (None, None);
    let Some(present) = timeline.present.take() else { return };
    present.put_back(world);
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
}

/// Puts the record of the moment into the world.
fn show_past(world: &mut World) {
    let Some(cursor) = world.resource::<Timeline>().cursor else { return };
    world.resource_scope(|world, mut history: Mut<History>| {
        let (previous, cycle) = history.around(cursor.ceil() as u64);
        let fraction = previous.map_or(1.0, |previous| (cursor - previous as f64) / (cycle - previous) as f64);
        *world.resource_mut::<DisplayFraction>() = DisplayFraction(fraction as f32);
        if world.resource::<Timeline>().shown == Some(cycle) {
            return;
        }
        world.resource_mut::<Timeline>().shown = Some(cycle);
        let records = history.record(cycle).and_then(|record| {
            let previous = previous.map(|previous| history.record(previous));
            Ok((record, previous.transpose()?.flatten()))
        });
        match records {
            Ok((Some(record), previous)) => {
                let fields = world.resource::<Timeline>().fields.clone();
                put_record(world, &history, &fields, record, previous.as_ref());
            }
            Ok((None, _)) => {}
            Err(error) => world.resource_mut::<Playback>().problem = Some(error.to_string()),
        }
    });
}

fn keep_cycle(current: Res<CurrentRecord>, mut history: ResMut<History>, mut playback: ResMut<Playback>) {
    if let Err(error) = history.push(&current.record) {
        playback.problem = Some(error.to_string());
    }
}

/// Stores the start of a match when one is started.
fn keep_start(
    recorded: RecordedMatch,
    mut current: ResMut<CurrentRecord>,
    scenario: Option<Res<Scenario>>,
    timeline: Res<Timeline>,
    half: Option<Res<PendingHalf>>,
    history: ResMut<History>,
    playback: ResMut<Playback>,
) {
    // A cycle that waits for a program is kept when it ends.
    let is_under_way = half.is_some_and(|half| *half != PendingHalf::Whole);
    let kept = is_under_way || history.last_cycle() == Some(recorded.cycle());
    if scenario.is_some() && !timeline.is_past() && !timeline.is_replay() && !kept {
        recorded.gather(&mut current);
        keep_cycle(current.into(), history, playback);
    }
}

fn handle_timeline_commands(world: &mut World) {
    let commands: Vec<TimelineCommand> = world.resource_mut::<Messages<TimelineCommand>>().drain().collect();
    for command in commands {
        match command {
            TimelineCommand::GoTo(cycle) => go_to(world, cycle as f64),
            TimelineCommand::Step(cycles) => {
                world.resource_mut::<Playback>().paused = true;
                step(world, cycles);
            }
            TimelineCommand::Skip(seconds) => {
                let clock = *world.resource::<CycleClock>();
                let now = world.resource::<Timeline>().cursor.unwrap_or(clock.cycle as f64);
                go_to(world, now + seconds / clock.period_s);
            }
            TimelineCommand::Present => return_to_present(world),
        }
    }
}

/// Plays the past at the wanted speed, up to the present.
fn play_past(world: &mut World) {
    let Some(cursor) = world.resource::<Timeline>().cursor else { return };
    let playback = world.resource::<Playback>();
    if playback.paused {
        return;
    }
    let elapsed_s = match playback.speed {
        Speed::Times(_) => world.resource::<Time<Virtual>>().delta_secs_f64(),
        Speed::Unlimited => FASTEST * world.resource::<Time<Real>>().delta_secs_f64(),
    };
    let cycles = elapsed_s / world.resource::<CycleClock>().period_s;
    world.resource_mut::<Playback>().note_progress(cycles);
    go_to(world, cursor + cycles);
    let timeline = world.resource::<Timeline>();
    let last = world.resource::<History>().last_cycle();
    // A replay pauses at its end.
    if timeline.is_replay() && timeline.shown == last && timeline.cursor == last.map(|last| last as f64) {
        world.resource_mut::<Playback>().paused = true;
    }
}

#[cfg(test)]
mod tests;
