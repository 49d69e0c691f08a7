//! The file of the scenario that is played: its match restarts when the file changes.

use bevy::prelude::*;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::{MatchCommand, TraceReading};
use crate::viewer::commands::ViewerCommand;
use crate::viewer::shared::Notice;

/// The time between two checks of the file, s.
const LOOK_EVERY_S: f32 = 0.5;

/// The file of the scenario, if any. The match restarts when the file changes.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
pub struct WatchedScenarioFile {
    file: Option<PathBuf>,
    modified: Option<SystemTime>,
    is_gone: bool,
    /// Whether teams, league, realism or robots were chosen in the window since.
    pub(super) is_changed: bool,
    /// Another file, which was invalid: it is opened when it changes.
    failed: Option<(PathBuf, Option<SystemTime>)>,
}

impl WatchedScenarioFile {
    /// Watches this file from now on.
    pub fn of(file: &Path) -> Self {
        Self { file: Some(file.to_owned()), modified: modified(file), ..Self::default() }
    }

    /// The same file, without its changes until now.
    pub(in crate::viewer) fn up_to_date(self) -> Self {
        Self { modified: self.file.as_deref().and_then(modified), ..self }
    }

    /// The same file, without another one that could not be opened.
    pub(in crate::viewer) fn without_failed(self) -> Self {
        Self { failed: None, ..self }
    }

    /// Notes that a file could not be opened. It may be a valid scenario the next time if its name is that of one.
    pub(super) fn note_failed(&mut self, file: &Path) {
        let may_be_valid = file.extension().is_some_and(|ending| ending == "json" || ending == "ron") && file.exists();
        if may_be_valid && self.file.as_deref() != Some(file) {
            self.failed = Some((file.to_owned(), modified(file)));
        }
    }

    /// Returns a file that has changed since it was looked at.
    fn changed(&mut self) -> Option<PathBuf> {
        let of_match = self.file.as_ref().map(|file| (file.clone(), &mut self.modified));
        let failed = self.failed.as_mut().map(|(file, modified)| (file.clone(), modified));
        self.is_gone = of_match.as_ref().is_some_and(|(file, _)| modified(file).is_none());
        // While the file is being replaced it may not exist for a moment.
        let (file, noted) = [of_match, failed].into_iter().flatten().find(|(file, noted)| {
            let now = modified(file);
            now.is_some() && now != **noted
        })?;
        *noted = modified(&file);
        Some(file)
    }

    /// The name of the file, if any.
    pub(super) fn name(&self) -> Option<String> {
        Some(self.file.as_ref()?.file_name()?.to_string_lossy().into_owned())
    }

    /// The origin of the scenario, for the window.
    pub(super) fn words(&self) -> String {
        let of_match = self.words_of_match();
        match &self.failed {
            Some((file, _)) => format!("{of_match}. {} is opened when it has been corrected", file.display()),
            None => of_match,
        }
    }

    fn words_of_match(&self) -> String {
        match &self.file {
            Some(file) if self.is_gone => format!("{} is gone; the match continues", file.display()),
            Some(file) if self.is_changed => {
                format!("{}, changed here: a change of the file restarts the match as in the file", file.display())
            }
            Some(file) => format!("{}: the match restarts when the file changes", file.display()),
            None if self.is_changed => "built in, changed here".to_owned(),
            None => "built in".to_owned(),
        }
    }
}

fn modified(file: &Path) -> Option<SystemTime> {
    file.metadata().and_then(|metadata| metadata.modified()).ok()
}

/// Stops watching when a built-in scenario is loaded.
pub(super) fn forget(
    mut commands: MessageReader<ViewerCommand>,
    mut source: ResMut<WatchedScenarioFile>,
    mut reading: ResMut<TraceReading>,
) {
    if commands.read().any(|command| matches!(command, ViewerCommand::Load(_))) {
        *source = WatchedScenarioFile::default();
        reading.give_up();
    }
}

/// Restarts the match when its file has changed. If the file cannot be read, the match continues and the error is
/// shown.
pub(super) fn watch(
    time: Res<Time<Real>>,
    mut since_s: Local<f32>,
    mut source: ResMut<WatchedScenarioFile>,
    notice: Option<ResMut<Notice>>,
    mut commands: MessageWriter<MatchCommand>,
) {
    *since_s += time.delta_secs();
    if *since_s < LOOK_EVERY_S {
        return;
    }
    *since_s = 0.0;
    let was_gone = source.is_gone;
    if let Some(file) = source.changed() {
        commands.write(MatchCommand::Open(file));
    }
    if source.is_gone
        && !was_gone
        && let Some(mut notice) = notice
    {
        notice.tell(source.words());
    }
}
