//! The two teams of a scenario, and the own settings of their robots.

use bevy::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

use super::robot_settings::{RobotPatch, patch_beside_fields, robot_settings};
use super::robot_spec::RobotSpec;
use naoisis_core::team::{PerTeam, Team};
use naoisis_core::word_or_object;

/// The two teams of a scenario: each is the name of a registered team; `exec:COMMAND`, a program that is started for each robot;
/// `policy:FILE`, a learned policy that plays each robot; or `remote`, for robots that are controlled from outside.
///
/// In files, a team is its name, or an object with the name as `team` and what all of its robots have in common: a `model`, or settings of
/// robots.
#[derive(Clone, PartialEq, Debug, Reflect)]
pub struct TeamsSpec {
    /// The blue team.
    pub blue: String,
    /// The pink team.
    pub pink: String,
    /// What the robots of each team have in common.
    pub robots: PerTeam<TeamRobots>,
}

/// What all robots of a team have in common.
#[derive(Clone, PartialEq, Debug, Default, Reflect)]
pub struct TeamRobots {
    /// The robots' [model](super::RobotModel), if it is not the scenario's.
    pub model: Option<String>,
    /// The robots' own settings.
    pub own: RobotPatch,
    /// The handicap, from 0 to 0.9: the robots are slower by this share, get up less often and see less.
    pub handicap: f32,
}

impl TeamsSpec {
    /// Prefix of a team's name that is the command line of a program.
    pub const EXEC: &str = "exec:";

    /// Prefix of a team's name that is the file of a learned policy.
    pub const POLICY: &str = "policy:";

    /// Creates two teams by their names, with the scenario's robots.
    pub fn new(blue: impl Into<String>, pink: impl Into<String>) -> Self {
        Self { blue: blue.into(), pink: pink.into(), robots: PerTeam::default() }
    }

    /// Returns the words of the command line in a team's name, split and unquoted like in a shell. Returns `None` for other names, and
    /// `Some(None)` if quotes are not closed.
    pub fn command_line(team: &str) -> Option<Option<Vec<String>>> {
        team.strip_prefix(Self::EXEC).map(shlex::split)
    }

    /// Returns the file of the learned policy in a team's name; `None` for other names.
    pub fn policy(team: &str) -> Option<&str> {
        team.strip_prefix(Self::POLICY)
    }

    /// Returns the name of a team.
    pub fn name(&self, team: Team) -> &str {
        match team {
            Team::Blue => &self.blue,
            Team::Pink => &self.pink,
        }
    }

    /// Returns a robot of a team, with what all its robots have in common.
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

/// The file form of a team.
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
    /// The file form of an [`Entry`] that is an object.
    EntryForm {
        /// The name of the team.
        team: String,
        /// The model of its robots, if it is another than the scenario's.
        #[serde(skip_serializing_if = "Option::is_none")]
        model: Option<String>,
        /// How much weaker its robots are than their settings: they walk and turn slower by this share, fail to get up as often as in
        /// 1 / (1 - handicap) tries, and miss this share of what they would detect.
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

word_or_object!(
    Entry,
    EntryForm,
    "the name of a team, or an object with a `team` and the `model` of its robots",
    |name, E| Ok(Entry { team: name.to_owned(), model: None, handicap: 0.0, own: RobotPatch::default() })
);

/// The file form of both teams.
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
