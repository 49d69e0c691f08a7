//! Robots that programs outside decide for, the league's GameController protocol, and matches as environments for learning.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod agents;
pub mod environment;
pub mod game_controller;
