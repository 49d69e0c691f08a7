//! The deprecated field `fidelity` of files, which is translated to `source`, `noise` and other settings of the sensors.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::deserialize;
use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::merge::for_each_team_and_robot;
use naoisis_sensing::sensing::fidelity::{Fidelity, FidelitySettings, SensorFidelity};
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::sonar::SonarSettings;
use naoisis_sensing::sensing::vision::VisionSettings;

/// Name of the field in files.
pub(super) const FIELD: &str = "fidelity";

/// Replaces the `fidelity` of a scenario, its teams and its robots by the corresponding settings of the sensors. Presets must be filled in
/// before. Invalid values are removed and become faults.
pub(super) fn translate(root: &mut Map<String, Value>, faults: &mut Vec<ScenarioFault>) {
    let of_all = take(root, &FieldPath::default(), faults);
    let common: Map<String, Value> =
        ["vision", "sonar", "odometry"].iter().filter_map(|&sensor| root.get_key_value(sensor)).map(owned).collect();
    for_each_team_and_robot(root, |settings, path| {
        let own = take(settings, path, faults);
        translate_sensors(settings, own, of_all, &common);
    });
    translate_sensors(root, of_all, FidelitySettings::default(), &Map::new());
}

fn owned((name, value): (&String, &Value)) -> (String, Value) {
    (name.clone(), value.clone())
}

/// Removes the fidelity of an object and returns it. Returns the default if it is missing or invalid; an invalid one becomes a fault.
fn take(holder: &mut Map<String, Value>, path: &FieldPath, faults: &mut Vec<ScenarioFault>) -> FidelitySettings {
    let Some(value) = holder.remove(FIELD) else { return FidelitySettings::default() };
    deserialize::read(&value).unwrap_or_else(|fault| {
        faults.push(ScenarioFault::of_shape(&fault, &path.field(FIELD)));
        FidelitySettings::default()
    })
}

/// Applies the fidelity `own` of an object to its own sensor settings, and to changed copies of the `common` ones.
fn translate_sensors(
    holder: &mut Map<String, Value>,
    own: FidelitySettings,
    of_all: FidelitySettings,
    common: &Map<String, Value>,
) {
    let FidelitySettings { vision, sonar, odometry } = own;
    translate_sensor::<VisionSettings>(holder, "vision", [vision, of_all.vision], common);
    translate_sensor::<SonarSettings>(holder, "sonar", [sonar, of_all.sonar], common);
    translate_sensor::<OdometrySettings>(holder, "odometry", [odometry, of_all.odometry], common);
}

fn translate_sensor<Sensor: SensorFidelity + DeserializeOwned + Serialize>(
    holder: &mut Map<String, Value>,
    name: &str,
    [own, of_all]: [Option<Fidelity>; 2],
    common: &Map<String, Value>,
) {
    let Some(fidelity) = own.or(of_all) else { return };
    // An object without own settings of the sensor uses the common ones.
    if own.is_none() && !holder.contains_key(name) {
        return;
    }
    let nothing = Value::Object(Map::new());
    let settings = holder.get(name).or_else(|| common.get(name)).unwrap_or(&nothing);
    // Settings of the wrong shape are reported when the types are read.
    let Ok(sensor) = deserialize::read::<Sensor>(settings) else { return };
    if let Ok(value) = serde_json::to_value(sensor.with_fidelity(fidelity)) {
        holder.insert(name.to_owned(), value);
    }
}
