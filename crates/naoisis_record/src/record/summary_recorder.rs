//! The summary of a match as a file: as a [page](super::summary_page), or as a [picture](super::summary_picture).

use bevy::prelude::*;
use std::io::{self, Write};
use std::path::Path;

use super::match_summary::MatchSummary;
use super::output_file::OutputFile;
use super::png_file::{Layer, encode_png};
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::summary_page::page;
use super::summary_picture::picture;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// A page, or a picture, that is being made.
pub struct SummaryRecorder {
    output: OutputFile,
    is_picture: bool,
    summary: Option<MatchSummary>,
}

impl SummaryRecorder {
    /// A file, which replaces any that is there when the match is over: a picture where its name ends in `.png`, or else a page.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let is_picture = path.extension().is_some_and(|extension| extension == "png");
        Ok(Self { output: OutputFile::create(path)?, is_picture, summary: None })
    }
}

impl Recorder for SummaryRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, _: &mut World) {
        let mut summary = MatchSummary::new(scenario);
        summary.look(record);
        self.summary = Some(summary);
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        if let Some(summary) = &mut self.summary {
            summary.look(record);
        }
    }

    fn finish(mut self: Box<Self>, end: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        if let Some(summary) = &mut self.summary {
            summary.how = end.result.and_then(|result| result.how());
        }
        let bytes = match &self.summary {
            Some(summary) if self.is_picture => png(&picture(summary)),
            Some(summary) => Ok(page(summary).into_bytes()),
            None => Ok(Vec::new()),
        };
        let mut file = self.output.writer()?;
        let written = bytes.and_then(|bytes| file.write_all(&bytes));
        self.output.close(written)?;
        Ok(None)
    }
}

/// A picture as a PNG file has it.
///
/// # Errors
/// None but of memory.
pub fn png(picture: &Image) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode_png(&mut bytes, Layer::Colours, picture)?;
    Ok(bytes)
}
