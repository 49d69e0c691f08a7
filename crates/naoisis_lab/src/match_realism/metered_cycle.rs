//! A cycle of a match as the meters read it.

use naoisis_sim::interface::cycle_record::CycleRecord;

/// A cycle of a match.
#[derive(Clone, Copy)]
pub(super) struct MeteredCycle<'a> {
    pub record: &'a CycleRecord,
    /// Whether the ball is in play after it.
    pub is_playing: bool,
    /// Its time, s; 0 where measuring begins.
    pub duration_s: f64,
}
