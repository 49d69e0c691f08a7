//! The state of a robot's own body, as the robot knows it.

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

/// Updates the [`BodyStatus`] of all robots in [`CycleSystems::Sense`].
pub struct BodyStatusPlugin;

impl Plugin for BodyStatusPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<BodyStatus>().add_systems(
            Cycle,
            (
                sense_body.in_set(CycleSystems::Sense),
                clear_readings_of_lying_robots
                    .in_set(CycleSystems::Sense)
                    .after(SensingSystems::Sonar)
                    .before(SensingSystems::Odometry),
            ),
        );
    }
}

/// The state of the robot's body.
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

/// Clears the readings of cameras and sonars of robots that lie: they point at the ground or the sky.
fn clear_readings_of_lying_robots(mut robots: Query<(&Posture, &mut Percepts, &mut SonarReading)>) {
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
