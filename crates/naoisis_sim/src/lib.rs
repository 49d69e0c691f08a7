//! A match: scenario files and presets, the built-in teams, starting and saving a match, and the record of a cycle.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod interface;
pub mod prelude;
pub mod scenario;
pub mod simulation;
pub mod teams;
