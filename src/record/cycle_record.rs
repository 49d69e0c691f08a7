//! What a line of a trace says of a cycle.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

use crate::behaviour::drawings::Drawings;
use crate::belief::Belief;
use crate::communication::ReceivedMessage;
use crate::events::MatchEvent;
use crate::game::{GameState, PenaltyReason, Score};
use crate::geometry::{Pose, file_units, to_radians};
use crate::robot::Velocity;
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::sensing::sonar::SonarReading;
use crate::sensing::vision::Percepts;
use crate::team::RobotId;

/// The world after a cycle, as a trace has it.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct CycleRecord {
    /// Cycles since the start.
    pub cycle: u64,
    /// Time since the start, s.
    pub time_s: f64,
    /// The ball, if there is one.
    pub ball: Option<BallRecord>,
    /// The robots, in the order of their ids.
    pub robots: Vec<RobotRecord>,
    /// The state of the game.
    pub game: GameRecord,
    /// What happened in the cycle.
    pub events: Vec<MatchEvent>,
}

/// The ball after a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct BallRecord {
    /// Its centre, m, pitch frame.
    pub position_m: Vec3,
    /// Its velocity, m/s, pitch frame.
    pub velocity_mps: Vec3,
}

/// A robot after a cycle, and what it sensed in it.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct RobotRecord {
    /// Which robot.
    pub id: RobotId,
    /// Where it is, pitch frame.
    #[serde(with = "file_units::pose")]
    pub pose: Pose,
    velocity: [f32; 3],
    head_deg: [f32; 2],
    /// How its body is.
    #[serde(default)]
    pub posture: Posture,
    /// The penalty that it serves.
    pub penalised: Option<PenaltyRecord>,
    /// What it knew of its own way.
    #[serde(with = "file_units::pose")]
    pub odometry: Pose,
    /// What its sonars heard.
    pub sonar_m: SonarReading,
    /// What it recognised.
    pub percepts: Percepts,
    /// The messages that it got.
    pub inbox: Vec<ReceivedMessage>,
    /// What it believed.
    pub belief: Option<Belief>,
    /// What sensors of the program's own read, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensors: BTreeMap<String, Value>,
    /// What its behaviour drew.
    #[serde(default, skip_serializing_if = "Drawings::is_empty")]
    pub drawings: Drawings,
}

impl RobotRecord {
    /// How it moves, pitch frame.
    pub fn velocity(&self) -> Velocity {
        let [x, y, angular_degps] = self.velocity;
        Velocity { linear: Vec2::new(x, y), angular: to_radians(angular_degps) }
    }

    /// Where its head is turned.
    pub fn head(&self) -> HeadAngles {
        let [yaw, pitch] = self.head_deg.map(to_radians);
        HeadAngles { yaw, pitch }
    }
}

/// A penalty that is being served.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct PenaltyRecord {
    /// What for.
    pub reason: PenaltyReason,
    /// Time of play until the robot may come back, s.
    pub time_left_s: f64,
}

/// The state of the game after a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct GameRecord {
    /// The state.
    pub state: GameState,
    /// Goals.
    pub score: Score,
    /// The half, from 1.
    pub half: u32,
    /// Time left in the half, s; none without a clock.
    pub time_left_s: Option<f64>,
}
