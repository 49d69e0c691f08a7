//! What most programs with a match in them need.

pub use naoisis_record::record::formats::LogFormatApp;
pub use naoisis_sim::prelude::*;
