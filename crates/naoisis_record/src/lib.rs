//! Recording matches (traces, counts, pictures, films, summaries), batches of matches, and expectations of their results.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

pub mod batch;
pub mod dataset;
pub mod expectations;
pub mod record;
pub mod whatif;
