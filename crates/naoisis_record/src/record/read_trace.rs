//! A trace as it is looked at: read whole, with progress.

use core::ops::ControlFlow;
use std::io;
use std::path::Path;

use super::history::History;
use super::read::{Ending, TraceError, TraceReader};
use naoisis_core::events::MatchEvent;
use naoisis_core::game::MatchResult;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// A whole trace in memory.
pub struct ReadTrace {
    /// The scenario of the match, with its seed.
    pub scenario: Scenario,
    /// The records of its cycles.
    pub history: History,
    /// All events, with their times, s.
    pub events: Vec<(f64, MatchEvent)>,
    /// The last record.
    pub last: Option<CycleRecord>,
    /// The most cycles from one record to the next.
    pub every: u64,
    /// The fields that records have.
    pub fields: Fields,
    /// How it ends.
    pub ending: Ending,
    /// The result of the match; `None` if the trace does not say.
    pub result: Option<MatchResult>,
}

impl ReadTrace {
    /// Reads a trace to its end.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn open(path: &Path) -> Result<ReadTrace, TraceError> {
        Self::open_told(path, |_| ControlFlow::Continue(()))
    }

    /// Reads a trace to its end and calls `told` after each cycle with its time, s. Reading ends there if that returns `Break`.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn open_told(path: &Path, mut told: impl FnMut(f64) -> ControlFlow<()>) -> Result<ReadTrace, TraceError> {
        let mut reader = TraceReader::open(path)?;
        let mut read = ReadTrace {
            scenario: reader.scenario().clone(),
            history: History::of_every(reader.every()),
            events: Vec::new(),
            last: None,
            every: reader.every(),
            fields: reader.fields().clone(),
            ending: Ending::NotYet,
            result: None,
        };
        while let Some(record) = reader.next_cycle()? {
            if let Err(error) = read.history.push(&record) {
                return Err(TraceError::Io { path: path.to_owned(), error: io::Error::other(error) });
            }
            read.events.extend(record.events.iter().map(|event| (record.time_s, event.clone())));
            let time_s = record.time_s;
            read.last = Some(record);
            if told(time_s).is_break() {
                return Ok(read);
            }
        }
        (read.ending, read.result) = (reader.ending(), reader.result());
        Ok(read)
    }
}
