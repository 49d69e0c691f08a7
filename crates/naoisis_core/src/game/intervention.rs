//! Interventions: requests of a person, a program or a scenario to the referee.
//!
//! An [`Intervention`] is a Bevy command (`commands.queue(Intervention::Whistle)`), and a scenario file lists interventions with their
//! times. They are applied at the end of the cycle, after the rules. An intervention that cannot be applied is refused and reported, and
//! nothing changes.

use bevy::prelude::*;
use core::fmt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PenaltyReason;
use crate::geometry::{Pose, file_units, to_degrees};
use crate::knowledge::Knowledge;
use crate::team::{RobotId, Team};

/// A request to the referee.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Intervention {
    /// Places the ball at the nearest free position.
    PlaceBall {
        /// Position, m, pitch frame.
        #[schemars(with = "[f32; 2]")]
        position_m: Vec2,
        /// Velocity, m/s, pitch frame.
        #[serde(default)]
        #[schemars(with = "[f32; 2]")]
        velocity_mps: Vec2,
    },
    /// Places a robot at the nearest free position.
    PlaceRobot {
        /// The robot.
        robot: RobotId,
        /// Pose, pitch frame: `[x m, y m, heading deg]` in files.
        #[serde(with = "file_units::pose")]
        #[schemars(with = "[f32; 3]")]
        pose: Pose,
    },
    /// Sets the score of play. Refused in a shoot-out.
    SetScore {
        /// Goals of the blue team.
        blue: u32,
        /// Goals of the pink team.
        pink: u32,
    },
    /// Removes a robot from the pitch.
    Penalise {
        /// The robot.
        robot: RobotId,
        /// The offence.
        #[serde(default)]
        reason: PenaltyReason,
        /// Duration, s of play. Without it the duration is that of the rules, and the penalty makes later ones longer, like the referee's
        /// own; with it, it does not.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 100_000.0))]
        duration_s: Option<f32>,
    },
    /// Picks up a robot at its team's request, for the penalty of the rules.
    PickUp {
        /// The robot.
        robot: RobotId,
    },
    /// Ends a robot's penalty.
    Return {
        /// The robot.
        robot: RobotId,
    },
    /// Whistles: `standby` becomes `ready` (for which the referee raises its arms), `ready` becomes `set`, `set` becomes `playing`. In play
    /// it has no effect but the sound.
    Whistle,
    /// Places the ball at rest, in play, for either team.
    DropBall {
        /// Position, m, pitch frame; the centre mark by default.
        #[serde(default)]
        #[schemars(with = "[f32; 2]")]
        position_m: Vec2,
    },
    /// Stops play for a kick-off.
    KickOff {
        /// The team that kicks off.
        team: Team,
    },
    /// Stops the match briefly: no robot may move, and no clock runs.
    Stop,
    /// Ends a brief stop, after which the match continues unchanged, or a time-out before its time.
    Resume,
    /// Requests a time-out of a team in the next stoppage of play, or begins one of the referee at once.
    Timeout {
        /// The team; absent for the referee.
        #[serde(default)]
        team: Option<Team>,
        /// Duration, s; by default as long as the rules allow.
        #[serde(default)]
        #[schemars(range(min = 0.0, max = 100_000.0))]
        duration_s: Option<f32>,
    },
    /// Requests that a player be replaced by a substitute as soon as the rules allow it.
    Substitute {
        /// The player.
        robot: RobotId,
        /// The substitute.
        by: RobotId,
    },
}

impl fmt::Display for Intervention {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Intervention::PlaceBall { position_m: Vec2 { x, y }, velocity_mps } if *velocity_mps == Vec2::ZERO => {
                write!(formatter, "the ball is put at ({x:.2}, {y:.2})")
            }
            Intervention::PlaceBall { position_m: Vec2 { x, y }, velocity_mps } => {
                write!(formatter, "the ball is kicked from ({x:.2}, {y:.2}) with {:.2} m/s", velocity_mps.length())
            }
            Intervention::PlaceRobot { robot, pose } => {
                let Vec2 { x, y } = pose.position;
                // Without a minus sign before zero.
                let heading_deg = to_degrees(pose.heading).round() + 0.0;
                write!(formatter, "{robot} is put at ({x:.2}, {y:.2}), facing {heading_deg:.0}°")
            }
            Intervention::SetScore { blue, pink } => write!(formatter, "the score is set to blue {blue} : pink {pink}"),
            Intervention::Penalise { robot, .. } => write!(formatter, "{robot} is penalised"),
            Intervention::PickUp { robot } => write!(formatter, "{robot} is picked up at its team's request"),
            Intervention::Return { robot } => write!(formatter, "{robot} may return"),
            Intervention::Whistle => formatter.write_str("the whistle"),
            Intervention::DropBall { position_m } => {
                write!(formatter, "the ball is dropped at ({:.2}, {:.2})", position_m.x, position_m.y)
            }
            Intervention::KickOff { team } => write!(formatter, "kick-off for {team}"),
            Intervention::Stop => formatter.write_str("a brief stop"),
            Intervention::Resume => formatter.write_str("the match goes on"),
            Intervention::Timeout { team: Some(team), .. } => write!(formatter, "{team} asks for a time-out"),
            Intervention::Timeout { team: None, .. } => formatter.write_str("a time-out of the referee"),
            Intervention::Substitute { robot, by } => write!(formatter, "{by} is to replace {robot}"),
        }
    }
}

/// An intervention at a given time.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimedIntervention {
    /// Time, s since the start: the intervention is applied at the end of the first cycle that ends then or later.
    #[schemars(range(min = 0.0))]
    pub at_s: f64,
    /// The intervention.
    #[serde(rename = "do")]
    pub intervention: Intervention,
}

/// The pending interventions.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Interventions {
    /// The interventions for the end of this cycle, in the order of the requests.
    pub queue: Vec<Intervention>,
    /// Those in the queue that robots requested, in the order of the queue.
    #[serde(skip)]
    pub(crate) requested: Vec<(RobotId, Intervention)>,
    /// The interventions for a later time, the latest first.
    scheduled: Vec<TimedIntervention>,
}

impl Interventions {
    /// The interventions of a scenario. Interventions for the same time keep their order.
    pub(crate) fn scheduled(list: &[TimedIntervention]) -> Self {
        let mut scheduled: Vec<_> = list.iter().rev().copied().collect();
        scheduled.sort_by(|a, b| b.at_s.total_cmp(&a.at_s));
        Self { scheduled, ..Self::default() }
    }

    /// Moves the interventions that are due at `time_s` to the queue.
    pub(crate) fn fall_due(&mut self, time_s: f64) {
        // Half a microsecond for the rounding of times in files.
        while let Some(next) = self.scheduled.pop_if(|next| next.at_s <= time_s + 5e-7) {
            self.queue.push(next.intervention);
        }
    }
}

impl Command for Intervention {
    type Out = ();

    fn apply(self, world: &mut World) {
        world.get_resource_or_init::<Interventions>().queue.push(self);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn those_of_a_scenario_fall_due_in_their_order() {
        let at = |at_s, blue| TimedIntervention { at_s, intervention: Intervention::SetScore { blue, pink: 0 } };
        let mut interventions = Interventions::scheduled(&[at(2.0, 3), at(1.0, 1), at(1.0, 2)]);
        interventions.fall_due(0.5);
        assert!(interventions.queue.is_empty());
        interventions.fall_due(1.0);
        let scores = [1, 2].map(|blue| Intervention::SetScore { blue, pink: 0 });
        assert_eq!(interventions.queue, scores);
        interventions.queue.clear();
        interventions.fall_due(5.0);
        assert_eq!(interventions.queue.len(), 1);
    }
}
