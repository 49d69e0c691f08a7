//! When a player last looked in each direction.

use bevy::prelude::*;
use core::f32::consts::TAU;
use serde::{Deserialize, Serialize};

use naoisis_core::geometry::wrap_angle;

/// The number of sectors into which directions are divided.
pub const DIRECTIONS: usize = 12;
/// A sector counts as seen if its middle is within this angle of the gaze, radians: a little less than half of a NAO's image.
pub const HALF_VIEW: f32 = 0.45;

/// When a player last had each direction of the team frame in view, s.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct GazeHistory([f32; DIRECTIONS]);

impl GazeHistory {
    /// Records the direction of the gaze, radians, team frame.
    pub fn note(&mut self, gaze: f32, now_s: f32) {
        let gaze = wrap_angle(gaze);
        for (index, looked_s) in self.0.iter_mut().enumerate() {
            let middle = (index as f32 + 0.5) * (TAU / DIRECTIONS as f32);
            // The angles are less than one and a half turns apart; a whole turn counts as zero.
            let apart = (middle - gaze).abs();
            *looked_s = if apart.min((TAU - apart).abs()) < HALF_VIEW { now_s } else { *looked_s };
        }
    }

    /// How long ago the player looked in `direction` (radians, team frame), s.
    pub fn age_s(&self, direction: f32, now_s: f32) -> f32 {
        let share = (direction / TAU).rem_euclid(1.0);
        let index = (share * DIRECTIONS as f32) as usize;
        now_s - self.0[index.min(DIRECTIONS - 1)]
    }
}
