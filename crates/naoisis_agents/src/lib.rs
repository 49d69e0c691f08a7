//! Robots controlled by external programs, the protocol of the league's GameController, and matches as learning
//! environments.

pub mod agents;
pub mod environment;
pub mod game_controller;
