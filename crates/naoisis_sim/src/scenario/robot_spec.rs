//! A robot of a scenario: who it is, where it stands, what controls it, and what it has of its own.

use bevy::prelude::*;
use core::fmt;
use serde::de::{self, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use naoisis_core::behaviour::script::ScriptEntry;
use naoisis_core::communication::MessageLimits;
use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::named_values::NamedValues;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::falls::FallModel;
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::MotionLimits;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::localisation_method::LocalisationMethod;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::fidelity::FidelitySettings;
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::sonar::SonarSettings;
use naoisis_sensing::sensing::vision::VisionSettings;

/// A robot at the start.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RobotSpec {
    /// Its team.
    pub team: Team,
    /// The jersey number, from 1.
    pub number: u8,
    /// Where it stands: `[x m, y m, heading deg]` in files.
    #[serde(with = "file_units::pose")]
    pub pose: Pose,
    /// Yaw and pitch of the head, radians (degrees in files).
    #[serde(rename = "head_deg", with = "file_units::degree_pair")]
    pub head: [f32; 2],
    /// What controls it.
    pub behaviour: BehaviourSpec,
    /// The [model](super::RobotModel) of this robot, if it is another than the scenario's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Its own body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<Body>,
    /// Its own way of kicking.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kicks: Option<KickSettings>,
    /// Its own sense of balance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub falls: Option<FallModel>,
    /// Its own cameras.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cameras: Option<CameraSettings>,
    /// How late it is what it sees and does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
    /// Its own way of walking.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionLimits>,
    /// Its own way of turning the head.
    #[serde(rename = "head", skip_serializing_if = "Option::is_none")]
    pub head_limits: Option<HeadLimits>,
    /// How true its own sensors are.
    #[serde(skip_serializing_if = "FidelitySettings::is_unset")]
    pub fidelity: FidelitySettings,
    /// Its own sonars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sonar: Option<SonarSettings>,
    /// What it recognises.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vision: Option<VisionSettings>,
    /// How it localises itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub localisation: Option<LocalisationMethod>,
    /// How exactly it knows its steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub odometry: Option<OdometrySettings>,
    /// How much it sends at most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub messages: Option<MessageLimits>,
    /// Its own settings of sensors that the program has registered.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    pub sensors: NamedValues,
}

impl RobotSpec {
    /// The robot's identity.
    pub fn id(&self) -> RobotId {
        RobotId::new(self.team, self.number)
    }
}

/// What controls a robot: `"idle"`, the name of a registered behaviour, `{ "script": [...] }`, or `{ "program": [...] }`.
#[derive(Clone, PartialEq, Debug, Reflect)]
pub enum BehaviourSpec {
    /// A registered behaviour; `idle` does nothing.
    Named(String),
    /// A script: what to do at which time.
    Script(Vec<ScriptEntry>),
    /// A program of its own: the words of its command line, run in the folder of the scenario's file.
    Program(Vec<String>),
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
        }
    }
}

// By hand: an untagged enum would lose where in a script something is wrong.
impl<'de> Deserialize<'de> for BehaviourSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct BehaviourVisitor;

        impl<'de> Visitor<'de> for BehaviourVisitor {
            type Value = BehaviourSpec;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("`idle`, the name of a behaviour, or an object with a `script` or a `program`")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<BehaviourSpec, E> {
                Ok(BehaviourSpec::Named(name.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<BehaviourSpec, A::Error> {
                let mut behaviour = None;
                while let Some(field) = map.next_key()? {
                    if behaviour.is_some() {
                        return Err(de::Error::custom("a robot has one behaviour; expected a `script` or a `program`"));
                    }
                    behaviour = Some(match field {
                        Field::Script => BehaviourSpec::Script(map.next_value()?),
                        Field::Program => BehaviourSpec::Program(map.next_value()?),
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
        }

        deserializer.deserialize_any(BehaviourVisitor)
    }
}
