//! The types for what a robot perceives and commands in a cycle, in the terms of the trace. Programs, recorders and readers of records all
//! use them.
//!
//! A [`Perception`] has only what a robot can know: not its true pose, and only the ball that it sees. A [`RobotCommand`] has the robot's
//! commands in this cycle, in the terms of a script's entry; each is optional.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

use crate::simulation::sensors::SensorRecord;
use naoisis_core::communication::{Inbox, Outbox, ReceivedMessage, TeamMessage};
use naoisis_core::events::{CommandKind, Refusal};
use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::head::{HeadAngles, HeadCommand};
use naoisis_core::robot::kick::{KickCommand, KickRequest};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::{PostureCommand, PostureRequest};
use naoisis_core::robot::request::{RequestCommand, TeamRequest};
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;

/// What a robot perceives in a cycle: the readings of its sensors, the messages that arrived, and the state of the game as told to it.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Perception {
    /// Yaw and pitch of the head, radians (degrees in files).
    #[serde(rename = "head_deg", with = "head_angles")]
    #[schemars(with = "[f32; 2]")]
    pub head: HeadAngles,
    /// Pose relative to the start by odometry: `[x m, y m, heading deg]` in files.
    #[serde(with = "file_units::pose")]
    #[schemars(with = "[f32; 3]")]
    pub odometry: Pose,
    /// Distances that the sonars measured, m.
    pub sonar_m: SonarReading,
    /// The objects that the robot recognises.
    pub percepts: Percepts,
    /// The messages that arrived.
    pub inbox: Vec<ReceivedMessage>,
    /// The state of the game as told to the robot.
    pub game: GameStatus,
    /// The state of the body.
    pub body: BodyStatus,
    /// Readings of the program's custom sensors, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, Value>,
}

/// What a robot wants in a cycle. What is not given stays as it is: the robot stands, and its head goes where it was told
/// to go.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RobotCommand {
    /// A step: `[dx m, dy m, dtheta deg]` in files.
    #[serde(with = "optional_walk", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub walk: Option<WalkCommand>,
    /// Where the head goes, yaw and pitch, radians (degrees in files).
    #[serde(rename = "head_deg", with = "optional_head", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 2]>")]
    pub head: Option<HeadCommand>,
    /// A kick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kick: Option<KickRequest>,
    /// Getting up, or a dive: `get_up`, or `{ "dive": "left" }`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posture: Option<PostureRequest>,
    /// A request to the referee: `timeout`, `pick_up`, or `{ "substitute": 6 }`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request: Option<TeamRequest>,
    /// A message for the team-mates, with any of `pose`, `ball_m`, `robots_m`, `intention`, `payload` and `datagram`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub say: Option<TeamMessage>,
}

impl RobotCommand {
    /// Returns whether there are no commands.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Removes a command that was refused because it cannot be executed or written down: it has a number that is not finite, or something
    /// that is far too large.
    pub fn refuse(&mut self, command: CommandKind, reason: Refusal) {
        if !matches!(reason, Refusal::NotFinite | Refusal::TooLarge) {
            return;
        }
        match command {
            CommandKind::Walk => self.walk = None,
            CommandKind::Head => self.head = None,
            CommandKind::Kick => self.kick = None,
            CommandKind::Posture => self.posture = None,
            CommandKind::Say => self.say = None,
            CommandKind::Request => self.request = None,
        }
    }
}

/// Query for the components that a [`Perception`] is made of.
#[derive(QueryData)]
pub struct Perceived {
    head: &'static HeadAngles,
    odometry: &'static Odometry,
    sonar: &'static SonarReading,
    percepts: &'static Percepts,
    inbox: &'static Inbox,
    game: &'static GameStatus,
    body: &'static BodyStatus,
    sensors: Option<&'static SensorRecord>,
}

impl PerceivedItem<'_, '_> {
    /// Returns what the robot perceives.
    pub fn perception(&self) -> Perception {
        Perception {
            head: *self.head,
            odometry: self.odometry.0,
            sonar_m: *self.sonar,
            percepts: self.percepts.clone(),
            inbox: self.inbox.0.clone(),
            game: *self.game,
            body: *self.body,
            sensors: self.sensors.map(|sensors| sensors.readings().clone()).unwrap_or_default(),
        }
    }
}

/// Query for the components that a [`RobotCommand`] is made of.
#[derive(QueryData)]
pub struct Commanded {
    walk: &'static WalkCommand,
    head: Ref<'static, HeadCommand>,
    kick: &'static KickCommand,
    posture: &'static PostureCommand,
    request: &'static RequestCommand,
    outbox: &'static Outbox,
}

impl CommandedItem<'_, '_> {
    /// Returns the commands given between the ticks `since` and `now`. The head command stays until it is changed, so it counts only if it
    /// is newer than `since`.
    pub fn command(&self, since: Tick, now: Tick) -> RobotCommand {
        RobotCommand {
            walk: (!self.walk.is_null()).then_some(*self.walk),
            head: self.head.last_changed().is_newer_than(since, now).then_some(*self.head),
            kick: self.kick.0,
            posture: self.posture.0,
            request: self.request.0,
            say: self.outbox.0.clone(),
        }
    }
}

/// Head angles: radians in memory, `[yaw deg, pitch deg]` in the file.
pub(super) mod head_angles {
    use super::{HeadAngles, file_units::degree_pair};
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(head: &HeadAngles, serializer: S) -> Result<S::Ok, S::Error> {
        degree_pair::serialize(&[head.yaw, head.pitch], serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<HeadAngles, D::Error> {
        degree_pair::deserialize(deserializer).map(|[yaw, pitch]| HeadAngles { yaw, pitch })
    }
}

/// An optional head command: radians in memory, `[yaw deg, pitch deg]` in the file.
mod optional_head {
    use super::{HeadCommand, file_units::optional_degree_pair};
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(head: &Option<HeadCommand>, serializer: S) -> Result<S::Ok, S::Error> {
        optional_degree_pair::serialize(&head.map(|head| [head.yaw, head.pitch]), serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<HeadCommand>, D::Error> {
        let head = optional_degree_pair::deserialize(deserializer)?;
        Ok(head.map(|[yaw, pitch]| HeadCommand { yaw, pitch }))
    }
}

/// An optional step: radians in memory, `[dx m, dy m, dtheta deg]` in the file.
mod optional_walk {
    use super::{WalkCommand, file_units::optional_step};
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(walk: &Option<WalkCommand>, serializer: S) -> Result<S::Ok, S::Error> {
        optional_step::serialize(&walk.map(|walk| [walk.dx, walk.dy, walk.dtheta]), serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<WalkCommand>, D::Error> {
        let walk = optional_step::deserialize(deserializer)?;
        Ok(walk.map(|[dx, dy, dtheta]| WalkCommand { dx, dy, dtheta }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::behaviour::script::ScriptEntry;
    use naoisis_core::kick_geometry::KickType;
    use serde_json::json;

    #[test]
    fn a_command_has_the_words_of_a_script_and_only_what_is_given() {
        assert_eq!(serde_json::to_value(RobotCommand::default()).unwrap(), json!({}));
        let words = json!({
            "walk": [0.004, -0.002, 3.0], "head_deg": [20.0, -10.0], "kick": { "type": "right_straight", "speed": 0.5 },
            "posture": { "dive": "left" }, "request": { "substitute": 6 }, "say": { "ball_m": [1.0, 0.5], "intention": "pass" },
        });
        let command: RobotCommand = serde_json::from_value(words.clone()).unwrap();
        assert_eq!(command.kick, Some(KickRequest::new(KickType::RightStraight, 0.5)));
        let entry: ScriptEntry = serde_json::from_value(words.clone()).unwrap();
        let [dx, dy, dtheta] = entry.walk.unwrap();
        assert_eq!(command.walk, Some(WalkCommand { dx, dy, dtheta }));
        assert_eq!(command.head.map(|head| [head.yaw, head.pitch]), entry.head);
        assert_eq!((command.kick, command.posture), (entry.kick, entry.posture));
        assert_eq!((command.request, entry.request), (Some(TeamRequest::Substitute(6)), command.request));
        assert_eq!(command.say, entry.say);
        let entry = serde_json::to_value(&entry).unwrap();
        for (word, value) in serde_json::to_value(&command).unwrap().as_object().unwrap() {
            assert_eq!(&entry[word], value);
        }
        assert!(serde_json::from_value::<RobotCommand>(json!({ "wlak": [0, 0, 0] })).is_err());
    }

    #[test]
    fn what_cannot_be_written_down_is_left_out_of_a_command() {
        let mut command = RobotCommand { walk: Some(WalkCommand::new(f32::NAN, 0.0, 0.0)), ..default() };
        command.posture = Some(PostureRequest::GetUp);
        command.refuse(CommandKind::Posture, Refusal::NotAllowed);
        command.refuse(CommandKind::Walk, Refusal::NotFinite);
        assert_eq!(command, RobotCommand { posture: Some(PostureRequest::GetUp), ..default() });
    }

    #[test]
    fn everything_in_a_perception_may_be_absent() {
        assert_eq!(serde_json::from_str::<Perception>("{}").unwrap(), Perception::default());
    }
}
