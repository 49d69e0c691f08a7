//! What a robot knows of its own body and of the game.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cycle::{Cycle, CycleSystems};
use crate::knowledge::Knowledge;
use crate::referee::Penalty;
use crate::robot::kick::KickPhase;
use crate::robot::motion::ExecutedStep;

/// Tells robots what their bodies are doing, in [`CycleSystems::Sense`].
pub struct BodyStatusPlugin;

impl Plugin for BodyStatusPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<BodyStatus>().add_systems(Cycle, sense_body.in_set(CycleSystems::Sense));
    }
}

/// What the robot's body is doing.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[serde(rename_all = "snake_case")]
pub enum BodyStatus {
    /// Standing, free to act.
    #[default]
    Standing,
    /// Walking.
    Walking,
    /// Swinging the leg for a kick.
    Kicking,
    /// Regaining balance after a kick.
    Recovering,
    /// Taken off the pitch by the referee.
    Penalised,
}

fn sense_body(mut robots: Query<(&KickPhase, &ExecutedStep, &Penalty, &mut BodyStatus)>) {
    for (kick, step, penalty, mut status) in &mut robots {
        *status = if penalty.is_active() {
            BodyStatus::Penalised
        } else {
            match kick {
                KickPhase::WindUp { .. } => BodyStatus::Kicking,
                KickPhase::Recovering { .. } => BodyStatus::Recovering,
                KickPhase::Ready if step.0.is_null() => BodyStatus::Standing,
                KickPhase::Ready => BodyStatus::Walking,
            }
        };
    }
}
