//! Lists what the file of a model leaves open: errors of the real robot that it does not give, and measures taken over from the NAO.

use serde_json::{Map, Value};

use super::field_path::{FieldPath, Segment};
use super::models::{RobotModel, has_a_trunk_of_its_own};
use super::robot_settings::RobotSettings;
use super::types::Scenario;
use naoisis_core::kick_geometry::KickType;

/// Returns the settings with measures, which the model of a robot other than the NAO must give.
fn measured() -> impl Iterator<Item = &'static str> {
    RobotSettings::EXACT.iter().copied().chain(["cameras", "motion"])
}

impl RobotModel {
    /// Returns whether the value at a place is a measure of the NAO, because the file does not have it.
    pub(super) fn is_of_nao(&self, place: &FieldPath) -> bool {
        let fields = place.segments().iter().map_while(|segment| match segment {
            Segment::Field(name) => Some(name.as_str()),
            Segment::Index(_) => None,
        });
        let fields: Vec<&str> = fields.collect();
        fields.first().is_some_and(|part| measured().any(|measured| measured == *part)) && !self.says(&fields.join("."))
    }

    /// Returns the paths of settings, such as `motion.gait`, for which the file gives no errors of the robot. Even a `realistic` match uses
    /// the paper's errors there. Parts that the robot does not have are left out.
    pub fn without_errors(&self) -> Vec<String> {
        let settings = self.all_settings();
        let lacks = |part: &str| match part {
            "kicks" => has_no_kicks(&settings),
            "cameras" | "vision" => has_no_cameras(&settings),
            "sonar" => settings.get("sonar").and_then(|sonar| sonar.get("fitted")) == Some(&Value::Bool(false)),
            _ => false,
        };
        let open = RobotSettings::ERRORS.iter().filter(|(part, fields)| {
            let says = settings.get(*part).is_some_and(|part| fields.is_empty() || says_any(part, fields));
            !says && !lacks(part)
        });
        open.map(|(part, fields)| fields.first().map_or((*part).to_owned(), |field| format!("{part}.{field}")))
            .collect()
    }

    /// Returns the paths of measures, such as `body.base`, that a robot with its own trunk takes over from the NAO, because its file does
    /// not have them. Empty for a file without a trunk, which describes a NAO with changes.
    pub fn measures_of_nao(&self) -> Vec<String> {
        if !has_a_trunk_of_its_own(&self.settings) {
            return Vec::new();
        }
        let own = self.all_settings();
        let nao = RobotModel::named(&Scenario::default().model).unwrap_or_else(|| self.clone()).settings;
        let mut paths = Vec::new();
        // A calibration includes the field of view.
        let is_calibrated = own.get("cameras").is_some_and(|cameras| cameras.get("intrinsics").is_some());
        for part in measured() {
            // The size of images does not matter for a robot without cameras.
            if part == "cameras" && has_no_cameras(&own) {
                continue;
            }
            if let Some(of_nao) = nao.get(part) {
                collect_missing(part, of_nao, own.get(part), &mut paths);
            }
        }
        paths.retain(|path| !is_calibrated || path != "cameras.diagonal_fov_deg");
        paths
    }
}

/// Returns whether settings are of a robot without cameras.
fn has_no_cameras(settings: &Map<String, Value>) -> bool {
    let mounts = settings.get("cameras").and_then(|cameras| cameras.get("mounts"));
    mounts.and_then(Value::as_array).is_some_and(Vec::is_empty)
}

/// Returns whether settings are of a robot whose kicks all have no reach.
fn has_no_kicks(settings: &Map<String, Value>) -> bool {
    let kick = |name: &str| settings.get("kicks")?.get(name);
    let has_no_reach =
        |kick: &Value| kick.get("max_distance_m").and_then(Value::as_f64).is_some_and(|reach_m| reach_m <= 0.0);
    let own = kick("own").and_then(Value::as_object);
    KickType::ALL.iter().all(|of_paper| kick(of_paper.name()).is_some_and(has_no_reach))
        && own.is_none_or(|own| own.values().all(has_no_reach))
}

/// Returns whether a value, or a value in it, has one of these fields.
fn says_any(part: &Value, fields: &[&str]) -> bool {
    let Value::Object(part) = part else { return false };
    part.iter().any(|(name, value)| (fields.contains(&name.as_str()) && !value.is_null()) || says_any(value, fields))
}

/// Collects the paths of values that are not among a robot's own. If a whole group is missing, only its path is collected.
fn collect_missing(path: &str, there: &Value, own: Option<&Value>, paths: &mut Vec<String>) {
    match (there, own) {
        // The looks of a robot are not measures.
        _ if path == "body.look" => {}
        (Value::Object(there), Some(Value::Object(own))) => {
            for (name, value) in there {
                collect_missing(&format!("{path}.{name}"), value, own.get(name), paths);
            }
        }
        (_, None) => paths.push(path.to_owned()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::MODELS;
    use serde_json::json;

    /// Returns the model of a robot with these settings.
    fn model(settings: Value, realistic: Value) -> RobotModel {
        let value =
            json!({ "name": "own", "description": "", "settings": settings, "realistic": realistic, "sources": {} });
        let mut model: RobotModel = serde_json::from_value(value).unwrap();
        super::super::models::leave_out_what_it_lacks(&mut model);
        model
    }

    #[test]
    fn models_that_come_with_the_program_leave_no_measure_open_and_hardly_an_error() {
        for preset in MODELS {
            let model = RobotModel::named(preset.name).unwrap();
            assert_eq!(model.measures_of_nao(), [""; 0], "{}", preset.name);
            let open = if preset.name == "rover" { vec!["sonar.noise", "breakdowns"] } else { vec![] };
            assert_eq!(model.without_errors(), open, "{}", preset.name);
        }
    }

    #[test]
    fn errors_that_a_file_does_not_give_are_named_and_those_of_what_there_is_not_are_none() {
        let torso = json!({ "torso": { "x_m": [-0.1, 0.1], "half_width_m": 0.2, "z_m": [0.0, 0.4] } });
        let blind = model(json!({ "body": torso }), json!({}));
        let open = ["motion.gait", "odometry.noise", "falls", "breakdowns", "hearing", "latency", "messages.loss"];
        assert_eq!(blind.without_errors(), open);
        let own = json!({ "own": { "flap": { "speed_sd": 0.1 } } });
        let realistic = json!({ "kicks": own, "falls": {}, "motion": { "gait": { "step_s": 0.3 } } });
        assert_eq!(
            model(json!({ "body": torso }), realistic).without_errors(),
            ["odometry.noise", "breakdowns", "hearing", "latency", "messages.loss"]
        );
    }

    #[test]
    fn measures_that_are_the_naos_are_named_by_groups() {
        let torso = json!({ "torso": { "half_width_m": 0.2 }, "neck_m": [0, 0, 0.4] });
        let bare = model(json!({ "body": torso, "motion": { "max_linear_mps": 0.5 } }), json!({}));
        assert_eq!(
            bare.measures_of_nao(),
            [
                "body.base", "body.foot_y_m", "body.height_m", "body.lying_height_m", "body.torso.x_m",
                "body.torso.z_m", "body.waistband", "motion.max_angular_degps",
            ]
        );
        assert_eq!(model(json!({ "body": { "height_m": 0.6 } }), json!({})).measures_of_nao(), [""; 0]);
    }
}
