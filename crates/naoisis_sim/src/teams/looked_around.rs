//! Where a player has looked of late.

use bevy::prelude::*;
use core::f32::consts::TAU;
use serde::{Deserialize, Serialize};

use naoisis_core::geometry::wrap_angle;

/// Into so many directions the surroundings are divided.
pub const DIRECTIONS: usize = 12;
/// What is beside the gaze by less than this is seen as well: a little less than half of a NAO's image, radians.
pub const HALF_VIEW: f32 = 0.45;

/// When a player last had each direction in view, s; directions are those of the team frame.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct LookedAround([f32; DIRECTIONS]);

impl LookedAround {
    /// Takes note of where the player looks: an angle, team frame.
    pub fn note(&mut self, gaze: f32, now_s: f32) {
        let gaze = wrap_angle(gaze);
        for (index, looked_s) in self.0.iter_mut().enumerate() {
            let middle = (index as f32 + 0.5) * (TAU / DIRECTIONS as f32);
            // They are less than one and a half turns apart, of which a whole one is nothing.
            let apart = (middle - gaze).abs();
            *looked_s = if apart.min((TAU - apart).abs()) < HALF_VIEW { now_s } else { *looked_s };
        }
    }

    /// How long ago the player looked into a direction, an angle in the team frame: s.
    pub fn age_s(&self, direction: f32, now_s: f32) -> f32 {
        let share = (direction / TAU).rem_euclid(1.0);
        let index = (share * DIRECTIONS as f32) as usize;
        now_s - self.0[index.min(DIRECTIONS - 1)]
    }
}
