//! Formats the lines of a trace, for any kind of file.

use bevy::prelude::*;
use serde::Serialize;

use super::recorder::MatchEnd;
use naoisis_core::behaviour::reasons::{Reasons, ask_for_reasons};
use naoisis_core::events::MatchEvent;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::trace_numbers::ShortestFloats;
use naoisis_sim::scenario::Scenario;

/// Name of the format in the header.
pub const FORMAT: &str = "naoisis-trace";
/// Version of the format in the header.
pub const VERSION: u32 = 1;

/// The cycles and fields of a trace. Recorders find it as a resource of their world while a trace is [converted](super::convert), so that a
/// trace written from it has the same extent.
#[derive(Resource, Clone)]
pub(super) struct TraceExtent {
    /// The cycles from one line to the next.
    pub every: u64,
    /// The fields that lines have.
    pub fields: Fields,
}

/// Formats the lines of a trace. Each ends with a line feed.
pub(super) struct TraceLines {
    pub extent: TraceExtent,
    /// Events of the cycles since the last line.
    events: Vec<MatchEvent>,
    last_cycle: Option<u64>,
    /// Whether robots' reasons are written. Otherwise they may still be there for another recorder.
    has_reasons: bool,
}

impl Default for TraceLines {
    fn default() -> Self {
        let extent = TraceExtent { every: 1, fields: Fields::default() };
        Self { extent, events: Vec::new(), last_cycle: None, has_reasons: true }
    }
}

impl TraceLines {
    /// Adds the header of a match.
    pub(super) fn add_header(
        &mut self,
        text: &mut Vec<u8>,
        scenario: &Scenario,
        world: &mut World,
    ) -> serde_json::Result<()> {
        let converted = world.get_resource::<TraceExtent>().cloned();
        let is_converted = converted.is_some();
        self.extent = converted.unwrap_or_else(|| self.extent.clone());
        let TraceExtent { every, fields } = &self.extent;
        if fields.names().iter().any(|name| name.starts_with("robots.reasons")) {
            ask_for_reasons(world);
        }
        self.has_reasons = is_converted || world.query::<&Reasons>().iter(world).next().is_some();
        let (line_type, format, version) = ("header", FORMAT, VERSION);
        let header = Header { line_type, format, version, seed: scenario.seed, every: *every, fields, scenario };
        serde_json::to_writer(&mut *text, &header)?;
        text.push(b'\n');
        Ok(())
    }

    /// Adds the line of the first cycle, or of the last.
    pub(super) fn add(&mut self, text: &mut Vec<u8>, record: &CycleRecord) -> serde_json::Result<()> {
        self.last_cycle = Some(record.cycle);
        let leaves_out = !self.has_reasons && record.robots.iter().any(|robot| robot.reasons.is_some());
        if self.events.is_empty() && !leaves_out {
            return self.add_line(text, record);
        }
        let mut record = record.clone();
        record.events.splice(..0, self.events.drain(..));
        if !self.has_reasons {
            record.robots.iter_mut().for_each(|robot| robot.reasons = None);
        }
        self.add_line(text, &record)
    }

    /// Adds the line of a cycle, if it has one.
    pub(super) fn add_cycle(&mut self, text: &mut Vec<u8>, record: &CycleRecord) -> serde_json::Result<()> {
        if record.cycle.is_multiple_of(self.extent.every) {
            return self.add(text, record);
        }
        self.events.extend_from_slice(&record.events);
        Ok(())
    }

    /// Adds the line of the last cycle, if it has none yet.
    pub(super) fn add_last(&mut self, text: &mut Vec<u8>, last: &CycleRecord) -> serde_json::Result<()> {
        if self.last_cycle.is_some_and(|written| written < last.cycle) {
            // Its events are already among the events since the last line.
            self.add(text, &CycleRecord { events: Vec::new(), ..last.clone() })?;
        }
        Ok(())
    }

    /// Adds the end of the match.
    pub(super) fn add_end(text: &mut Vec<u8>, end: &MatchEnd) -> serde_json::Result<()> {
        serde_json::to_writer(&mut *text, end)?;
        text.push(b'\n');
        Ok(())
    }

    fn add_line(&self, text: &mut Vec<u8>, record: &CycleRecord) -> serde_json::Result<()> {
        let fields = &self.extent.fields;
        let mut serializer = serde_json::Serializer::with_formatter(&mut *text, ShortestFloats);
        if fields.is_all() {
            record.serialize(&mut serializer)?;
        } else {
            fields.of(record).serialize(&mut serializer)?;
        }
        text.push(b'\n');
        Ok(())
    }
}

#[derive(Serialize)]
struct Header<'a> {
    #[serde(rename = "type")]
    line_type: &'static str,
    format: &'static str,
    version: u32,
    seed: u64,
    #[serde(skip_serializing_if = "is_one")]
    every: u64,
    #[serde(skip_serializing_if = "Fields::is_all")]
    fields: &'a Fields,
    scenario: &'a Scenario,
}

fn is_one(every: &u64) -> bool {
    *every == 1
}
