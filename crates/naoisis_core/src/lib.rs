//! The match itself: pitch, ball, bodies, walking, kicks, falls, collisions, messages, the game and its referee, and how
//! behaviours are registered.
//!
//! Nothing here knows what robots see or believe, how a scenario is written, or what is recorded: those are the crates above.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

/// Gives an error type its text as its `Debug` form, as `main` and tests that return an error print that.
#[macro_export]
macro_rules! debug_as_displayed {
    ($error:ty) => {
        impl core::fmt::Debug for $error {
            fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, formatter)
            }
        }
    };
}

pub mod ball;
pub mod behaviour;
pub mod camera_model;
pub mod collision;
pub mod communication;
pub mod cycle;
pub mod events;
pub mod game;
pub mod geometry;
pub mod kick_geometry;
pub mod knowledge;
pub mod named_values;
pub mod pitch;
pub mod random;
pub mod read_file;
pub mod referee;
pub mod replace_file;
pub mod robot;
pub mod short_name;
pub mod statistics;
pub mod team;
