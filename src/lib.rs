//! naoisis: a behavioural simulator of humanoid robot soccer. Coarse motion, strict perception.
//!
//! Robots walk, turn their heads and kick within the limits of a NAO, and know nothing but what two cameras, two
//! sonars, odometry and team messages tell them. Behaviours are Bevy systems that read only their own robots' sensors;
//! the engine refuses others.
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
//! | begin | [`guide`] |
//! | run and look at a match, or test a behaviour | [`simulation`] |
//! | write a behaviour, or a team | [`behaviour`], and what it may know in [`behaviour::barrier`] |
//! | know what a robot measures | [`sensing`], [`communication`], [`referee::GameStatus`] |
//! | know what a robot believes | [`belief`] |
//! | know what a robot can do | [`robot::motion`], [`robot::head`], [`robot::kick`] |
//! | know what happens to it | [`collision`], [`ball`], [`referee`] |
//! | describe a situation in a file | [`scenario`] |
//! | record a match | [`record::trace`]; in a way of your own: [`record::recorder`], [`record::formats`] |
//! | have a sensor of your own | [`simulation::sensors`] |
//! | have a rule of your own | [`simulation::rules`] |
//! | add anything else | [`guide::extending`] |
//! | test a team in a line | [`expectations`] |
//! | decide for robots from outside the app | [`agents`] |
//! | tell robots of the game in the league's own protocol | [`game_controller`] |
//! | have all commands in a program of your own | [`cli::run`] |
//! | know what happens, in a system of your own | [`events`], and for observers [`simulation::triggers`] |
//! | have a match in an app of your own | [`guide::own_app`] |
//! | play thousands of matches | [`batch`] |
//! | let something learn | [`environment`], and the Python package |
//! | save a match and go on from it | [`simulation::snapshot`] |
//! | add a system at the right place | [`cycle::CycleSystems`] |
//!
//! # What may grow
//!
//! Enums that name kinds of things (events, penalties, kicks, noises) and what the simulation hands out (percepts, statuses,
//! evidence, records) are `#[non_exhaustive]`: a `match` on them has an arm for the rest, a test makes them by `new` or `default`.
//! What a program builds itself (scenarios, rules, settings) gets new fields, too, each with a default: end a literal with
//! `..default()`, and it builds with the next version.
//!
//! # Layers
//!
//! This crate is a facade: it has the modules of the crates below. A module uses those of the layers below it and none above,
//! and so do crates; a test (`tests/it/layers.rs`) reads this table and the imports. A new module gets a place in this table.
//!
//! | crate | modules, from the lowest to the highest | what is there |
//! |---|---|---|
//! | `naoisis_core` | `knowledge` `short_name` `geometry` `statistics` `kick_geometry` `named_values` `read_file` `replace_file` `team` `cycle` `pitch` `ball` `random` `game` `events` `robot` `camera_model` `collision` `communication` `referee` `behaviour` | the match: what is played with, robots, rules and referee, registration of behaviours and the information barrier |
//! | `naoisis_sensing` | `appearance` `sensing` `belief` | what everything looks like; sonars, odometry, cameras, vision; estimators |
//! | `naoisis_sim` | `scenario` `teams` `simulation` `interface` `prelude` | scenario files and presets, the built-in teams, a match from its start, saved matches, the record of a cycle |
//! | `naoisis_agents` | `agents` `game_controller` `environment` | robots that programs outside decide for, the league's protocol, environments for learning |
//! | `naoisis_record` | `record` `batch` `whatif` `expectations` `dataset` | traces, pictures, films and summaries; many matches; expectations; labelled images |
//! | `naoisis_lab` | `calibration` `description` `trials` `match_realism` `figures` | models fitted to logs of real robots or made of their descriptions, robots measured beside their sources, matches beside real ones, pictures of the paper |
//! | `naoisis_gpu` | `mesh` `renderer` | camera images drawn on a graphics card |
//! | `naoisis_viewer` | `viewer` | the window |
//! | `naoisis_cli` | `cli` | the commands |
//!
//! # Units and frames
//!
//! SI units and radians, in `f32`. The pitch frame has its origin at the centre mark, +x towards the yellow goal, +y
//! to the left of +x, +z up; blue defends -x in the first half. The team frame is the pitch frame turned by half a
//! turn for the team that defends +x: its own goal is always at -x. A robot's frame has its origin between the feet on
//! the ground, x to the front, y to the left. Files write angles in degrees, and units into the names of fields.
#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod guide;
pub mod prelude;

pub use naoisis_agents::{agents, environment, game_controller};
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

/// What tests, benchmarks and the Python package use beside the public modules. It may change in any version.
#[doc(hidden)]
pub mod internal {
    pub use naoisis_core::named_values;
    pub use naoisis_lab::{calibration, description, figures, match_realism, trials};
    pub use naoisis_sensing::appearance;
}

/// The README's examples, so that they are tested.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
