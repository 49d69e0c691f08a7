//! Commands that start and end a match.

use bevy::prelude::*;

use super::spawn::despawn_match;
use super::start::start;
use super::triggers::{MatchEnd, MatchEnded, MatchNotStarted};
use crate::scenario::Scenario;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::CycleEvents;
use naoisis_core::game::{Game, GameState};

/// Starts and ends a match from a system, an observer, or any other place with [`Commands`].
///
/// Commands of a system in the [`Cycle`](naoisis_core::cycle::Cycle) would be applied in the middle of a cycle. Use an
/// [observer](super::triggers) there instead.
pub trait MatchCommands {
    /// Starts the scenario's match in the world, and removes an earlier one. Triggers [`MatchStarted`](super::MatchStarted), or
    /// [`MatchNotStarted`] if the scenario contradicts itself or has unregistered names. The earlier match continues in that case.
    fn start_match(&mut self, scenario: Scenario) -> &mut Self;

    /// Removes the match from the world, and triggers [`MatchEnded`] unless the match was over already. Does nothing if there is no match.
    fn end_match(&mut self) -> &mut Self;
}

impl MatchCommands for Commands<'_, '_> {
    fn start_match(&mut self, scenario: Scenario) -> &mut Self {
        self.queue(move |world: &mut World| {
            if let Err(fault) = start(world, &scenario) {
                error!("the match `{}` cannot be started: {fault}", scenario.name);
                world.trigger(MatchNotStarted { fault });
            }
        });
        self
    }

    fn end_match(&mut self) -> &mut Self {
        self.queue(end_match);
        self
    }
}

/// Removes the match from the world: its robots, ball and posts, and its [`Scenario`]. The game's state and score stay until the next match
/// starts. Triggers [`MatchEnded`] unless the match was over already. Does nothing if there is no match.
pub fn end_match(world: &mut World) {
    if !world.contains_resource::<Scenario>() {
        return;
    }
    let was_over = is_over(world);
    world.remove_resource::<Scenario>();
    despawn_match(world);
    world.insert_resource(CycleEvents::default());
    if !was_over {
        let score = world.resource::<Game>().score;
        world.trigger(MatchEnded { reason: MatchEnd::Removed, score });
    }
}

/// Returns whether the match in the world is over, by the final whistle or by the scenario's [time](Scenario::last_cycle).
pub fn is_over(world: &World) -> bool {
    let has_whistled = world.get_resource::<Game>().is_some_and(|game| game.state == GameState::Finished);
    has_whistled || is_time_over(world)
}

/// Returns whether the scenario's [time](Scenario::last_cycle) is over.
pub(super) fn is_time_over(world: &World) -> bool {
    let last_cycle = world.get_resource::<Scenario>().and_then(Scenario::last_cycle);
    let clock = world.get_resource::<CycleClock>();
    last_cycle.zip(clock).is_some_and(|(last, clock)| clock.cycle >= last)
}
