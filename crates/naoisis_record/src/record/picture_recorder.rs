//! Records all kinds of pictures of a match with one renderer.

use bevy::prelude::*;

use super::frames::FrameRecorder;
use super::match_renderer::MatchRenderer;
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::sheet::SheetRecorder;
use super::video::VideoRecorder;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// Records pictures of a match.
#[derive(Default)]
pub struct PictureRecorder {
    /// Draws the pictures.
    pub renderer: MatchRenderer,
    /// Writes PNG files.
    pub frames: Option<FrameRecorder>,
    /// Writes a video.
    pub video: Option<VideoRecorder>,
    /// Makes a contact sheet.
    pub sheet: Option<SheetRecorder>,
}

impl PictureRecorder {
    /// Returns whether no pictures are recorded.
    pub fn is_empty(&self) -> bool {
        self.frames.is_none() && self.video.is_none() && self.sheet.is_none()
    }
}

impl Recorder for PictureRecorder {
    fn record(&mut self, _: &CycleRecord, world: &mut World) {
        self.renderer.look(world);
        if let Some(frames) = &mut self.frames {
            frames.record(world, &mut self.renderer);
        }
        if let Some(video) = &mut self.video {
            video.record(world, &mut self.renderer);
        }
        if let Some(sheet) = &mut self.sheet {
            sheet.record(world, &mut self.renderer);
        }
    }

    fn has_failed(&self) -> bool {
        self.frames.as_ref().is_some_and(FrameRecorder::has_failed)
            || self.video.as_ref().is_some_and(VideoRecorder::has_failed)
    }

    /// Waits until everything is written.
    fn finish(self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        let frames = self.frames.map_or(Ok(0), FrameRecorder::finish);
        let video = self.video.map_or(Ok(0), VideoRecorder::finish);
        let sheet = self.sheet.map_or(Ok(()), SheetRecorder::finish);
        frames.and(video).and(sheet).map(|()| None)
    }
}
