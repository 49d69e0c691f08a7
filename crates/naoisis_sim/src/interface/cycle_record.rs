//! The record of a cycle: the world after it, and what each robot perceived, believed and commanded in it.
//!
//! Lines of a trace, replays of a match, and all other recordings are made from these records.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

use super::vocabulary::{Perception, RobotCommand, head_angles};
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::communication::{ReceivedMessage, StatusReport};
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Game, GameState, PenaltyReason, Rules, Score};
use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::pitch::End;
use naoisis_core::referee::{GameStatus, SetPlayStatus};
use naoisis_core::robot::Velocity;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;

/// The world after a cycle.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename = "cycle")]
pub struct CycleRecord {
    /// Cycles since the start.
    pub cycle: u64,
    /// Time since the start, s.
    pub time_s: f64,
    /// The ball, if there is one; of several, the first.
    #[serde(default)]
    pub ball: Option<BallRecord>,
    /// All balls, if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub balls: Vec<BallRecord>,
    /// The robots, in the order of their ids: by team, then by number.
    #[serde(default)]
    pub robots: Vec<RobotRecord>,
    /// The state of the game.
    #[serde(default)]
    pub game: GameRecord,
    /// The events of the cycle: each a `kind`, and what belongs to it.
    #[serde(default)]
    #[schemars(with = "Vec<Value>")]
    pub events: Vec<MatchEvent>,
}

impl CycleRecord {
    /// The balls beside the first.
    pub fn more_balls(&self) -> &[BallRecord] {
        self.balls.get(1..).unwrap_or_default()
    }

    /// Returns the record of a robot, if it is there.
    pub fn robot(&self, id: RobotId) -> Option<&RobotRecord> {
        self.robots.iter().find(|robot| robot.id == id)
    }
}

/// The ball after a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BallRecord {
    /// Its centre, m, pitch frame.
    #[schemars(with = "[f32; 3]")]
    pub position_m: Vec3,
    /// Its velocity, m/s, pitch frame.
    #[schemars(with = "[f32; 3]")]
    pub velocity_mps: Vec3,
}

/// A robot after a cycle, and what it perceived, believed and wanted in it.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct RobotRecord {
    /// Its team and number: `blue1`.
    pub id: RobotId,
    /// Its true pose, pitch frame: `[x m, y m, heading deg]` in files.
    #[serde(default, with = "file_units::pose")]
    #[schemars(with = "[f32; 3]")]
    pub pose: Pose,
    /// Its true velocity, pitch frame: `[x m/s, y m/s, turn deg/s]` in files.
    #[serde(default, with = "velocity")]
    #[schemars(with = "[f32; 3]")]
    pub velocity: Velocity,
    /// The angles of its head: `[yaw deg, pitch deg]` in files.
    #[serde(default, rename = "head_deg", with = "head_angles")]
    #[schemars(with = "[f32; 2]")]
    pub head: HeadAngles,
    /// Its true posture; left out if it is upright.
    #[serde(default, skip_serializing_if = "is_upright")]
    #[schemars(with = "Value")]
    pub posture: Posture,
    /// The penalty that it serves.
    #[serde(default)]
    pub penalised: Option<PenaltyRecord>,
    /// Its pose relative to the start by its own steps: `[x m, y m, heading deg]` in files.
    #[serde(default, with = "file_units::pose")]
    #[schemars(with = "[f32; 3]")]
    pub odometry: Pose,
    /// The distances that its sonars measured, m.
    #[serde(default)]
    pub sonar_m: SonarReading,
    /// The objects that its cameras detected: places on the ground, m, robot frame, and pixels `[u, v]`.
    #[serde(default)]
    pub percepts: Percepts,
    /// The messages that arrived.
    #[serde(default)]
    pub inbox: Vec<ReceivedMessage>,
    /// Its information about the game, delayed if the rules say so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub game: Option<GameStatus>,
    /// The state of its body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStatus>,
    /// The readings of custom sensors by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, Value>,
    /// Its beliefs, in the frame of its team.
    #[serde(default)]
    pub belief: Option<Belief>,
    /// Its commands in the words of a script, each only if it was given; none at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<RobotCommand>,
    /// The drawings of its behaviour.
    #[serde(default, skip_serializing_if = "Drawings::is_empty")]
    #[schemars(with = "Value")]
    pub drawings: Drawings,
    /// Its intention, if its program tells it by itself and not only in a message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intention: Option<String>,
    /// The values that its program plots, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f32>,
    /// The reasons for its decision, if its behaviour gives them and they were asked for by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reasons: Option<Reasons>,
    /// The last status report of its program to a GameController.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reported: Option<StatusReport>,
}

impl RobotRecord {
    /// Creates the record of a robot about which nothing is known.
    pub fn new(id: RobotId) -> Self {
        Self { id, ..default() }
    }

    /// Returns the robot's intention: the one that its program tells, or else that of its message.
    pub fn intention(&self) -> Option<&str> {
        let said = || self.command.as_ref()?.say.as_ref()?.intention.as_deref();
        self.intention.as_deref().or_else(said)
    }

    /// Adds what the robot perceived.
    #[must_use]
    pub fn with_perception(self, perception: Perception) -> Self {
        let Perception { head, odometry, sonar_m, percepts, inbox, game, body, sensors } = perception;
        let (game, body) = (Some(game), Some(body));
        RobotRecord { head, odometry, sonar_m, percepts, inbox, game, body, sensors, ..self }
    }

    /// Returns what the robot perceived: the record without what it cannot know.
    pub fn perception(&self) -> Perception {
        Perception {
            head: self.head,
            odometry: self.odometry,
            sonar_m: self.sonar_m,
            percepts: self.percepts.clone(),
            inbox: self.inbox.clone(),
            game: self.game.unwrap_or_default(),
            body: self.body.unwrap_or_default(),
            sensors: self.sensors.clone(),
        }
    }
}

fn has_first_goalkeepers(goalkeepers: &PerTeam<Option<u8>>) -> bool {
    *goalkeepers == PerTeam::default()
}

fn is_upright(posture: &Posture) -> bool {
    posture.is_upright()
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct PenaltyRecord {
    /// The offence.
    pub reason: PenaltyReason,
    /// Time of play until the robot may come back, s.
    pub time_left_s: f64,
}

/// The state of the game after a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct GameRecord {
    /// The state of play.
    pub state: GameState,
    /// The goals of `blue` and `pink`.
    pub score: Score,
    /// The half, from 1.
    pub half: u32,
    /// Time left in the half, s; none if the rules have no clock.
    pub time_left_s: Option<f64>,
    /// The end that the blue team defends.
    #[serde(default)]
    pub blue_end: End,
    /// The team that the ball belongs to: by the free kick under way, or else by the last kick-off; none after a drop ball.
    #[serde(default)]
    pub kicking_team: Option<Team>,
    /// The free kick under way, or the kick-off that is one team's own.
    #[serde(default)]
    pub set_play: Option<SetPlayStatus>,
    /// Time left of `ready`, of `set`, of a free kick, of a time-out or of a shot in a shoot-out, s.
    #[serde(default)]
    pub secondary_time_left_s: Option<f64>,
    /// The numbers of the goalkeepers of `blue` and `pink`, if a substitute has replaced one with number 1.
    #[serde(default, skip_serializing_if = "has_first_goalkeepers")]
    pub goalkeepers: PerTeam<Option<u8>>,
    /// How many time-outs `blue` and `pink` may still take.
    #[serde(default)]
    pub timeouts_left: PerTeam<u32>,
    /// How many messages `blue` and `pink` may still send; none if unlimited.
    #[serde(default)]
    pub messages_left: Option<PerTeam<u32>>,
    /// How often the referee has whistled.
    #[serde(default)]
    pub whistles: u32,
    /// How often the referee has raised its arms for a half's first `ready`.
    #[serde(default)]
    pub ready_signals: u32,
    /// The penalty shoot-out under way, or that decided the match.
    #[serde(default)]
    pub shoot_out: Option<ShootOutRecord>,
    /// Whether the match is stopped briefly: no robot may move, and all clocks stand.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub stopped: bool,
}

impl GameRecord {
    /// Returns the end that a team defends.
    pub fn own_end(&self, team: Team) -> End {
        match team {
            Team::Blue => self.blue_end,
            Team::Pink => self.blue_end.opposite(),
        }
    }

    /// Returns the state of a game under these rules.
    pub fn of(game: &Game, rules: &Rules, clock: &CycleClock) -> Self {
        let seconds = |cycles: u64| cycles as f64 * clock.period_s;
        GameRecord {
            state: game.state,
            score: game.score,
            half: game.half,
            time_left_s: game.cycles_left.map(seconds),
            blue_end: game.blue_end,
            kicking_team: game.set_play.map(|set_play| set_play.team).or(game.kick_off()),
            set_play: game.set_play.map(|set_play| SetPlayStatus { kind: set_play.kind, team: Some(set_play.team) }),
            secondary_time_left_s: game.secondary_cycles_left(rules, clock).map(seconds),
            goalkeepers: game.goalkeepers,
            timeouts_left: game.timeouts_left,
            messages_left: game.messages_left,
            whistles: game.whistles,
            ready_signals: game.ready_signals,
            shoot_out: game.shoot_out.map(|shoot_out| ShootOutRecord {
                team: shoot_out.team,
                taken: shoot_out.taken,
                goals: shoot_out.goals,
            }),
            stopped: game.stop.is_some(),
        }
    }
}

/// A penalty shoot-out.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
pub struct ShootOutRecord {
    /// The shooting team.
    pub team: Team,
    /// The shots of `blue` and `pink` so far.
    pub taken: Score,
    /// The goals of `blue` and `pink` in it.
    pub goals: Score,
}

/// A velocity: m/s and rad/s in memory, `[x m/s, y m/s, turn deg/s]` in the file.
mod velocity {
    use super::{Velocity, file_units::step};
    use bevy::math::Vec2;
    use serde::{Deserializer, Serializer};

    pub fn serialize<S: Serializer>(velocity: &Velocity, serializer: S) -> Result<S::Ok, S::Error> {
        step::serialize(&[velocity.linear.x, velocity.linear.y, velocity.angular], serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Velocity, D::Error> {
        step::deserialize(deserializer).map(|[x, y, angular]| Velocity { linear: Vec2::new(x, y), angular })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_perceives_all_of_its_record_but_what_it_cannot_know() {
        fn fields(value: impl Serialize) -> Vec<String> {
            let value = serde_json::to_value(value).unwrap();
            let mut names: Vec<String> = value.as_object().unwrap().keys().cloned().collect();
            names.sort();
            names
        }
        let sensors = BTreeMap::from([("ear".to_owned(), Value::Bool(true))]);
        let perception = Perception { sensors, ..default() };
        let record = RobotRecord { command: Some(default()), ..RobotRecord::new(RobotId::new(Team::Blue, 1)) };
        let record = record.with_perception(perception.clone());
        assert_eq!(record.perception(), perception);
        let mut expected = fields(&perception);
        expected.extend(["belief", "command", "id", "penalised", "pose", "velocity"].map(str::to_owned));
        expected.sort();
        assert_eq!(fields(&record), expected);
    }
}
