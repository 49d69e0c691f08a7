//! The items that most programs with a match need: see [`naoisis_sim::prelude`].

pub use naoisis_record::record::formats::LogFormatApp;
pub use naoisis_sim::prelude::*;
