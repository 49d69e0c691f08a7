//! Fits camera misalignment and detection rates to sightings.

use bevy::math::{DMat3, DVec3};

use super::log::{LoggedSighting, Motion, Thing};
use super::{
    Calibration, basis, between_robots, groups, jackknife_positive, mean, of_transformed, variance, wrap_degrees,
};
use naoisis_core::camera_model::CameraIntrinsics;
use naoisis_core::statistics::{Estimate, jackknife};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::vision::{ClassNoise, VisionNoise};
use naoisis_sim::scenario::{RobotModel, Scenario};

/// Longest time between two sightings that are compared, s.
const LONGEST_GAP_S: f64 = 0.2;
/// Least number of sightings for a detection curve.
const FOR_A_CURVE: usize = 100;
/// Steepest detection curve. A model's exponent is at most 100.
const STEEPEST: f64 = 60.0;

/// The angular error of a sighting: to the left and down, degrees.
#[derive(Clone, Copy)]
struct Off {
    robot: usize,
    motion: Motion,
    time_s: Option<f64>,
    yaw_deg: f64,
    pitch_deg: f64,
    /// Variance of the pixel error, degrees².
    pixel_variance: f64,
}

/// Fits the figures of sightings.
pub(super) fn fit(sightings: &[LoggedSighting], model: &RobotModel, into: &mut Calibration) {
    if sightings.is_empty() {
        into.lacking.push("vision.noise: no sightings".to_owned());
        return;
    }
    let scenario = model.scenario().unwrap_or_default();
    let offs: Vec<Off> = sightings.iter().filter_map(|sighting| off(sighting, &scenario)).collect();
    gaze(&offs, into);
    for (thing, word, class) in Thing::NAMES {
        let of_thing: Vec<LoggedSighting> =
            sightings.iter().copied().filter(|sighting| sighting.thing == thing).collect();
        if !of_thing.is_empty() {
            let rows: Vec<Detection> = of_thing.iter().map(Detection::of).collect();
            detection(&rows, word, class, into);
        }
    }
}

/// Returns the angular error of a sighting, if the object was detected.
fn off(sighting: &LoggedSighting, scenario: &Scenario) -> Option<Off> {
    let seen = sighting.seen?;
    let bearing = |[x, y]: [f64; 2]| libm::atan2(y, x);
    let depression = |[x, y]: [f64; 2]| libm::atan2(sighting.lens_height_m, libm::hypot(x, y));
    // An object that is seen too far to the right means that the camera looks too far to the left. One that is seen too high means that the
    // camera looks too far down.
    let yaw_deg = wrap_degrees((bearing(sighting.real) - bearing(seen)).to_degrees());
    let pitch_deg = (depression(sighting.real) - depression(seen)).to_degrees();
    let noise = &scenario.settings.vision.noise;
    let pixel = f64::from(class_of(noise, sighting.thing).pixel_sd) / focal_length(&scenario.settings.cameras);
    let head = f64::from(noise.head_angle_sd);
    let pixel_variance = (pixel * pixel + head * head) * 1.0_f64.to_degrees() * 1.0_f64.to_degrees();
    Some(Off {
        robot: sighting.robot,
        motion: sighting.motion,
        time_s: sighting.time_s,
        yaw_deg,
        pitch_deg,
        pixel_variance,
    })
}

fn class_of(noise: &VisionNoise, thing: Thing) -> &ClassNoise {
    match thing {
        Thing::Ball => &noise.ball,
        Thing::GoalPost => &noise.goal_posts,
        Thing::Robot => &noise.robots,
        Thing::Junction => &noise.junctions,
        Thing::PenaltyCross => &noise.penalty_crosses,
        Thing::CentreCircle => &noise.centre_circle,
    }
}

/// Returns the focal length in pixels: pixels per radian at the centre of the image.
pub(super) fn focal_length(cameras: &CameraSettings) -> f64 {
    f64::from(CameraIntrinsics::from(cameras).focal.x)
}

/// Fits bias, spread and correlation of the camera direction.
fn gaze(offs: &[Off], into: &mut Calibration) {
    let robot = |off: &Off| off.robot;
    let pixel =
        |offs: &[Off]| mean(&offs.iter().map(|off| off.pixel_variance).collect::<Vec<f64>>()).unwrap_or_default();
    // Yaw and pitch together, relative to each robot's own mean.
    let within = move |offs: &[Off]| -> Option<f64> {
        let (mut squares, mut degrees) = (0.0, 0.0);
        for of_robot in super::by_robot(offs, robot) {
            for angle in [|off: &Off| off.yaw_deg, |off: &Off| off.pitch_deg] {
                let values: Vec<f64> = of_robot.iter().map(angle).collect();
                squares += variance(&values)? * (values.len() as f64 - 1.0);
                degrees += values.len() as f64 - 1.0;
            }
        }
        Some((squares / degrees - pixel(offs)).max(0.0).sqrt())
    };
    for (motion, name) in [(Motion::Standing, "standing"), (Motion::Walking, "walking")] {
        let of_motion: Vec<Off> = offs.iter().copied().filter(|off| off.motion == motion).collect();
        let estimate = if of_motion.len() < 20 { None } else { jackknife_positive(&groups(&of_motion, robot), within) };
        let needs = format!("{} sightings while {name}; twenty are needed", of_motion.len());
        let path = format!("vision.noise.gaze.{name}_sd_deg");
        into.add(&path, estimate, &basis(&of_motion, "sightings", robot), &needs);
    }
    let all = basis(offs, "sightings", robot);
    // The two means of each robot are two samples of the bias.
    let bias = between_robots(offs, robot, |offs| {
        let of = |angle: fn(&Off) -> f64| {
            Some([mean(&offs.iter().map(angle).collect::<Vec<f64>>())?, chance_of_mean(offs, angle)])
        };
        Some([of(|off| off.yaw_deg)?, of(|off| off.pitch_deg)?])
    });
    into.add("vision.noise.gaze.bias_sd_deg", bias, &all, "sightings of fewer than three robots (column `robot`)");
    if offs.iter().any(|off| off.time_s.is_none()) {
        into.lacking.push("vision.noise.gaze.correlation_s: a column `time_s` in every row".to_owned());
        return;
    }
    let correlation = if offs.len() < 100 { None } else { jackknife_positive(&groups(offs, robot), correlation_s) };
    let lacks = if offs.len() < 100 {
        format!("{} sightings with `time_s`; a hundred are needed", offs.len())
    } else {
        format!(
            "successive errors are independent in these {} sightings, or more than {LONGEST_GAP_S} s apart",
            offs.len()
        )
    };
    into.add("vision.noise.gaze.correlation_s", correlation, &all, &lacks);
}

/// Returns the variance of the mean of one robot with correlated errors, from the means of stretches.
fn chance_of_mean(offs: &[Off], angle: fn(&Off) -> f64) -> f64 {
    let length = offs.len().div_ceil(super::STRETCHES).max(1);
    let means: Vec<f64> =
        offs.chunks(length).filter_map(|offs| mean(&offs.iter().map(angle).collect::<Vec<f64>>())).collect();
    variance(&means).unwrap_or_default() / (means.len() as f64).max(1.0)
}

/// Returns the time constant of the errors. They are a first-order process: the covariance of two errors a time dt apart is exp(-dt / τ)
/// times the variance. Uses pairs of neighbours; pixel errors are independent.
fn correlation_s(offs: &[Off]) -> Option<f64> {
    let (mut products, mut squares, mut gaps, mut pairs) = (0.0, 0.0, 0.0, 0.0);
    for of_robot in super::by_robot(offs, |off| off.robot) {
        for motion in [Motion::Standing, Motion::Walking] {
            let rows: Vec<Off> = of_robot.iter().copied().filter(|off| off.motion == motion).collect();
            for angle in [|off: &Off| off.yaw_deg, |off: &Off| off.pitch_deg] {
                let Some(mean) = mean(&rows.iter().map(angle).collect::<Vec<f64>>()) else { continue };
                for pair in rows.windows(2) {
                    let gap = pair[1].time_s? - pair[0].time_s?;
                    if gap <= 0.0 || gap > LONGEST_GAP_S {
                        continue;
                    }
                    let [one, other] = [angle(&pair[0]) - mean, angle(&pair[1]) - mean];
                    products += one * other;
                    squares += (one * one + other * other) / 2.0 - pair[0].pixel_variance;
                    gaps += gap;
                    pairs += 1.0;
                }
            }
        }
    }
    let correlation = products / squares;
    (pairs > 0.0 && correlation > 0.0 && correlation < 1.0).then(|| -(gaps / pairs) / libm::log(correlation))
}

/// Returns the paths of the figures of a detection curve, in the order of [`Curve::parameters`].
pub(super) fn detection_paths(class: &str) -> [String; 3] {
    ["miss_probability", "falloff.half_distance_m", "falloff.exponent"]
        .map(|name| format!("vision.noise.{class}.{name}"))
}

/// Fits misses and fall-off of a class, or reports what is missing.
fn detection(sightings: &[Detection], word: &str, class: &str, into: &mut Calibration) {
    match detection_curve(sightings) {
        Some(estimates) => {
            let basis = basis(sightings, "sightings", |sighting| sighting.robot);
            for (path, estimate) in detection_paths(class).iter().zip(estimates) {
                into.add(path, Some(estimate), &basis, "");
            }
        }
        None => {
            let (rows, missed) = (sightings.len(), sightings.iter().filter(|sighting| !sighting.is_seen).count());
            let needs = if rows < FOR_A_CURVE {
                format!("{FOR_A_CURVE} rows are needed, those where it was not seen included, from near and far")
            } else if missed == 0 {
                "rows where it was not seen are needed, too".to_owned()
            } else {
                "they show no fall-off with distance; rows from near and far are needed".to_owned()
            };
            into.lacking
                .push(format!("vision.noise.{class}: {rows} rows of `{word}`, {missed} of them not seen; {needs}"));
        }
    }
}

/// Returns the maximum-likelihood misses and fall-off of a class. `None` if the data do not determine the fall-off.
pub(super) fn detection_curve(sightings: &[Detection]) -> Option<[Estimate; 3]> {
    if sightings.len() < FOR_A_CURVE || sightings.iter().all(|sighting| sighting.is_seen) {
        return None;
    }
    let groups = groups(sightings, |sighting| sighting.robot);
    let usual = Curve::new(0.1, 4.0, 6.0);
    // Intervals are those of the unbounded parameters, so that they contain no impossible values.
    let estimate = |index: usize| {
        let found = jackknife(&groups, |sightings| Some(Curve::fitted(sightings, usual).0[index]))?;
        Some(of_transformed(found, |parameter| Curve(DVec3::splat(parameter)).parameters()[index]))
    };
    let estimates = [estimate(0)?, estimate(1)?, estimate(2)?];
    let [_, half_distance_m, exponent] = &estimates;
    // An interval wider than its value is no information.
    let is_known = |estimate: &Estimate| estimate.margin() < estimate.value;
    (is_known(half_distance_m) && is_known(exponent) && exponent.value < STEEPEST).then_some(estimates)
}

/// Whether an object in view was detected, and at which distance.
#[derive(Clone, Copy)]
pub(super) struct Detection {
    pub(super) robot: usize,
    pub(super) distance_m: f64,
    pub(super) is_seen: bool,
}

impl Detection {
    fn of(sighting: &LoggedSighting) -> Self {
        let distance_m = libm::hypot(sighting.real[0], sighting.real[1]);
        Self { robot: sighting.robot, distance_m, is_seen: sighting.seen.is_some() }
    }
}

/// A detection curve: the probability is (1 - miss) / (1 + (d / half)^exponent). The parameters are unbounded: the log
/// odds of a miss, and the logarithms of the half distance in m and of the exponent.
#[derive(Clone, Copy)]
struct Curve(DVec3);

impl Curve {
    /// Creates a curve from a probability, a distance in m and an exponent.
    fn new(miss: f64, half_m: f64, exponent: f64) -> Self {
        Self(DVec3::new(libm::log(miss / (1.0 - miss)), libm::log(half_m), libm::log(exponent)))
    }

    fn parameters(self) -> [f64; 3] {
        let Self(DVec3 { x, y, z }) = self;
        [1.0 / (1.0 + libm::exp(-x)), libm::exp(y), libm::exp(z)]
    }

    /// Returns the detection probability at `distance_m`, and its derivatives by the parameters.
    fn seen_at(self, distance_m: f64) -> (f64, DVec3) {
        let [miss, half_m, exponent] = self.parameters();
        let times = libm::pow(distance_m / half_m, exponent);
        let noticed = 1.0 / (1.0 + times);
        let seen = (1.0 - miss) * noticed;
        let by_times = -seen * noticed * times;
        let slopes =
            DVec3::new(-seen * miss, -by_times * exponent, by_times * exponent * libm::log(distance_m / half_m));
        (seen, slopes)
    }

    /// Returns the maximum-likelihood curve by Fisher scoring. If there are hardly any sightings between always and never detected, the
    /// exponent stays within a factor of e of that of `start`.
    fn fitted(sightings: &[Detection], start: Curve) -> Curve {
        /// Largest change of a parameter in a step.
        const LONGEST_STEP: f64 = 0.5;
        let mut curve = start;
        for _ in 0..100 {
            let mut slope = DVec3::new(0.0, 0.0, start.0.z - curve.0.z);
            let mut information = DMat3::from_diagonal(DVec3::new(1e-6, 1e-6, 1.0));
            for sighting in sightings {
                let (seen, slopes) = curve.seen_at(sighting.distance_m.max(1e-3));
                let weight = 1.0 / (seen * (1.0 - seen)).max(1e-9);
                let off = f64::from(u8::from(sighting.is_seen)) - seen;
                slope += slopes * (weight * off);
                information += DMat3::from_cols(slopes * slopes.x, slopes * slopes.y, slopes * slopes.z) * weight;
            }
            let step = information.inverse() * slope;
            if !step.is_finite() {
                break;
            }
            curve = Curve(curve.0 + step.clamp(DVec3::splat(-LONGEST_STEP), DVec3::splat(LONGEST_STEP)));
            if step.length() < 1e-8 {
                break;
            }
        }
        curve
    }
}
