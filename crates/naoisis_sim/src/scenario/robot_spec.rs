//! A robot of a scenario: its identity, its place, its behaviour, and its own settings.

use bevy::prelude::*;
use core::fmt;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

use super::robot_settings::{RobotPatch, patch_beside_fields, robot_settings};
use naoisis_core::behaviour::script::ScriptEntry;
use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::robot::posture::LyingOn;
use naoisis_core::team::{RobotId, Team};

/// A robot at the start of a match. In files, the fields of `own` are beside the others.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(from = "RobotForm", into = "RobotForm")]
pub struct RobotSpec {
    /// Its team.
    pub team: Team,
    /// The jersey number, from 1.
    pub number: u8,
    /// Pose at the start: `[x m, y m, heading deg]` in files.
    pub pose: Pose,
    /// Yaw and pitch of the head, radians (`head_deg`, degrees, in files).
    pub head_angles: [f32; 2],
    /// Behaviour that controls the robot.
    pub behaviour: BehaviourSpec,
    /// The robot's own [model](super::RobotModel), if it is not the scenario's.
    pub model: Option<String>,
    /// Whether the robot begins as a substitute beside the pitch. Its `pose` is ignored then.
    pub substitute: bool,
    /// The side of the body on which the robot lies at the start. `None` if it stands.
    pub lies_on: Option<LyingOn>,
    /// The robot's own settings.
    pub own: RobotPatch,
}

robot_settings! { patch_beside_fields {
    RobotSpec as
    /// The file form of a [`RobotSpec`].
    RobotForm {
        /// Its team.
        team: Team,
        /// The jersey number, from 1.
        #[schemars(range(min = 1, max = 255))]
        number: u8,
        /// Where it stands: `[x m, y m, heading deg]`.
        #[serde(with = "file_units::pose")]
        #[schemars(with = "[f32; 3]")]
        pose: Pose,
        /// Yaw and pitch of the head, degrees.
        #[serde(rename = "head_deg", with = "file_units::degree_pair")]
        #[schemars(with = "[f32; 2]")]
        head_angles: [f32; 2],
        /// What controls it.
        behaviour: BehaviourSpec,
        /// The model of this robot, if it is another than the scenario's.
        #[serde(skip_serializing_if = "Option::is_none")]
        model: Option<String>,
        /// Whether it begins as a substitute, beside the pitch, wherever its `pose` is.
        #[serde(skip_serializing_if = "is_false")]
        substitute: bool,
        /// The side of the body on which it lies at the start; none: it stands.
        #[serde(skip_serializing_if = "Option::is_none")]
        lies_on: Option<LyingOn>,
    }
} }

fn is_false(flag: &bool) -> bool {
    !flag
}

impl RobotSpec {
    /// Returns the robot's id.
    pub fn id(&self) -> RobotId {
        RobotId::new(self.team, self.number)
    }
}

/// The behaviour of a robot: `"idle"`, the name of a registered behaviour, `{ "script": [...] }`, `{ "program": [...] }`, or
/// `{ "policy": "FILE.onnx" }`.
#[derive(Clone, PartialEq, Debug, Reflect)]
pub enum BehaviourSpec {
    /// A registered behaviour; `idle` does nothing.
    Named(String),
    /// A script of timed commands.
    Script(Vec<ScriptEntry>),
    /// A program for this robot: the words of its command line, run in the folder of the scenario's file.
    Program(Vec<String>),
    /// A learned policy: the path of its ONNX file, from the folder of the scenario's file.
    Policy(String),
}

impl JsonSchema for BehaviourSpec {
    fn schema_name() -> Cow<'static, str> {
        "Behaviour".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let script = generator.subschema_for::<Vec<ScriptEntry>>();
        json_schema!({
            "description": "`idle`, the name of a behaviour, a script, the words of a program's command line, or the file of a learned policy.",
            "anyOf": [
                { "type": "string" },
                { "type": "object", "properties": { "script": script }, "required": ["script"], "additionalProperties": false },
                {
                    "type": "object",
                    "properties": { "program": { "type": "array", "items": { "type": "string" } } },
                    "required": ["program"],
                    "additionalProperties": false,
                },
                {
                    "type": "object",
                    "properties": { "policy": { "type": "string" } },
                    "required": ["policy"],
                    "additionalProperties": false,
                },
            ],
        })
    }
}

impl Default for BehaviourSpec {
    fn default() -> Self {
        BehaviourSpec::Named("idle".to_owned())
    }
}

impl Serialize for BehaviourSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            BehaviourSpec::Named(name) => serializer.serialize_str(name),
            BehaviourSpec::Script(entries) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("script", entries)?;
                map.end()
            }
            BehaviourSpec::Program(words) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("program", words)?;
                map.end()
            }
            BehaviourSpec::Policy(file) => {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry("policy", file)?;
                map.end()
            }
        }
    }
}

// Implemented by hand, because an untagged enum would lose the place of an error in a script.
impl<'de> Deserialize<'de> for BehaviourSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct BehaviourVisitor;

        impl<'de> Visitor<'de> for BehaviourVisitor {
            type Value = BehaviourSpec;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str(
                    "`idle`, the name of a behaviour, or an object with a `script`, a `program` or a `policy`",
                )
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<BehaviourSpec, E> {
                Ok(BehaviourSpec::Named(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<BehaviourSpec, A::Error> {
                let mut behaviour = None;
                while let Some(field) = map.next_key()? {
                    if behaviour.is_some() {
                        return Err(de::Error::custom(
                            "a robot has one behaviour; expected a `script`, a `program` or a `policy`",
                        ));
                    }
                    behaviour = Some(match field {
                        Field::Script => BehaviourSpec::Script(map.next_value()?),
                        Field::Program => BehaviourSpec::Program(map.next_value()?),
                        Field::Policy => BehaviourSpec::Policy(map.next_value()?),
                    });
                }
                behaviour.ok_or_else(|| de::Error::missing_field("script"))
            }
        }

        #[derive(Deserialize)]
        #[serde(field_identifier, rename_all = "snake_case")]
        enum Field {
            Script,
            Program,
            Policy,
        }

        deserializer.deserialize_any(BehaviourVisitor)
    }
}
