//! What has happened in a match so far, to look at it again.
//!
//! A [`History`] keeps a record of every cycle: that of a trace's line, whether the match is being played here or was
//! read from a file. Records are kept compressed in blocks; one block at a time is unpacked to be looked at.

use bevy::prelude::*;
use serde::Serialize;
use std::collections::VecDeque;
use std::io;
use std::ops::RangeInclusive;
use std::path::Path;

use super::read::{CycleRecord, Ending, TraceError, TraceReader};
use crate::events::MatchEvent;
use crate::kick_geometry::KickType;
use crate::scenario::Scenario;
use crate::team::{RobotId, Team};

/// Records in a block.
const BLOCK: usize = 64;
/// Beyond this many bytes the oldest blocks are forgotten.
const MOST_BYTES: usize = 400 << 20;
/// How well blocks are compressed: the fastest of zstd's levels.
const LEVEL: i32 = 1;

/// A whole trace, to look at.
pub struct ReadTrace {
    /// What the match started from; its seed is in it.
    pub scenario: Scenario,
    /// The records of its cycles.
    pub history: History,
    /// Everything that happened, with its time, s.
    pub events: Vec<(f64, MatchEvent)>,
    /// The last of its records.
    pub last: Option<CycleRecord>,
    /// How it ends.
    pub ending: Ending,
}

impl ReadTrace {
    /// Reads a trace to its end.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn open(path: &Path) -> Result<ReadTrace, TraceError> {
        let mut reader = TraceReader::open(path)?;
        let mut read = ReadTrace {
            scenario: reader.scenario().clone(),
            history: History::default(),
            events: Vec::new(),
            last: None,
            ending: Ending::NotYet,
        };
        while let Some(record) = reader.next_cycle()? {
            if let Err(error) = read.history.push(record.cycle, &record, &record.events) {
                return Err(TraceError::Io { path: path.to_owned(), error: io::Error::other(error) });
            }
            read.events.extend(record.events.iter().map(|event| (record.time_s, event.clone())));
            read.last = Some(record);
        }
        read.ending = reader.ending();
        Ok(read)
    }
}

/// What a mark on the timeline stands for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MarkKind {
    /// A goal.
    Goal,
    /// The ball left the pitch.
    Out,
    /// A robot was penalised.
    Penalty,
    /// A half began, or the match ended.
    Whistle,
}

/// A moment that is worth finding again.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mark {
    /// The cycle in which it was.
    pub cycle: u64,
    /// What it was.
    pub kind: MarkKind,
    /// The team that it is to be credited to or blamed on.
    pub team: Option<Team>,
}

impl Mark {
    fn of(event: &MatchEvent, cycle: u64) -> Option<Mark> {
        let (kind, team) = match event {
            MatchEvent::Goal { team, .. } => (MarkKind::Goal, Some(*team)),
            MatchEvent::BallOut { last_touch, .. } => (MarkKind::Out, *last_touch),
            MatchEvent::Penalty { robot, .. } => (MarkKind::Penalty, Some(robot.team)),
            MatchEvent::HalfBegins { .. } | MatchEvent::FinalWhistle => (MarkKind::Whistle, None),
            _ => return None,
        };
        Some(Mark { cycle, kind, team })
    }
}

/// A kick, for the leg to swing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KickMark {
    /// The cycle in which it was.
    pub cycle: u64,
    /// Who kicked.
    pub robot: RobotId,
    /// Which kick.
    pub kick_type: KickType,
}

/// Some records in a row, as bytes.
#[derive(Clone, Default, Debug)]
struct Block {
    /// The records one after another; compressed but in the last block.
    bytes: Vec<u8>,
    /// Where each record ends in the unpacked bytes.
    ends: Vec<usize>,
}

/// The records of all cycles so far.
#[derive(Resource, Clone, Default, Debug)]
pub struct History {
    first_cycle: u64,
    /// Whole blocks, compressed.
    packed: VecDeque<Block>,
    packed_bytes: usize,
    /// The records since then.
    open: Block,
    marks: Vec<Mark>,
    kicks: Vec<KickMark>,
    /// The block that was looked at last, unpacked, and which one it is.
    unpacked: Option<(usize, Vec<u8>)>,
}

/// A record that cannot be kept or read. It is the program's own, so that this does not happen.
#[derive(Debug, thiserror::Error)]
#[error("a record of the match cannot be kept: {0}")]
pub struct HistoryError(String);

impl History {
    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.packed.is_empty() && self.open.ends.is_empty()
    }

    /// The first and last cycle that there is a record of.
    pub fn cycles(&self) -> Option<RangeInclusive<u64>> {
        let count = (self.packed.len() * BLOCK + self.open.ends.len()) as u64;
        (count > 0).then(|| self.first_cycle..=self.first_cycle + count - 1)
    }

    /// The last cycle that there is a record of.
    pub fn last_cycle(&self) -> Option<u64> {
        self.cycles().map(|cycles| *cycles.end())
    }

    /// The moments that are worth finding again, in their order.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// The last kick of a robot until the end of a cycle.
    pub fn last_kick(&self, robot: RobotId, cycle: u64) -> Option<KickMark> {
        let until = self.kicks.partition_point(|kick| kick.cycle <= cycle);
        self.kicks[..until].iter().rev().find(|kick| kick.robot == robot).copied()
    }

    /// Bytes of memory that the records take.
    pub fn size_bytes(&self) -> usize {
        self.packed_bytes + self.open.bytes.len()
    }

    /// Keeps the record of a cycle. If it does not follow the last one, those before it are forgotten.
    ///
    /// # Errors
    /// When the record cannot be encoded.
    pub fn push(&mut self, cycle: u64, record: &impl Serialize, events: &[MatchEvent]) -> Result<(), HistoryError> {
        if self.last_cycle().is_none_or(|last| last + 1 != cycle) {
            self.clear();
            self.first_cycle = cycle;
        }
        serde_json::to_writer(&mut self.open.bytes, record).map_err(|error| HistoryError(error.to_string()))?;
        self.open.ends.push(self.open.bytes.len());
        self.marks.extend(events.iter().filter_map(|event| Mark::of(event, cycle)));
        self.kicks.extend(events.iter().filter_map(|event| match event {
            MatchEvent::Kick { robot, kick_type, result, reason, .. }
                if crate::appearance::gait::swings(*result, *reason) =>
            {
                Some(KickMark { cycle, robot: *robot, kick_type: *kick_type })
            }
            _ => None,
        }));
        if self.open.ends.len() == BLOCK {
            self.pack()?;
        }
        Ok(())
    }

    /// The record of a cycle, if there is one.
    ///
    /// # Errors
    /// When it cannot be decoded.
    pub fn record(&mut self, cycle: u64) -> Result<Option<CycleRecord>, HistoryError> {
        if !self.cycles().is_some_and(|cycles| cycles.contains(&cycle)) {
            return Ok(None);
        }
        let index = (cycle - self.first_cycle) as usize;
        let (block, place) = (index / BLOCK, index % BLOCK);
        let (bytes, ends) = match self.packed.get(block) {
            None => (&self.open.bytes, &self.open.ends),
            Some(packed) => {
                let size = packed.ends.last().copied().unwrap_or_default();
                if self.unpacked.as_ref().is_none_or(|(unpacked, _)| *unpacked != block) {
                    let bytes =
                        zstd::bulk::decompress(&packed.bytes, size).map_err(|error| HistoryError(error.to_string()))?;
                    self.unpacked = Some((block, bytes));
                }
                match &self.unpacked {
                    Some((_, bytes)) => (bytes, &packed.ends),
                    None => return Ok(None),
                }
            }
        };
        let start = if place == 0 { 0 } else { ends[place - 1] };
        let record = serde_json::from_slice(&bytes[start..ends[place]]);
        record.map(Some).map_err(|error| HistoryError(error.to_string()))
    }

    fn pack(&mut self) -> Result<(), HistoryError> {
        let mut block = core::mem::take(&mut self.open);
        block.bytes = zstd::bulk::compress(&block.bytes, LEVEL).map_err(|error| HistoryError(error.to_string()))?;
        self.packed_bytes += block.bytes.len();
        self.packed.push_back(block);
        while self.packed_bytes > MOST_BYTES
            && let Some(oldest) = self.packed.pop_front()
        {
            self.packed_bytes -= oldest.bytes.len();
            self.first_cycle += BLOCK as u64;
            self.unpacked = None;
            let first = self.first_cycle;
            self.marks.retain(|mark| mark.cycle >= first);
            self.kicks.retain(|kick| kick.cycle >= first);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::trace::MatchLine;
    use super::*;
    use crate::simulation::{MatchApp, NaoisisPlugins};
    use bevy::ecs::system::RunSystemOnce;
    use serde_json::Value;

    /// Whether two values are the same but for rounding.
    fn same(one: &Value, other: &Value) -> bool {
        match (one, other) {
            (Value::Number(one), Value::Number(other)) => {
                let [one, other] = [one, other].map(|number| number.as_f64().unwrap());
                (one - other).abs() <= 1e-6 * (1.0 + one.abs())
            }
            (Value::Array(one), Value::Array(other)) => {
                one.len() == other.len() && one.iter().zip(other).all(|(one, other)| same(one, other))
            }
            (Value::Object(one), Value::Object(other)) => {
                one.len() == other.len()
                    && one.iter().all(|(key, one)| other.get(key).is_some_and(|other| same(one, other)))
            }
            (one, other) => one == other,
        }
    }

    fn push(line: MatchLine, mut history: ResMut<History>) {
        history.push(line.clock.cycle, &line.line(), &line.events).unwrap();
    }

    #[test]
    fn every_record_is_what_the_line_of_the_trace_says() {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins).init_resource::<History>();
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        let mut lines = Vec::new();
        for _ in 0..=200 {
            app.world_mut().run_system_once(push).unwrap();
            let line = app.world_mut().run_system_once(|line: MatchLine| serde_json::to_string(&line.line())).unwrap();
            lines.push(line.unwrap());
            app.run_cycles(1);
        }
        let mut history = app.world_mut().resource_mut::<History>();
        assert_eq!(history.cycles(), Some(0..=200));
        // There and back, so that blocks are unpacked again.
        for cycle in (0..=200_u64).chain((0..=200).rev().step_by(7)) {
            let mut written: Value = serde_json::from_str(&lines[cycle as usize]).unwrap();
            written.as_object_mut().unwrap().remove("type");
            for robot in written["robots"].as_array_mut().unwrap() {
                robot.as_object_mut().unwrap().entry("posture").or_insert("Upright".into());
            }
            let read = serde_json::to_value(history.record(cycle).unwrap().unwrap()).unwrap();
            assert!(same(&read, &written), "cycle {cycle}");
        }
        assert_eq!(history.record(201).unwrap(), None);
    }

    #[test]
    fn a_jump_of_the_clock_begins_a_new_history() {
        let mut history = History::default();
        let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
        for cycle in 5..=80 {
            history.push(cycle, &cycle, if cycle == 7 { std::slice::from_ref(&goal) } else { &[] }).unwrap();
        }
        assert_eq!(history.cycles(), Some(5..=80));
        assert_eq!(history.marks(), [Mark { cycle: 7, kind: MarkKind::Goal, team: Some(Team::Pink) }]);
        history.push(0, &0, &[]).unwrap();
        assert_eq!((history.cycles(), history.marks()), (Some(0..=0), &[][..]));
    }
}
