//! Compares simulated matches with real ones: plays whole matches, counts them, and compares them with published figures.
//!
//! A [`MatchMeter`] reads the record of each cycle and computes the [`MatchMeasures`] of a match. A [`Quantity`] is a value of all matches
//! together with its 95 % interval. [`RealFigures`] are the contents of a file with figures of real matches and their sources. A
//! [`Comparison`] compares the two. `naoisis realism --match` prints it.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::internal::match_realism::{Comparison, RealFigures, play_match};
//! use naoisis::prelude::*;
//!
//! let simulator = || {
//!     let mut app = App::new();
//!     app.add_plugins(NaoisisPlugins);
//!     app
//! };
//! let scenario = Scenario { duration_s: Some(5.0), ..Scenario::named("spl2025")? };
//! let measures = [play_match(simulator, &scenario)?];
//! let comparison = Comparison::of(&measures, &RealFigures::built_in(), "spl2025");
//! let goals = comparison.row("goals").unwrap();
//! assert_eq!(goals.estimate.unwrap().value, f64::from(measures[0].goals.blue + measures[0].goals.pink));
//! assert_eq!(goals.real.as_ref().unwrap().year, "2022-2024");
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod ball_meter;
mod comparison;
mod estimates;
mod measures;
mod meter;
mod metered_cycle;
mod playing;
mod quantities;
mod real_figures;
mod robot_meter;

pub use comparison::{ComparedFigure, ComparedRow, Comparison, Mark};
pub use estimates::{IntervalKind, Quantity};
pub use measures::{FieldMeasures, MatchMeasures, NextTouch, PenaltyGroup};
pub use meter::MatchMeter;
pub use playing::{MatchFailure, play_match, play_matches};
pub use quantities::quantities;
pub use real_figures::{Bound, Certainty, RealFigure, RealFigures, RealFiguresError};
