//! Fidelity of sensors: one word for both their source and their noise.
//!
//! Scenarios can state these separately: `source` is where the percepts of a sensor come from (`"vision": { "source": "image" }`), and the
//! `realism` chooses the noise. The word `fidelity` of older files is still read and stands for both, for all robots or for one, for all
//! sensors or for each:
//!
//! ```
//! # use naoisis::prelude::*;
//! # use naoisis::sensing::fidelity::Fidelity;
//! # use naoisis::sensing::sonar::SonarNoise;
//! let scenario = Scenario::from_json(
//!     r#"{ "fidelity": "ideal",
//!          "robots": [{ "number": 1 },
//!                     { "number": 2, "pose": [1, 0, 0], "fidelity": { "sonar": "noisy", "odometry": "truth" } }] }"#,
//! )?;
//! let own = scenario.settings_of(&scenario.robots[1]);
//! assert_eq!(own.vision.fidelity(), Fidelity::Ideal);
//! assert_ne!(own.sonar.noise, SonarNoise::None);
//! # Ok::<(), naoisis::scenario::ScenarioError>(())
//! ```
//!
//! and a program can change the settings of a robot at any time, also in the middle of a match. The code of behaviours does not change:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::sensing::fidelity::{Fidelity, SensorFidelity};
//! use naoisis::sensing::vision::VisionSettings;
//!
//! /// Lets the blue team see without errors.
//! fn remove_errors(mut robots: Query<(&RobotId, &mut VisionSettings)>) {
//!     for (id, mut vision) in &mut robots {
//!         if id.team == Team::Blue {
//!             vision.set_fidelity(Fidelity::Ideal);
//!         }
//!     }
//! }
//! ```
//!
//! | | `truth` | `ideal` | `noisy` | `image` |
//! |---|---|---|---|---|
//! | vision | everything on the pitch | objects in view, exactly | with its noise, or [`VisionNoise::default`] | objects found in rendered images |
//! | sonar | the sector without limits of range | the sector, exactly | with its noise, or [`SonarNoise::DEFAULT`] | as `noisy` |
//! | odometry | the true motion | the steps, exactly | with its noise, or [`OdometryNoise::default`] | as `noisy` |
//!
//! `noisy` keeps the noise of a sensor's settings, and gives those without noise the default one. If no fidelity is given, the settings do
//! not change.

use bevy::prelude::*;
use serde::de::value::StrDeserializer;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::sensing::odometry::{OdometryNoise, OdometrySettings, OdometrySource};
use crate::sensing::sonar::{SonarNoise, SonarSettings, SonarSource};
use crate::sensing::vision::{VisionNoise, VisionSettings, VisionSource};
use naoisis_core::word_or_object;

/// The fidelity of a sensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fidelity {
    /// Perfect and unlimited, for debugging.
    Truth,
    /// With the limits of the sensor, without noise.
    Ideal,
    /// With the sensor's noise.
    #[default]
    Noisy,
    /// From rendered images, for vision; other sensors are noisy.
    Image,
}

/// Settings of a sensor whose fidelity can be chosen.
pub trait SensorFidelity {
    /// Chooses the fidelity. Geometry, ranges and other settings do not change; nor does existing noise if the fidelity is `Noisy`.
    fn set_fidelity(&mut self, fidelity: Fidelity);

    /// The settings with this fidelity; unchanged for `None`.
    #[must_use]
    fn with_fidelity(mut self, fidelity: impl Into<Option<Fidelity>>) -> Self
    where
        Self: Sized,
    {
        if let Some(fidelity) = fidelity.into() {
            self.set_fidelity(fidelity);
        }
        self
    }
}

impl SensorFidelity for VisionSettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        self.source = match fidelity {
            Fidelity::Truth => VisionSource::Truth,
            Fidelity::Ideal | Fidelity::Noisy => VisionSource::Geometric,
            Fidelity::Image => VisionSource::Image,
        };
        match fidelity {
            Fidelity::Truth | Fidelity::Ideal => self.noise = VisionNoise::none(),
            Fidelity::Noisy if self.noise == VisionNoise::none() => self.noise = VisionNoise::default(),
            Fidelity::Noisy | Fidelity::Image => {}
        }
    }
}

impl VisionSettings {
    /// The fidelity that these settings have.
    pub fn fidelity(&self) -> Fidelity {
        match self.source {
            VisionSource::Truth => Fidelity::Truth,
            VisionSource::Image => Fidelity::Image,
            VisionSource::Geometric if self.noise == VisionNoise::none() => Fidelity::Ideal,
            VisionSource::Geometric => Fidelity::Noisy,
        }
    }
}

impl SensorFidelity for SonarSettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        self.source = if fidelity == Fidelity::Truth { SonarSource::Truth } else { SonarSource::Echo };
        match fidelity {
            Fidelity::Truth | Fidelity::Ideal => {
                self.noise = SonarNoise::None;
                self.miss_probability = 0.0;
                self.crosstalk_probability = 0.0;
            }
            Fidelity::Noisy | Fidelity::Image => {
                if self.noise == SonarNoise::None {
                    self.noise = SonarNoise::DEFAULT;
                }
            }
        }
    }
}

impl SensorFidelity for OdometrySettings {
    fn set_fidelity(&mut self, fidelity: Fidelity) {
        self.source = if fidelity == Fidelity::Truth { OdometrySource::Truth } else { OdometrySource::Steps };
        match fidelity {
            Fidelity::Truth | Fidelity::Ideal => self.noise = OdometryNoise::none(),
            Fidelity::Noisy | Fidelity::Image => {
                if self.noise == OdometryNoise::none() {
                    self.noise = OdometryNoise::default();
                }
            }
        }
    }
}

/// The fidelity of each sensor. In files, a word for all sensors, or an object with a word for some; the settings of the others do not
/// change.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect)]
pub struct FidelitySettings {
    /// The vision.
    pub vision: Option<Fidelity>,
    /// The sonars.
    pub sonar: Option<Fidelity>,
    /// The odometry.
    pub odometry: Option<Fidelity>,
}

impl FidelitySettings {
    /// The same for all sensors.
    pub fn all(fidelity: Fidelity) -> Self {
        Self { vision: Some(fidelity), sonar: Some(fidelity), odometry: Some(fidelity) }
    }

    /// Fills unset sensors from `others`.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        Self {
            vision: self.vision.or(others.vision),
            sonar: self.sonar.or(others.sonar),
            odometry: self.odometry.or(others.odometry),
        }
    }

    /// Whether no sensor is set.
    pub fn is_unset(&self) -> bool {
        *self == Self::default()
    }
}

/// Reads a field that is present. A plain `Option` would require `Some(...)` in RON.
pub fn present<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// The object form of [`FidelitySettings`].
#[derive(Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct FidelityFields {
    #[serde(deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    vision: Option<Fidelity>,
    #[serde(deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    sonar: Option<Fidelity>,
    #[serde(deserialize_with = "present", skip_serializing_if = "Option::is_none")]
    odometry: Option<Fidelity>,
}

impl Serialize for FidelitySettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let FidelitySettings { vision, sonar, odometry } = *self;
        match vision {
            Some(fidelity) if *self == FidelitySettings::all(fidelity) => fidelity.serialize(serializer),
            _ => FidelityFields { vision, sonar, odometry }.serialize(serializer),
        }
    }
}

impl From<FidelityFields> for FidelitySettings {
    fn from(FidelityFields { vision, sonar, odometry }: FidelityFields) -> Self {
        Self { vision, sonar, odometry }
    }
}

word_or_object!(
    FidelitySettings,
    FidelityFields,
    "`truth`, `ideal`, `noisy`, `image`, or an object with one of these for a sensor",
    |word, E| Fidelity::deserialize(StrDeserializer::<E>::new(word)).map(FidelitySettings::all)
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::sonar::SonarReading;
    use crate::sensing::testing::{sense, sensing_app, spawn_ball, spawn_post, spawn_robot};
    use crate::sensing::vision::Percepts;
    use naoisis_core::team::Team;

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

    #[test]
    fn noisy_keeps_a_noise_that_is_set_and_ideal_takes_it_away() {
        let coarse = SonarSettings { noise: SonarNoise::Uniform { half_width_m: 0.1 }, ..default() };
        assert_eq!(coarse.with_fidelity(Fidelity::Noisy), coarse);
        let ideal = coarse.with_fidelity(Fidelity::Ideal);
        assert_eq!(ideal.noise, SonarNoise::None);
        assert_eq!(ideal.with_fidelity(Fidelity::Noisy).noise, SonarNoise::DEFAULT);
        assert_eq!(ideal.with_fidelity(None), ideal);
    }

    #[test]
    fn a_word_is_for_all_sensors_and_an_object_for_each() {
        let read = |json: &str| serde_json::from_str::<FidelitySettings>(json);
        assert_eq!(read(r#""truth""#).unwrap(), FidelitySettings::all(Fidelity::Truth));
        let some = read(r#"{ "vision": "ideal", "odometry": "noisy" }"#).unwrap();
        assert_eq!(
            some,
            FidelitySettings { vision: Some(Fidelity::Ideal), sonar: None, odometry: Some(Fidelity::Noisy) }
        );
        for fidelities in [some, FidelitySettings::all(Fidelity::Ideal), FidelitySettings::default()] {
            assert_eq!(read(&serde_json::to_string(&fidelities).unwrap()).unwrap(), fidelities);
        }
        assert!(read(r#""perfect""#).unwrap_err().to_string().contains("unknown variant `perfect`"));
        assert!(read(r#"{ "smell": "truth" }"#).is_err());
    }
}
