//! The two teams and the identities of robots.

use bevy::prelude::*;
use core::fmt;
use core::ops::{Index, IndexMut};
use core::str::FromStr;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::knowledge::Knowledge;

/// One of the two teams, named by the colour of their waistbands (2010 rule book, section 2.4).
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Team {
    /// Defends the blue goal at -x in the first half.
    #[default]
    Blue,
    /// Defends the yellow goal at +x in the first half.
    Pink,
}

impl Team {
    /// Both teams, blue first.
    pub const BOTH: [Team; 2] = [Team::Blue, Team::Pink];

    /// The other team.
    pub fn opponent(self) -> Team {
        match self {
            Team::Blue => Team::Pink,
            Team::Pink => Team::Blue,
        }
    }

    /// The team's name in files: `blue` or `pink`.
    pub fn name(self) -> &'static str {
        match self {
            Team::Blue => "blue",
            Team::Pink => "pink",
        }
    }
}

impl fmt::Display for Team {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// A robot's identity: its team and jersey number. Everything that depends on an order of the robots sorts by it.
/// Written `blue1` in files.
#[derive(Component, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect)]
#[component(immutable)]
#[reflect(Component, Serialize, Deserialize, @Knowledge::Sensor)]
pub struct RobotId {
    /// The robot's team.
    pub team: Team,
    /// The jersey number, from 1.
    pub number: u8,
}

impl Default for RobotId {
    /// Returns `blue1`.
    fn default() -> Self {
        Self { team: Team::Blue, number: 1 }
    }
}

impl RobotId {
    /// The jersey number of the goalkeeper.
    pub const GOALKEEPER: u8 = 1;

    /// The robot of `team` with jersey `number`.
    pub const fn new(team: Team, number: u8) -> Self {
        Self { team, number }
    }

    /// Whether it is its team's goalkeeper, unless another has replaced that.
    pub const fn is_goalkeeper(self) -> bool {
        self.number == Self::GOALKEEPER
    }

    /// Whether it is its team's goalkeeper. `keepers` are the numbers of goalkeepers that have replaced [`GOALKEEPER`](Self::GOALKEEPER).
    pub fn is_goalkeeper_of(self, keepers: &PerTeam<Option<u8>>) -> bool {
        self.role_number(keepers[self.team]) == Self::GOALKEEPER
    }

    /// The number by which it has its place and its task, if `keeper` is the number of its team's goalkeeper in place of
    /// [`GOALKEEPER`](Self::GOALKEEPER): these two have changed.
    pub fn role_number(self, keeper: Option<u8>) -> u8 {
        match keeper {
            Some(keeper) if self.number == keeper => Self::GOALKEEPER,
            Some(keeper) if self.is_goalkeeper() => keeper,
            _ => self.number,
        }
    }

    /// A number that is different for every robot and the same in every match; never zero.
    pub fn stable_number(self) -> u64 {
        1 + 256 * (self.team as u64) + u64::from(self.number)
    }
}

impl fmt::Display for RobotId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}{}", self.team, self.number)
    }
}

/// Error of parsing a [`RobotId`]: the word names no robot.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a robot: expected a team and a jersey number, such as `blue1` or `pink3`")]
pub struct NotARobotId(pub String);

debug_as_displayed!(NotARobotId);

impl FromStr for RobotId {
    type Err = NotARobotId;

    fn from_str(word: &str) -> Result<Self, NotARobotId> {
        Team::BOTH
            .into_iter()
            .find_map(|team| {
                let number = word.strip_prefix(team.name())?.parse().ok()?;
                (number > 0).then_some(RobotId { team, number })
            })
            .ok_or_else(|| NotARobotId(word.to_owned()))
    }
}

impl Serialize for RobotId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for RobotId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

impl JsonSchema for RobotId {
    fn schema_name() -> Cow<'static, str> {
        "RobotId".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "A robot: its team and jersey number, such as `blue1`.",
            "pattern": "^(blue|pink)[1-9][0-9]*$"
        })
    }
}

/// Jersey numbers of robots of one team. In files, they are an array.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Vec<u8>", into = "Vec<u8>")]
pub struct JerseyNumbers([u8; 32]);

impl JerseyNumbers {
    /// Adds a number.
    pub fn insert(&mut self, number: u8) {
        self.0[usize::from(number / 8)] |= 1 << (number % 8);
    }

    /// Returns whether `number` is one of them.
    pub fn contains(self, number: u8) -> bool {
        self.0[usize::from(number / 8)] & (1 << (number % 8)) != 0
    }

    /// Returns whether there are none.
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }

    /// Returns the numbers in their order.
    pub fn iter(self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |number| self.contains(*number))
    }
}

impl From<Vec<u8>> for JerseyNumbers {
    fn from(list: Vec<u8>) -> Self {
        let mut numbers = Self::default();
        list.into_iter().for_each(|number| numbers.insert(number));
        numbers
    }
}

impl From<JerseyNumbers> for Vec<u8> {
    fn from(numbers: JerseyNumbers) -> Self {
        numbers.iter().collect()
    }
}

/// A value for each team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct PerTeam<T> {
    /// The blue team's.
    pub blue: T,
    /// The pink team's.
    pub pink: T,
}

impl<T> PerTeam<T> {
    /// The values that `of` returns for each team.
    pub fn new(mut of: impl FnMut(Team) -> T) -> Self {
        Self { blue: of(Team::Blue), pink: of(Team::Pink) }
    }
}

impl<T> Index<Team> for PerTeam<T> {
    type Output = T;

    fn index(&self, team: Team) -> &T {
        match team {
            Team::Blue => &self.blue,
            Team::Pink => &self.pink,
        }
    }
}

impl<T> IndexMut<Team> for PerTeam<T> {
    fn index_mut(&mut self, team: Team) -> &mut T {
        match team {
            Team::Blue => &mut self.blue,
            Team::Pink => &mut self.pink,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_ids_order_by_team_then_number_and_print_as_in_traces() {
        let ids = ["blue1", "blue2", "blue10", "pink1"].map(|word| word.parse::<RobotId>().unwrap());
        assert!(ids.is_sorted());
        assert_eq!(ids.map(|id| id.to_string()), ["blue1", "blue2", "blue10", "pink1"]);
        for wrong in ["blue0", "blue", "red1", "1", "blue256"] {
            assert!(wrong.parse::<RobotId>().is_err());
        }
    }

    #[test]
    fn jersey_numbers_are_an_array_in_files() {
        let numbers: JerseyNumbers = serde_json::from_str("[7, 2, 63, 64, 255, 7]").unwrap();
        assert_eq!(serde_json::to_string(&numbers).unwrap(), "[2,7,63,64,255]");
        assert!(numbers.contains(7) && !numbers.contains(3) && !numbers.contains(65));
        assert!(JerseyNumbers::default().is_empty() && !numbers.is_empty());
    }
}
