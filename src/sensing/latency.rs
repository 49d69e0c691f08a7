//! Latency: what is perceived is older when it is decided on, and what is decided happens later.
//!
//! **What is late.** An image takes its time from exposure to what is recognised in it, and so do commands on their way to the
//! motors. [`Percepts::time_s`] says when they were seen. What joints and the body's own state say is as fresh as the cycle.
//!
//! **Units.** Seconds; whole cycles of them, the nearest. None by default.
//!
//! **The real NAO**: 30 to 100 ms from exposure to motion, by what teams report.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::scene::SensingSystems;
use super::vision::Percepts;
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::knowledge::Knowledge;
use crate::robot::kick::{KickCommand, KickRequest};
use crate::robot::motion::WalkCommand;

/// Holds back percepts, and commands before they are taken over.
pub struct LatencyPlugin;

impl Plugin for LatencyPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Latency>()
            .register_type::<OnTheirWay>()
            .add_systems(Cycle, hold_back_percepts.in_set(SensingSystems::Late))
            .add_systems(Cycle, hold_back_commands.in_set(CycleSystems::Act).before(ActSystems::Say));
    }
}

/// How late a robot's percepts and commands are.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[require(OnTheirWay)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Latency {
    /// From an image's exposure until what is recognised in it can be decided on, s.
    pub vision_s: f32,
    /// From a walk's command until a step can take it over, s.
    pub walk_s: f32,
    /// From a kick's command until the leg begins, s.
    pub kick_s: f32,
}

/// What is on its way, the oldest first.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct OnTheirWay {
    percepts: VecDeque<Percepts>,
    walks: VecDeque<WalkCommand>,
    kicks: VecDeque<Option<KickRequest>>,
}

fn hold_back_percepts(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut Percepts, &mut OnTheirWay)>) {
    for (latency, mut percepts, mut on_their_way) in &mut robots {
        percepts.time_s = clock.start_time_s();
        let cycles = clock.cycles_in(latency.vision_s);
        if cycles > 0 || !on_their_way.percepts.is_empty() {
            *percepts = after(cycles, &mut on_their_way.percepts, core::mem::take(&mut *percepts));
        }
    }
}

fn hold_back_commands(
    clock: Res<CycleClock>,
    mut robots: Query<(&Latency, &mut WalkCommand, &mut KickCommand, &mut OnTheirWay)>,
) {
    for (latency, mut walk, mut kick, mut on_their_way) in &mut robots {
        let [walk_cycles, kick_cycles] = [latency.walk_s, latency.kick_s].map(|seconds| clock.cycles_in(seconds));
        if walk_cycles > 0 || !on_their_way.walks.is_empty() {
            *walk = after(walk_cycles, &mut on_their_way.walks, *walk);
        }
        if kick_cycles > 0 || !on_their_way.kicks.is_empty() {
            kick.0 = after(kick_cycles, &mut on_their_way.kicks, kick.0);
        }
    }
}

/// Sends a value on its way, and takes the one that arrives after so many cycles; nothing while there is none.
fn after<T: Default>(cycles: u32, on_their_way: &mut VecDeque<T>, value: T) -> T {
    on_their_way.push_back(value);
    let mut arrived = T::default();
    while on_their_way.len() > cycles as usize {
        arrived = on_their_way.pop_front().unwrap_or_default();
    }
    arrived
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_arrives_after_its_cycles_and_what_is_too_old_is_dropped_when_it_gets_faster() {
        let mut queue = VecDeque::new();
        let arrived: Vec<u32> = (1..=6).map(|value| after(2, &mut queue, value)).collect();
        assert_eq!(arrived, [0, 0, 1, 2, 3, 4]);
        assert_eq!((after(1, &mut queue, 7), after(0, &mut queue, 8)), (6, 8));
        assert!(queue.is_empty());
    }
}
