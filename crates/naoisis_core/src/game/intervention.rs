//! Interventions: what a person, a program or a scenario makes the referee do.
//!
//! An [`Intervention`] is a Bevy command (`commands.queue(Intervention::Whistle)`), and a scenario file lists them with
//! the time at which they happen. They are carried out at the end of the cycle, after the rules have been applied;
//! what cannot be done is refused and reported, and nothing changes.

use bevy::prelude::*;
use core::fmt;
use serde::{Deserialize, Serialize};

use super::PenaltyReason;
use crate::geometry::{Pose, file_units};
use crate::knowledge::Knowledge;
use crate::team::{RobotId, Team};

/// Something that the referee is made to do.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Intervention {
    /// Puts the ball down, where there is room for it.
    PlaceBall {
        /// Where to put it, m, pitch frame.
        position_m: Vec2,
        /// With which velocity, m/s, pitch frame.
        #[serde(default)]
        velocity_mps: Vec2,
    },
    /// Puts a robot down, where there is room for it.
    PlaceRobot {
        /// The robot.
        robot: RobotId,
        /// Where to put it, pitch frame: `[x m, y m, heading deg]` in files.
        #[serde(with = "file_units::pose")]
        pose: Pose,
    },
    /// Sets the score.
    SetScore {
        /// Of the blue team.
        blue: u32,
        /// Of the pink team.
        pink: u32,
    },
    /// Removes a robot from the pitch.
    Penalise {
        /// The robot.
        robot: RobotId,
        /// The reason that is given.
        #[serde(default)]
        reason: PenaltyReason,
        /// For how long, s of play. Without it as long as the rules say for this reason, and it counts as the referee's own
        /// penalties do; with it, it counts for nothing else.
        #[serde(default)]
        duration_s: Option<f32>,
    },
    /// Ends a robot's penalty.
    Return {
        /// The robot.
        robot: RobotId,
    },
    /// Whistles: `standby` becomes `ready` (for which the referee raises its arms), `ready` becomes `set`, `set` becomes `playing`. In play it is only heard.
    Whistle,
    /// Puts the ball down to rest, in play, with neither team having a right to it.
    DropBall {
        /// Where to put it, m, pitch frame; the centre mark by default.
        #[serde(default)]
        position_m: Vec2,
    },
    /// Stops play for a kick-off.
    KickOff {
        /// Of this team.
        team: Team,
    },
}

impl fmt::Display for Intervention {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Intervention::PlaceBall { position_m, velocity_mps } => write!(
                formatter,
                "the ball is put at ({:.2}, {:.2}) with {:.2} m/s",
                position_m.x,
                position_m.y,
                velocity_mps.length()
            ),
            Intervention::PlaceRobot { robot, pose } => {
                write!(formatter, "{robot} is put at ({:.2}, {:.2})", pose.position.x, pose.position.y)
            }
            Intervention::SetScore { blue, pink } => write!(formatter, "the score is set to blue {blue} : pink {pink}"),
            Intervention::Penalise { robot, .. } => write!(formatter, "{robot} is penalised"),
            Intervention::Return { robot } => write!(formatter, "{robot} may return"),
            Intervention::Whistle => formatter.write_str("the whistle"),
            Intervention::DropBall { position_m } => {
                write!(formatter, "the ball is dropped at ({:.2}, {:.2})", position_m.x, position_m.y)
            }
            Intervention::KickOff { team } => write!(formatter, "kick-off for {team}"),
        }
    }
}

/// An intervention at a given time.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedIntervention {
    /// When, s since the start: it is carried out at the end of the first cycle that ends then or later.
    pub at_s: f64,
    /// What is done.
    #[serde(rename = "do")]
    pub intervention: Intervention,
}

/// The interventions to come.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Interventions {
    /// Those for the end of this cycle, in the order in which they were asked for.
    pub queue: Vec<Intervention>,
    /// Those for a later time, the latest first.
    scheduled: Vec<TimedIntervention>,
}

impl Interventions {
    /// The interventions that a scenario lists; of those for the same time the first in the list comes first.
    pub fn scheduled(list: &[TimedIntervention]) -> Self {
        let mut scheduled: Vec<_> = list.iter().rev().copied().collect();
        scheduled.sort_by(|a, b| b.at_s.total_cmp(&a.at_s));
        Self { queue: Vec::new(), scheduled }
    }

    /// Moves those that are due at `time_s` to the queue.
    pub fn fall_due(&mut self, time_s: f64) {
        // Half a microsecond for rounding: a time given with a few digits is met by the cycle that it means.
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
