//! The two sonars (paper, section 3.1 and Fig. 4).
//!
//! **What they measure.** Each sonar measures the distance to the nearest point of another robot's torso or of a post inside a sector of ±18°
//! about its direction, 19.48° to the left or right of the robot's x axis. The apex is the robot's centre, and distances are measured at
//! the sonar's height, 0.40 m: the ball and legs are too low. The sonars are in the chest, so they turn with the body and not with the head.
//!
//! **Units, range and rate.** Metres, from 0.15 to 0.75. Without an echo in that range there is no reading. An object nearer than the minimum
//! gives no reading either, and hides objects behind it: the manual of 2010 says that "under 15 cm there is no distance information". There
//! is a new reading in each cycle, or at the rate of the pings ([`SonarSettings::rate_hz`]): in between the last one stays.
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
use core::cell::LazyCell;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::appearance::scene::{Scene, ScenePost, SceneRobot};
use crate::sensing::scene::{ScenePlugin, SensingSystems};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::geometry::{Pose, file_units, to_radians, unit, unrotate};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::{RandomStream, RandomStreams};
use naoisis_core::team::RobotId;

mod sector;

use sector::{Sector, nearer};

/// Tolerance at the ends of the range, for rounding, m.
const EDGE_M: f32 = 1e-6;

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
    /// The time of the ping, s since the start of the match; `None` if it was the start of this cycle, as always for sonars without a
    /// [rate](SonarSettings::rate_hz) and a [latency](naoisis_core::robot::latency).
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

/// The source of a robot's sonar readings.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SonarSource {
    /// The echoes in the sector.
    #[default]
    Echo,
    /// Exact and at any distance in the sector, for debugging.
    Truth,
}

/// The error of a measured distance. Files may also say `"default"`: [`SonarNoise::DEFAULT`].
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", from = "SonarNoiseForm")]
pub enum SonarNoise {
    /// Exact distances.
    #[default]
    None,
    /// Normally distributed.
    Gaussian {
        /// Standard deviation, m.
        sd_m: f32,
    },
    /// Uniformly distributed.
    Uniform {
        /// Greatest deviation to either side, m.
        half_width_m: f32,
    },
    /// Normally distributed, with some readings anywhere in the range.
    Outliers {
        /// Standard deviation of the good readings, m.
        sd_m: f32,
        /// Probability of a reading anywhere between minimum and maximum.
        probability: f32,
    },
}

/// The form of a [`SonarNoise`] in files.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum SonarNoiseForm {
    /// Exact distances.
    None,
    /// Normally distributed, 1 cm.
    Default,
    /// Normally distributed.
    Gaussian {
        /// Standard deviation, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        sd_m: f32,
    },
    /// Uniformly distributed.
    Uniform {
        /// Greatest deviation to either side, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        half_width_m: f32,
    },
    /// Normally distributed, with some readings anywhere in the range.
    Outliers {
        /// Standard deviation of the good readings, m.
        #[schemars(range(min = 0.0, max = 10.0))]
        sd_m: f32,
        /// Probability of a reading anywhere between minimum and maximum.
        #[schemars(range(min = 0.0, max = 1.0))]
        probability: f32,
    },
}

impl From<SonarNoiseForm> for SonarNoise {
    fn from(form: SonarNoiseForm) -> Self {
        match form {
            SonarNoiseForm::None => SonarNoise::None,
            SonarNoiseForm::Default => SonarNoise::DEFAULT,
            SonarNoiseForm::Gaussian { sd_m } => SonarNoise::Gaussian { sd_m },
            SonarNoiseForm::Uniform { half_width_m } => SonarNoise::Uniform { half_width_m },
            SonarNoiseForm::Outliers { sd_m, probability } => SonarNoise::Outliers { sd_m, probability },
        }
    }
}

impl SonarNoise {
    /// The noise of [`SonarSettings::default`]: 1 cm, normally distributed.
    pub const DEFAULT: SonarNoise = SonarNoise::Gaussian { sd_m: 0.01 };

    /// Adds the error to a true distance. The result is not clamped to the range from `min` to `max`, m.
    pub fn perturb(self, distance: f32, [min, max]: [f32; 2], stream: &mut RandomStream) -> f32 {
        match self {
            SonarNoise::None => distance,
            SonarNoise::Gaussian { sd_m } => distance + stream.gaussian(sd_m),
            SonarNoise::Uniform { half_width_m } => distance + half_width_m * (2.0 * stream.uniform() - 1.0),
            SonarNoise::Outliers { sd_m, probability } => {
                if stream.chance(probability) {
                    min + (max - min) * stream.uniform()
                } else {
                    distance + stream.gaussian(sd_m)
                }
            }
        }
    }
}

/// Geometry and noise of a robot's sonars.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(SonarReading, SonarPings)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct SonarSettings {
    /// Whether the robot has sonars.
    pub fitted: bool,
    /// The source of the readings.
    pub source: SonarSource,
    /// Least distance, m: 0.15 (paper, section 3.1).
    #[schemars(range(min = 0.0, max = 10.0))]
    pub min_m: f32,
    /// Greatest distance, m: 0.75 (paper, section 3.1).
    pub max_m: f32,
    /// Direction of the left sonar, radians (degrees in files); the right one is mirrored: 19.48° (paper, Fig. 4b).
    #[serde(rename = "heading_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = -180.0, max = 180.0))]
    pub heading: f32,
    /// Half the opening of the sector, radians (degrees in files): 18° (paper, Fig. 4b).
    #[serde(rename = "half_angle_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.1, max = 90.0))]
    pub half_angle: f32,
    /// Height above the ground, m: 0.40 (paper, Fig. 4b).
    #[schemars(range(min = 0.0, max = 2.0))]
    pub height_m: f32,
    /// Error of the distance.
    pub noise: SonarNoise,
    /// Probability that an echo is missed.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub miss_probability: f32,
    /// Rate of the pings, Hz; `None` for one in each cycle.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub rate_hz: Option<f32>,
    /// Probability that a sonar takes a ping of another robot that faces it for an echo.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub crosstalk_probability: f32,
}

impl Default for SonarSettings {
    fn default() -> Self {
        Self {
            fitted: true,
            source: SonarSource::Echo,
            min_m: 0.15,
            max_m: 0.75,
            heading: to_radians(19.48),
            half_angle: to_radians(18.0),
            height_m: 0.40,
            noise: SonarNoise::DEFAULT,
            miss_probability: 0.0,
            rate_hz: None,
            crosstalk_probability: 0.0,
        }
    }
}

fn measure_distances(
    scene: Res<Scene>,
    clock: Res<CycleClock>,
    sonars: Query<(&RobotId, &SonarSettings)>,
    mut robots: Query<(&RobotId, &Pose, &SonarSettings, &mut SonarPings, &mut SonarReading, &mut RandomStreams)>,
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

/// The true distances to the nearest points in the sectors of the left and the right sonar, up to the greatest range of the settings.
pub fn echoes(settings: &SonarSettings, own_id: RobotId, own_pose: Pose, scene: &Scene) -> [Option<f32>; 2] {
    let range = match settings.source {
        SonarSource::Echo => settings.max_m,
        SonarSource::Truth => f32::INFINITY,
    };
    let may_hear = |place: Vec2, reach: f32| is_near(place - own_pose.position, reach + range + EDGE_M);
    // Computed on first use: usually nothing is near.
    let sectors = LazyCell::new(|| SonarSectors::of(settings, own_pose.forward()));
    let mut nearest = [None, None];
    let mut hear = |distance_to: &dyn Fn(Vec2) -> Option<f32>| {
        nearest[0] = nearer(nearest[0], distance_to(sectors.left_axis));
        nearest[1] = nearer(nearest[1], distance_to(sectors.right_axis));
    };
    for robot in &scene.robots {
        if robot.id != own_id && may_hear(robot.pose.position, robot.reach) {
            let centre = unrotate(sectors.forward, robot.pose.position - own_pose.position);
            let facing = unrotate(sectors.forward, robot.forward);
            hear(&|axis| distance_to_body(sectors.sector, axis, robot, centre, facing, settings.height_m));
        }
    }
    for ScenePost { position, post } in &scene.posts {
        if post.height >= settings.height_m && may_hear(*position, post.radius) {
            let centre = unrotate(sectors.forward, *position - own_pose.position);
            hear(&|axis| sectors.sector.distance_to_disc(unrotate(axis, centre), post.radius));
        }
    }
    nearest.map(|distance| distance.filter(|&distance| distance <= range + EDGE_M))
}

/// The sectors of a robot's two sonars.
#[derive(Clone, Copy)]
struct SonarSectors {
    /// The unit vector along which the robot faces, pitch frame.
    forward: Vec2,
    /// The unit vectors along the sonars' axes, robot frame.
    left_axis: Vec2,
    right_axis: Vec2,
    sector: Sector,
}

impl SonarSectors {
    fn of(settings: &SonarSettings, forward: Vec2) -> Self {
        let left_axis = unit(settings.heading);
        let right_axis = Vec2::new(left_axis.x, -left_axis.y);
        Self { forward, left_axis, right_axis, sector: Sector::new(settings.half_angle) }
    }

    /// Whether `place`, m, robot frame, is in the sector of the left sonar, and of the right one.
    fn contain(&self, place: Vec2) -> [bool; 2] {
        [self.left_axis, self.right_axis].map(|axis| self.sector.contains(unrotate(axis, place)))
    }
}

/// Whether the left and the right sonar receive pings of another robot: each of the two robots is in a sector of the other.
fn hears_pings<'a>(
    settings: &SonarSettings,
    own_id: RobotId,
    own_pose: Pose,
    scene: &Scene,
    sonar_of: impl Fn(RobotId) -> Option<&'a SonarSettings>,
) -> [bool; 2] {
    let sectors = SonarSectors::of(settings, own_pose.forward());
    let mut hears = [false; 2];
    for robot in scene.robots.iter().filter(|robot| robot.id != own_id) {
        let offset = robot.pose.position - own_pose.position;
        let heard = sectors.contain(unrotate(sectors.forward, offset));
        if heard == [false; 2] {
            continue;
        }
        let Some(sender) = sonar_of(robot.id) else { continue };
        let reaches = sender.source == SonarSource::Echo && is_near(offset, 2.0 * sender.max_m);
        // Most robots have the same sonars.
        let is_alike = [sender.heading, sender.half_angle] == [settings.heading, settings.half_angle];
        let others = if is_alike { sectors } else { SonarSectors::of(sender, robot.forward) };
        if reaches && others.contain(unrotate(robot.forward, -offset)) != [false; 2] {
            hears = [hears[0] || heard[0], hears[1] || heard[1]];
        }
    }
    hears
}

/// Adds crosstalk to a reading: with a probability, a false echo anywhere in the range. The nearer of the false and the true echo counts.
fn with_crosstalk(
    settings: &SonarSettings,
    reading: SonarReading,
    [left, right]: [bool; 2],
    stream: &mut RandomStream,
) -> SonarReading {
    let mut listen = |measured: Option<f32>, hears: bool| {
        let false_echo = (hears && stream.chance(settings.crosstalk_probability))
            .then(|| settings.min_m + (settings.max_m - settings.min_m) * stream.uniform());
        nearer(measured, false_echo)
    };
    SonarReading { left: listen(reading.left, left), right: listen(reading.right, right), ..reading }
}

fn is_near(offset: Vec2, distance: f32) -> bool {
    offset.length_squared() <= distance * distance
}

/// The distance to the boxes of a robot's body at the height of the sonar: at the default height, its torso. The robot stands at `centre`
/// and faces along `facing`, both in the frame of the robot with the sonar.
fn distance_to_body(
    sector: Sector,
    axis: Vec2,
    robot: &SceneRobot,
    centre: Vec2,
    facing: Vec2,
    height: f32,
) -> Option<f32> {
    let (centre, facing) = (unrotate(axis, centre), unrotate(axis, facing));
    if !sector.may_contain(centre, robot.reach + EDGE_M) {
        return None;
    }
    let distance_to = |body: naoisis_core::robot::body::BodyBox| {
        let [rear, front] = body.x_m;
        let half_width = body.half_width_m;
        let corners = [(rear, -half_width), (front, -half_width), (front, half_width), (rear, half_width)];
        sector.distance_to_polygon(corners.map(|(x, y)| centre + facing.rotate(Vec2::new(x, y))))
    };
    robot
        .boxes
        .into_iter()
        .filter(|body| (body.z_m[0]..=body.z_m[1]).contains(&height))
        .filter_map(distance_to)
        .reduce(f32::min)
}

/// The readings for these true distances, left and right.
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
