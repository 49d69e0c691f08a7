//! A cycle of a match, as the meters read it.

use naoisis_sim::interface::cycle_record::CycleRecord;

/// A cycle of a match.
#[derive(Clone, Copy)]
pub(super) struct MeteredCycle<'a> {
    pub record: &'a CycleRecord,
    /// Whether the ball is in play after the cycle.
    pub is_playing: bool,
    /// Duration of the cycle, s; 0 at the start of measuring.
    pub duration_s: f64,
}
