//! What is written of matches (traces, pictures, films, summaries), many matches at a time, and expectations of them.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod batch;
pub mod expectations;
pub mod record;
pub mod whatif;
