//! Strokes of the pen on the pitch.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The least length of a stroke, m. Shorter drags are ignored.
const SHORTEST_M: f32 = 0.05;

/// A stroke of the pen, m, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PenMark {
    /// An arrow from the first point to the second.
    Arrow(Vec2, Vec2),
    /// A circle with this centre through the second point.
    Zone(Vec2, Vec2),
}

/// The pen and its strokes.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct Pen {
    /// Whether the mouse draws.
    pub is_on: bool,
    /// The strokes, oldest first.
    pub marks: Vec<PenMark>,
    /// The start of the stroke in progress.
    begun: Option<Vec2>,
    /// The stroke in progress.
    under_way: Option<PenMark>,
}

impl Pen {
    /// Returns whether a stroke is in progress.
    pub fn is_drawing(&self) -> bool {
        self.begun.is_some()
    }

    /// Returns the stroke in progress, if any.
    pub fn under_way(&self) -> Option<PenMark> {
        self.under_way
    }

    /// Starts a stroke at a position.
    pub fn press(&mut self, at: Vec2) {
        self.begun = Some(at);
    }

    /// Moves the pen to a position of the pitch, with Shift or without.
    pub fn move_to(&mut self, at: Vec2, shift: bool) {
        let Some(begun) = self.begun else { return };
        let is_drag = begun.distance(at) >= SHORTEST_M;
        self.under_way = is_drag.then_some(if shift { PenMark::Zone(begun, at) } else { PenMark::Arrow(begun, at) });
    }

    /// Ends the stroke.
    pub fn release(&mut self) {
        self.begun = None;
        self.marks.extend(self.under_way.take());
    }
}
