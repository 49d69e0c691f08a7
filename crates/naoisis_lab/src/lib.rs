//! Compares simulated robots and matches with figures of real ones, makes models from descriptions of robots, fits models to logs, and
//! draws the figures of the paper.

pub mod calibration;
pub mod description;
pub mod figures;
pub mod match_realism;
pub mod trials;
