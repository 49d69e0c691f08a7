//! The referee: game states, score, halves, goals and outs, restarts, penalties, and the reasons of decisions.
//!
//! At the end of every cycle the referee judges a [`snapshot`] of the match. The rules, one file each, are plain functions of the snapshot;
//! their results are collected in [`decide::Decisions`], which one system applies. Every decision is a
//! [`MatchEvent`](crate::events::MatchEvent) with its [`Evidence`](crate::game::Evidence): robots, position, measured quantity, the rule in
//! one sentence, and what would have changed the decision. `naoisis run --explain` prints the decisions as a [match report](report).
//!
//! # Rules as data
//!
//! [`Rules`] has a switch and the figures of each rule. Presets are files in `assets/rules`; a scenario names one, or
//! changes some of its fields: `rules: (preset: "spl2010", half_s: 300, pushing_limit: None)`.
//!
//! Sections are those of the rule books of the Standard Platform League of 2010 and 2025; laws and headings those of the Humanoid Soccer
//! League's book of 2026 (1.1.1). `hsl2026_german_open` has that league's rules before it: its GameController 6 and the draft of January.
//!
//! | rule | source | `naoisis` | `spl2010` | `spl2025` | `hsl2026` | `extended` | `free` |
//! |---|---|---|---|---|---|---|---|
//! | [goals](goal), own goals | 2010: 3.3; 2025: 3.3 | yes | yes | yes | yes | yes | |
//! | [no goal straight from the kick-off](kick_off_shot) | 2010: 4.5 | | yes | | | | |
//! | [indirect goals](indirect_goal) | 2025: 3.4 | | | yes | after an indirect restart; of two robots, straight from the kick-off | | |
//! | a lead of ten goals ends the match | 2025: 3.16 | | | yes | yes | | |
//! | [message budget](crate::game::Rules::message_budget) | 2025: 2.4.2 | | | 1200 | 12,000 | | |
//! | [ball out](ball_out) leads to | 2010: 3.9; 2025: 3.8 | kick-off | throw-in | [free kick](set_play) | [free kick](set_play) | kick-off | |
//! | `ready` and `set` before a kick-off, [legal places](positions) | 2010: 3.5; 2025: 3.7 | placed | yes | yes | yes | placed | |
//! | [`standby`](crate::game::Rules::standby_s) before a half's first `ready` | 2025: 3.2 | | | 10 s | | | |
//! | an illegal place in `set` | 2010: 3.5; 2025: 4.4.1; HSL GameController | | by hand | 15 s | 45 s + 10 s | | |
//! | [motion in `set`](forbidden_motion) | 2025: 4.5.2; HSL GameController | | | 15 s in place | 15 s + 10 s in place | | |
//! | [motion in `standby`](forbidden_motion) | 2025: 4.5.1 | | | the team, up to 45 s | | | |
//! | [fouls in `ready`](crate::game::Rules::fouls_in_ready) | 2025: 4; `GameController`s | | | yes | yes | | |
//! | a robot that begins outside its half takes the kick-off | 2025: 3.7 | | | yes | yes | | |
//! | [pushing](collision) | paper: 3.4; 2010: 4.9; 2025: 4.10 | 30 s | 30 s, the 4th for the half | 45 s + 10 s, free kick | 45 s + 10 s ¹ | 30 s | |
//! | [penalty kick](penalty_kick) | 2025: 3.10 | | | yes | yes | | |
//! | a penalty kick extends the half; a keeper off its line gives a goal | HSL: 7.4, penalty kick | | | | yes | | |
//! | an indirect free kick in the offenders' area is taken from its line | HSL: 13.3.1 | | | | yes | | |
//! | [obstruction] | 2010: 4.14 | | yes | | | | |
//! | [stalling] | paper: 3.4 | yes | | | | yes | |
//! | [ball holding](ball_holding), the ball is put back | 2010: 4.6; 2025: 4.8 | | yes | yes | yes | | |
//! | [leaving the field](leaving_field), staying in a goal | 2010: 4.12; 2025: 4.12 | | yes | yes | yes | | |
//! | [illegal defender](illegal_defender) | 2010: 4.13; 2025: 4.4.2 | | all but the keeper | the 4th | the 4th | | |
//! | [inactive robots](inactive) | 2010: 4.7; 2025: 4.6 | | yes | yes | yes | | |
//! | [game stuck](game_stuck) | 2010: 3.10; 2025: 3.11 | | 15 s | 30 s, walking counts | 10 s at the ball, 30 s with nobody within 1 m | | |
//! | falls, getting up | paper: 4 | | | | | yes | |
//! | [lying for too long](fallen) | 2010: 4.7; 2025: 4.6 | | 20 s | 2 attempts | 3 attempts | 20 s | |
//! | dives | paper: 4 | | | | | yes | |
//! | [penalty shoot-out](shoot_out) | 2010: 3.8; 2025: 3.19; paper: 4 | | 5 x 60 s | 3 x 30 s | 3 x 60 s | 5 x 60 s | |
//! | halves, change of sides, clock | 2010: 3.1; 2025: 3.1 | 2 x 600 s | 2 x 600 s | 2 x 600 s, runs on | 2 x 600 s, runs on | 2 x 600 s | |
//! | [a half ends when a shot has come to rest](ball_stop) | 2025: 3.18 | | | yes | yes | | |
//! | [notice of the start of play](GameStatus) | 2025: 3.2; HSL GameController | at once | at once | 15 s late | 10 s late | at once | at once |
//! | [notice of goals](GameStatus) | 2025: 3.3; HSL GameController | at once | at once | 15 s late | at once | at once | at once |
//! | [notice of a half's first `ready`](GameStatus) | 2025: 3.2 | at once | at once | 45 s late | at once | at once | at once |
//! | [an offence near the ball](crate::game::Rules::offence_free_kick_m) stops play | HSL: law 12 | | | | free kick | | |
//! | [cautions](crate::game::Rules::cautions_to_send_off) | HSL: law 12 | | | | the 2nd is a red card | | |
//! | [who may be where before a kick-off is taken](set_play) | 2025: 3.7, 4.4.1; HSL: law 8 | | | both teams | both teams | | |
//! | [double touch](indirect_goal::judge_double_touch) | HSL: kick-in, goal kick, corner kick | | | | indirect free kick | | |
//! | [a set play into the own goal](indirect_goal::judge_own) | HSL: law 13 | goal | goal | goal | corner kick | goal | |
//! | [motion in a brief stop](forbidden_motion) | HSL: emergency stop | | | | 45 s + 10 s | | |
//! | [extra time](crate::game::Rules::extra_time_halves) | HSL: law 10 | if set | if set | if set | if set | if set | |
//! | [time-outs](crate::game::Rules::timeouts) of a team | 2010: 3.12; 2025: 3.13; HSL: time-out | | 1 x 300 s | 1 x 300 s | 1 x 300 s | | |
//! | [substitutes] enter in time-outs, at half time, and | 2025: 3.12; HSL: 3.4 | if set | | as picked up | in stoppages | if set | |
//!
//! ¹ If the push destabilises the other robot or lasts 5 s; with a caution and a free kick.
//!
//! The following are not modelled: hands and arms (no robot moves them), wide stances (2010: 4.8; 2025: 4.9; a dive is the only one, and
//! ends by itself), and the break at half time. Brief stops and the requests of teams - pick-ups, time-outs, substitutes - are
//! [interventions](crate::game::Intervention); behaviours and programs make them by a [request](crate::robot::request). The referee makes
//! no mistakes, and decides at once. At a restart the ball is put exactly where the book says: a robot that stands there is moved aside.
//!
//! A robot that is penalised for motion stays where it is, as an obstacle. A robot that is [removed](removal) waits beside the pitch,
//! cannot act, is not an obstacle, and is informed by its [`GameStatus`]. It returns on the halfway line at the side away from the ball
//! (2010), or from its waiting position (2025).
//!
//! [substitutes]: crate::game::Rules::substitution
//!
//! People and programs change the match by [interventions](crate::game::Intervention), as commands or at a given time of a
//! scenario.
//!
//! With an [`OutsideReferee`] in the world, as with a real GameController, the referee judges nothing and applies its decisions.
//!
//! # Adding a rule
//!
//! The page "A rule" of the guide shows how to add one.

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
pub mod forbidden_motion;
pub mod formation;
pub mod game_stuck;
pub mod goal;
pub mod hearing;
pub mod illegal_defender;
pub mod inactive;
pub mod indirect_goal;
mod intervention;
pub mod kick_off_shot;
pub mod leaving_field;
pub mod memory;
mod message_budget;

pub mod custom_rules;
pub mod obstruction;
mod outside;
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
mod standby;
mod status;
mod substitution;
mod systems;
#[cfg(test)]
mod testing;
mod timeout;
pub mod touch;

pub use custom_rules::CustomRule;
pub use formation::{formation, start_pose};
pub use memory::{RefereeMemory, RobotMemory};
pub use positions::IllegalPosition;
pub use status::{Announcement, GameStatus, SetPlayStatus};
pub use touch::Touch;

use self::hearing::{HeardWhistles, Hearing};
use crate::cycle::{BeginCycle, Cycle, CycleClock, CycleSystems};
use crate::game::{Game, Interventions, OutsideReferee, Penalty, Rules, TimedIntervention};
use crate::random::RandomStream;
use crate::robot::falls::FallSystems;
use crate::robot::request::RequestCommand;
use crate::team::RobotId;

/// The referee, in [`CycleSystems::Officiate`], and the robots' [`GameStatus`], in [`CycleSystems::Sense`].
pub struct RefereePlugin;

impl Plugin for RefereePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Game>()
            .init_resource::<Rules>()
            .init_resource::<RefereeMemory>()
            .init_resource::<Interventions>()
            .init_resource::<custom_rules::CustomRules>()
            .register_type::<Interventions>()
            .register_type::<OutsideReferee>()
            .register_type::<Game>()
            .register_type::<Rules>()
            .register_type::<RefereeMemory>()
            .register_type::<Penalty>()
            .register_type::<GameStatus>()
            .register_type::<Hearing>()
            .register_type::<HeardWhistles>()
            .register_type::<RequestCommand>()
            .register_required_components::<RobotId, RequestCommand>()
            .register_required_components::<RobotId, Penalty>()
            .register_required_components::<RobotId, GameStatus>()
            .register_required_components::<RobotId, Hearing>()
            .register_required_components::<RobotId, HeardWhistles>()
            .add_systems(
                Cycle,
                (
                    (systems::begin_match, hearing::hear_whistles)
                        .chain()
                        .in_set(CycleSystems::First)
                        .after(BeginCycle),
                    systems::update_status.in_set(CycleSystems::Sense),
                    (systems::pass_on_requests, systems::officiate)
                        .chain()
                        .in_set(CycleSystems::Officiate)
                        .after(FallSystems),
                ),
            );
    }
}

/// Reseeds the coin of the referee.
pub fn reseed(world: &mut World, seed: u64) {
    if let Some(mut memory) = world.get_resource_mut::<RefereeMemory>() {
        memory.coin = Some(RandomStream::for_match(seed, "coin"));
    }
}

/// Resets the referee for a match by `rules`. `interventions` are applied at their times.
pub fn start(world: &mut World, clock: &CycleClock, rules: &Rules, seed: u64, interventions: &[TimedIntervention]) {
    let game = Game::at_start(rules, clock);
    world.insert_resource(RefereeMemory { coin: Some(RandomStream::for_match(seed, "coin")), ..default() });
    world.insert_resource(Interventions::scheduled(interventions));
    world.insert_resource(game);
}
