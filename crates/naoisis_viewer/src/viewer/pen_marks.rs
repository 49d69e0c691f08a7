//! What is drawn with the pen on the pitch.

use bevy::prelude::*;

/// What is shorter was no drag, m.
const SHORTEST_M: f32 = 0.05;

/// Something that was drawn, m, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum PenMark {
    /// From here to there.
    Arrow(Vec2, Vec2),
    /// A circle with this centre, through that place.
    Zone(Vec2, Vec2),
}

/// The pen, and what was drawn with it.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct Pen {
    /// Whether the mouse draws.
    pub is_on: bool,
    /// What was drawn, oldest first.
    pub marks: Vec<PenMark>,
    /// Where the mark that is being drawn begins.
    begun: Option<Vec2>,
    /// That mark.
    under_way: Option<PenMark>,
}

impl Pen {
    /// Whether something is being drawn.
    pub fn is_drawing(&self) -> bool {
        self.begun.is_some()
    }

    /// The mark that is being drawn, if one is.
    pub fn under_way(&self) -> Option<PenMark> {
        self.under_way
    }

    /// The mouse is pressed at a place.
    pub fn press(&mut self, at: Vec2) {
        self.begun = Some(at);
    }

    /// It is at a place of the pitch, with Shift or without.
    pub fn move_to(&mut self, at: Vec2, shift: bool) {
        let Some(begun) = self.begun else { return };
        let is_drag = begun.distance(at) >= SHORTEST_M;
        self.under_way = is_drag.then_some(if shift { PenMark::Zone(begun, at) } else { PenMark::Arrow(begun, at) });
    }

    /// It is let go.
    pub fn release(&mut self) {
        self.begun = None;
        self.marks.extend(self.under_way.take());
    }
}
