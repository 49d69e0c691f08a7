//! Measured robots and matches compared with their sources, models fitted to logs of real robots, and the figures of the paper.

pub mod calibration;
pub mod figures;
pub mod match_realism;
pub mod trials;
