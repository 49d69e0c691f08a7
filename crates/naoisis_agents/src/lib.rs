//! Robots controlled by external programs, the protocol of the league's GameController, and matches as learning
//! environments.
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
