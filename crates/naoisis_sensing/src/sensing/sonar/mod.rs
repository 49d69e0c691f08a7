//! The two sonars (paper, section 3.1 and Fig. 4).
//!
//! **What they measure.** Each sonar measures the distance to the nearest point of another robot's torso or of a post inside a sector of ±18°
//! about its direction, 19.48° to the left or right of the robot's x axis. The apex is the robot's centre, and distances are measured at
//! the sonar's height, 0.40 m: the ball and legs are too low. The sonars are in the chest, so they turn with the body and not with the head.
//!
//! **Units, range and rate.** Metres, from 0.15 to 0.75. Without an echo in that range there is no reading. An object nearer than the
//! minimum gives no reading either, and hides objects behind it: the manual of 2010 says that "under 15 cm there is no distance
//! information". There is a new reading in each cycle, or at the rate of the pings ([`SonarSettings::rate_hz`]), between which the last one
//! stays.
//!
//! **Noise.** [`SonarNoise`] is added to the distance of an echo, and the sum is clamped to the range; a missed echo
//! ([`SonarSettings::miss_probability`]) gives no reading. The default is a normal distribution with 1 cm standard deviation
//! and no misses: the sensor's resolution is 1 cm, and NaoDevils' simulator has ±1 cm too, and misses 10 % of the echoes.
//!
//! **Crosstalk** ([`SonarSettings::crosstalk_probability`]): two robots with sonars that face each other receive each other's pings. Such a
//! ping arrives at any time, and gives a false reading at a random distance, unless there is a nearer echo. As it travels one way only, it
//! is received from twice the range of an echo.
//!
//! For noise of your own, set [`SonarNoise::None`] and change the [`SonarReading`] in a system in [`SensingSystems::Custom`], with random
//! numbers from a [`RandomStream`] of its own.
//!
//! **The real NAO** measures every 100 ms, receives the pulses of others, and its effective cone is given as 60°.
//! rUNSWift's report of 2010 found spikes ([`SonarNoise::Outliers`]) and readings beyond 1 m unreliable.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::cycle::{Cycle, CycleSystems};
//! use naoisis::random::RandomStream;
//! use naoisis::sensing::scene::SensingSystems;
//! use naoisis::sensing::sonar::SonarReading;
//!
//! /// An old sonar, whose readings are multiples of 5 cm.
//! fn coarse_readings(mut sonars: Query<&mut SonarReading>) {
//!     for mut reading in &mut sonars {
//!         reading.left = reading.left.map(|distance| (distance * 20.0).round() / 20.0);
//!     }
//! }
//!
//! fn plugin(app: &mut App) {
//!     app.add_systems(Cycle, coarse_readings.in_set(SensingSystems::Custom));
//! }
//! ```

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::appearance::scene::Scene;
use crate::sensing::scene::{ScenePlugin, SensesNothing, SensingSystems};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::geometry::Pose;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::{RandomStream, RandomStreams};
use naoisis_core::team::RobotId;

mod crosstalk;
mod echoes;
mod sector;
mod settings;

pub use echoes::echoes;
pub use settings::{SonarNoise, SonarSettings, SonarSource};

use crosstalk::{hears_pings, with_crosstalk};
use echoes::EDGE_M;

/// Tolerance of the time of a ping, for rounding, s.
const EDGE_S: f32 = 1e-5;

/// Fills every robot's [`SonarReading`].
pub struct SonarPlugin;

impl Plugin for SonarPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ScenePlugin>() {
            app.add_plugins(ScenePlugin);
        }
        app.register_type::<SonarSettings>()
            .register_type::<SonarReading>()
            .register_type::<SonarPings>()
            .add_systems(Cycle, measure_distances.in_set(SensingSystems::Sonar));
    }
}

/// The last readings of the two sonars, m; `None` without an echo in range.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct SonarReading {
    /// The left sonar's distance, m.
    pub left: Option<f32>,
    /// The right sonar's distance, m.
    pub right: Option<f32>,
    /// The time of the ping, s since the start of the match; `None` if it was the start of this cycle, as always for sonars without
    /// `rate_hz` and without latency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// The timing of a robot's pings.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub(crate) struct SonarPings {
    /// The time until the next ping, s. Drawn on first use, so that robots do not ping at the same times.
    until_next_s: Option<f32>,
}

impl SonarPings {
    /// Advances by a cycle of `period` seconds, with `rate_hz` pings a second. Returns whether there is a ping in this cycle.
    fn advance(&mut self, rate_hz: f32, period: f32, stream: &mut RandomStream) -> bool {
        let gap_s = rate_hz.recip();
        let until_next_s = self.until_next_s.unwrap_or_else(|| gap_s * stream.uniform()) - period;
        let is_due = until_next_s <= EDGE_S;
        // Cycles longer than the gap have one ping each.
        self.until_next_s = Some(if is_due { (until_next_s + gap_s).max(0.0) } else { until_next_s });
        is_due
    }
}

fn measure_distances(
    scene: Res<Scene>,
    clock: Res<CycleClock>,
    sonars: Query<(&RobotId, &SonarSettings)>,
    mut robots: Query<
        (&RobotId, &Pose, &SonarSettings, &mut SonarPings, &mut SonarReading, &mut RandomStreams),
        Without<SensesNothing>,
    >,
) {
    for (&id, &pose, settings, mut pings, mut reading, mut streams) in &mut robots {
        if !settings.fitted {
            reading.set_if_neq(SonarReading::default());
            continue;
        }
        if settings.source == SonarSource::Echo
            && let Some(rate_hz) = settings.rate_hz
            && !pings.advance(rate_hz, clock.period(), &mut streams.sonar_pings)
        {
            continue;
        }
        *reading = measure(settings, echoes(settings, id, pose, &scene), &mut streams.sonar);
        if settings.source == SonarSource::Echo && settings.rate_hz.is_some() {
            reading.time_s = Some(clock.start_time_s());
        }
        if settings.source == SonarSource::Echo && settings.crosstalk_probability > 0.0 {
            let sonar_of = |other: RobotId| sonars.iter().find(|(id, _)| **id == other).map(|(_, sonar)| sonar);
            let hears = hears_pings(settings, id, pose, &scene, sonar_of);
            *reading = with_crosstalk(settings, *reading, hears, &mut streams.sonar_pings);
        }
    }
}

/// The readings for these true distances to the left and to the right.
pub fn measure(settings: &SonarSettings, [left, right]: [Option<f32>; 2], stream: &mut RandomStream) -> SonarReading {
    let mut listen = |distance: Option<f32>| match settings.source {
        SonarSource::Truth => distance,
        SonarSource::Echo => {
            let distance = distance.filter(|&distance| distance >= settings.min_m - EDGE_M)?;
            if stream.chance(settings.miss_probability) {
                return None;
            }
            let measured = settings.noise.perturb(distance, [settings.min_m, settings.max_m], stream);
            Some(measured.max(settings.min_m).min(settings.max_m))
        }
    };
    SonarReading { left: listen(left), right: listen(right), time_s: None }
}

#[cfg(test)]
mod tests;
