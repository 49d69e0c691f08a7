//! What robots measure and believe: sonars, odometry, camera images, vision, and the estimators that make beliefs of them.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod appearance;
pub mod belief;
pub mod sensing;
