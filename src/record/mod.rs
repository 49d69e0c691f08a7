//! Records of matches.

pub mod beliefs;
pub mod trace;
