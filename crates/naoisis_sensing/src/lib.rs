//! Measurements and beliefs of robots: sonars, odometry, camera images, vision, and the estimators that turn them into beliefs.
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
