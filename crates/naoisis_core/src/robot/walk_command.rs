//! The walk that a behaviour wants, and what came of it.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;

/// The displacement wanted in this cycle. Null again after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct WalkCommand {
    /// Forward, m, in the robot frame before the turn.
    pub dx: f32,
    /// To the left, m, in the robot frame before the turn.
    pub dy: f32,
    /// Counter-clockwise turn, radians.
    pub dtheta: f32,
}

impl WalkCommand {
    /// A command of these displacements: metres, metres and radians.
    pub const fn new(dx: f32, dy: f32, dtheta: f32) -> Self {
        Self { dx, dy, dtheta }
    }

    /// The displacement of one cycle at these velocities: forward and to the left, m/s, and counter-clockwise, rad/s. The same
    /// walk however long the cycles are.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use naoisis::prelude::*;
    ///
    /// #[derive(Component, Default)]
    /// struct Circler;
    ///
    /// fn circle(clock: Res<CycleClock>, mut robots: Query<&mut WalkCommand, With<Circler>>) {
    ///     for mut walk in &mut robots {
    ///         // Around a circle with a radius of 1 m.
    ///         *walk = WalkCommand::at_velocity(0.15, 0.0, 0.15, &clock);
    ///     }
    /// }
    /// ```
    pub fn at_velocity(forward_mps: f32, left_mps: f32, turn_radps: f32, clock: &CycleClock) -> Self {
        let period = clock.period();
        Self::new(forward_mps * period, left_mps * period, turn_radps * period)
    }

    /// Whether it asks for no motion at all.
    pub fn is_null(self) -> bool {
        self == WalkCommand::default()
    }

    /// The translation, m, in the robot frame before the turn.
    pub fn translation(self) -> Vec2 {
        Vec2::new(self.dx, self.dy)
    }
}
