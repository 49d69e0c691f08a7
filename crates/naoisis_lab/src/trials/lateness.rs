//! Trials of the latency of images, sonars and heads.

use serde_json::json;

use super::{Laboratory, MeasuredQuantity, TrialError};
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{to_degrees, wrap_angle};
use naoisis_core::robot::head::HeadAngles;
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

/// The longest latency, s.
const LONGEST_S: f64 = 2.0;

/// Measures the ages of images and echoes when they arrive, and the delay of the head.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let mut quantities = Vec::new();
    if !real.settings.cameras.mounts.as_slice().is_empty() {
        // Small images are as late as large ones.
        let cameras = json!({ "render": "software", "width": 16, "height": 12 });
        let age_s = youngest(&mut laboratory, cameras, |laboratory| {
            let clock = laboratory.app.world().resource::<CycleClock>();
            let taken = laboratory.app.robot::<CameraImages>(super::TRIED)?.cycle?;
            Some((clock.cycle - taken) as f64 * clock.period_s)
        })?;
        quantities.push((
            "from an image to when it can be looked at",
            age_s,
            real.settings.latency.image_s,
            "latency.image_s",
        ));
    }
    if real.settings.sonar.fitted {
        let age_s = youngest(&mut laboratory, json!({}), |laboratory| {
            let now = laboratory.app.world().resource::<CycleClock>().start_time_s();
            Some(now - laboratory.app.robot::<SonarReading>(super::TRIED)?.time_s.unwrap_or(now))
        })?;
        quantities.push(("sonar: from a ping to its echo", age_s, real.settings.latency.sonar_s, "latency.sonar_s"));
    }
    if real.settings.head.moves() && real.settings.head.yaw[0] < real.settings.head.yaw[1] {
        let waits_s = head_waits_s(&mut laboratory, to_degrees(real.settings.head.yaw[1]))?;
        quantities.push(("command to when the head turns", waits_s, real.settings.latency.head_s, "latency.head_s"));
    }
    let quantity = |(name, measured, late_s, path): (&str, f64, f32, &str)| {
        laboratory.quantity(name, "s", measured, f64::from(late_s), path)
    };
    Ok(quantities.into_iter().map(quantity).collect())
}

/// The least age of readings that arrive within the longest latency, s; 0 if there are none.
fn youngest(
    laboratory: &mut Laboratory,
    cameras: serde_json::Value,
    age_s: impl Fn(&Laboratory) -> Option<f64>,
) -> Result<f64, TrialError> {
    laboratory.begin(json!({ "ball": null, "cameras": cameras, "robots": [{ "team": "blue", "number": 1 }] }))?;
    // Before the first reading arrives, there is no age.
    let cycles = laboratory.cycles(LONGEST_S);
    laboratory.app.run_cycles(cycles);
    let mut youngest_s = f64::INFINITY;
    for _ in 0..cycles {
        laboratory.app.run_cycles(1);
        youngest_s = age_s(laboratory).unwrap_or(f64::INFINITY).min(youngest_s);
    }
    Ok(if youngest_s.is_finite() { youngest_s } else { 0.0 })
}

/// The delay of the head when it is commanded to turn as far as it can, s.
fn head_waits_s(laboratory: &mut Laboratory, yaw_deg: f32) -> Result<f64, TrialError> {
    let turns = json!({ "script": [{ "from_s": 0, "head_deg": [yaw_deg, 0] }] });
    laboratory.begin(json!({ "ball": null, "robots": [{ "team": "blue", "number": 1, "behaviour": turns }] }))?;
    let began = laboratory.reading::<HeadAngles>().yaw;
    let cycles = laboratory.cycles(LONGEST_S);
    let waited = (0..cycles).find(|_| {
        laboratory.app.run_cycles(1);
        wrap_angle(laboratory.reading::<HeadAngles>().yaw - began).abs() > 1e-4
    });
    Ok(waited.unwrap_or(cycles) as f64 * laboratory.period_s())
}
