//! Odometry: the pose of the robot according to its steps.
//!
//! **What it measures.** The pose relative to that at the start of the match: the sum of the steps that the legs executed ([`ExecutedStep`]:
//! after limits and the error of the motion), each with an error of its own. It does not include [slip](naoisis_core::robot::gait::Slip),
//! pushes, or being carried by the referee, and it is never corrected.
//!
//! **Units and rate.** Metres and radians, in the frame of the first pose; once a cycle, for the motion of the previous cycle.
//!
//! **Noise.** [`OdometryNoise`]: random errors whose variance grows with the distance walked and the angle turned, so that they do not
//! depend on the duration of a cycle. After 1 m in a straight line, they are `translation_sd_m` along and across the path, and
//! `heading_per_metre_sd` radians of heading. In addition there are systematic factors, 1 by default. The preset `default` (5 cm and 2°
//! after a metre, 3° after a radian) is smaller than most teams assume: HULKs' filter assumes 5 cm along and 1 cm across for each metre of
//! a step, and 0.5°, B-Human's self-locator 20 % of the translation and 30 % of the rotation, rUNSWift's of 2010 a slip factor of 0.9 (so
//! `translation_scale` 1.11).
//!
//! **Truth** ([`OdometrySource::Truth`]) is for debugging: the true motion of the robot, including pushes and being carried.
//!
//! **The real NAO** computes it from its joint angles and the foot that it assumes to support it; it does not measure the slip of its feet
//! and the play in its joints.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sensing::scene::{ScenePlugin, SensingSystems};
use naoisis_core::cycle::Cycle;
use naoisis_core::geometry::{Pose, file_units, to_radians};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::{RandomStream, RandomStreams};
use naoisis_core::robot::gait::StepNoise;
use naoisis_core::robot::motion::{ExecutedStep, WalkCommand};

/// Fills every robot's [`Odometry`].
pub struct OdometryPlugin;

impl Plugin for OdometryPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ScenePlugin>() {
            app.add_plugins(ScenePlugin);
        }
        app.register_type::<OdometrySettings>()
            .register_type::<Odometry>()
            .register_type::<OdometryOrigin>()
            .add_systems(Cycle, count_steps.in_set(SensingSystems::Odometry));
    }
}

/// The measured pose since the start of the match, in the frame of the robot's first pose (m, radians). It drifts, and does not include
/// being carried.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Odometry(pub Pose);

/// Errors of the odometry. In scenario files: `"none"`, `"default"`, or an object with a `preset` and the fields that differ
/// from it.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryNoise {
    /// Standard deviation of the position after 1 m, along and across the path, m. Grows with the square root of the distance.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub translation_sd_m: f32,
    /// Standard deviation of the heading after 1 m, radians (degrees in files). Grows with the square root of the distance.
    #[serde(rename = "heading_per_metre_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 360.0))]
    pub heading_per_metre_sd: f32,
    /// Standard deviation of the heading after a turn of 1 radian, radians (degrees in files). Grows with the square root of the angle.
    #[serde(rename = "rotation_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 360.0))]
    pub rotation_sd: f32,
    /// The measured distance for a metre walked, m.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub translation_scale: f32,
    /// The measured angle for a turn of 1 radian, radians.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub rotation_scale: f32,
}

impl Default for OdometryNoise {
    fn default() -> Self {
        Self {
            translation_sd_m: 0.05,
            heading_per_metre_sd: to_radians(2.0),
            rotation_sd: to_radians(3.0),
            ..Self::none()
        }
    }
}

impl OdometryNoise {
    /// The presets by name.
    pub const PRESETS: [(&'static str, fn() -> Self); 2] = [("none", Self::none), ("default", Self::default)];

    /// The preset `none`: exact measurements.
    pub fn none() -> Self {
        Self {
            translation_sd_m: 0.0,
            heading_per_metre_sd: 0.0,
            rotation_sd: 0.0,
            translation_scale: 1.0,
            rotation_scale: 1.0,
        }
    }

    /// The measurement of an executed step, with errors drawn from `stream`.
    pub fn measure(&self, step: WalkCommand, stream: &mut RandomStream) -> Pose {
        if step.is_null() {
            return Pose::default();
        }
        let Self { translation_sd_m, heading_per_metre_sd, rotation_sd, .. } = *self;
        let error = StepNoise { translation_sd_m, heading_per_metre_sd, rotation_sd }.draw(step, stream);
        Pose::new(
            self.translation_scale * step.dx + error.dx,
            self.translation_scale * step.dy + error.dy,
            self.rotation_scale * step.dtheta + error.dtheta,
        )
    }
}

/// The source of a robot's odometry.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum OdometrySource {
    /// The steps of the legs, with errors.
    #[default]
    Steps,
    /// The true motion, for debugging.
    Truth,
}

/// The pose of the odometry's frame in the pitch frame, while the source is the true motion.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub(crate) struct OdometryOrigin(Option<Pose>);

/// The odometry of a robot.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(Odometry, OdometryOrigin)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct OdometrySettings {
    /// The source of the measurements.
    pub source: OdometrySource,
    /// Errors of the measured steps.
    pub noise: OdometryNoise,
}

impl OdometrySettings {
    /// Odometry without error.
    pub fn exact() -> Self {
        Self { source: OdometrySource::Steps, noise: OdometryNoise::none() }
    }
}

fn count_steps(
    mut robots: Query<(
        &Pose,
        &ExecutedStep,
        &OdometrySettings,
        &mut OdometryOrigin,
        &mut Odometry,
        &mut RandomStreams,
    )>,
) {
    for (&pose, step, settings, mut origin, mut odometry, mut streams) in &mut robots {
        match settings.source {
            OdometrySource::Truth => {
                // If the source changes to the truth in the middle of a match, the robot continues from its measured pose.
                let origin = *origin.0.get_or_insert_with(|| pose.compose(odometry.0.relative(Pose::default())));
                odometry.0 = origin.relative(pose);
            }
            OdometrySource::Steps => {
                if origin.0.is_some() {
                    origin.0 = None;
                }
                if !step.0.is_null() {
                    odometry.0 = odometry.0.compose(settings.noise.measure(step.0, &mut streams.odometry));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::testing::{sense, sensing_app, set, spawn_robot};
    use approx::assert_abs_diff_eq;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::team::Team;

    #[test]
    fn exact_odometry_adds_up_the_steps_from_the_first_pose() {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [-2.0, 1.0, 77.0], [0.0, 0.0]);
        assert_eq!(sense::<Odometry>(&mut app, robot), Odometry::default());
        set(&mut app, robot, ExecutedStep(WalkCommand::new(0.1, 0.0, FRAC_PI_2)));
        sense::<Odometry>(&mut app, robot);
        // After the first step the robot faces left; the second step goes there.
        let Odometry(pose) = sense(&mut app, robot);
        assert_abs_diff_eq!(pose.position, Vec2::new(0.1, 0.1), epsilon = 1e-6);
        assert_abs_diff_eq!(pose.heading.abs(), core::f32::consts::PI, epsilon = 1e-6);
        // Being carried is not a step.
        set(&mut app, robot, (Pose::new(1.0, 1.0, 0.0), ExecutedStep::default()).0);
        set(&mut app, robot, ExecutedStep::default());
        assert_eq!(sense::<Odometry>(&mut app, robot).0, pose);
    }

    #[test]
    fn the_truth_knows_of_being_carried_and_goes_on_where_the_steps_ended() {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [1.0, 0.0, 90.0], [0.0, 0.0]);
        // The robot measured a step of 10 cm that did not move it.
        set(&mut app, robot, ExecutedStep(WalkCommand::new(0.1, 0.0, 0.0)));
        assert_abs_diff_eq!(sense::<Odometry>(&mut app, robot).0.position.x, 0.1, epsilon = 1e-6);
        set(&mut app, robot, OdometrySettings { source: OdometrySource::Truth, ..default() });
        assert_abs_diff_eq!(sense::<Odometry>(&mut app, robot).0.position.x, 0.1, epsilon = 1e-6);
        // Carried by 0.5 m to its right, which is +x of the pitch for a robot that faces +y.
        set(&mut app, robot, Pose::new(1.5, 0.0, FRAC_PI_2));
        let Odometry(pose) = sense(&mut app, robot);
        assert_abs_diff_eq!(pose.position, Vec2::new(0.1, -0.5), epsilon = 1e-6);
    }

    #[test]
    fn errors_after_a_metre_are_the_same_for_short_and_long_steps() {
        let noise = OdometryNoise { heading_per_metre_sd: 0.03, ..default() };
        let mut stream = RandomStream::for_match(3, "odometry test");
        for steps in [10, 100] {
            let length = 1.0 / steps as f32;
            let walks = 4000;
            let mut sums = [0.0f64; 4];
            for _ in 0..walks {
                // Headings are summed separately from positions, so that the drift of one does not bend the other.
                let (mut place, mut heading) = (Vec2::ZERO, 0.0);
                for _ in 0..steps {
                    let step = noise.measure(WalkCommand::new(length, 0.0, 0.0), &mut stream);
                    place += step.position;
                    heading += step.heading;
                }
                sums[0] += f64::from(place.x - 1.0);
                sums[1] += f64::from(place.x - 1.0).powi(2);
                sums[2] += f64::from(place.y).powi(2);
                sums[3] += f64::from(heading).powi(2);
            }
            let mean = |sum: f64| sum / f64::from(walks);
            // Standard error of a mean: sd / sqrt(4000) = 0.0158 sd; of a standard deviation: sd / sqrt(8000) = 0.0112 sd.
            // Four of them: 99.99 % confidence each.
            assert!(mean(sums[0]).abs() < 4.0 * 0.0158 * 0.05);
            for (sum, sd) in [(sums[1], 0.05), (sums[2], 0.05), (sums[3], 0.03)] {
                assert!((mean(sum).sqrt() - sd).abs() < 4.0 * 0.0112 * sd, "{} instead of {sd}", mean(sum).sqrt());
            }
        }
    }

    #[test]
    fn a_turn_errs_in_heading_only_and_a_scale_is_systematic() {
        let noise = OdometryNoise { rotation_scale: 0.9, rotation_sd: 0.1, ..OdometryNoise::default() };
        let mut stream = RandomStream::for_match(4, "odometry test");
        let turns = 10_000;
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        for _ in 0..turns {
            let step = noise.measure(WalkCommand::new(0.0, 0.0, -0.25), &mut stream);
            assert_eq!(step.position, Vec2::ZERO);
            sum += f64::from(step.heading);
            squares += f64::from(step.heading + 0.225).powi(2);
        }
        // sd = 0.1 sqrt(0.25) = 0.05; four standard errors of the mean (0.0005) and of the sd (0.00035): 99.99 %.
        assert!((sum / f64::from(turns) + 0.225).abs() < 4.0 * 0.0005);
        assert!(((squares / f64::from(turns)).sqrt() - 0.05).abs() < 4.0 * 0.00036);
    }

    #[test]
    fn settings_written_by_a_program_read_back() {
        let written = serde_json::to_string(&OdometrySettings::default()).unwrap();
        assert_eq!(serde_json::from_str::<OdometrySettings>(&written).unwrap(), OdometrySettings::default());
    }
}
