//! The two teams of a scenario, and what their robots have of their own.

use bevy::prelude::*;
use core::fmt;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

use super::robot_settings::{RobotPatch, patch_beside_fields, robot_settings};
use super::robot_spec::RobotSpec;
use naoisis_core::team::{PerTeam, Team};

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
    /// What the robots of each have of their own.
    pub robots: PerTeam<TeamRobots>,
}

/// What all robots of a team have of their own.
#[derive(Clone, PartialEq, Debug, Default, Reflect)]
pub struct TeamRobots {
    /// Their [model](super::RobotModel), if it is another than the scenario's.
    pub model: Option<String>,
    /// Their own settings.
    pub own: RobotPatch,
    /// How much weaker they are than their settings, 0 to 0.9: slower by this share, with more falls and poorer eyes.
    pub handicap: f32,
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
        let TeamRobots { model, own, .. } = self.robots[team].clone();
        RobotSpec { team, number, model, own, ..default() }
    }
}

impl Default for TeamsSpec {
    fn default() -> Self {
        Self::new("roles", "chasers")
    }
}

/// A team as files have it.
#[derive(Clone)]
struct Entry {
    team: String,
    model: Option<String>,
    handicap: f32,
    own: RobotPatch,
}

fn is_none(handicap: &f32) -> bool {
    *handicap == 0.0
}

robot_settings! { patch_beside_fields {
    Entry as
    /// An [`Entry`] that is an object.
    EntryForm {
        /// The name of the team.
        team: String,
        /// The model of its robots, if it is another than the scenario's.
        #[serde(skip_serializing_if = "Option::is_none")]
        model: Option<String>,
        /// How much weaker its robots are than their settings: they walk and turn slower by this share, fall more often by the factor
        /// 1 / (1 - handicap), and miss this share of what they would detect.
        #[serde(default, skip_serializing_if = "is_none")]
        #[schemars(range(min = 0.0, max = 0.9))]
        handicap: f32,
    }
} }

impl JsonSchema for Entry {
    fn schema_name() -> Cow<'static, str> {
        "TeamEntry".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The name of a team, or an object with it as `team` and what its robots have of their own.",
            "anyOf": [{ "type": "string" }, generator.subschema_for::<EntryForm>()],
        })
    }
}

impl Serialize for Entry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.model.is_none() && self.own.is_empty() && is_none(&self.handicap) {
            return serializer.serialize_str(&self.team);
        }
        EntryForm::from(self.clone()).serialize(serializer)
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
                Ok(Entry { team: name.to_owned(), model: None, handicap: 0.0, own: RobotPatch::default() })
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Entry, A::Error> {
                EntryForm::deserialize(MapAccessDeserializer::new(map)).map(Entry::from)
            }
        }

        deserializer.deserialize_any(EntryVisitor)
    }
}

/// Both teams as files have them.
#[derive(Serialize, Deserialize, JsonSchema)]
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
        let entry = |team: Team| {
            let TeamRobots { model, own, handicap } = teams.robots[team].clone();
            Entry { team: teams.name(team).to_owned(), model, handicap, own }
        };
        Self { blue: entry(Team::Blue), pink: entry(Team::Pink) }
    }
}

impl JsonSchema for TeamsSpec {
    fn schema_name() -> Cow<'static, str> {
        "Teams".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Entries::json_schema(generator)
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
        let robots_of = |Entry { model, own, handicap, .. }: Entry| TeamRobots { model, own, handicap };
        Ok(Self {
            blue: blue.team.clone(),
            pink: pink.team.clone(),
            robots: PerTeam { blue: robots_of(blue), pink: robots_of(pink) },
        })
    }
}
