//! The plugin that records matches, and its place in the cycle.

use bevy::prelude::*;

use super::formats::LogFormatApp;
use super::game_controller_log::GameControllerLogRecorder;
use super::mcap::McapRecorder;
use super::page::PageRecorder;
use super::recorder::{self, Recorders};
use super::trace::TraceRecorder;
use naoisis_core::cycle::{Cycle, CycleHalf, CycleSystems};
use naoisis_sim::interface::gather::{GatherPlugin, RecordSystems};

/// Gathers the record of every cycle ([`GatherPlugin`]) and passes it to the [recorders](recorder).
pub struct RecordPlugin;

impl Plugin for RecordPlugin {
    fn build(&self, app: &mut App) {
        let trace = "a line of JSON a cycle, compressed if its name ends in .zst";
        app.add_plugins(GatherPlugin)
            .add_log_format("trace", trace, TraceRecorder::create)
            .add_log_format("html", "a page that plays the match in a browser, in one file", PageRecorder::create)
            .name_endings("trace", &[".jsonl", ".jsonl.zst"])
            .name_endings("html", &[".html"])
            .add_log_format(
                "mcap",
                "MCAP with the trace and channels for Foxglove and Lichtblick",
                McapRecorder::create,
            )
            .name_endings("mcap", &[".mcap"])
            .add_log_format(
                "gamecontroller",
                "YAML as the league's GameController writes it",
                GameControllerLogRecorder::create,
            )
            // Recorders have exclusive access to the world, so they run when no other systems do.
            .configure_sets(
                Cycle,
                RecordSystems::Write.after(CycleSystems::Record).before(CycleSystems::Last).in_set(CycleHalf::Act),
            )
            .add_systems(
                Cycle,
                recorder::record_cycle.in_set(RecordSystems::Write).run_if(resource_exists::<Recorders>),
            );
    }
}
