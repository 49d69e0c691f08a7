//! What the file of a model leaves open: which errors of a real robot it does not give, and which measures are another robot's.

use serde_json::{Map, Value};

use super::field_path::{FieldPath, Segment};
use super::models::{RobotModel, has_a_trunk_of_its_own};
use super::robot_settings::RobotSettings;
use super::types::Scenario;
use naoisis_core::kick_geometry::KickType;

/// The parts in which a robot that is no NAO has measures that it must say.
fn measured() -> impl Iterator<Item = &'static str> {
    RobotSettings::EXACT.iter().copied().chain(["motion"])
}

impl RobotModel {
    /// Whether what is at a place is a measure of the NAO's, as the file does not say it.
    pub(super) fn is_of_nao(&self, place: &FieldPath) -> bool {
        let fields = place.segments().iter().map_while(|segment| match segment {
            Segment::Field(name) => Some(name.as_str()),
            Segment::Index(_) => None,
        });
        let fields: Vec<&str> = fields.collect();
        fields.first().is_some_and(|part| measured().any(|measured| measured == *part)) && !self.says(&fields.join("."))
    }

    /// Where the file does not say how the robot errs, so that even a `realistic` match has the paper's there: paths of settings, such as
    /// `motion.gait`. What the robot does not have at all is none of them.
    pub fn without_errors(&self) -> Vec<String> {
        let settings = self.all_settings();
        let lacks = |part: &str| match part {
            "kicks" => has_no_kicks(&settings),
            "vision" => has_no_cameras(&settings),
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

    /// The measures that a robot with a trunk of its own has of the NAO, as its file does not say them: paths of settings, such as
    /// `body.base`. A file without a trunk is of a NAO with changes, and has none of them.
    pub fn measures_of_nao(&self) -> Vec<String> {
        if !has_a_trunk_of_its_own(&self.settings) {
            return Vec::new();
        }
        let own = self.all_settings();
        let nao = RobotModel::named(&Scenario::default().model).unwrap_or_else(|| self.clone()).settings;
        let mut paths = Vec::new();
        // A calibration has the field of view.
        let is_calibrated = own.get("cameras").is_some_and(|cameras| cameras.get("intrinsics").is_some());
        for part in measured() {
            // Of a robot without cameras it is no matter how large their images are.
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

/// Whether settings are of a robot without cameras.
fn has_no_cameras(settings: &Map<String, Value>) -> bool {
    let mounts = settings.get("cameras").and_then(|cameras| cameras.get("mounts"));
    mounts.and_then(Value::as_array).is_some_and(Vec::is_empty)
}

/// Whether settings are of a robot whose kicks all have no reach.
fn has_no_kicks(settings: &Map<String, Value>) -> bool {
    let kick = |name: &str| settings.get("kicks")?.get(name);
    let has_no_reach =
        |kick: &Value| kick.get("max_distance_m").and_then(Value::as_f64).is_some_and(|reach_m| reach_m <= 0.0);
    let own = kick("own").and_then(Value::as_object);
    KickType::ALL.iter().all(|of_paper| kick(of_paper.name()).is_some_and(has_no_reach))
        && own.is_none_or(|own| own.values().all(has_no_reach))
}

/// Whether a part, or something in it, has one of these fields.
fn says_any(part: &Value, fields: &[&str]) -> bool {
    let Value::Object(part) = part else { return false };
    part.iter().any(|(name, value)| (fields.contains(&name.as_str()) && !value.is_null()) || says_any(value, fields))
}

/// The paths of what is there and not among a robot's own: of a group that it says nothing of the group.
fn collect_missing(path: &str, there: &Value, own: Option<&Value>, paths: &mut Vec<String>) {
    match (there, own) {
        // What a robot looks like is no measure.
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

    /// The model of a robot with these settings.
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
        let open = ["motion.gait", "odometry.noise", "falls", "breakdowns", "latency", "messages.loss"];
        assert_eq!(blind.without_errors(), open);
        let own = json!({ "own": { "flap": { "speed_sd": 0.1 } } });
        let realistic = json!({ "kicks": own, "falls": {}, "motion": { "gait": { "step_s": 0.3 } } });
        assert_eq!(
            model(json!({ "body": torso }), realistic).without_errors(),
            ["odometry.noise", "breakdowns", "latency", "messages.loss"]
        );
    }

    #[test]
    fn measures_that_are_the_naos_are_named_by_groups() {
        let torso = json!({ "torso": { "half_width_m": 0.2 }, "neck_m": [0, 0, 0.4] });
        let bare = model(json!({ "body": torso, "motion": { "max_linear_mps": 0.5 } }), json!({}));
        assert_eq!(
            bare.measures_of_nao(),
            [
                "body.base",
                "body.foot_y_m",
                "body.height_m",
                "body.lying_height_m",
                "body.torso.x_m",
                "body.torso.z_m",
                "body.waistband",
                "motion.max_angular_degps",
            ]
        );
        assert_eq!(model(json!({ "body": { "height_m": 0.6 } }), json!({})).measures_of_nao(), [""; 0]);
    }
}
