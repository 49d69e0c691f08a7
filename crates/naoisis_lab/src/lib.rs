//! Measured robots compared with their sources, models fitted to logs of real robots, and the figures of the paper.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod calibration;
pub mod figures;
pub mod trials;
