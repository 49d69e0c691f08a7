//! Plots: any number of robots and the ball over the whole match, chosen by a click on its value or from a list.
//!
//! The values of a plotted field are read after each cycle. A thread finds those of earlier cycles: measured numbers
//! from the records, numbers in components by replaying the match from its [keyframes](Keyframes). This works for
//! matches and for traces.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::sync::{Mutex, PoisonError};

pub mod catalogue;
mod chart;
mod export;
pub mod field;
pub mod list;
mod measured;
mod panel;
pub mod series;
pub mod subject;
pub mod wording;
mod worker;

use super::cycle_samples::CycleSamples;
use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::layout::LayoutSystems;
use super::rebuild::{RebuildProgress, Rebuilt};
use super::shared::Selection;
use super::theme::tenths;
use super::timeline::Timeline;
use catalogue::{FieldList, list_fields};
use field::{Field, KnownField, Source, Subject};
use naoisis_core::ball::Ball;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use series::Series;
use worker::{Reply, Task};

/// The most plots.
const MOST_PINS: usize = 24;

/// Keeps and shows the [`Plots`].
pub struct PlotsPlugin;

impl Plugin for PlotsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Plots>()
            .init_resource::<FieldList>()
            .add_message::<PlotCommand>()
            .add_systems(Update, (list_fields, apply, reset, listen, ask).chain())
            .add_systems(EguiPrimaryContextPass, panel::show.run_if(is_open).in_set(LayoutSystems::Plots));
    }
}

fn is_open(display: Res<DisplaySettings>) -> bool {
    display.plots
}

/// Commands about plots.
#[derive(Message, Clone, PartialEq, Eq, Debug)]
pub enum PlotCommand {
    /// Adds or removes the curve of a field, for the robot if it is a field of robots.
    Toggle(Field, Option<RobotId>),
    /// Removes the plot of a field.
    Remove(Field),
}

/// A plotted field.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Pin {
    /// The field.
    pub field: Field,
    /// The robots with a curve; empty for a field of the ball.
    #[serde(default)]
    pub robots: BTreeSet<RobotId>,
}

impl Pin {
    /// Whether there is a curve of a robot, or of the ball.
    fn has(&self, subject: Subject) -> bool {
        match subject {
            Subject::Robot(id) => self.robots.contains(&id),
            Subject::Ball => true,
        }
    }
}

/// The plotted fields and their values.
#[derive(Resource, Default, Debug)]
pub struct Plots {
    /// The plotted fields, from top to bottom.
    pub pins: Vec<Pin>,
    data: BTreeMap<Field, FieldValues>,
    /// The match of the values.
    of: Keyframes,
    job: Option<Job>,
}

/// The known values of a field.
#[derive(Default, Debug)]
struct FieldValues {
    curves: BTreeMap<Subject, Series>,
    /// All values before this cycle are known.
    until: u64,
    /// All values from this cycle on are known, because they were read while the match was played.
    since: Option<u64>,
    /// Why no more values of the past can be known.
    fault: Option<String>,
}

/// A thread that finds values of the past.
#[derive(Debug)]
struct Job {
    fields: BTreeSet<Field>,
    replies: Mutex<Receiver<Reply>>,
}

impl Plots {
    /// Returns the curve of a field, if any values are known.
    pub fn series(&self, field: &Field, subject: Subject) -> Option<&Series> {
        self.data.get(field)?.curves.get(&subject)
    }

    /// Returns the number of plotted fields, and of curves with values.
    pub fn counts(&self) -> [usize; 2] {
        let curves = self.pins.iter().flat_map(|pin| {
            let known = self.data.get(&pin.field).into_iter().flat_map(|known| &known.curves);
            known.filter(|(subject, series)| pin.has(**subject) && !series.is_empty())
        });
        [self.pins.len(), curves.count()]
    }

    /// Returns whether a field is plotted.
    pub fn is_pinned(&self, field: &Field) -> bool {
        self.pins.iter().any(|pin| pin.field == *field)
    }

    /// Whether the match is still being read for a field.
    fn is_reading(&self, field: &Field) -> bool {
        self.job.as_ref().is_some_and(|job| job.fields.contains(field))
    }

    /// Why not all values of a field are known, or how far they are known so far.
    fn state(&self, field: &Field, clock: &CycleClock) -> Option<String> {
        let known = self.data.get(field)?;
        if let Some(fault) = &known.fault {
            return Some(format!("Earlier values are not known: {fault}."));
        }
        let job = self.job.as_ref().filter(|job| job.fields.contains(field));
        let until_s = CycleClock { cycle: known.until, ..*clock }.end_time_s();
        job.map(|_| format!("Reading the match: at {}…", tenths(until_s)))
    }

    fn note(&mut self, field: &Field, values: impl IntoIterator<Item = (Subject, u64, f32)>) {
        let known = self.data.entry(field.clone()).or_default();
        for (subject, cycle, value) in values {
            known.curves.entry(subject).or_default().set(cycle, value);
        }
    }
}

fn apply(
    mut commands: MessageReader<PlotCommand>,
    list: Res<FieldList>,
    selection: Res<Selection>,
    roster: Res<Roster>,
    mut plots: ResMut<Plots>,
    mut display: ResMut<DisplaySettings>,
) {
    for command in commands.read() {
        match command {
            PlotCommand::Remove(field) => plots.pins.retain(|pin| pin.field != *field),
            PlotCommand::Toggle(field, robot) => {
                let Some(known) = list.find(field) else { continue };
                let robot = robot.or(selection.0).filter(|_| !known.of_ball);
                let robots: BTreeSet<RobotId> = match robot {
                    Some(robot) => [robot].into(),
                    None if known.of_ball => BTreeSet::new(),
                    None => roster.iter().map(|(id, _)| id).collect(),
                };
                toggle(&mut plots.pins, field, robots);
                if plots.is_pinned(field) {
                    display.plots = true;
                }
            }
        }
    }
}

/// Adds curves for robots, or removes them if all have one; a plot without curves is removed.
fn toggle(pins: &mut Vec<Pin>, field: &Field, robots: BTreeSet<RobotId>) {
    let Some(index) = pins.iter().position(|pin| pin.field == *field) else {
        if pins.len() < MOST_PINS {
            pins.push(Pin { field: field.clone(), robots });
        }
        return;
    };
    let pin = &mut pins[index];
    if robots.is_subset(&pin.robots) {
        pin.robots.retain(|robot| !robots.contains(robot));
        if pin.robots.is_empty() {
            pins.remove(index);
        }
    } else {
        pin.robots.extend(robots);
    }
}

/// Removes the values of another match, and of fields that are no longer plotted.
fn reset(keyframes: Res<Keyframes>, mut plots: ResMut<Plots>) {
    if !plots.of.is_same(&keyframes) {
        let pins = core::mem::take(&mut plots.pins);
        *plots = Plots { pins, of: keyframes.clone(), ..default() };
    }
    let is_needed = |field: &Field| plots.pins.iter().any(|pin| pin.field == *field);
    if plots.data.keys().any(|field| !is_needed(field)) {
        let pinned: BTreeSet<Field> = plots.pins.iter().map(|pin| pin.field.clone()).collect();
        plots.data.retain(|field, _| pinned.contains(field));
    }
}

/// Starts a thread that finds the missing values of all fields.
fn ask(
    mut plots: ResMut<Plots>,
    list: Res<FieldList>,
    (history, keyframes): (Res<History>, Res<Keyframes>),
    (timeline, clock): (Res<Timeline>, Res<CycleClock>),
    (simulator, rebuilt): (Option<Res<Simulator>>, Option<Res<Rebuilt>>),
) {
    let Some(last) = history.last_cycle().filter(|_| !plots.pins.is_empty()) else { return };
    let fields: Vec<Field> = plots.pins.iter().map(|pin| pin.field.clone()).collect();
    let mut wanted = Vec::new();
    let mut cycles = [u64::MAX, 0];
    for known in fields.iter().filter_map(|field| list.find(field)) {
        let data = plots.data.entry(known.field.clone()).or_default();
        let end = data.since.unwrap_or(last + 1);
        if data.until < end && data.fault.is_none() {
            cycles = [cycles[0].min(data.until), cycles[1].max(end - 1)];
            wanted.push(known.clone());
        }
    }
    let is_asked = |job: &Job| wanted.iter().all(|known| job.fields.contains(&known.field));
    if wanted.is_empty() || plots.job.as_ref().is_some_and(is_asked) {
        return;
    }
    // As soon as the match of a trace is played again, it has a keyframe at its start.
    let is_kept = keyframes.before(cycles[0]).is_some() || keyframes.fault().is_some() || simulator.is_none();
    if !is_kept {
        let failed = rebuilt.and_then(|rebuilt| match &rebuilt.progress {
            RebuildProgress::Failed(message) => Some(message.clone()),
            _ => None,
        });
        match failed {
            Some(message) => {
                for known in wanted.iter().filter(|known| matches!(known.source, Source::Component { .. })) {
                    plots.data.entry(known.field.clone()).or_default().fault = Some(message.clone());
                }
                wanted.retain(|known| matches!(known.source, Source::Measured(_)));
            }
            None => wanted.retain(|known| matches!(known.source, Source::Measured(_))),
        }
        if wanted.is_empty() {
            return;
        }
    }
    let task = Task {
        fields: wanted.clone(),
        cycles,
        history: history.clone(),
        keyframes: keyframes.clone(),
        recorded: timeline.fields().clone(),
        simulator: simulator.map(|simulator| simulator.0),
        period_s: clock.period_s,
    };
    let fields: BTreeSet<Field> = wanted.into_iter().map(|known| known.field).collect();
    match worker::begin(task) {
        Ok(replies) => plots.job = Some(Job { fields, replies: Mutex::new(replies) }),
        Err(error) => {
            for field in fields {
                plots.data.entry(field).or_default().fault = Some(error.to_string());
            }
        }
    }
}

fn listen(mut plots: ResMut<Plots>) {
    let Some(job) = &plots.job else { return };
    let mut replies = Vec::new();
    let mut is_over = false;
    {
        let receiver = job.replies.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            match receiver.try_recv() {
                Ok(reply) => replies.push(reply),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    is_over = true;
                    break;
                }
            }
        }
    }
    for reply in replies {
        match reply {
            Reply::Values { until, fields, values } => {
                for (field, values) in worker::by_field(&fields, values) {
                    plots.note(&field, values);
                    let known = plots.data.entry(field).or_default();
                    known.until = known.until.max(until + 1);
                }
            }
            Reply::Fault(fields, fault) => {
                for field in fields {
                    plots.data.entry(field).or_default().fault = Some(fault.clone());
                }
            }
        }
    }
    if is_over {
        plots.job = None;
    }
}

/// Reads the plotted fields after a cycle.
pub(super) fn note_cycle(world: &mut World) {
    if world.get_resource::<Plots>().is_none_or(|plots| plots.pins.is_empty()) {
        return;
    }
    world.resource_scope(|world, mut plots: Mut<Plots>| {
        let fields: Vec<KnownField> = {
            let list = world.resource::<FieldList>();
            plots.pins.iter().filter_map(|pin| list.find(&pin.field).cloned()).collect()
        };
        let clock = *world.resource::<CycleClock>();
        let mut values = read_components(world, &fields);
        if let Some(sample) = world.get_resource::<CycleSamples>().and_then(|samples| samples.sample(clock.cycle)) {
            for (index, field) in fields.iter().enumerate() {
                if let Source::Measured(measured) = field.source {
                    let measured = measured.values(sample, clock.period_s).into_iter();
                    values.extend(measured.map(|(subject, value)| (index, subject, value)));
                }
            }
        }
        for (index, subject, value) in values {
            plots.note(&fields[index].field, [(subject, clock.cycle, value)]);
        }
        for known in &fields {
            plots.data.entry(known.field.clone()).or_default().since.get_or_insert(clock.cycle);
        }
    });
}

/// The current values of fields in components: index of the field, subject, value.
fn read_components(world: &mut World, fields: &[KnownField]) -> Vec<(usize, Subject, f32)> {
    if fields.iter().all(|field| matches!(field.source, Source::Measured(_))) {
        return Vec::new();
    }
    let Some(registry) = world.get_resource::<AppTypeRegistry>().cloned() else { return Vec::new() };
    let registry = registry.read();
    let mut balls = world.query_filtered::<Entity, With<Ball>>();
    let ball = balls.iter(world).next().map(|ball| (Subject::Ball, ball));
    let robots = world.resource::<Roster>().iter().map(|(id, robot)| (Subject::Robot(id), robot));
    let subjects: Vec<(Subject, Entity)> = robots.chain(ball).collect();
    let mut values = Vec::new();
    for (index, field) in fields.iter().enumerate() {
        let Source::Component { type_id, steps, factor } = &field.source else { continue };
        let Some(component) = registry.get_type_data::<ReflectComponent>(*type_id) else { continue };
        for (subject, entity) in subjects.iter().filter(|(subject, _)| field.of_ball == (*subject == Subject::Ball)) {
            let Ok(entity) = world.get_entity(*entity) else { continue };
            let value = component.reflect(entity).and_then(|value| field::read(value.as_partial_reflect(), steps));
            values.extend(value.map(|value| (index, *subject, factor * value)));
        }
    }
    values
}

#[cfg(test)]
mod tests;
