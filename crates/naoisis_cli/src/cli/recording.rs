//! The shape of what records a match by options of `naoisis run`.

use bevy::prelude::*;

use super::outputs::Output;
use naoisis_record::record::recorder::Recorder;

/// The options of a way to record.
pub trait Recording {
    /// That the options fit each other.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The files that it writes anew.
    fn outputs(&self) -> Vec<Output>;

    /// Whether it takes standard output, so that nothing else may be printed there.
    fn takes_standard_output(&self) -> bool {
        false
    }

    /// Opens what is to be written of the match in the world, with `force` in place of what is there.
    fn open(&self, world: &World, force: bool) -> Result<Vec<Box<dyn Recorder>>, String>;
}
