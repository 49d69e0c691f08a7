//! naoisis: a simulator of humanoid robot soccer for testing behaviours, with coarse motion and strict perception.
//!
//! Robots walk, turn their heads and kick within the limits of a NAO. They know only what two cameras, two sonars, odometry and team
//! messages tell them. Behaviours are Bevy systems that read only the sensors of their own robots: the engine refuses others.
//!
//! # A match in ten lines
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, NaoisisPlugins));
//! app.start_match(&Scenario::named("match3v3")?)?;
//! app.run_cycles(300);
//! assert!(app.ball().is_some_and(|ball| ball.is_finite()));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! # Where to look
//!
//! | you want to | read |
//! |---|---|
//! | get started | [`guide`] |
//! | run and look at a match, or test a behaviour | [`simulation`] |
//! | write a behaviour, or a team | [`behaviour`], and what it may know in [`behaviour::barrier`] |
//! | know what a robot measures | [`sensing`], [`communication`], [`referee::GameStatus`] |
//! | know what a robot believes | [`belief`] |
//! | know what a robot can do | [`robot::motion`], [`robot::head`], [`robot::kick`] |
//! | know what happens to it | [`collision`], [`ball`], [`referee`] |
//! | describe a situation in a file | [`scenario`] |
//! | record a match | [`record::trace`]; in your own format: [`record::recorder`], [`record::formats`] |
//! | add your own sensor | [`simulation::sensors`] |
//! | add your own rule | [`simulation::rules`] |
//! | add anything else | [`guide::extending`] |
//! | test a team from the command line | [`expectations`] |
//! | control robots from outside the app | [`agents`] |
//! | send robots the state of the game in the league's protocol | [`game_controller`] |
//! | have all commands in your own program | [`cli::run`] |
//! | react in your own systems to what happens | [`events`], and for observers [`simulation::triggers`] |
//! | run a match in your own app | [`guide::own_app`] |
//! | play thousands of matches | [`batch`] |
//! | train a learner | [`environment`], and the Python package |
//! | save a match and continue it | [`simulation::snapshot`] |
//! | add a system at the right place | [`cycle::CycleSystems`] |
//!
//! # Compatibility
//!
//! Enums of kinds (events, penalties, kicks, noises) and types that the simulation returns (percepts, statuses, evidence, records) are
//! `#[non_exhaustive]`: a `match` on them needs an arm for the rest, and tests create them by `new` or `default`. Types that programs build
//! themselves (scenarios, rules, settings) get new fields with defaults: end a literal with `..default()`, and it builds with the next
//! version.
//!
//! # Layers
//!
//! This crate is a facade with the modules of the crates below. A module may use those of the layers below it, but none above. The same
//! holds for crates. The test `tests/it/layers.rs` compares this table with the imports, so a new module needs a place in it.
//!
//! | crate | modules, from the lowest to the highest | what is there |
//! |---|---|---|
//! | `naoisis_core` | `knowledge` `short_name` `geometry` `kick_geometry` `named_values` `read_file` `replace_file` `team` `cycle` `pitch` `ball` `random` `statistics` `game` `events` `robot` `camera_model` `collision` `communication` `referee` `behaviour` | the match: what is played with, robots, rules and referee, registration of behaviours and the information barrier |
//! | `naoisis_sensing` | `appearance` `sensing` `belief` | what everything looks like; sonars, odometry, cameras, vision; estimators |
//! | `naoisis_sim` | `scenario` `teams` `simulation` `interface` `prelude` | scenario files and presets, the built-in teams, a match from its start, saved matches, the record of a cycle |
//! | `naoisis_agents` | `agents` `game_controller` `environment` `policy` | robots that programs outside decide for, the league's protocol, environments for learning, learned policies as players |
//! | `naoisis_booster` | `messages` `buttons` `visual_kick` `firmware` `vision` `topics` `reach` `participant` `player` | programs written for Booster's SDK as players, over DDS |
//! | `naoisis_record` | `record` `batch` `whatif` `expectations` `dataset` | traces, pictures, films and summaries; many matches; expectations; labelled images |
//! | `naoisis_lab` | `calibration` `description` `trials` `match_realism` `figures` | models fitted to logs of real robots or made of their descriptions, robots measured beside their sources, matches beside real ones, pictures of the paper |
//! | `naoisis_gpu` | `mesh` `renderer` | camera images drawn on a graphics card |
//! | `naoisis_viewer` | `viewer` | the window |
//! | `naoisis_cli` | `cli` | the commands |
//!
//! # Units and frames
//!
//! SI units and radians, in `f32`. The pitch frame has its origin at the centre mark, +x towards the yellow goal, +y to the left of +x, and
//! +z up; blue defends -x in the first half. The team frame is the pitch frame, turned by half a turn for the team that defends +x, so that
//! the own goal is always at -x. The frame of a robot has its origin between the feet on the ground, x to the front and y to the left.
//! Files contain angles in degrees, and their fields' names contain units.
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod guide;
pub mod prelude;

pub use naoisis_agents::{agents, environment, game_controller, policy};
pub use naoisis_cli::cli;
pub use naoisis_core::{
    ball, behaviour, camera_model, collision, communication, cycle, events, game, geometry, kick_geometry, knowledge,
    pitch, random, referee, robot, statistics, team,
};
#[cfg(feature = "gpu")]
pub use naoisis_gpu as gpu;
pub use naoisis_record::{batch, dataset, expectations, record, whatif};
pub use naoisis_sensing::{belief, sensing};
pub use naoisis_sim::{interface, scenario, simulation, teams};
#[cfg(feature = "viewer")]
pub use naoisis_viewer::viewer;

/// Modules for tests, benchmarks and the Python package. They may change in any version.
#[doc(hidden)]
pub mod internal {
    pub use naoisis_core::named_values;
    pub use naoisis_lab::{calibration, description, figures, match_realism, trials};
    pub use naoisis_sensing::appearance;
}

/// The examples of the README, so that they are tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
