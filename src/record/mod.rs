//! Records of matches.

pub mod beliefs;
pub mod frames;
pub mod trace;
