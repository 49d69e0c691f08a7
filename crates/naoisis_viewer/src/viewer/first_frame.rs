//! Measures the time from the start to the first frame.

use bevy::diagnostic::FrameCount;
use bevy::prelude::*;
use std::time::Instant;

/// Reports the time from the start to the first frame.
pub struct FirstFramePlugin {
    /// The start: the creation of the plugin, or earlier if the program sets it.
    pub began: Instant,
}

impl Default for FirstFramePlugin {
    fn default() -> Self {
        Self { began: Instant::now() }
    }
}

impl Plugin for FirstFramePlugin {
    fn build(&self, app: &mut App) {
        let began = self.began;
        let tell = move || info!("first frame after {:.2} s", began.elapsed().as_secs_f32());
        // If frames are drawn in parallel with the next update, the first one is done when the second has been handed over.
        app.add_systems(Last, tell.run_if(|frame: Res<FrameCount>| frame.0 == 2));
    }
}
