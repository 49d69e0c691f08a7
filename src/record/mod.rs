//! Records of matches.

pub mod trace;
