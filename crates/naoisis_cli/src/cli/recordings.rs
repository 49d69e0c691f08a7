//! What `naoisis run` records of a match. A format with options of its own is a file with them, and a line here; one
//! without is registered where the program begins, and written by `--log`.

use bevy::prelude::*;
use clap::Args;

use super::beliefs::BeliefArguments;
use super::logs::LogArguments;
use super::outputs::Output;
use super::pictures::PictureArguments;
use super::recording::Recording;
use super::reviews::ReviewArguments;
use super::traces::TraceArguments;
use naoisis_record::record::recorder::Recorder;

macro_rules! recordings {
    ($($name:ident: $arguments:ty,)*) => {
        /// The options of all ways to record.
        #[derive(Args, Debug, Clone, Default)]
        pub struct Recordings {
            $(
                #[command(flatten)]
                pub $name: $arguments,
            )*
        }

        impl Recordings {
            fn all(&self) -> Vec<&dyn Recording> {
                vec![$(&self.$name),*]
            }
        }
    };
}

// What is opened first leaves nothing behind when another cannot be opened: files that are written over come last.
recordings! {
    pictures: PictureArguments,
    trace: TraceArguments,
    beliefs: BeliefArguments,
    reviews: ReviewArguments,
    logs: LogArguments,
}

impl Recordings {
    /// That the options fit each other.
    pub fn check(&self) -> Result<(), String> {
        self.all().into_iter().try_for_each(Recording::check)
    }

    /// The files that are written anew.
    pub fn outputs(&self) -> Vec<Output> {
        self.all().into_iter().flat_map(Recording::outputs).collect()
    }

    /// Whether standard output is taken, so that nothing else may be printed there.
    pub fn take_standard_output(&self) -> bool {
        self.all().into_iter().any(Recording::takes_standard_output)
    }

    /// Opens everything that is to be written of the match in the world, with `force` in place of what is there.
    pub fn open(&self, world: &World, force: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let opened = self.all().into_iter().map(|recording| recording.open(world, force));
        Ok(opened.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }
}
