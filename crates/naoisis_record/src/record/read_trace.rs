//! Reads a whole trace into memory, with progress.

use core::ops::ControlFlow;
use std::io;
use std::path::{Path, PathBuf};

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
    /// How the trace ends.
    pub ending: Ending,
    /// The result of the match. `None` if the trace does not have it.
    pub result: Option<MatchResult>,
}

impl ReadTrace {
    /// Reads a trace to its end.
    ///
    /// # Errors
    /// The first fault of the trace, and where it is.
    pub fn open(path: &Path) -> Result<ReadTrace, TraceError> {
        Self::open_told(path, |_| ControlFlow::Continue(()))
    }

    /// Reads a trace to its end and calls `told` after each cycle with its time, s. Stops reading if `told` returns `Break`.
    ///
    /// # Errors
    /// The first fault of the trace, and where it is.
    pub fn open_told(path: &Path, told: impl FnMut(f64) -> ControlFlow<()>) -> Result<ReadTrace, TraceError> {
        let mut parts = TraceParts::open(path)?;
        let read = parts.next_part(usize::MAX, told)?;
        parts.fault.map_or(Ok(read), Err)
    }
}

/// Reads a trace in parts, so that the first ones can be shown while the rest is read.
pub struct TraceParts {
    path: PathBuf,
    reader: TraceReader,
    /// The fault after the last part, for the next call.
    fault: Option<TraceError>,
}

impl TraceParts {
    /// Opens a trace and reads its header.
    ///
    /// # Errors
    /// The first fault of the header, and where it is.
    pub fn open(path: &Path) -> Result<Self, TraceError> {
        Ok(Self { path: path.to_owned(), reader: TraceReader::open(path)?, fault: None })
    }

    /// Reads at most `records` further cycles, and calls `told` after each with its time, s. Stops if `told` returns `Break`. The part's
    /// ending is [`Ending::NotYet`] if there may be more.
    ///
    /// # Errors
    /// The first fault of the trace, and where it is. Cycles before it are a part of their own, which is returned first.
    pub fn next_part(
        &mut self,
        records: usize,
        mut told: impl FnMut(f64) -> ControlFlow<()>,
    ) -> Result<ReadTrace, TraceError> {
        let Self { path, reader, fault } = self;
        if let Some(fault) = fault.take() {
            return Err(fault);
        }
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
        for _ in 0..records {
            let record = match reader.next_cycle() {
                Ok(Some(record)) => record,
                Ok(None) => {
                    (read.ending, read.result) = (reader.ending(), reader.result());
                    break;
                }
                Err(error) if read.last.is_some() => {
                    *fault = Some(error);
                    break;
                }
                Err(error) => return Err(error),
            };
            if let Err(error) = read.history.push(&record) {
                return Err(TraceError::Io { path: path.clone(), error: io::Error::other(error) });
            }
            read.events.extend(record.events.iter().map(|event| (record.time_s, event.clone())));
            let time_s = record.time_s;
            read.last = Some(record);
            if told(time_s).is_break() {
                break;
            }
        }
        Ok(read)
    }
}
