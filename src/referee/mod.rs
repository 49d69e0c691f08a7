//! The referee: game states, score, halves, goals and outs.
//!
//! At the end of every cycle the referee looks at a [`snapshot`] of the match. The rules, one file each, are plain
//! functions of it; what they say becomes [`decide::Decisions`], which one system carries out.

use bevy::prelude::*;

pub mod areas;
pub mod ball_holding;
pub mod ball_out;
pub mod boundary;
pub mod collision;
pub mod decide;
pub mod evidence;
pub mod fallen;
pub mod formation;
mod game;
pub mod game_stuck;
pub mod goal;
pub mod illegal_defender;
pub mod inactive;
pub mod indirect_goal;
pub mod intervention;
pub mod kick_off_shot;
pub mod leaving_field;
pub mod memory;
mod penalise;
pub mod penalty;
pub mod placing;
pub mod positions;
pub mod removal;
pub mod report;
mod restarts;
mod rules;
pub mod set_play;
pub mod shoot_out;
pub mod snapshot;
pub mod stalling;
mod status;
mod systems;
#[cfg(test)]
mod testing;
pub mod touch;

pub use evidence::Evidence;
pub use formation::formation;
pub use game::{Game, GameState, Score};
pub use intervention::{Intervention, Interventions, TimedIntervention};
pub use memory::RefereeMemory;
pub use penalty::{ActivePenalty, Penalty, PenaltyReason};
pub use positions::IllegalPosition;
pub use rules::{BallOutRestart, DefenderLimit, KickOffPositions, KickOffProcedure, ReturnPlace, Rules, RulesError};
pub use set_play::{SetPlay, SetPlayKind};
pub use shoot_out::ShootOut;
pub use status::{Announcement, GameStatus, SetPlayStatus};
pub use touch::Touch;

use crate::cycle::{BeginCycle, Cycle, CycleClock, CycleSystems};
use crate::random::RandomStream;
use crate::robot::RobotId;
use crate::scenario::Scenario;

/// The referee, in [`CycleSystems::Officiate`], and the robots' [`GameStatus`], in [`CycleSystems::Sense`].
pub struct RefereePlugin;

impl Plugin for RefereePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Game>()
            .init_resource::<Rules>()
            .init_resource::<RefereeMemory>()
            .init_resource::<Interventions>()
            .register_type::<Interventions>()
            .register_type::<Game>()
            .register_type::<Rules>()
            .register_type::<RefereeMemory>()
            .register_type::<Penalty>()
            .register_type::<GameStatus>()
            .register_required_components::<RobotId, Penalty>()
            .register_required_components::<RobotId, GameStatus>()
            .add_systems(
                Cycle,
                (
                    systems::begin_match.in_set(CycleSystems::First).after(BeginCycle),
                    status::tell_status.in_set(StatusSystems).in_set(CycleSystems::Sense),
                    systems::officiate.in_set(OfficiateSystems).in_set(CycleSystems::Officiate),
                ),
            );
    }
}

/// The system in which the referee judges.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct OfficiateSystems;

/// The system that tells the robots the state of the game.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct StatusSystems;

/// Prepares the referee for the match of a scenario.
pub fn start(world: &mut World, scenario: &Scenario, clock: &CycleClock) {
    let game = Game::at_start(&scenario.rules, clock);
    world.insert_resource(RefereeMemory {
        announcement: Announcement::of(&game),
        coin: Some(RandomStream::for_match(scenario.seed, "coin")),
        ..default()
    });
    world.insert_resource(Interventions::scheduled(&scenario.interventions));
    world.insert_resource(game);
}
