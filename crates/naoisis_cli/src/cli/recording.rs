//! The common interface of the options with which `naoisis run` records a match.

use bevy::prelude::*;

use super::outputs::Output;
use naoisis_record::record::recorder::Recorder;

/// The options of one kind of recording.
pub trait Recording {
    /// Checks that the options are compatible.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// Returns the files that it writes.
    fn outputs(&self) -> Vec<Output>;

    /// Returns whether it writes to standard output, so that nothing else may.
    fn takes_standard_output(&self) -> bool {
        false
    }

    /// Opens the outputs for the match in `world`, with `force` replacing existing ones.
    fn open(&self, world: &World, force: bool) -> Result<Vec<Box<dyn Recorder>>, String>;
}
