//! Writes the summary of a match to a file: as a [page](super::summary_page) or as a [picture](super::summary_picture).

use bevy::prelude::*;
use std::io::{self, Write};
use std::path::Path;

use super::match_summary::MatchSummary;
use super::output_file::OutputFile;
use super::png_file::{Layer, encode_png};
use super::recorder::{MatchEnd, RecordError, Recorder};
use super::summary_page::page;
use super::summary_picture::picture;
use super::team_names::team_names;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Writes the summary of a match.
pub struct SummaryRecorder {
    output: OutputFile,
    is_picture: bool,
    summary: Option<MatchSummary>,
}

impl SummaryRecorder {
    /// Creates a file, which replaces an earlier file when the match is over: a picture if its name ends in `.png`, otherwise a page.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let is_picture = path.extension().is_some_and(|extension| extension == "png");
        Ok(Self { output: OutputFile::create(path)?, is_picture, summary: None })
    }
}

impl Recorder for SummaryRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        let mut summary = MatchSummary::new(scenario);
        // The robots of a match are listed: their teams are known by their behaviours.
        let names = world.get_resource::<BehaviourRegistry>().map(|registry| team_names(scenario, registry));
        summary.teams = names.or(summary.teams);
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

/// Returns a picture in PNG format.
///
/// # Errors
/// Errors of the encoder.
pub fn png(picture: &Image) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode_png(&mut bytes, Layer::Colours, picture)?;
    Ok(bytes)
}
