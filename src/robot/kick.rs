//! Kicks: the four types of the paper's section 3.2, their geometry (Table 2), and their course in time.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::geometry::file_units;
use crate::knowledge::Knowledge;

/// The foot that kicks.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Foot {
    /// The left foot, at +y in the robot frame.
    Left,
    /// The right foot, at -y in the robot frame.
    Right,
}

/// The four types of kick (paper, section 3.2).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KickType {
    /// Forward with the left foot.
    LeftStraight,
    /// Forward with the right foot.
    RightStraight,
    /// With the left foot, extended to the front and swung inwards: a ball on the robot's right leaves to the right.
    LeftSide,
    /// With the right foot: a ball on the robot's left leaves to the left.
    RightSide,
}

/// A kick that a behaviour wants.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KickRequest {
    /// Which kick.
    #[serde(rename = "type")]
    pub kick_type: KickType,
    /// 0 to 1: the share of the type's greatest launch speed. Clamped outside; a kick of NaN is refused.
    #[serde(default = "full_speed")]
    pub speed: f32,
}

fn full_speed() -> f32 {
    1.0
}

/// The kick wanted in this cycle, if any. None again after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct KickCommand(pub Option<KickRequest>);

/// Where a robot is in the course of a kick: it neither walks nor kicks again before it has recovered.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub enum KickPhase {
    /// Not kicking.
    #[default]
    Ready,
    /// The leg swings; the ball is struck when the time is over.
    WindUp {
        /// The kick under way.
        request: KickRequest,
        /// Cycles until the foot meets the ball.
        cycles_left: u32,
    },
    /// Regaining balance.
    Recovering {
        /// Cycles until the robot may walk again.
        cycles_left: u32,
    },
}

/// How far one type of kick sends the ball.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KickRange {
    /// Distance that the ball rolls at speed 1 with nothing in its way, m.
    pub max_distance_m: f32,
}

impl Default for KickRange {
    fn default() -> Self {
        Self { max_distance_m: 4.0 }
    }
}

/// Settings of the kicks.
///
/// Distances: rUNSWift's forward kick of 2010 reached 4.0 to 5.8 m at full power, its side kick 2 to 3 m.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct KickSettings {
    /// The left straight kick; 4 m by default.
    pub left_straight: KickRange,
    /// The right straight kick; 4 m by default.
    pub right_straight: KickRange,
    /// The left side kick; 2 m by default.
    pub left_side: KickRange,
    /// The right side kick; 2 m by default.
    pub right_side: KickRange,
    /// A side kick from the wrong side is a straight kick at this share of the speed (paper, section 3.2).
    pub wrong_side_speed_factor: f32,
    /// From the command until the foot meets the ball, s.
    pub wind_up_s: f32,
    /// From then until the robot can walk or kick again, s.
    pub recovery_s: f32,
    /// Standard deviation of the direction, radians (degrees in files).
    #[serde(rename = "direction_sd_deg", with = "file_units::degrees")]
    pub direction_sd: f32,
    /// Standard deviation of the launch speed, as a share of it.
    pub speed_sd: f32,
}

impl Default for KickSettings {
    fn default() -> Self {
        Self {
            left_straight: KickRange { max_distance_m: 4.0 },
            right_straight: KickRange { max_distance_m: 4.0 },
            left_side: KickRange { max_distance_m: 2.0 },
            right_side: KickRange { max_distance_m: 2.0 },
            wrong_side_speed_factor: 0.5,
            wind_up_s: 0.0,
            recovery_s: 1.0,
            direction_sd: 0.0,
            speed_sd: 0.0,
        }
    }
}
