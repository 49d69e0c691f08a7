//! Keeps the records of a match in memory.
//!
//! A [`History`] has the record of every cycle of a match that is being played or was read from a trace. Records are compressed in blocks.
//! One block at a time is unpacked. When a long match takes too much memory, the older half keeps every second record, then every fourth, and
//! so on: the whole match stays accessible. The events of a removed record are in the record before it.

use bevy::prelude::*;
use std::collections::VecDeque;
use std::ops::{Range, RangeInclusive};

use super::match_marks::{KickMark, Mark};
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::stride::Swing;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// Records in a block.
const BLOCK: usize = 64;
/// Size at which a block is full, whatever its number of records, bytes.
const LARGEST_BLOCK_BYTES: usize = 8 << 20;
/// Size beyond which older records are removed, bytes.
const MOST_BYTES: usize = 400 << 20;
/// Compression level: the fastest of zstd.
const LEVEL: i32 = 1;

/// Consecutive records as bytes.
#[derive(Clone, Default, Debug)]
struct Block {
    /// The records one after another. All blocks but the last are compressed.
    bytes: Vec<u8>,
    /// The cycle of each record, and where it ends in the unpacked bytes.
    ends: Vec<(u64, usize)>,
}

impl Block {
    fn last_cycle(&self) -> Option<u64> {
        self.ends.last().map(|(cycle, _)| *cycle)
    }

    /// Returns the records up to `cycle`. The block must not be compressed.
    fn until(mut self, cycle: u64) -> Block {
        self.ends.retain(|(earlier, _)| *earlier <= cycle);
        self.bytes.truncate(self.ends.last().map_or(0, |(_, end)| *end));
        self
    }

    /// Returns the unpacked bytes of a compressed block.
    fn unpack(&self) -> Result<Vec<u8>, HistoryError> {
        let size = self.ends.last().map_or(0, |(_, end)| *end);
        zstd::bulk::decompress(&self.bytes, size).map_err(HistoryError::of)
    }

    /// Returns a block with every second record of this and a later block. Events of the others are in the record before. All blocks are
    /// compressed.
    fn thinned_with(&self, later: &Block) -> Result<Block, HistoryError> {
        let mut joined = Block::default();
        let mut kept: Option<CycleRecord> = None;
        let mut add = |record: CycleRecord| -> Result<(), HistoryError> {
            serde_json::to_writer(&mut joined.bytes, &record).map_err(HistoryError::of)?;
            joined.ends.push((record.cycle, joined.bytes.len()));
            Ok(())
        };
        for block in [self, later] {
            let bytes = block.unpack()?;
            let mut start = 0;
            for (index, (_, end)) in block.ends.iter().enumerate() {
                let record: CycleRecord = serde_json::from_slice(&bytes[start..*end]).map_err(HistoryError::of)?;
                start = *end;
                match &mut kept {
                    Some(kept) if index % 2 == 1 => kept.events.extend(record.events),
                    _ => kept.replace(record).map_or(Ok(()), &mut add)?,
                }
            }
        }
        kept.map_or(Ok(()), add)?;
        joined.bytes = zstd::bulk::compress(&joined.bytes, LEVEL).map_err(HistoryError::of)?;
        Ok(joined)
    }

    /// Returns the range, in the unpacked bytes, of the first record at or after `cycle`.
    fn find(&self, cycle: u64) -> Option<Range<usize>> {
        let place = self.ends.partition_point(|(earlier, _)| *earlier < cycle);
        let start = place.checked_sub(1).map_or(0, |previous| self.ends[previous].1);
        self.ends.get(place).map(|(_, end)| start..*end)
    }
}

/// The records of a match, one for every cycle or for every few cycles.
#[derive(Resource, Clone, Debug)]
pub struct History {
    /// The most cycles from one record to the next.
    every: u64,
    /// Full blocks, compressed.
    packed: VecDeque<Block>,
    packed_bytes: usize,
    /// The records since the last full block.
    open: Block,
    marks: Vec<Mark>,
    kicks: Vec<KickMark>,
    /// The block that was unpacked last: the cycle of its last record, and its bytes.
    unpacked: Option<(u64, Vec<u8>)>,
    /// The size beyond which older records are removed, bytes.
    most_bytes: usize,
    /// The index of the block that is thinned next, and the most cycles between two records since.
    next_thinned: usize,
    widest: u64,
}

impl Default for History {
    fn default() -> Self {
        Self::of_every(1)
    }
}

/// A record cannot be encoded or decoded. This does not happen with the program's own records.
#[derive(thiserror::Error)]
#[error("a record of the match cannot be kept: {0}")]
pub struct HistoryError(String);

naoisis_core::debug_as_displayed!(HistoryError);

impl HistoryError {
    fn of(error: impl core::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

impl History {
    /// Creates an empty history whose records are at most `every` cycles apart.
    pub fn of_every(every: u64) -> Self {
        Self {
            every: every.max(1),
            packed: VecDeque::new(),
            packed_bytes: 0,
            open: Block::default(),
            marks: Vec::new(),
            kicks: Vec::new(),
            unpacked: None,
            most_bytes: MOST_BYTES,
            next_thinned: 0,
            widest: 1,
        }
    }

    /// Removes all records.
    pub fn clear(&mut self) {
        *self = Self { most_bytes: self.most_bytes, ..Self::of_every(self.every) };
    }

    /// Returns whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.last_cycle().is_none()
    }

    /// Returns the first and the last cycle with a record.
    pub fn cycles(&self) -> Option<RangeInclusive<u64>> {
        let (first, _) = self.blocks().next()?.ends.first()?;
        Some(*first..=self.last_cycle()?)
    }

    /// Returns the last cycle with a record.
    pub fn last_cycle(&self) -> Option<u64> {
        self.open.last_cycle().or_else(|| self.packed.back().and_then(Block::last_cycle))
    }

    /// Returns the marks, in the order of their cycles.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// Returns the last kick of `robot` up to the end of `cycle`.
    pub fn last_kick(&self, robot: RobotId, cycle: u64) -> Option<KickMark> {
        let until = self.kicks.partition_point(|kick| kick.cycle <= cycle);
        self.kicks[..until].iter().rev().find(|kick| kick.robot == robot).copied()
    }

    /// Returns how the leg of `robot` swings at the end of `cycle`, where a cycle takes `period_s`. This is the swing of its next kick if
    /// it has begun, or otherwise of its last kick.
    pub fn swing(&self, robot: RobotId, cycle: u64, period_s: f64, kicks: &KickSettings) -> Option<Swing> {
        let until = self.kicks.partition_point(|kick| kick.cycle <= cycle);
        let swing = |kick: &KickMark| {
            let strikes_s = kick.cycle.saturating_sub(1) as f64 * period_s;
            Swing::of(kick.kick_type, kick.is_reduced, strikes_s, kicks)
        };
        let next = self.kicks[until..].iter().find(|kick| kick.robot == robot).map(swing);
        let begun = next.filter(|next| next.begins_s < cycle as f64 * period_s);
        begun.or_else(|| self.last_kick(robot, cycle).as_ref().map(swing))
    }

    /// Returns the memory that the records take, bytes.
    pub fn size_bytes(&self) -> usize {
        self.packed_bytes + self.open.bytes.len()
    }

    /// Adds the record of a cycle. If it does not follow the last record, all earlier ones are removed.
    ///
    /// # Errors
    /// If the record cannot be encoded.
    pub fn push(&mut self, record: &CycleRecord) -> Result<(), HistoryError> {
        let (cycle, events) = (record.cycle, &record.events);
        if !self.last_cycle().is_some_and(|last| last < cycle && cycle - last <= self.every()) {
            self.clear();
        }
        serde_json::to_writer(&mut self.open.bytes, record).map_err(|error| HistoryError(error.to_string()))?;
        self.open.ends.push((cycle, self.open.bytes.len()));
        self.marks.extend(events.iter().filter_map(|event| Mark::of(event, cycle)));
        self.kicks.extend(events.iter().filter_map(|event| KickMark::of(event, cycle)));
        if self.open.ends.len() == BLOCK || self.open.bytes.len() > LARGEST_BLOCK_BYTES {
            self.pack()?;
        }
        Ok(())
    }

    /// Moves the records of `later` to the end of this history. If they do not follow its last record, its own records are removed.
    ///
    /// # Errors
    /// If records cannot be compressed.
    pub fn append(&mut self, mut later: History) -> Result<(), HistoryError> {
        let Some(cycles) = later.cycles() else { return Ok(()) };
        if !self.last_cycle().is_some_and(|last| last < *cycles.start() && *cycles.start() - last <= self.every()) {
            self.clear();
        }
        for history in [&mut *self, &mut later] {
            if !history.open.ends.is_empty() {
                history.pack()?;
            }
        }
        self.packed_bytes += later.packed_bytes;
        self.packed.append(&mut later.packed);
        self.marks.append(&mut later.marks);
        self.kicks.append(&mut later.kicks);
        self.widest = self.widest.max(later.every());
        self.thin()
    }

    /// Returns the record of `cycle`, or the first record after it. Returns `None` if there is neither.
    ///
    /// # Errors
    /// If the record cannot be decoded.
    pub fn record(&mut self, cycle: u64) -> Result<Option<CycleRecord>, HistoryError> {
        let (bytes, range) = match self.packed.get(self.block_of(cycle)) {
            None => (&self.open.bytes, self.open.find(cycle)),
            Some(packed) => {
                let last = packed.last_cycle().unwrap_or_default();
                if self.unpacked.as_ref().is_none_or(|(unpacked, _)| *unpacked != last) {
                    self.unpacked = Some((last, packed.unpack()?));
                }
                match &self.unpacked {
                    Some((_, bytes)) => (bytes, packed.find(cycle)),
                    None => return Ok(None),
                }
            }
        };
        let Some(range) = range else { return Ok(None) };
        serde_json::from_slice(&bytes[range]).map(Some).map_err(|error| HistoryError(error.to_string()))
    }

    /// Returns the history up to the end of `cycle`, for a match that continues differently from there.
    ///
    /// # Errors
    /// If the records around `cycle` cannot be decoded.
    pub fn until(&self, cycle: u64) -> Result<History, HistoryError> {
        let whole = self.packed.partition_point(|block| block.last_cycle().is_none_or(|last| last <= cycle));
        let part = match self.packed.get(whole) {
            Some(packed) => Block { bytes: packed.unpack()?, ends: packed.ends.clone() },
            None => self.open.clone(),
        };
        let packed: VecDeque<Block> = self.packed.iter().take(whole).cloned().collect();
        Ok(History {
            every: self.every,
            packed_bytes: packed.iter().map(|block| block.bytes.len()).sum(),
            packed,
            open: part.until(cycle),
            marks: self.marks.iter().filter(|mark| mark.cycle <= cycle).copied().collect(),
            kicks: self.kicks.iter().filter(|kick| kick.cycle <= cycle).copied().collect(),
            unpacked: None,
            most_bytes: self.most_bytes,
            next_thinned: 0,
            widest: self.widest,
        })
    }

    /// Returns the most cycles from one record to the next.
    pub fn every(&self) -> u64 {
        self.every.max(self.widest)
    }

    /// Returns the cycle of the last record before `cycle`, and that of the first record at or after it. If there is none after it: `None`
    /// and the last cycle.
    pub fn around(&self, cycle: u64) -> (Option<u64>, u64) {
        let index = self.block_of(cycle);
        let block = self.packed.get(index).unwrap_or(&self.open);
        let place = block.ends.partition_point(|(earlier, _)| *earlier < cycle);
        let before = place.checked_sub(1).map(|place| block.ends[place].0);
        let before = before.or_else(|| self.packed.get(index.checked_sub(1)?)?.last_cycle());
        match block.ends.get(place) {
            Some((found, _)) => (before, *found),
            None => (None, self.last_cycle().unwrap_or_default()),
        }
    }

    /// Returns the index of the block with the first record at or after `cycle`. The index of the open block is the number of packed ones.
    fn block_of(&self, cycle: u64) -> usize {
        self.packed.partition_point(|block| block.last_cycle().is_none_or(|last| last < cycle))
    }

    fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.packed.iter().chain([&self.open])
    }

    fn pack(&mut self) -> Result<(), HistoryError> {
        let mut block = core::mem::take(&mut self.open);
        block.bytes = zstd::bulk::compress(&block.bytes, LEVEL).map_err(|error| HistoryError(error.to_string()))?;
        self.packed_bytes += block.bytes.len();
        self.packed.push_back(block);
        self.thin()
    }

    /// Removes every second record of older blocks while the history takes too much memory.
    fn thin(&mut self) -> Result<(), HistoryError> {
        // Each round thins the older half. Two blocks become one, so that blocks keep their size.
        while self.packed_bytes > self.most_bytes && self.packed.len() > 2 {
            if self.next_thinned >= self.packed.len() / 2 {
                self.next_thinned = 0;
            }
            let at = self.next_thinned;
            let Some(second) = self.packed.remove(at + 1) else { return Ok(()) };
            let joined = self.packed[at].thinned_with(&second)?;
            let gap = joined.ends.windows(2).map(|pair| pair[1].0 - pair[0].0).max().unwrap_or_default();
            let next = self.packed.get(at + 1).unwrap_or(&self.open).ends.first();
            let to_next = next.zip(joined.last_cycle()).map_or(0, |((next, _), last)| next - last);
            self.widest = self.widest.max(gap).max(to_next);
            self.packed_bytes =
                self.packed_bytes + joined.bytes.len() - self.packed[at].bytes.len() - second.bytes.len();
            self.packed[at] = joined;
            self.unpacked = None;
            self.next_thinned += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
