//! Presets: named fields, rules, balls and noise, and how a scenario's own values are laid over them and over those of its realism.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::sync::LazyLock;

use super::apply_realism;
use super::deserialize;
use super::fault::ScenarioFault;
use super::fidelity;
use super::field_path::FieldPath;
use super::inline_models;
use super::leagues;
use super::merge::{for_each_team_and_robot, lay_over};
use super::message_limits;
use super::preset::{Preset, presets};
use super::realism::RealismSettings;
use super::robot_settings::RobotSettings;
use super::types::{BallSpec, Scenario};
use super::wording::{did_you_mean, one_of, quoted};
use naoisis_core::ball::BallLook;
use naoisis_core::game::Rules;
use naoisis_core::pitch::Pitch;
use naoisis_core::team::Team;
use naoisis_sensing::sensing::odometry::OdometryNoise;
use naoisis_sensing::sensing::vision::VisionNoise;

/// The fields that come with the program: `assets/fields`.
pub const FIELD_PRESETS: &[Preset] = presets![
    "fields":
    "naoisis"
    "hsl2026_small"
    "hsl2026_middle"
    "hsl2026_large"
    "spl2010"
    "spl2025"
];

/// The rules that come with the program: `assets/rules`.
pub const RULES_PRESETS: &[Preset] =
    presets!["rules": "naoisis" "spl2010" "spl2025" "hsl2026" "hsl2026_german_open" "extended" "free"];

/// The balls that come with the program: `assets/balls`.
pub const BALL_PRESETS: &[Preset] =
    presets!["balls": "hsl2026" "hsl2026_large" "hsl2026_small" "naoisis" "spl2010" "spl2025"];

/// Returns the pitch of the preset `name` among the [`FIELD_PRESETS`].
pub fn pitch_preset(name: &str) -> Option<Pitch> {
    preset(FIELD_PRESETS, name)
}

/// Returns the rules of the preset `name` among the [`RULES_PRESETS`].
pub fn rules_preset(name: &str) -> Option<Rules> {
    preset(RULES_PRESETS, name)
}

fn preset<T: DeserializeOwned>(presets: &[Preset], name: &str) -> Option<T> {
    let preset = presets.iter().find(|preset| preset.name == name)?;
    deserialize::read(&preset.value()).ok()
}

impl BallSpec {
    /// Returns the ball `name` among the [`BALL_PRESETS`], at rest on the centre mark.
    pub fn preset(name: &str) -> Option<BallSpec> {
        preset(BALL_PRESETS, name)
    }
}

/// Fills in the values that a file gives by name or leaves out: presets, the common settings of each robot, and jersey numbers. Presets
/// become values only here.
///
/// Returns the faults. Values that cannot be filled in are removed; of an object that names an unknown preset, only the name is removed.
pub fn resolve(root: &mut Map<String, Value>) -> Vec<ScenarioFault> {
    let mut faults = Vec::new();
    let path = FieldPath::default();
    complete_looks(root);
    leagues::lay_under(root, &mut faults);
    inline_models::take_apart(root, RobotSettings::OF_MODEL, &mut faults);
    let mut real = apply_realism::settings_of(root, &mut faults);
    if root.get("ball").is_some_and(Value::is_null) {
        // Without a ball there is nothing to fill in.
        real.remove("ball");
    } else if let Some(ball) = real.get_mut("ball") {
        faults.extend(fill_in_named(ball, &path.field("ball"), BALL_PRESETS).err());
    }
    fill_in_noises(&mut real, &path, &Map::new(), &mut faults);
    for (field, presets) in [("field", FIELD_PRESETS), ("rules", RULES_PRESETS), ("ball", BALL_PRESETS)] {
        if let Some(value) = root.get_mut(field)
            && !(field == "ball" && value.is_null())
            && let Err(fault) = fill_in_named(value, &path.field(field), presets)
        {
            faults.push(fault);
            if !value.is_object() {
                root.remove(field);
            }
        }
    }
    fill_in_noises(root, &path, &real, &mut faults);
    for (field, mut real) in real {
        match root.get_mut(&field) {
            None => {
                root.insert(field, real);
            }
            Some(own @ Value::Object(_)) => {
                lay_over(&mut real, own.take(), &field);
                *own = real;
            }
            Some(_) => {}
        }
    }
    let of_all =
        |field: &str| if field == "messages" { message_limits::common(root) } else { root.get(field).cloned() };
    let of_robots = RobotSettings::OF_PROGRAM.iter().chain(RobotSettings::OF_MODEL);
    let common: Map<String, Value> = of_robots.filter_map(|&field| Some((field.to_owned(), of_all(field)?))).collect();
    let realisms = apply_realism::realisms_of(root);
    for_each_team_and_robot(root, |settings, path| resolve_robot(settings, path, &common, realisms, &mut faults));
    if let Some(Value::Array(robots)) = root.get_mut("robots") {
        number(robots);
    }
    fidelity::translate(root, &mut faults);
    faults
}

/// Writes the looks that are left out by an object with all other fields, such as those in the header of a trace: they have their defaults,
/// and not the values of a league, a model or a preset.
fn complete_looks(settings: &mut Map<String, Value>) {
    static WHOLE: LazyLock<Value> = LazyLock::new(|| serde_json::to_value(Scenario::default()).unwrap_or_default());
    let looks = [
        ("ball", "look", json!(BallLook::default())),
        ("body", "jersey", Value::Null),
        ("field", "unevenness", json!(0.0)),
        ("field", "people", json!(0)),
    ];
    for (field, look, default) in looks {
        let (Some(Value::Object(own)), Some(Value::Object(whole))) = (settings.get_mut(field), WHOLE.get(field)) else {
            continue;
        };
        if whole.keys().all(|name| own.contains_key(name)) {
            own.entry(look).or_insert(default);
        }
    }
}

/// Fills in the own settings of a robot, or of all robots of a team. They are changes of the `common` settings, or of the settings of their
/// own model.
fn resolve_robot(
    robot: &mut Map<String, Value>,
    path: &FieldPath,
    common: &Map<String, Value>,
    realisms: Option<RealismSettings>,
    faults: &mut Vec<ScenarioFault>,
) {
    complete_looks(robot);
    let own_model = apply_realism::model_of(robot, path, RobotSettings::OF_MODEL, faults).zip(realisms);
    let of_model = own_model.map(|(model, realisms)| {
        let mut settings = apply_realism::settings_of_model(&model, realisms);
        settings.retain(|field, _| RobotSettings::OF_MODEL.contains(&field.as_str()));
        message_limits::keep_only(&mut settings);
        fill_in_noises(&mut settings, path, &Map::new(), faults);
        // Settings that the model does not have are those of the paper, whatever the scenario's other robots have.
        for &field in RobotSettings::OF_MODEL {
            // Limits that neither the model nor the scenario has are left out.
            if field == "messages" && !settings.contains_key(field) && !common.contains_key(field) {
                continue;
            }
            let mut base = of_the_match(field, common.get(field));
            if let Some(own) = settings.remove(field) {
                lay_over(&mut base, own, field);
            }
            settings.insert(field.to_owned(), base);
        }
        settings
    });
    let base = of_model.as_ref().unwrap_or(common);
    fill_in_noises(robot, path, base, faults);
    for (field, base) in base {
        let Some(own @ Value::Object(_)) = robot.get_mut(field) else { continue };
        let mut merged = base.clone();
        lay_over(&mut merged, own.take(), field);
        *own = merged;
    }
    for (field, value) in of_model.into_iter().flatten() {
        robot.entry(field).or_insert(value);
    }
}

/// Returns the common settings that belong to the match, whatever a robot's model: how images are made, whether robots see by images, and
/// their jerseys.
fn of_the_match(field: &str, common: Option<&Value>) -> Value {
    let only = |settings: &Map<String, Value>, wanted: &str| {
        let kept = settings.iter().filter(|(name, _)| *name == wanted);
        Value::Object(kept.map(|(name, value)| (name.clone(), value.clone())).collect())
    };
    match (field, common) {
        ("cameras", Some(cameras)) => cameras.clone(),
        ("vision", Some(Value::Object(vision))) => only(vision, "source"),
        ("body", Some(Value::Object(body))) => only(body, "jersey"),
        _ => Value::Object(Map::new()),
    }
}

/// Replaces the name of a preset by its values.
fn fill_in_named(value: &mut Value, path: &FieldPath, presets: &[Preset]) -> Result<(), ScenarioFault> {
    let names: Vec<&str> = presets.iter().map(|preset| preset.name).collect();
    let value_of = |name: &str| presets.iter().find(|preset| preset.name == name).map(Preset::value);
    fill_in(value, path, &names, value_of, || None)
}

/// Fills in the noise presets of the sensors. Without a preset, fields are changes of the noise in the `common` settings.
fn fill_in_noises(
    settings: &mut Map<String, Value>,
    path: &FieldPath,
    common: &Map<String, Value>,
    faults: &mut Vec<ScenarioFault>,
) {
    let results = [
        fill_in_noise(settings, path, "vision", &VisionNoise::PRESETS, common),
        fill_in_noise(settings, path, "odometry", &OdometryNoise::PRESETS, common),
    ];
    faults.extend(results.into_iter().filter_map(Result::err));
}

/// Fills in the noise preset of one sensor.
fn fill_in_noise<Noise: Serialize + Default>(
    settings: &mut Map<String, Value>,
    path: &FieldPath,
    sensor: &str,
    presets: &[(&str, fn() -> Noise)],
    common: &Map<String, Value>,
) -> Result<(), ScenarioFault> {
    let Some(Value::Object(fields)) = settings.get_mut(sensor) else { return Ok(()) };
    let Some(noise) = fields.get_mut("noise") else { return Ok(()) };
    let names: Vec<&str> = presets.iter().map(|(name, _)| *name).collect();
    let value_of = |wanted: &str| {
        let (_, preset) = presets.iter().find(|(name, _)| *name == wanted)?;
        serde_json::to_value(preset()).ok()
    };
    let of_common = common.get(sensor).and_then(|settings| settings.get("noise"));
    let base = || of_common.cloned().or_else(|| serde_json::to_value(Noise::default()).ok());
    let filled = fill_in(noise, &path.field(sensor).field("noise"), &names, value_of, base);
    if filled.is_err() && !noise.is_object() {
        fields.remove("noise");
    }
    filled
}

/// Replaces the name of a preset, or an object with `preset`, by the preset's values with the object's own values laid over them. An object
/// without a preset is laid over `base`, if there is one.
fn fill_in(
    value: &mut Value,
    path: &FieldPath,
    names: &[&str],
    value_of: impl Fn(&str) -> Option<Value>,
    base: impl Fn() -> Option<Value>,
) -> Result<(), ScenarioFault> {
    let lay_over_base = |value: &mut Value| {
        if let Some(mut base) = base() {
            lay_over(&mut base, value.take(), "");
            *value = base;
        }
    };
    let (name, name_path) = match value {
        Value::String(name) => (Some(core::mem::take(name)), path.clone()),
        Value::Object(fields) => match fields.remove("preset") {
            None => {
                lay_over_base(value);
                return Ok(());
            }
            Some(Value::String(name)) => (Some(name), path.field("preset")),
            Some(_) => (None, path.field("preset")),
        },
        _ => (None, path.clone()),
    };
    let found = name.as_deref().and_then(&value_of);
    let Some(mut preset) = found else {
        let message = match &name {
            Some(name) => {
                let meant = did_you_mean(name, names.iter().copied());
                format!("there is no preset {}{meant}", quoted(name))
            }
            None => format!("{} is not the name of a preset", quoted(name_path.last_field().unwrap_or_default())),
        };
        let or_object = if name_path == *path { ", or an object with fields" } else { "" };
        let expected = format!("{}{or_object}", one_of(names.iter().copied()));
        if value.is_object() {
            lay_over_base(value);
        }
        return Err(ScenarioFault::new(name_path, message, expected));
    };
    if value.is_object() {
        let field = path.last_field().unwrap_or_default();
        lay_over(&mut preset, value.take(), field);
    }
    *value = preset;
    Ok(())
}

/// Gives robots without a jersey number the smallest free number of their team.
fn number(robots: &mut [Value]) {
    let team_of =
        |robot: &Value| robot.get("team").and_then(Value::as_str).unwrap_or(Team::default().name()).to_owned();
    for index in 0..robots.len() {
        if robots[index].get("number").is_some() {
            continue;
        }
        let team = team_of(&robots[index]);
        let taken: Vec<u64> = robots
            .iter()
            .filter(|robot| team_of(robot) == team)
            .filter_map(|robot| robot.get("number").and_then(Value::as_u64))
            .collect();
        let Some(free) = (1..=u64::from(u8::MAX)).find(|number| !taken.contains(number)) else { continue };
        if let Value::Object(robot) = &mut robots[index] {
            robot.insert("number".to_owned(), free.into());
        }
    }
}

#[cfg(test)]
mod tests;
