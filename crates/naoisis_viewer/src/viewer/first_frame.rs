//! How long it takes until something is seen.

use bevy::diagnostic::FrameCount;
use bevy::prelude::*;
use std::time::Instant;

/// Says how long it took from the start to the first frame.
pub struct FirstFramePlugin {
    /// The start: when the plugin was made, or earlier, if the program says so.
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
        let tell = move || info!("the first frame was there after {:.2} s", began.elapsed().as_secs_f32());
        // Where drawing goes on beside the next frame, the first is done when the second has been handed over.
        app.add_systems(Last, tell.run_if(|frame: Res<FrameCount>| frame.0 == 2));
    }
}
