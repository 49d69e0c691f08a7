//! How true a sensor is: perfect, exact or noisy, for each robot and sensor.
//!
//! In a scenario, a sensor's `source` and `noise` say it; a program changes the settings of a robot at any time, also in
//! the middle of a match:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::sensing::fidelity::{Fidelity, SensorFidelity};
//! use naoisis::sensing::vision::VisionSettings;
//!
//! /// Lets the blue team see without errors.
//! fn clear_eyes(mut robots: Query<(&RobotId, &mut VisionSettings)>) {
//!     for (id, mut vision) in &mut robots {
//!         if id.team == Team::Blue {
//!             vision.set_fidelity(Fidelity::Ideal);
//!         }
//!     }
//! }
//! ```
//!
//! | | `truth` | `ideal` | `noisy` |
//! |---|---|---|---|
//! | vision | everything on the pitch | what is in view, exactly | with [`VisionNoise::default`] |
//! | sonar | the sector without limits of range | the sector, exactly | with [`SonarNoise::DEFAULT`] |
//! | odometry | the steps, exactly | the steps, exactly | with [`OdometryNoise::default`] |

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::sensing::odometry::{OdometryNoise, OdometrySettings};
use crate::sensing::sonar::{SonarNoise, SonarSettings, SonarSource};
use crate::sensing::vision::{VisionNoise, VisionSettings, VisionSource};

/// How true a sensor is.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// Perfect and unlimited, for debugging.
    Truth,
    /// Limited as the sensor is, without noise.
    Ideal,
    /// With the sensor's default noise.
    #[default]
    Noisy,
}

/// Settings of a sensor whose fidelity can be chosen.
pub trait SensorFidelity {
    /// Chooses it, in place of whatever noise is set. Geometry, ranges and other settings stay.
    fn set_fidelity(&mut self, fidelity: Fidelity);

    /// The same settings with another fidelity.
    fn with_fidelity(mut self, fidelity: Fidelity) -> Self
    where
        Self: Sized,
    {
        self.set_fidelity(fidelity);
        self
    }
}

impl SensorFidelity for VisionSettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        (self.source, self.noise) = match fidelity {
            Fidelity::Truth => (VisionSource::Truth, VisionNoise::none()),
            Fidelity::Ideal => (VisionSource::Geometric, VisionNoise::none()),
            Fidelity::Noisy => (VisionSource::Geometric, VisionNoise::default()),
        };
    }
}

impl SensorFidelity for SonarSettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        (self.source, self.noise) = match fidelity {
            Fidelity::Truth => (SonarSource::Truth, SonarNoise::None),
            Fidelity::Ideal => (SonarSource::Echo, SonarNoise::None),
            Fidelity::Noisy => (SonarSource::Echo, SonarNoise::DEFAULT),
        };
        self.miss_probability = 0.0;
    }
}

impl SensorFidelity for OdometrySettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        self.noise = match fidelity {
            Fidelity::Truth | Fidelity::Ideal => OdometryNoise::none(),
            Fidelity::Noisy => OdometryNoise::default(),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Team;
    use crate::sensing::sonar::SonarReading;
    use crate::sensing::testing::{sense, sensing_app, spawn_ball, spawn_post, spawn_robot};
    use crate::sensing::vision::Percepts;

    #[test]
    fn noisy_is_the_default_of_every_sensor() {
        assert_eq!(VisionSettings::default().with_fidelity(Fidelity::Noisy), VisionSettings::default());
        assert_eq!(SonarSettings::default().with_fidelity(Fidelity::Noisy), SonarSettings::default());
        assert_eq!(OdometrySettings::default().with_fidelity(Fidelity::Noisy), OdometrySettings::default());
    }

    #[test]
    fn a_robots_fidelity_changes_in_the_middle_of_a_match() {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 0.0]);
        spawn_ball(&mut app, -2.0, 0.0);
        // 2 m away along the left sonar's axis.
        spawn_post(&mut app, 2.05 * 0.942_76, 2.05 * 0.333_48, None);
        let mut choose = |fidelity| {
            let mut entity = app.world_mut().entity_mut(robot);
            entity.get_mut::<VisionSettings>().unwrap().set_fidelity(fidelity);
            entity.get_mut::<SonarSettings>().unwrap().set_fidelity(fidelity);
            let percepts = sense::<Percepts>(&mut app, robot);
            (percepts.ball.is_some(), app.world().get::<SonarReading>(robot).unwrap().left.is_some())
        };
        assert_eq!(choose(Fidelity::Ideal), (false, false));
        assert_eq!(choose(Fidelity::Truth), (true, true));
        assert_eq!(choose(Fidelity::Noisy), (false, false));
    }
}
