//! All recordings of `naoisis run`. For a format with options of its own, add a file with these options and a line here. A format without
//! options is registered by `add_log_format`, and written by `--log`.

use bevy::prelude::*;
use clap::Args;

use super::live::LiveArguments;
use super::logs::LogArguments;
use super::outputs::Output;
use super::pictures::PictureArguments;
use super::recording::Recording;
use super::reviews::ReviewArguments;
use super::traces::TraceArguments;
use naoisis_record::record::recorder::Recorder;

macro_rules! recordings {
    ($($name:ident: $arguments:ty,)*) => {
        /// The options of all recordings.
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

// Recordings are opened in this order. The first ones leave nothing behind if a later one cannot be opened. Those that write over files
// come last.
recordings! {
    pictures: PictureArguments,
    trace: TraceArguments,
    reviews: ReviewArguments,
    logs: LogArguments,
    live: LiveArguments,
}

impl Recordings {
    /// Checks that the options are compatible.
    pub fn check(&self) -> Result<(), String> {
        self.all().into_iter().try_for_each(Recording::check)
    }

    /// Returns the files that are written.
    pub fn outputs(&self) -> Vec<Output> {
        self.all().into_iter().flat_map(Recording::outputs).collect()
    }

    /// Returns whether a recording writes to standard output, so that nothing else may.
    pub fn take_standard_output(&self) -> bool {
        self.all().into_iter().any(Recording::takes_standard_output)
    }

    /// Opens all outputs for the match in `world`, with `force` replacing existing ones.
    pub fn open(&self, world: &World, force: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        let opened = self.all().into_iter().map(|recording| recording.open(world, force));
        Ok(opened.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }
}
