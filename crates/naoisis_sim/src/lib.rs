//! A match: scenario files and presets, the built-in teams, starting and saving a match, and the record of a cycle.

pub mod interface;
pub mod prelude;
pub mod scenario;
pub mod simulation;
pub mod teams;
