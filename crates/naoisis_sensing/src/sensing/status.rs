//! What a robot knows of its own body and of the game.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sensing::scene::SensingSystems;
use crate::sensing::sonar::SonarReading;
use crate::sensing::vision::Percepts;
use naoisis_core::cycle::{Cycle, CycleSystems};
use naoisis_core::game::Penalty;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::kick::KickPhase;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::robot::posture::Posture;

/// Tells robots what their bodies are doing, in [`CycleSystems::Sense`].
pub struct BodyStatusPlugin;

impl Plugin for BodyStatusPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<BodyStatus>().add_systems(
            Cycle,
            (
                sense_body.in_set(CycleSystems::Sense),
                lie_blind.in_set(CycleSystems::Sense).after(SensingSystems::Sonar).before(SensingSystems::Odometry),
            ),
        );
    }
}

/// What the robot's body is doing.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
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
    /// Lying on the ground: it can get up.
    Fallen,
    /// Getting up.
    GettingUp,
    /// Diving.
    Diving,
    /// Taken off the pitch by the referee.
    Penalised,
}

impl BodyStatus {
    /// Whether the robot can walk and kick.
    pub fn is_free(self) -> bool {
        matches!(self, BodyStatus::Standing | BodyStatus::Walking)
    }
}

/// Who lies has its cameras on the ground or at the sky, and its sonars too: it recognises and hears nothing.
fn lie_blind(mut robots: Query<(&Posture, &mut Percepts, &mut SonarReading)>) {
    for (posture, mut percepts, mut sonar) in &mut robots {
        if !posture.is_upright() {
            *percepts = Percepts::default();
            *sonar = SonarReading::default();
        }
    }
}

fn sense_body(mut robots: Query<(&KickPhase, &ExecutedStep, &Penalty, &Posture, &mut BodyStatus)>) {
    for (kick, step, penalty, posture, mut status) in &mut robots {
        *status = if penalty.is_active() {
            BodyStatus::Penalised
        } else {
            match (*posture, *kick) {
                (Posture::Fallen { .. }, _) => BodyStatus::Fallen,
                (Posture::GettingUp { .. }, _) => BodyStatus::GettingUp,
                (Posture::Diving { .. }, _) => BodyStatus::Diving,
                (Posture::Upright, KickPhase::WindUp { .. }) => BodyStatus::Kicking,
                (Posture::Upright, KickPhase::Recovering { .. }) => BodyStatus::Recovering,
                (Posture::Upright, KickPhase::Ready) if step.0.is_null() => BodyStatus::Standing,
                (Posture::Upright, KickPhase::Ready) => BodyStatus::Walking,
            }
        };
    }
}
