//! Records of matches.

pub mod beliefs;
pub mod frames;
pub mod history;
pub mod read;
pub mod trace;
