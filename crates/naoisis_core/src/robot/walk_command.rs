//! The walk command of a behaviour.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;

/// The commanded displacement for this cycle. Reset to zero after every cycle.
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

    /// The displacement of one cycle at these velocities, forward and to the left, m/s, and counter-clockwise, rad/s, which does
    /// not depend on the duration of a cycle.
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

    /// Whether all displacements are zero.
    pub fn is_null(self) -> bool {
        self == WalkCommand::default()
    }

    /// The translation, m, in the robot frame before the turn.
    pub fn translation(self) -> Vec2 {
        Vec2::new(self.dx, self.dy)
    }
}
