//! Measured robots and matches compared with their sources, models made of descriptions of robots and fitted to their logs, and the
//! figures of the paper.

pub mod calibration;
pub mod description;
pub mod figures;
pub mod match_realism;
pub mod trials;
