//! Robots: who they are, their bodies, heads, walking and kicks.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

pub mod body;
pub mod head;
pub mod kick;
pub mod motion;
pub mod posture;

use crate::cycle::{BeginCycle, Cycle, CycleSystems};
use crate::geometry::Pose;

/// Robots that exist, walk, turn their heads and kick. Adds the plugins of the submodules.
pub struct RobotPlugin;

impl Plugin for RobotPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Roster>()
            .register_type::<RobotId>()
            .register_type::<Velocity>()
            .register_type::<Pose>()
            .register_type::<PreviousPose>()
            .register_type::<Roster>()
            .register_type::<body::BodyBounds>()
            .add_observer(enter_roster)
            .add_observer(leave_roster)
            .add_systems(Cycle, remember_poses.in_set(CycleSystems::First).after(BeginCycle))
            .add_plugins((head::HeadPlugin, motion::MotionPlugin, kick::KickPlugin, posture::PosturePlugin));
    }
}

/// One of the two teams, named by the colour of their waistbands (2010 rule book, section 2.4).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, Serialize, Deserialize)]
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

/// Which robot this is: its team and jersey number. Totally ordered, so that whatever depends on an order sorts by
/// it. Written `blue1` in files.
#[derive(Component, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect)]
#[component(immutable)]
#[reflect(Component, Serialize, Deserialize, @Knowledge::Sensor)]
pub struct RobotId {
    /// The robot's team.
    pub team: Team,
    /// The jersey number, from 1.
    pub number: u8,
}

impl RobotId {
    /// The robot of `team` with jersey `number`.
    pub const fn new(team: Team, number: u8) -> Self {
        Self { team, number }
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

/// A word that names no robot.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a robot: expected a team and a jersey number, such as `blue1` or `pink3`")]
pub struct NotARobotId(pub String);

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

/// Linear and angular velocity over the last cycle, in the pitch frame: what the robot really did, after
/// limits, error and collisions.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Velocity {
    /// Metres per second.
    pub linear: Vec2,
    /// Radians per second, counter-clockwise.
    pub angular: f32,
}

/// Where a robot or the ball was at the start of the cycle under way.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct PreviousPose(pub Pose);

/// All robots, ordered by [`RobotId`]: whatever depends on an order goes through the robots in this one.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default, Reflect)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Roster(Vec<(RobotId, Entity)>);

impl Roster {
    /// The robots' entities in the order of their ids.
    pub fn entities(&self) -> impl ExactSizeIterator<Item = Entity> + '_ {
        self.0.iter().map(|(_, entity)| *entity)
    }

    /// Ids and entities, in the order of the ids.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (RobotId, Entity)> + '_ {
        self.0.iter().copied()
    }

    /// The entity of a robot.
    pub fn get(&self, id: RobotId) -> Option<Entity> {
        self.0.binary_search_by_key(&id, |(id, _)| *id).ok().map(|index| self.0[index].1)
    }

    /// The number of robots.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no robot.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn enter_roster(added: On<Add, RobotId>, ids: Query<&RobotId>, mut roster: ResMut<Roster>) {
    if let Ok(id) = ids.get(added.entity) {
        let place = roster.0.partition_point(|(other, _)| other < id);
        roster.0.insert(place, (*id, added.entity));
    }
}

fn leave_roster(removed: On<Remove, RobotId>, mut roster: ResMut<Roster>) {
    roster.0.retain(|(_, entity)| *entity != removed.entity);
}

fn remember_poses(mut poses: Query<(&Pose, &mut PreviousPose)>) {
    for (pose, mut previous) in &mut poses {
        previous.0 = *pose;
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
}
