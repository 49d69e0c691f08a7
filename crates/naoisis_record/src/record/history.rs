//! Keeps the records of a match in memory.
//!
//! A [`History`] has the record of every cycle of a match that is being played or was read from a trace. Records are compressed in blocks.
//! One block at a time is unpacked.

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
/// Size beyond which the oldest blocks are removed, bytes.
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
        }
    }

    /// Removes all records.
    pub fn clear(&mut self) {
        *self = Self::of_every(self.every);
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
        if !self.last_cycle().is_some_and(|last| last < cycle && cycle - last <= self.every) {
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
        if !self.last_cycle().is_some_and(|last| last < *cycles.start() && *cycles.start() - last <= self.every) {
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
        self.forget_oldest();
        Ok(())
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
                    let size = packed.ends.last().map_or(0, |(_, end)| *end);
                    let bytes =
                        zstd::bulk::decompress(&packed.bytes, size).map_err(|error| HistoryError(error.to_string()))?;
                    self.unpacked = Some((last, bytes));
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
            Some(packed) => {
                let size = packed.ends.last().map_or(0, |(_, end)| *end);
                let bytes =
                    zstd::bulk::decompress(&packed.bytes, size).map_err(|error| HistoryError(error.to_string()))?;
                Block { bytes, ends: packed.ends.clone() }
            }
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
        })
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
        self.forget_oldest();
        Ok(())
    }

    /// Removes the oldest records while the history takes too much memory.
    fn forget_oldest(&mut self) {
        while self.packed_bytes > MOST_BYTES
            && let Some(oldest) = self.packed.pop_front()
        {
            self.packed_bytes -= oldest.bytes.len();
            self.unpacked = None;
            let forgotten = oldest.last_cycle().unwrap_or_default();
            self.marks.retain(|mark| mark.cycle > forgotten);
            self.kicks.retain(|kick| kick.cycle > forgotten);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::match_marks::MarkKind;
    use super::*;
    use crate::record::RecordPlugin;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::robot::Roster;
    use naoisis_core::robot::body::Body;
    use naoisis_core::robot::head::HeadAngles;
    use naoisis_core::team::Team;
    use naoisis_sensing::appearance::stride::Stride;
    use naoisis_sim::interface::gather::{CurrentRecord, gather_start};
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn every_record_comes_back_as_it_was() {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        gather_start(app.world_mut());
        let (mut history, mut records) = (History::default(), Vec::new());
        for _ in 0..=200 {
            let record = app.world().resource::<CurrentRecord>().record.clone();
            history.push(&record).unwrap();
            records.push(record);
            app.run_cycles(1);
        }
        assert_eq!(history.cycles(), Some(0..=200));
        // Forwards and backwards, so that blocks are unpacked again.
        for cycle in (0..=200_u64).chain((0..=200).rev().step_by(7)) {
            assert_eq!(history.record(cycle).unwrap().as_ref(), Some(&records[cycle as usize]), "cycle {cycle}");
        }
        assert_eq!(history.record(201).unwrap(), None);
    }

    #[test]
    fn a_history_of_parts_is_that_of_the_whole() {
        let mut whole = History::default();
        let mut parts = [0..=99_u64, 100..=100, 101..=300].map(|cycles| {
            let mut part = History::default();
            cycles.for_each(|cycle| part.push(&empty_record(cycle)).unwrap());
            part
        });
        (0..=300).for_each(|cycle| whole.push(&empty_record(cycle)).unwrap());
        let [joined, later @ ..] = &mut parts;
        later.iter().for_each(|part| joined.append(part.clone()).unwrap());
        joined.append(History::default()).unwrap();
        assert_eq!(joined.cycles(), Some(0..=300));
        assert_eq!(joined.last_cycle(), Some(300));
        for cycle in (0..=301).rev() {
            assert_eq!(joined.record(cycle).unwrap(), whole.record(cycle).unwrap(), "cycle {cycle}");
            assert_eq!(joined.around(cycle), whole.around(cycle), "cycle {cycle}");
        }
        // The joined history continues at its end.
        joined.push(&empty_record(301)).unwrap();
        assert_eq!(joined.cycles(), Some(0..=301));
        // Other records replace it.
        let mut other = History::default();
        other.push(&empty_record(5)).unwrap();
        joined.append(other).unwrap();
        assert_eq!(joined.cycles(), Some(5..=5));
    }

    #[test]
    fn legs_swing_in_playback_as_they_did() {
        for (kick, wind_up_s, ball_y_m) in [
            ("left_straight", 0.0, 0.05),
            ("left_straight", 0.7, 0.05),
            ("left_side", 0.7, -0.05),
            ("left_side", 0.7, 0.05),
        ] {
            let mut app = App::new();
            app.add_plugins((NaoisisPlugins, RecordPlugin));
            let scenario = format!(
                r#"{{ "rules": "free", "ball": {{ "position_m": [0.15, {ball_y_m}] }}, "kicks": {{ "wind_up_s": {wind_up_s} }},
                     "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "from_s": 0.5, "kick": {{ "type": "{kick}" }} }}] }} }}] }}"#
            );
            app.start_match(&Scenario::from_json(&scenario).unwrap()).unwrap();
            gather_start(app.world_mut());
            let id = RobotId::new(Team::Blue, 1);
            let entity = app.world().resource::<Roster>().get(id).unwrap();
            app.world_mut().entity_mut(entity).insert(Stride::default());
            let (mut history, mut live) = (History::default(), Vec::new());
            for _ in 0..60 {
                app.run_cycles(1);
                history.push(&app.world().resource::<CurrentRecord>().record).unwrap();
                live.push(*app.robot::<Stride>(id).unwrap());
            }
            let legs = |stride: Stride| stride.joints(id, HeadAngles::default(), &Body::default()).legs[0];
            for (cycle, live) in (1..).zip(live) {
                let kick = history.swing(id, cycle, 1.0 / 30.0, app.robot::<KickSettings>(id).unwrap());
                let [was, again] = [live, Stride { kick, ..live }].map(legs);
                assert!(
                    (was.hip - again.hip).abs() < 1e-3 && (was.aside - again.aside).abs() < 1e-3,
                    "{scenario}: {cycle}"
                );
            }
        }
    }

    fn empty_record(cycle: u64) -> CycleRecord {
        CycleRecord { cycle, ..default() }
    }

    #[test]
    fn a_jump_of_the_clock_begins_a_new_history() {
        let mut history = History::default();
        let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
        for cycle in 5..=80 {
            let events = if cycle == 7 { vec![goal.clone()] } else { Vec::new() };
            history.push(&CycleRecord { events, ..empty_record(cycle) }).unwrap();
        }
        assert_eq!(history.cycles(), Some(5..=80));
        assert_eq!(history.marks(), [Mark { cycle: 7, kind: MarkKind::Goal, team: Some(Team::Pink) }]);
        history.push(&empty_record(0)).unwrap();
        assert_eq!((history.cycles(), history.marks()), (Some(0..=0), &[][..]));
    }

    #[test]
    fn what_was_until_a_cycle_goes_on_in_another_way() {
        let mut history = History::default();
        for cycle in 0..=200 {
            let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
            let events = if cycle % 100 == 50 { vec![goal] } else { Vec::new() };
            history.push(&CycleRecord { events, ..empty_record(cycle) }).unwrap();
        }
        for last in [0, 63, 64, 100, 199, 200, 500] {
            let mut until = history.until(last).unwrap();
            let last = last.min(200);
            assert_eq!(until.cycles(), Some(0..=last));
            assert_eq!(until.marks().len(), history.marks().iter().filter(|mark| mark.cycle <= last).count());
            until.push(&CycleRecord { time_s: 7.0, ..empty_record(last + 1) }).unwrap();
            assert_eq!(until.cycles(), Some(0..=last + 1));
            for cycle in 0..=last {
                assert_eq!(until.record(cycle).unwrap(), history.record(cycle).unwrap());
            }
        }
    }

    #[test]
    fn where_only_every_so_many_cycles_have_a_record_the_next_one_is_found() {
        let mut history = History::of_every(10);
        for cycle in (0..=2000).step_by(10).chain([2003]) {
            history.push(&empty_record(cycle)).unwrap();
        }
        assert_eq!(history.cycles(), Some(0..=2003));
        for (asked, found) in [(0, 0), (1, 10), (640, 640), (641, 650), (1999, 2000), (2001, 2003)] {
            assert_eq!(history.record(asked).unwrap().map(|record| record.cycle), Some(found));
        }
        assert_eq!(history.record(2004).unwrap(), None);
    }
}
