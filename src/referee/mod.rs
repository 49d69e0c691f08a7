//! The referee: game states, score, halves, goals and outs, restarts, penalties, and why.
//!
//! At the end of every cycle the referee looks at a [`snapshot`] of the match. The rules, one file each, are plain
//! functions of it; what they say becomes [`decide::Decisions`], which one system carries out. Every verdict is a
//! [`MatchEvent`](crate::events::MatchEvent) with its [`Evidence`](crate::game::Evidence): who, where, what was measured, the rule in one
//! sentence, and what would have changed it. `naoisis run --explain` prints them as a [match report](report).
//!
//! # Rules as data
//!
//! [`Rules`] has a switch and the figures of each rule. Presets are files in `assets/rules`; a scenario names one, or
//! changes some of its fields: `rules: (preset: "spl2010", half_s: 300, pushing_limit: None)`.
//!
//! | rule | source | `naoisis` | `spl2010` | `spl2025` | `extended` | `free` |
//! |---|---|---|---|---|---|---|
//! | [goals](goal), own goals | 2010: 3.5 | yes | yes | yes | yes | |
//! | [no goal straight from the kick-off](kick_off_shot) | 2010: 4.4 | | yes | | | |
//! | [indirect goals](indirect_goal) | 2025: Indirect Kick | | | yes | | |
//! | a lead of ten goals ends the match | 2025: Mercy Rule | | | yes | | |
//! | [ball out](ball_out) leads to | 2010: 3.9; 2025: Ball Leaving the Field | kick-off | throw-in | [free kick](set_play) | kick-off | |
//! | `ready` and `set` before a kick-off, [legal places](positions) | 2010: 3.6; 2025: Kick-off | placed | yes | yes | placed | |
//! | an illegal place in `set` | 2010: 3.6; 2025: Illegal Position | | by hand | 15 s | | |
//! | [pushing](collision) | paper: 3.4; 2010: 4.8 | 30 s | 30 s, the 4th for the half | 45 s + 10 s, free kick | 30 s | |
//! | [stalling] | paper: 3.4 | yes | | | yes | |
//! | [ball holding](ball_holding) | 2010: 4.5 | | yes | yes | | |
//! | [leaving the field](leaving_field), staying in a goal | 2010: 4.10 | | yes | yes | | |
//! | [illegal defender](illegal_defender) | 2010: 4.11; 2025: Own Goal Area | | all but the keeper | the 4th | | |
//! | [inactive robots](inactive) | 2010: 4.6 | | yes | yes | | |
//! | [game stuck](game_stuck) | 2010: 3.10; 2025: Game Stuck | | 15 s | 30 s | | |
//! | falls, getting up, [lying for too long](fallen) | 2010: 4.6; paper: 4 | | | | yes | |
//! | dives | paper: 4 | | | | yes | |
//! | [penalty shoot-out](shoot_out) | 2010: 3.8.1; paper: 4 | | | | yes | |
//! | halves, change of sides, clock | 2010: 3.2 | 2 x 600 s | 2 x 600 s | 2 x 600 s, runs on | 2 x 600 s | |
//!
//! A robot that is [removed](removal) waits beside the pitch, cannot act, is no obstacle, and reads of it in its
//! [`GameStatus`]. It comes back on the halfway line at the side away from the ball (2010), or from where it waited
//! (2025).
//!
//! What whoever runs the match can do to it, by command or at a given time of a scenario, is an [`Intervention`](crate::game::Intervention).
//!
//! # A rule more
//!
//! How to add one is on a page of the guide: [a rule](crate::guide::extending::rule).

use bevy::prelude::*;

pub mod areas;
pub mod ball_holding;
pub mod ball_out;
pub mod ball_stop;
pub mod boundary;
pub mod collision;
mod crossings;
pub mod decide;
pub mod fallen;
pub mod formation;
pub mod game_stuck;
pub mod goal;
pub mod illegal_defender;
pub mod inactive;
pub mod indirect_goal;
mod intervention;
pub mod kick_off_shot;
pub mod leaving_field;
pub mod memory;
mod message_budget;
pub mod obstruction;
pub mod own_rules;
mod penalise;
pub mod penalty_kick;
mod penalty_restart;
pub mod placing;
pub mod positions;
pub mod removal;
pub mod report;
mod restarts;
pub mod robot_rules;
pub mod set_play;
pub mod shoot_out;
pub mod snapshot;
pub mod stalling;
mod status;
mod systems;
#[cfg(test)]
mod testing;
pub mod touch;

pub use formation::formation;
pub use memory::RefereeMemory;
pub use own_rules::OwnRule;
pub use positions::IllegalPosition;
pub use status::{Announcement, GameStatus, SetPlayStatus};
pub use touch::Touch;

use crate::cycle::{BeginCycle, Cycle, CycleClock, CycleSystems};
use crate::game::{Game, Interventions, Penalty, Rules, TimedIntervention};
use crate::random::RandomStream;
use crate::robot::falls::FallSystems;
use crate::team::RobotId;

/// The referee, in [`CycleSystems::Officiate`], and the robots' [`GameStatus`], in [`CycleSystems::Sense`].
pub struct RefereePlugin;

impl Plugin for RefereePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Game>()
            .init_resource::<Rules>()
            .init_resource::<RefereeMemory>()
            .init_resource::<Interventions>()
            .init_resource::<own_rules::OwnRules>()
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
                    systems::tell_status.in_set(CycleSystems::Sense),
                    systems::officiate.in_set(CycleSystems::Officiate).after(FallSystems),
                ),
            );
    }
}

/// Prepares the referee for a match by these rules, with this seed, in which it is made to do so much.
pub fn start(world: &mut World, clock: &CycleClock, rules: &Rules, seed: u64, interventions: &[TimedIntervention]) {
    let game = Game::at_start(rules, clock);
    world.insert_resource(RefereeMemory { coin: Some(RandomStream::for_match(seed, "coin")), ..default() });
    world.insert_resource(Interventions::scheduled(interventions));
    world.insert_resource(game);
}
