//! The viewer: a window that shows matches.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod viewer;
