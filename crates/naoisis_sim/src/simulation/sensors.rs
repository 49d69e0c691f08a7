//! Custom sensors: settings in scenario files, readings for behaviours, in traces and in saved matches.
//!
//! A sensor consists of two components and a system: its settings, its reading, and the system that updates the reading.
//!
//! The page "A sensor" of the guide has an example.
//!
//! Every robot has the sensor, with its default settings. `"sensors"` in a scenario changes them for all robots or for one, and `null`
//! removes the sensor. A trace has the readings under `"sensors"` of each robot. The built-in sensors of this form, such as the
//! [`imu`](naoisis_sensing::sensing::imu), are there for robots that programs play in `realistic` vision, and for robots that are given
//! settings of them, if only `{}`.

use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;
use bevy::reflect::{GetTypeRegistration, TypeRegistry, Typed};
use core::any::TypeId;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

use crate::scenario::{FieldPath, Realism, RobotSpec, Scenario, ScenarioFault, read_settings, unknown_name};
use naoisis_core::behaviour::Remote;
use naoisis_core::cycle::{Cycle, CycleSystems};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::named_values::NamedValues;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::scene::SensingSystems;

/// The settings of a sensor: a component that is read from files and saved with a match.
pub trait SensorSettings: Component + Default + DeserializeOwned + Reflect + Typed + GetTypeRegistration {}

impl<T: Component + Default + DeserializeOwned + Reflect + Typed + GetTypeRegistration> SensorSettings for T {}

/// The reading of a sensor: a component that is written to traces and saved with a match. Its default is the reading of a robot that has
/// not sensed yet.
pub trait SensorReading: Component + Default + Serialize + Reflect + Typed + GetTypeRegistration {}

impl<T: Component + Default + Serialize + Reflect + Typed + GetTypeRegistration> SensorReading for T {}

/// Why a sensor was refused.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("sensor `{sensor}` is refused: {reason}")]
#[non_exhaustive]
pub struct SensorError {
    /// The intended name of the sensor.
    pub sensor: String,
    /// What is wrong with it.
    pub reason: SensorErrorKind,
}

naoisis_core::debug_as_displayed!(SensorError);

/// The reason why a sensor is refused.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorErrorKind {
    /// The name is not valid.
    #[error("its name is no word of lower-case letters, digits and underscores")]
    NotAName,
    /// The name belongs to another sensor.
    #[error("another sensor has this name; give it a name of its own")]
    NameTaken,
    /// The settings or the reading belong to another sensor.
    #[error("`{component}` is another sensor's; give each sensor components of its own")]
    ComponentTaken {
        /// The component's type.
        component: String,
    },
    /// The settings accept fields that do not exist, so that misspelt ones would be ignored.
    #[error("`{component}` accepts fields that it does not have; add `#[serde(deny_unknown_fields)]` to it")]
    AcceptsUnknownFields {
        /// The component's type.
        component: String,
    },
    /// A component is not marked with who may know it, or cannot be saved.
    #[error(
        "`{component}` lacks a part of its mark; it needs `#[derive(Reflect)]` and `#[reflect(Component, @Knowledge::{mark:?})]`"
    )]
    NotMarked {
        /// The component's type.
        component: String,
        /// The mark that it needs.
        mark: Knowledge,
    },
    /// There are robots already, which would lack the sensor.
    #[error("it is registered while a match is on; register sensors before the match starts")]
    MatchIsOn,
}

naoisis_core::debug_as_displayed!(SensorErrorKind);

/// Methods of [`App`] that register sensors.
pub trait SensorApp {
    /// Registers a sensor: `system` updates the `Reading` of each robot according to its `Settings`. It runs with the built-in sensors,
    /// before the behaviours. It belongs to the simulation and may read the true state. Behaviours may read the measurements.
    ///
    /// # Errors
    /// [`SensorError`] if the name or a component belongs to another sensor, or a component is not marked with who may know it.
    fn try_add_sensor<Settings: SensorSettings, Reading: SensorReading, M>(
        &mut self,
        name: &str,
        system: impl IntoScheduleConfigs<ScheduleSystem, M>,
    ) -> Result<&mut Self, SensorError>;

    /// Does the same as [`SensorApp::try_add_sensor`], for a sensor that cannot be refused.
    ///
    /// # Panics
    /// If the sensor is refused.
    #[track_caller]
    fn add_sensor<Settings: SensorSettings, Reading: SensorReading, M>(
        &mut self,
        name: &str,
        system: impl IntoScheduleConfigs<ScheduleSystem, M>,
    ) -> &mut Self {
        match self.try_add_sensor::<Settings, Reading, M>(name, system) {
            Ok(app) => app,
            Err(error) => panic!("{error}"),
        }
    }
}

impl SensorApp for App {
    fn try_add_sensor<Settings: SensorSettings, Reading: SensorReading, M>(
        &mut self,
        name: &str,
        system: impl IntoScheduleConfigs<ScheduleSystem, M>,
    ) -> Result<&mut Self, SensorError> {
        register::<Settings, Reading, M>(self, name, false, system).map(|()| self)
    }
}

/// Registers a sensor that robots have where a scenario, league, model or robot names it, or where a program plays a realistic robot.
///
/// # Errors
/// As for [`SensorApp::try_add_sensor`].
pub(super) fn add_optional_sensor<Settings: SensorSettings, Reading: SensorReading, M>(
    app: &mut App,
    name: &str,
    system: impl IntoScheduleConfigs<ScheduleSystem, M>,
) -> Result<(), SensorError> {
    register::<Settings, Reading, M>(app, name, true, system)
}

fn register<Settings: SensorSettings, Reading: SensorReading, M>(
    app: &mut App,
    name: &str,
    is_optional: bool,
    system: impl IntoScheduleConfigs<ScheduleSystem, M>,
) -> Result<(), SensorError> {
    let refuse = |reason| Err(SensorError { sensor: name.to_owned(), reason });
    let is_word = |letter: u8| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == b'_';
    if name.is_empty() || !name.bytes().all(is_word) {
        return refuse(SensorErrorKind::NotAName);
    }
    if accepts_unknown_fields::<Settings>() {
        return refuse(SensorErrorKind::AcceptsUnknownFields { component: Settings::type_path().to_owned() });
    }
    app.register_type::<Settings>().register_type::<Reading>();
    {
        let types = app.world().resource::<AppTypeRegistry>().read();
        let settings = mark_of::<Settings>(&types);
        if settings.is_none() {
            return refuse(not_marked::<Settings>(Knowledge::Public));
        }
        if mark_of::<Reading>(&types) != Some(Knowledge::Sensor) {
            return refuse(not_marked::<Reading>(Knowledge::Sensor));
        }
    }
    let robots = app.world().try_query_filtered::<(), With<RobotId>>();
    if robots.is_some_and(|mut robots| robots.iter(app.world()).next().is_some()) {
        return refuse(SensorErrorKind::MatchIsOn);
    }
    let mut registry = app.world_mut().get_resource_or_init::<SensorRegistry>();
    if registry.sensors.contains_key(name) {
        return refuse(SensorErrorKind::NameTaken);
    }
    for (id, component) in
        [(TypeId::of::<Settings>(), Settings::type_path()), (TypeId::of::<Reading>(), Reading::type_path())]
    {
        if registry.sensors.values().any(|sensor| sensor.components.contains(&id)) {
            return refuse(SensorErrorKind::ComponentTaken { component: component.to_owned() });
        }
    }
    let turn = registry.sensors.len();
    registry.sensors.insert(name.to_owned(), Sensor { is_optional, ..Sensor::of::<Settings, Reading>() });
    // Sensors may use the same random streams, so they run in the order of their registration.
    let write_down = write_down::<Reading>(name.to_owned()).run_if(resource_exists::<ReadingsAreRecorded>);
    app.add_systems(Cycle, (system.into_configs(), write_down.into_configs()).chain().in_set(SensorTurn(turn)));
    app.configure_sets(Cycle, SensorTurn(turn).in_set(SensingSystems::Custom));
    // Without the `SensingPlugin`, nothing else says when they run.
    app.configure_sets(Cycle, SensingSystems::Custom.in_set(CycleSystems::Sense));
    for earlier in 0..turn {
        app.configure_sets(Cycle, SensorTurn(turn).after(SensorTurn(earlier)));
    }
    Ok(())
}

/// The system set of a registered sensor, by its index.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct SensorTurn(usize);

/// Returns whether `T` can be read from a table with a field that it cannot know.
pub(super) fn accepts_unknown_fields<T: DeserializeOwned>() -> bool {
    serde_json::from_value::<T>(serde_json::json!({ "\u{0}": null })).is_ok()
}

/// Returns the mark of a component, if it can be saved.
fn mark_of<C: Component>(types: &TypeRegistry) -> Option<Knowledge> {
    types.get_type_data::<ReflectComponent>(TypeId::of::<C>())?;
    Knowledge::of_type(types, TypeId::of::<C>())
}

fn not_marked<C: Component + Typed>(mark: Knowledge) -> SensorErrorKind {
    SensorErrorKind::NotMarked { component: C::type_path().to_owned(), mark }
}

/// Marks a world in which readings of custom sensors are recorded.
#[derive(Resource, Default)]
pub struct ReadingsAreRecorded;

/// The readings of a robot's custom sensors by name, in the form of traces.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect)]
#[reflect(Component, @Knowledge::Truth)]
pub struct SensorRecord(NamedValues);

impl SensorRecord {
    /// Returns the readings, by the names of the sensors.
    pub fn readings(&self) -> &BTreeMap<String, Value> {
        &self.0.0
    }
}

fn write_down<Reading: SensorReading>(sensor: String) -> impl FnMut(Query<(&Reading, &mut SensorRecord)>) {
    move |mut robots| {
        for (reading, mut record) in &mut robots {
            record.0.set(&sensor, as_value(reading));
        }
    }
}

/// Converts a reading to the form of traces. The conversion by text keeps only the significant digits of single precision.
fn as_value(reading: &impl Serialize) -> Option<Value> {
    let text = serde_json::to_string(reading).ok()?;
    serde_json::from_str(&text).ok()
}

/// The registered sensors, by name.
#[derive(Resource, Default)]
pub struct SensorRegistry {
    sensors: BTreeMap<String, Sensor>,
}

/// The operations on a sensor, without its types.
#[derive(Clone, Copy)]
struct Sensor {
    components: [TypeId; 2],
    /// Whether only robots that programs play have it without being given settings of it.
    is_optional: bool,
    check: fn(&Value, &FieldPath) -> Result<(), ScenarioFault>,
    insert: fn(&mut EntityWorldMut, Option<&Value>),
    remove: fn(&mut EntityWorldMut),
    reading: fn(EntityRef) -> Option<Value>,
}

impl Sensor {
    fn of<Settings: SensorSettings, Reading: SensorReading>() -> Self {
        Self {
            components: [TypeId::of::<Settings>(), TypeId::of::<Reading>()],
            is_optional: false,
            check: |value, path| read_settings::<Settings>(value, path).map(|_| ()),
            insert: |robot, value| {
                // Invalid settings were found before the match started.
                let settings = value.and_then(|value| read_settings(value, &FieldPath::default()).ok());
                robot.insert(settings.unwrap_or_else(Settings::default));
                if !robot.contains::<Reading>() {
                    robot.insert(Reading::default());
                }
            },
            remove: |robot| {
                robot.remove::<(Settings, Reading)>();
            },
            reading: |robot| robot.get::<Reading>().and_then(as_value),
        }
    }

    /// Gives a robot the sensor with its settings in a scenario, or removes it if they are `null`.
    fn set(&self, name: &str, robot: &mut EntityWorldMut, scenario: &Scenario, spec: &RobotSpec) {
        // Programs for real robots rely on all of their sensors.
        let needs_all = robot.contains::<Remote>() && scenario.realism.vision == Realism::Realistic;
        let settings = settings_of(name, scenario, spec);
        if settings.map_or(self.is_optional && !needs_all, Value::is_null) {
            (self.remove)(robot);
        } else {
            (self.insert)(robot, settings);
        }
        let reading = (self.reading)(robot.as_readonly());
        if let Some(mut record) = robot.get_mut::<SensorRecord>() {
            record.0.set(name, reading);
        }
    }
}

impl SensorRegistry {
    /// Returns the names of all sensors, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.sensors.keys().map(String::as_str)
    }

    /// Returns the faults of a scenario's sensors: unregistered names and invalid settings.
    pub(super) fn faults(&self, scenario: &Scenario) -> Vec<ScenarioFault> {
        let root = FieldPath::default();
        let own =
            scenario.robots.iter().enumerate().filter_map(|(index, robot)| Some((index, robot.own.sensors.as_ref()?)));
        let of_robots = own
            .flat_map(|(index, sensors)| self.faults_of(sensors, root.field("robots").index(index).field("sensors")));
        self.faults_of(&scenario.settings.sensors, root.field("sensors")).chain(of_robots).collect()
    }

    fn faults_of(&self, specs: &NamedValues, path: FieldPath) -> impl Iterator<Item = ScenarioFault> {
        specs.0.iter().filter_map(move |(name, value)| {
            let path = path.key(name);
            match self.sensors.get(name) {
                None => Some(unknown_name(&path, "sensor", name, self.names()).at_key()),
                Some(_) if value.is_null() => None,
                Some(sensor) => (sensor.check)(value, &path).err(),
            }
        })
    }

    /// Gives a robot its sensors, with the settings of the scenario.
    pub(super) fn equip(&self, robot: &mut EntityWorldMut, scenario: &Scenario, spec: &RobotSpec) {
        for (name, sensor) in &self.sensors {
            sensor.set(name, robot, scenario, spec);
        }
    }

    /// Returns the names of the sensors that only robots that programs play have without being given settings of them, sorted.
    pub fn optional_names(&self) -> impl Iterator<Item = &str> {
        self.sensors.iter().filter(|(_, sensor)| sensor.is_optional).map(|(name, _)| name.as_str())
    }

    /// Changes the settings of a robot that differ between two scenarios.
    pub(super) fn change(&self, robot: &mut EntityWorldMut, [old, new]: [(&Scenario, &RobotSpec); 2]) {
        for (name, sensor) in &self.sensors {
            let [before, after] = [old, new].map(|(scenario, spec)| settings_of(name, scenario, spec));
            if before != after {
                sensor.set(name, robot, new.0, new.1);
            }
        }
    }
}

/// Returns a robot's own settings of a sensor, or otherwise the common ones, if there are any.
fn settings_of<'a>(name: &str, scenario: &'a Scenario, robot: &'a RobotSpec) -> Option<&'a Value> {
    robot.own.sensors.as_ref().and_then(|own| own.get(name)).or_else(|| scenario.settings.sensors.get(name))
}
