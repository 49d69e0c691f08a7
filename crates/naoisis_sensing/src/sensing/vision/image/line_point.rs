//! What lines and crosses are found from.

use bevy::prelude::*;

/// Lines that meet nearer than this to a goal post are probably bars that carry the net, m; and spots are parts of them.
pub(super) const GOAL_M: f32 = 0.5;

/// A point in the middle of a line.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Point {
    pub(super) pixel: Vec2,
    /// On the ground, m, robot frame.
    pub(super) place: Vec2,
    /// The column or row in which it was found.
    pub(super) scan: usize,
    /// The points that belong to one line have the same.
    pub(super) chain: usize,
}
