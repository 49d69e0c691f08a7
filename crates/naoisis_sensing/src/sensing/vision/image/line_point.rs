//! Points on lines, from which lines and crosses are found.

use bevy::prelude::*;

/// Junctions and spots within this distance of a goal post probably belong to the frame of the net, m.
pub(super) const GOAL_M: f32 = 0.5;

/// A point in the middle of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Point {
    pub(super) pixel: Vec2,
    /// On the ground, m, robot frame.
    pub(super) place: Vec2,
    /// The column or row in which it was found.
    pub(super) scan: usize,
    /// The number of the chain: points of one line have the same.
    pub(super) chain: usize,
}
