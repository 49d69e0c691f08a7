//! Latency: sensor readings are old when a robot decides, and commands are executed later than they are given.
//!
//! | what | setting | the time of the reading |
//! |---|---|---|
//! | objects recognised in images | `vision_s` | `Percepts::time_s` |
//! | images, for robots that process them themselves | `image_s` | `CameraImages::cycle`, and an image's `time_s` for programs |
//! | sonars | `sonar_s` | `SonarReading::time_s` |
//! | walks, kicks, head angles | `walk_s`, `kick_s`, `head_s` | |
//!
//! This module delays commands; the sensors delay their readings. Joint angles, odometry and the state of the body are never delayed: a
//! NAO's board reads them every 10 ms, which is less than half a cycle. Messages have [a delay of their
//! own](crate::communication::MessageSettings::delay_cycles).
//!
//! **Units.** Seconds, rounded to whole cycles. No delay by default.
//!
//! **The real NAO**: 30 to 100 ms from exposure to motion, as teams report.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::head::{HeadAngles, HeadCommand, LateHeadCommand};
use super::kick::{KickCommand, KickRequest};
use super::motion::WalkCommand;
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::Refusal;
use crate::knowledge::Knowledge;

/// Delays commands before they are carried out, at the start of [`CycleSystems::Act`].
pub struct LatencyPlugin;

impl Plugin for LatencyPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Latency>()
            .register_type::<CommandQueues>()
            .add_systems(Cycle, delay_commands.in_set(CycleSystems::Act).before(ActSystems::Say));
    }
}

/// The delays of a robot's readings and commands.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(CommandQueues, LateHeadCommand)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Latency {
    /// From an image's exposure until the objects recognised in it are known, s. Includes `image_s`.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub vision_s: f32,
    /// From an image's exposure until the image is available, s.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 2.0))]
    pub image_s: f32,
    /// From a ping until the reading is available, s.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 2.0))]
    pub sonar_s: f32,
    /// From a walk command until a step follows it, s.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub walk_s: f32,
    /// From a kick command until the leg begins to move, s.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub kick_s: f32,
    /// From a head command until the joints begin to turn, s.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 2.0))]
    pub head_s: f32,
}

impl Latency {
    /// Whether any reading is delayed.
    pub fn delays_readings(&self) -> bool {
        [self.vision_s, self.image_s, self.sonar_s] != [0.0; 3]
    }

    /// Whether any command is delayed.
    fn delays_commands(&self) -> bool {
        [self.walk_s, self.kick_s, self.head_s] != [0.0; 3]
    }
}

fn is_zero(seconds: &f32) -> bool {
    *seconds == 0.0
}

/// The commands that have not been carried out yet, the oldest first.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
#[serde(default)]
pub struct CommandQueues {
    walks: VecDeque<WalkCommand>,
    kicks: VecDeque<Option<KickRequest>>,
    heads: VecDeque<HeadCommand>,
}

impl CommandQueues {
    fn are_empty(&self) -> bool {
        self.walks.is_empty() && self.kicks.is_empty() && self.heads.is_empty()
    }
}

pub(super) fn delay_commands(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Latency,
        &mut WalkCommand,
        &mut KickCommand,
        &HeadCommand,
        &HeadAngles,
        &mut LateHeadCommand,
        &mut CommandQueues,
    )>,
) {
    for (latency, mut walk, mut kick, head, angles, mut late_head, mut queues) in &mut robots {
        if !latency.delays_commands() && queues.are_empty() && late_head.0.is_none() {
            continue;
        }
        let [walk_cycles, kick_cycles, head_cycles] =
            [latency.walk_s, latency.kick_s, latency.head_s].map(|seconds| clock.cycles_in(seconds));
        if walk_cycles > 0 || !queues.walks.is_empty() {
            delay(&mut *walk, walk_cycles, &mut queues.walks);
        }
        if kick_cycles > 0 || !queues.kicks.is_empty() {
            delay(&mut kick.0, kick_cycles, &mut queues.kicks);
        }
        delay_head(head_cycles, (head, angles), &mut late_head, &mut queues.heads);
    }
}

/// Delays the head command by `cycles`. A head command stays until it is changed: the joints follow the command given `cycles` ago, and
/// keep their angles until the first one arrives.
fn delay_head(
    cycles: u32,
    (command, angles): (&HeadCommand, &HeadAngles),
    late: &mut LateHeadCommand,
    queue: &mut VecDeque<HeadCommand>,
) {
    if cycles == 0 {
        late.0 = None;
        queue.clear();
        return;
    }
    let stays = HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
    // A command that is not a number is refused, and the head stays where it is.
    let is_refused = Refusal::of_numbers([command.yaw, command.pitch]).is_some();
    queue.push_back(if is_refused { stays } else { *command });
    while queue.len() > cycles as usize {
        late.0 = queue.pop_front();
    }
    late.0 = Some(late.0.unwrap_or(stays));
}

/// Delays `value` by `cycles`: puts it into the queue, and replaces it by the value that is due, or by the default if none is.
pub fn delay<T: Default>(value: &mut T, cycles: u32, queue: &mut VecDeque<T>) {
    let cycles = cycles as usize;
    // The usual case: the queue has the right length, and the oldest value makes room for the new one.
    if queue.len() == cycles
        && let Some(oldest) = queue.pop_front()
    {
        queue.push_back(core::mem::replace(value, oldest));
        return;
    }
    queue.push_back(core::mem::take(value));
    while queue.len() > cycles {
        *value = queue.pop_front().unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_delayed_by_their_cycles_and_old_ones_are_dropped_when_the_delay_gets_shorter() {
        let mut queue = VecDeque::new();
        let mut after = |mut value: u32, cycles: u32| {
            delay(&mut value, cycles, &mut queue);
            value
        };
        let arrived: Vec<u32> = (1..=6).map(|value| after(value, 2)).collect();
        assert_eq!(arrived, [0, 0, 1, 2, 3, 4]);
        assert_eq!((after(7, 1), after(8, 0), after(9, 0)), (6, 8, 9));
        assert!(queue.is_empty());
    }
}
