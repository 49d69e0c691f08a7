//! The thread that finds values of the past, by reading records and replaying the match.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::io;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

use super::field::{Field, KnownField, Source, Subject};
use super::read_components;
use crate::viewer::cycle_samples::CycleSample;
use crate::viewer::keyframes::{Keyframes, MakeApp};
use crate::viewer::theme::tenths;
use naoisis_core::cycle::{CycleClock, try_run_cycle};
use naoisis_record::record::beliefs::Sensed;
use naoisis_record::record::history::History;
use naoisis_record::whatif::is_same;
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::interface::fields::Fields;

/// The number of cycles between two replies.
const AT_ONCE: u64 = 100;

/// A task of the thread.
pub(super) struct Task {
    /// The fields.
    pub fields: Vec<KnownField>,
    /// The first and the last cycle.
    pub cycles: [u64; 2],
    pub history: History,
    pub keyframes: Keyframes,
    /// The parts that the records contain.
    pub recorded: Fields,
    pub simulator: Option<MakeApp>,
    pub period_s: f64,
}

/// A reply of the thread.
#[derive(Debug)]
pub(super) enum Reply {
    /// The values of these fields until the end of a cycle.
    Values { until: u64, fields: Vec<Field>, values: Vec<(usize, Subject, u64, f32)> },
    /// No more values of these fields can be known, and why.
    Fault(Vec<Field>, String),
}

/// Starts a task; it ends when the receiver is dropped.
pub(super) fn begin(task: Task) -> io::Result<Receiver<Reply>> {
    let (said, replies) = mpsc::channel();
    thread::Builder::new().name("plots".to_owned()).spawn(move || {
        let _nobody_listens = work(task, &said);
    })?;
    Ok(replies)
}

/// An error if the receiver was dropped.
type Listened = Result<(), mpsc::SendError<Reply>>;

fn work(mut task: Task, said: &Sender<Reply>) -> Listened {
    let fields = core::mem::take(&mut task.fields);
    let is_measured = |field: &KnownField| matches!(field.source, Source::Measured(_));
    let (measured, components): (Vec<_>, Vec<_>) = fields.into_iter().partition(is_measured);
    if !measured.is_empty() {
        read_records(&mut task, measured, said)?;
    }
    if !components.is_empty() {
        play_again(&mut task, components, said)?;
    }
    Ok(())
}

/// Values that are collected for a reply.
struct Gathered<'a> {
    fields: Vec<KnownField>,
    values: Vec<(usize, Subject, u64, f32)>,
    said: &'a Sender<Reply>,
}

impl Gathered<'_> {
    fn names(&self) -> Vec<Field> {
        self.fields.iter().map(|field| field.field.clone()).collect()
    }

    fn say(&mut self, until: u64) -> Listened {
        let values = core::mem::take(&mut self.values);
        self.said.send(Reply::Values { until, fields: self.names(), values })
    }

    fn fail(&mut self, until: u64, why: impl Into<String>) -> Listened {
        self.say(until)?;
        self.said.send(Reply::Fault(self.names(), why.into()))
    }
}

/// Reads measured numbers from the records.
fn read_records(task: &mut Task, fields: Vec<KnownField>, said: &Sender<Reply>) -> Listened {
    let mut gathered = Gathered { fields, values: Vec::new(), said };
    let [first, last] = task.cycles;
    // The first cycle was sensed at the end of the one before, which an earlier task has read.
    let earlier = first.checked_sub(1).and_then(|cycle| task.history.record(cycle).ok()?);
    let mut before = earlier.map(|record| (record.cycle, Sensed::of(&record)));
    let mut next = first;
    while next <= last {
        // The record of this cycle, or the next record.
        let (_, cycle) = task.history.around(next);
        let record = match task.history.record(cycle) {
            Ok(Some(record)) if record.cycle >= next && record.cycle <= last => record,
            Ok(_) => break,
            Err(error) => return gathered.fail(next, error.to_string()),
        };
        let cycle = record.cycle;
        let sensed = before.take().filter(|(before, _)| before + 1 == cycle).map(|(_, sensed)| sensed);
        let sample = CycleSample::of(&record, sensed.as_ref());
        for (index, field) in gathered.fields.iter().enumerate() {
            if let Source::Measured(measured) = field.source {
                let values = measured.values(&sample, task.period_s).into_iter();
                gathered.values.extend(values.map(|(subject, value)| (index, subject, cycle, value)));
            }
        }
        before = Some((cycle, Sensed::of(&record)));
        if cycle / AT_ONCE != next.saturating_sub(1) / AT_ONCE {
            gathered.say(cycle)?;
        }
        next = cycle + 1;
    }
    gathered.say(last)
}

/// Reads numbers in components by replaying the match from its keyframes.
fn play_again(task: &mut Task, fields: Vec<KnownField>, said: &Sender<Reply>) -> Listened {
    let mut gathered = Gathered { fields, values: Vec::new(), said };
    let [first, last] = task.cycles;
    if let Some(fault) = task.keyframes.fault() {
        return gathered.fail(first, fault);
    }
    let Some(simulator) = task.simulator else {
        return gathered.fail(first, "this program cannot replay the match");
    };
    let Some((_, moment)) = task.keyframes.before(first) else {
        return gathered.fail(first, "the match is not kept from before this moment");
    };
    let mut app = simulator();
    app.insert_resource(SensingThreads(1));
    if let Err(error) = moment.put_back(app.world_mut()) {
        return gathered.fail(first, error.to_string());
    }
    loop {
        let cycle = app.world().resource::<CycleClock>().cycle;
        // The result of interventions by hand in a cycle is only in the keyframe after that cycle.
        if let Some((kept, moment)) = task.keyframes.before(cycle)
            && kept == cycle
            && let Err(error) = moment.put_back(app.world_mut())
        {
            return gathered.fail(cycle, error.to_string());
        }
        if cycle >= first {
            let values = read_components(app.world_mut(), &gathered.fields);
            gathered.values.extend(values.into_iter().map(|(index, subject, value)| (index, subject, cycle, value)));
        }
        if cycle.is_multiple_of(AT_ONCE) {
            gathered.say(cycle)?;
            let record = task.history.record(cycle).ok().flatten().filter(|record| record.cycle == cycle);
            if record.is_some_and(|record| !is_same(&app, &record, &task.recorded)) {
                gathered.values.clear();
                let at = tenths(app.world().resource::<CycleClock>().end_time_s());
                return gathered.fail(
                    cycle,
                    format!("the replayed match differs at {at}: its behaviours or the program have changed"),
                );
            }
        }
        if cycle >= last {
            return gathered.say(last);
        }
        if let Err(panic) = try_run_cycle(app.world_mut()) {
            return gathered.fail(cycle, panic.to_string());
        }
    }
}

/// Groups values by field.
pub(super) fn by_field(
    fields: &[Field],
    values: Vec<(usize, Subject, u64, f32)>,
) -> BTreeMap<Field, Vec<(Subject, u64, f32)>> {
    let mut sorted: BTreeMap<Field, Vec<(Subject, u64, f32)>> =
        fields.iter().map(|field| (field.clone(), Vec::new())).collect();
    for (index, subject, cycle, value) in values {
        if let Some(values) = fields.get(index).and_then(|field| sorted.get_mut(field)) {
            values.push((subject, cycle, value));
        }
    }
    sorted
}
