//! The [`Scene`] of a cycle, gathered once for the sensors of all robots, and the order of the sensors.

use bevy::prelude::*;

use crate::appearance::gather::MatchScene;
pub use crate::appearance::scene::Scene;
use naoisis_core::cycle::{Cycle, CycleSystems};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::RobotId;

/// Gathers the [`Scene`] in every cycle, and orders the sensors.
pub struct ScenePlugin;

impl Plugin for ScenePlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Scene>()
            .init_resource::<Pitch>()
            .init_resource::<Scene>()
            .configure_sets(
                Cycle,
                (
                    SensingSystems::Scene,
                    SensingSystems::Images,
                    SensingSystems::Vision,
                    SensingSystems::Sonar,
                    SensingSystems::Odometry,
                    SensingSystems::Late,
                    SensingSystems::Custom,
                )
                    .chain()
                    .in_set(CycleSystems::Sense),
            )
            .configure_sets(
                Cycle,
                (
                    SensingSystems::Scene,
                    SensingSystems::Images,
                    SensingSystems::Vision,
                    SensingSystems::Sonar,
                    SensingSystems::Late,
                )
                    .in_set(SightAndSonar),
            )
            .configure_sets(Cycle, SightAndSonar.run_if(not_all_are_blind))
            .add_systems(Cycle, gather_scene.in_set(SensingSystems::Scene));
    }
}

/// The steps of [`CycleSystems::Sense`], in this order. All sensors measure the same instant, and each has its own random streams.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SensingSystems {
    /// The [`Scene`] is gathered.
    Scene,
    /// [`CameraImages`](crate::sensing::camera::CameraImages) are taken.
    Images,
    /// [`Percepts`](crate::sensing::vision::Percepts) are filled.
    Vision,
    /// [`SonarReading`](crate::sensing::sonar::SonarReading)s are filled.
    Sonar,
    /// [`Odometry`](crate::sensing::odometry::Odometry) is filled.
    Odometry,
    /// Readings are [delayed](naoisis_core::robot::latency).
    Late,
    /// For a program's own sensors, and for its own noise on the readings of the others.
    Custom,
}

/// The systems that are needed for robots that see or measure distances.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct SightAndSonar;

/// Marks a robot without vision and sonar: its percepts and its sonar reading stay as they are, and its gaze does not rock. What it does is
/// the same, and so are the random numbers of everything else. If all robots have the mark, only the systems for [`Odometry`](SensingSystems::Odometry) and
/// the [custom](SensingSystems::Custom) ones of [`SensingSystems`] run. The mark is not part of a saved match.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct SensesNothing;

/// Whether there is a robot that senses, or none at all.
fn not_all_are_blind(
    blind: Query<(), With<SensesNothing>>,
    others: Query<(), (With<RobotId>, Without<SensesNothing>)>,
) -> bool {
    blind.is_empty() || !others.is_empty()
}

fn gather_scene(source: MatchScene, mut scene: ResMut<Scene>) {
    source.gather(&mut scene);
}
