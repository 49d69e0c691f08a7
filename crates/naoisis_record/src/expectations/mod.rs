//! Tests of matches by [expectations](naoisis_sim::scenario::Expectation), such as `blue.goals >= 1`.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::expectations::play;
//! use naoisis::prelude::*;
//!
//! let scenario = Scenario::named("kick_right_straight")?;
//! let expected = ["blue1.kicks >= 1 within 2 s".parse()?, "blue.goals >= 1".parse()?];
//! let simulator = || {
//!     let mut app = App::new();
//!     app.add_plugins(NaoisisPlugins);
//!     app
//! };
//! let verdicts = play(simulator, &scenario, &expected)?;
//! assert!(verdicts[0].holds && !verdicts[1].holds);
//! assert_eq!(verdicts[1].to_string(), "blue.goals >= 1: it was 0");
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

mod junit;
mod measure;
mod verdict;

pub use junit::junit;

pub use verdict::{Verdict, Watch, judge, play, play_all};
