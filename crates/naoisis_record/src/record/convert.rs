//! Converts a trace to another format, with any [recorder](Recorder) that needs only the records.

use bevy::prelude::*;
use core::ops::ControlFlow;

use super::read::{TraceError, TraceReader};
use super::recorder::{RecordError, Recorder};
use super::team_names::team_names;
use super::trace_lines::TraceExtent;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::PerTeam;
use naoisis_sim::scenario::{Scenario, TeamsSpec};

/// Why a trace cannot be converted.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// The trace cannot be read.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The new file cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The trace has only its header.
    #[error("the trace has no cycle after its header; expected at least one")]
    Empty,
}

naoisis_core::debug_as_displayed!(ConvertError);

/// Passes all cycles of the trace to the recorder that `create` makes, and returns its final text. The recording of a trace that breaks off
/// breaks off, too. `registry` names the teams. `told` is called after each cycle with its time, s; if it returns `Break`, the recording
/// breaks off there.
///
/// # Errors
/// The fault of the trace and where it is, or the reason why the recorder cannot write.
pub fn convert(
    reader: &mut TraceReader,
    registry: &BehaviourRegistry,
    create: impl FnOnce() -> Result<Box<dyn Recorder>, RecordError>,
    mut told: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Option<String>, ConvertError> {
    let scenario = reader.scenario().clone();
    let mut last = reader.next_cycle()?.ok_or(ConvertError::Empty)?;
    let mut recorder = create()?;
    let mut world = World::new();
    world.insert_resource(TraceExtent { every: reader.every(), fields: reader.fields().clone() });
    let PerTeam { blue, pink } = team_names(&scenario, registry);
    world.insert_resource(Scenario { teams: Some(TeamsSpec::new(blue, pink)), ..scenario.clone() });
    recorder.start(&scenario, &last, &mut world);
    while let Some(record) = reader.next_cycle()? {
        recorder.record(&record, &mut world);
        last = record;
        if recorder.has_failed() || told(last.time_s).is_break() {
            break;
        }
    }
    Ok(match reader.end() {
        Some(end) => recorder.finish(&end, &last)?,
        None => recorder.break_off(&last)?,
    })
}
