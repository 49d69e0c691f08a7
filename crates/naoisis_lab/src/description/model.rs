//! Adds the figures that no description has, and writes the text of the model.

use serde_json::{Map, Value, json};

use super::body::Measures;
use super::figures::{Figures, metres};
use crate::calibration::ron_text;
use naoisis_sim::scenario::RobotModel;

/// Height of the hips of the Booster K1, whose gait is scaled for other robots, m.
const K1_HIP_M: f64 = 0.4345;
/// Walking speed of the Booster K1, m/s.
const K1_SPEED_MPS: f64 = 0.6;

/// Sets the figures that no description has: walking, kicks, and the errors of a real robot. All are guesses. Returns the realistic part.
pub(super) fn add_guesses(figures: &mut Figures, measures: &Measures) -> Map<String, Value> {
    // The speed of similar gaits grows with the square root of the legs' length (Froude number).
    let speed = (K1_SPEED_MPS * (measures.hip_m / K1_HIP_M).sqrt() * 20.0).round() / 20.0;
    let speed = speed.max(0.1);
    let reason = "by the length of the legs, as the Booster K1 walks";
    figures.guess("motion.max_linear_mps", json!(speed), reason);
    figures.guess("motion.max_angular_degps", json!(120.0), "as the Booster K1's");
    figures.guess("sonar.fitted", json!(false), "robots of today have none");
    let (front, aside) = (measures.front_m, measures.foot_y_m);
    for (kick, side) in [("left_straight", 1.0), ("right_straight", -1.0)] {
        let beside = |least: f64, most: f64| {
            if side > 0.0 { json!([metres(least), metres(most)]) } else { json!([metres(-most), metres(-least)]) }
        };
        let kick_model = json!({
            "max_distance_m": 6.0,
            "region": {
                "x_m": [metres(front + 0.02), metres(front + 0.28)],
                "y_m": beside(0.0, aside + 0.08),
                "foot_m": [metres(front), metres(side * aside)],
                "best_m": [metres(front + 0.18), metres(side * (aside + 0.005))],
                "direction": "ahead",
            },
        });
        figures.guess(&format!("kicks.{kick}"), kick_model, "by that foot straight ahead, as the Booster K1's");
    }
    // The errors are those of a similar robot: one with legs, or one on wheels.
    let preset = if measures.has_legs { "booster_k1" } else { "rover" };
    let mut realistic = RobotModel::named(preset).map(|model| model.realistic).unwrap_or_default();
    realistic.remove("ball");
    if let Some(Value::Object(motion)) = realistic.get_mut("motion") {
        motion.insert("max_linear_mps".to_owned(), json!(speed));
        motion.insert("max_angular_degps".to_owned(), json!(120.0));
    }
    for part in realistic.keys() {
        let source = format!("guess: as the {preset}'s");
        match part.as_str() {
            "motion" => figures.sources.insert("motion.gait".to_owned(), source),
            "kicks" => {
                let Some(Value::Object(kicks)) = realistic.get(part) else { continue };
                for name in kicks.keys() {
                    figures.sources.insert(format!("kicks.{name}"), source.clone());
                }
                None
            }
            part => figures.sources.insert(part.to_owned(), source),
        };
    }
    realistic
}

/// What has to be measured on the real robot, and how.
pub(super) const TO_MEASURE: [&str; 5] = [
    "walking: speeds to all sides, acceleration, slip (motion; `naoisis calibrate` fits it to a log of walks)",
    "kicks: where the ball must lie, how far it goes, how much it spreads (kicks; `naoisis calibrate`)",
    "the head: how fast it turns (head.max_degps)",
    "the camera: its calibration (--camera-info FILE), its image's size, what it misses (vision.noise; `naoisis calibrate`)",
    "falls and getting up (falls), delays (latency), odometry (odometry.noise)",
];

/// Returns the text of the model's file.
pub(super) fn text(name: &str, file: &str, figures: &Figures, realistic: &Map<String, Value>) -> String {
    let description = format!("{name}, imported from {file}; what no description has is a guess");
    let model = json!({
        "name": name,
        "description": description,
        "settings": figures.settings,
        "realistic": realistic,
        "sources": figures.sources,
    });
    let mut text = format!(
        "// Made by naoisis from {}. `sources` says where each figure is from; those that begin with `guess:` are to be measured:\n",
        file.escape_debug()
    );
    for line in TO_MEASURE {
        text.push_str(&format!("// - {line}\n"));
    }
    text.push_str(&ron_text(&model));
    text.push('\n');
    text
}
