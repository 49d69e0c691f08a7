//! When in a cycle a match is recorded.

use bevy::prelude::*;

use super::formats::LogFormatApp;
use super::gather::{self, CurrentRecord, RecordSystems};
use super::recorder::{self, Recorders};
use super::trace::TraceRecorder;
use crate::cycle::{Cycle, CycleHalf, CycleSystems};
use crate::simulation::sensors::ReadingsAreRecorded;

/// Gathers the [`CurrentRecord`] of every cycle while there is one, and lets the [recorders](recorder) have it.
pub struct RecordPlugin;

impl Plugin for RecordPlugin {
    fn build(&self, app: &mut App) {
        let is_recorded = resource_exists::<CurrentRecord>;
        let trace = "a line of JSON a cycle, compressed if its name ends in .zst";
        app.init_resource::<ReadingsAreRecorded>()
            .add_log_format("trace", trace, TraceRecorder::create)
            .configure_sets(
                Cycle,
                (
                    (RecordSystems::Gather, RecordSystems::Keep).chain().in_set(CycleSystems::Record),
                    // Recorders have the whole world to look at: they come when nobody else is at work.
                    RecordSystems::Write.after(CycleSystems::Record).before(CycleSystems::Last).in_set(CycleHalf::Act),
                ),
            )
            .add_systems(
                Cycle,
                (
                    gather::note_commands
                        .after(CycleSystems::Decide)
                        .before(CycleSystems::Act)
                        .in_set(CycleHalf::Act)
                        .run_if(is_recorded),
                    gather::gather_record.in_set(RecordSystems::Gather).run_if(is_recorded),
                    recorder::record_cycle.in_set(RecordSystems::Write).run_if(resource_exists::<Recorders>),
                ),
            );
    }
}
