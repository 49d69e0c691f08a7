//! Robots controlled by external programs, the protocol of the league's GameController, matches as learning environments, and
//! learned policies as players.

pub mod agents;
pub mod environment;
pub mod game_controller;
pub mod policy;
