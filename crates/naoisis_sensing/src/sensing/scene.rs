//! What there is to sense in a cycle: the [`Scene`], gathered once for the sensors of all robots.

use bevy::prelude::*;

use crate::appearance::gather::MatchScene;
pub use crate::appearance::scene::Scene;
use naoisis_core::cycle::{Cycle, CycleSystems};
use naoisis_core::pitch::Pitch;

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
            .add_systems(Cycle, gather_scene.in_set(SensingSystems::Scene));
    }
}

/// The sensors, in the order in which they are read. All read the same instant; the order only settles who draws on a
/// robot's random streams first, and they are separate anyway.
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
    /// What is [late](crate::sensing::latency) is held back.
    Late,
    /// A place for a user's own sensors, and for noise of a user's own on readings that are filled by now.
    Custom,
}

fn gather_scene(source: MatchScene, mut scene: ResMut<Scene>) {
    source.gather(&mut scene);
}
