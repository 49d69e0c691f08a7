//! The two teams of a scenario, and what their robots have of their own.

use bevy::prelude::*;
use core::fmt;
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::robot_spec::RobotSpec;
use naoisis_core::communication::MessageLimits;
use naoisis_core::named_values::NamedValues;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::falls::FallModel;
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::MotionLimits;
use naoisis_core::team::{PerTeam, Team};
use naoisis_sensing::belief::localisation_method::LocalisationMethod;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::fidelity::FidelitySettings;
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::sonar::SonarSettings;
use naoisis_sensing::sensing::vision::VisionSettings;

/// Two teams, by name; or as `exec:COMMAND`, a program that is started for each of their robots; or as `remote`, whose robots
/// are decided for from outside.
///
/// In files, a team is its name, or an object with the name as `team`, and what all of its robots have of their own: a `model`,
/// or settings that a robot could have.
#[derive(Clone, PartialEq, Debug, Reflect)]
pub struct TeamsSpec {
    /// The blue team.
    pub blue: String,
    /// The pink team.
    pub pink: String,
    /// What the robots of each have of their own. Neither their ids nor their places or behaviours.
    pub robots: PerTeam<RobotSpec>,
}

impl TeamsSpec {
    /// What the name of a team begins with that is the command line of a program.
    pub const EXEC: &str = "exec:";

    /// Two teams by their names, with the scenario's robots.
    pub fn new(blue: impl Into<String>, pink: impl Into<String>) -> Self {
        Self { blue: blue.into(), pink: pink.into(), robots: PerTeam::default() }
    }

    /// The words of the command line that the name of a team stands for, if it does: quoted and parted as a shell would.
    /// None among them if quotes are not closed.
    pub fn command_line(team: &str) -> Option<Option<Vec<String>>> {
        team.strip_prefix(Self::EXEC).map(shlex::split)
    }

    /// The name of a team.
    pub fn name(&self, team: Team) -> &str {
        match team {
            Team::Blue => &self.blue,
            Team::Pink => &self.pink,
        }
    }

    /// A robot of a team, with what they all have of their own.
    pub fn robot(&self, team: Team, number: u8) -> RobotSpec {
        RobotSpec { team, number, ..self.robots[team].clone() }
    }
}

impl Default for TeamsSpec {
    fn default() -> Self {
        Self::new("roles", "chasers")
    }
}

/// A team as files have it.
struct Entry {
    team: String,
    robots: RobotSpec,
}

macro_rules! entry_fields {
    ($($(#[$attribute:meta])* $field:ident as $name:literal: $type:ty,)*) => {
        /// An [`Entry`] that is an object: the fields that a robot could have, but for who it is, where it stands and what it does.
        #[derive(Default, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        struct EntryFields {
            team: String,
            $($(#[$attribute])* #[serde(rename = $name)] $field: $type,)*
        }

        impl From<EntryFields> for Entry {
            fn from(fields: EntryFields) -> Self {
                let EntryFields { team, $($field,)* } = fields;
                Self { team, robots: RobotSpec { $($field,)* ..RobotSpec::default() } }
            }
        }

        impl From<&Entry> for EntryFields {
            fn from(entry: &Entry) -> Self {
                let RobotSpec { $($field,)* .. } = entry.robots.clone();
                Self { team: entry.team.clone(), $($field,)* }
            }
        }
    };
}

entry_fields! {
    #[serde(skip_serializing_if = "Option::is_none")]
    model as "model": Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    body as "body": Option<Body>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kicks as "kicks": Option<KickSettings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    falls as "falls": Option<FallModel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cameras as "cameras": Option<CameraSettings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    latency as "latency": Option<Latency>,
    #[serde(skip_serializing_if = "Option::is_none")]
    motion as "motion": Option<MotionLimits>,
    #[serde(skip_serializing_if = "Option::is_none")]
    head_limits as "head": Option<HeadLimits>,
    #[serde(skip_serializing_if = "FidelitySettings::is_unset")]
    fidelity as "fidelity": FidelitySettings,
    #[serde(skip_serializing_if = "Option::is_none")]
    sonar as "sonar": Option<SonarSettings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vision as "vision": Option<VisionSettings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    localisation as "localisation": Option<LocalisationMethod>,
    #[serde(skip_serializing_if = "Option::is_none")]
    odometry as "odometry": Option<OdometrySettings>,
    #[serde(skip_serializing_if = "Option::is_none")]
    messages as "messages": Option<MessageLimits>,
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    sensors as "sensors": NamedValues,
}

impl Serialize for Entry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.robots == RobotSpec::default() {
            return serializer.serialize_str(&self.team);
        }
        EntryFields::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Entry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EntryVisitor;

        impl<'de> Visitor<'de> for EntryVisitor {
            type Value = Entry;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("the name of a team, or an object with a `team` and the `model` of its robots")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Entry, E> {
                Ok(Entry { team: name.to_owned(), robots: RobotSpec::default() })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Entry, A::Error> {
                EntryFields::deserialize(MapAccessDeserializer::new(map)).map(Entry::from)
            }
        }

        deserializer.deserialize_any(EntryVisitor)
    }
}

/// Both teams as files have them.
#[derive(Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Entries {
    blue: Entry,
    pink: Entry,
}

impl Default for Entries {
    fn default() -> Self {
        Self::from(&TeamsSpec::default())
    }
}

impl From<&TeamsSpec> for Entries {
    fn from(teams: &TeamsSpec) -> Self {
        let entry = |team: Team| Entry { team: teams.name(team).to_owned(), robots: teams.robots[team].clone() };
        Self { blue: entry(Team::Blue), pink: entry(Team::Pink) }
    }
}

impl Serialize for TeamsSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Entries::from(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TeamsSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Entries { blue, pink } = Entries::deserialize(deserializer)?;
        Ok(Self { blue: blue.team, pink: pink.team, robots: PerTeam { blue: blue.robots, pink: pink.robots } })
    }
}
