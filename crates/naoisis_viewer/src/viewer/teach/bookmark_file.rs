//! Stores bookmarks in a file beside the trace, or beside the scenario file for each seed.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::bookmarks::{Bookmark, Bookmarks};
use super::pen::PenMark;
use crate::viewer::branches::Branches;
use crate::viewer::camera::viewpoint::Viewpoint;
use crate::viewer::camera::{CameraMode, ViewerCamera};
use crate::viewer::drive::PlayedFile;
use crate::viewer::keyframes::Keyframes;
use crate::viewer::shared::{Notice, OpenedTrace, TraceSaved};
use crate::viewer::theme::count;
use crate::viewer::timeline::Timeline;
use naoisis_core::geometry::{to_degrees, to_radians};
use naoisis_core::read_file::read_file;
use naoisis_core::replace_file::replace_file;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::Scenario;

/// The file of the match's bookmarks.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct BookmarkFile {
    /// The match and its file; nothing is stored without one.
    of: Option<(Keyframes, Option<PathBuf>)>,
    /// The bookmarks in the file.
    written: Vec<Bookmark>,
}

/// The contents of a file of bookmarks.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    bookmarks: Vec<KeptBookmark>,
}

/// A bookmark in a file.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptBookmark {
    cycle: u64,
    caption: String,
    #[serde(default)]
    marks: Vec<PenMark>,
    #[serde(default)]
    selected: Option<RobotId>,
    #[serde(default)]
    robots_world: bool,
    view: KeptView,
}

/// The camera of a bookmark.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptView {
    focus_m: [f32; 3],
    azimuth_deg: f32,
    elevation_deg: f32,
    distance_m: f32,
    /// Width by height of the area in which the view was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    aspect: Option<f32>,
}

impl From<&Bookmark> for KeptBookmark {
    fn from(bookmark: &Bookmark) -> Self {
        let view = bookmark.camera.wanted;
        Self {
            cycle: bookmark.cycle,
            caption: bookmark.caption.clone(),
            marks: bookmark.marks.clone(),
            selected: bookmark.selected,
            robots_world: bookmark.robots_world,
            view: KeptView {
                focus_m: view.focus.to_array(),
                azimuth_deg: to_degrees(view.azimuth),
                elevation_deg: to_degrees(view.elevation),
                distance_m: view.distance,
                aspect: bookmark.aspect,
            },
        }
    }
}

impl From<KeptBookmark> for Bookmark {
    fn from(kept: KeptBookmark) -> Self {
        let view = Viewpoint {
            focus: kept.view.focus_m.into(),
            azimuth: to_radians(kept.view.azimuth_deg),
            elevation: to_radians(kept.view.elevation_deg),
            distance: kept.view.distance_m,
        };
        Self {
            cycle: kept.cycle,
            caption: kept.caption,
            marks: kept.marks,
            selected: kept.selected,
            robots_world: kept.robots_world,
            camera: ViewerCamera { current: view, wanted: view, mode: CameraMode::Orbit },
            aspect: kept.view.aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0),
        }
    }
}

/// Returns the file of bookmarks for a match: beside its trace, or beside its scenario file, with the seed.
fn file_of(trace: Option<&Path>, scenario: Option<(&Path, u64)>) -> Option<PathBuf> {
    let (path, ending) = match (trace, scenario) {
        (Some(trace), _) => (trace, ".bookmarks.json".to_owned()),
        (None, Some((path, seed))) => (path, format!(".seed{seed}.bookmarks.json")),
        (None, None) => return None,
    };
    let mut name = OsString::from(path.file_name()?);
    name.push(ending);
    Some(path.with_file_name(name))
}

/// Reads the bookmarks of a file; empty if the file does not exist.
///
/// # Errors
/// A message when the file cannot be read or is invalid.
fn read(path: &Path) -> Result<Vec<Bookmark>, String> {
    let text = match read_file(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(format!("{}: {error}", path.display())),
    };
    let kept: Kept = serde_json::from_slice(&text)
        .map_err(|error| format!("{}:{}:{}: {error}", path.display(), error.line(), error.column()))?;
    let mut bookmarks: Vec<Bookmark> = kept.bookmarks.into_iter().map(Bookmark::from).collect();
    bookmarks.sort_by_key(|bookmark| bookmark.cycle);
    Ok(bookmarks)
}

fn write(path: &Path, bookmarks: &[Bookmark]) -> io::Result<()> {
    let kept = Kept { bookmarks: bookmarks.iter().map(KeptBookmark::from).collect() };
    let text = serde_json::to_string_pretty(&kept)? + "\n";
    replace_file(path, |mut file| file.write_all(text.as_bytes()))
}

/// Reads the bookmarks of a match when it is opened, and writes them when they change.
pub(super) fn keep(
    (keyframes, branches): (Res<Keyframes>, Option<Res<Branches>>),
    (timeline, trace): (Res<Timeline>, Res<OpenedTrace>),
    (played, scenario): (Option<Res<PlayedFile>>, Option<Res<Scenario>>),
    mut bookmarks: ResMut<Bookmarks>,
    mut file: ResMut<BookmarkFile>,
    mut notice: ResMut<Notice>,
) {
    let are_stored = file.of.as_ref().is_some_and(|(_, path)| path.is_some());
    if bookmarks.are_stored != are_stored {
        // The bookmarks themselves do not change by this.
        bookmarks.bypass_change_detection().are_stored = are_stored;
    }
    if file.of.as_ref().is_none_or(|(of, _)| !of.is_same(&keyframes)) {
        // The bookmarks of other branches are not stored.
        let is_fork = branches.is_some_and(|branches| branches.is_fork(&keyframes));
        let trace = trace.0.as_deref().filter(|_| timeline.is_replay());
        let played = played.as_ref().and_then(|played| played.0.as_ref());
        let path = played.map(|file| Path::new(&file.source.name)).filter(|path| path.is_file());
        let scenario = path.zip(scenario.as_ref().map(|scenario| scenario.seed)).filter(|_| !timeline.is_replay());
        let mut path = file_of(trace, scenario).filter(|_| !is_fork);
        let read = path.as_deref().map_or_else(|| Ok(Vec::new()), read);
        let found = read.unwrap_or_else(|error| {
            notice.tell(format!("{error}; its bookmarks are ignored, and new ones are not saved"));
            path = None;
            Vec::new()
        });
        if !found.is_empty() {
            notice.tell(format!("{} of this match; J: first one", count(found.len(), "bookmark")));
            bookmarks.take_in(found.clone(), &keyframes);
        }
        *file = BookmarkFile { of: Some((keyframes.clone(), path)), written: found };
        return;
    }
    let Some((_, Some(path))) = &file.of else { return };
    if !bookmarks.is_changed() || bookmarks.list() == file.written {
        return;
    }
    if let Err(error) = write(path, bookmarks.list()) {
        notice.tell(format!("{}: {error}; bookmarks are not saved", path.display()));
        file.of = Some((keyframes.clone(), None));
        return;
    }
    file.written = bookmarks.list().to_vec();
}

/// Writes the bookmarks of a match that is saved beside its trace.
pub(super) fn keep_beside_trace(
    mut saved: MessageReader<TraceSaved>,
    bookmarks: Res<Bookmarks>,
    mut notice: ResMut<Notice>,
) {
    for TraceSaved(trace) in saved.read().filter(|_| !bookmarks.list().is_empty()) {
        let Some(path) = file_of(Some(trace), None) else { continue };
        if let Err(error) = write(&path, bookmarks.list()) {
            notice.tell(format!("{}: {error}; bookmarks are not saved", path.display()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    fn bookmark(cycle: u64) -> Bookmark {
        let view = Viewpoint { focus: Vec3::new(1.0, 2.0, 0.0), azimuth: 0.5, elevation: 1.0, distance: 3.0 };
        Bookmark {
            cycle,
            caption: "seen".to_owned(),
            marks: vec![PenMark::Arrow(Vec2::ZERO, Vec2::X), PenMark::Zone(Vec2::Y, Vec2::ONE)],
            selected: Some(RobotId::new(Team::Blue, 2)),
            robots_world: true,
            camera: ViewerCamera { current: view, wanted: view, mode: CameraMode::Orbit },
            aspect: Some(1.5),
        }
    }

    #[test]
    fn bookmarks_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("match.jsonl.zst.bookmarks.json");
        assert_eq!(read(&path), Ok(Vec::new()), "none where there is no file");
        write(&path, &[bookmark(70), bookmark(30)]).unwrap();
        let found = read(&path).unwrap();
        assert_eq!(found.iter().map(|bookmark| bookmark.cycle).collect::<Vec<_>>(), [30, 70]);
        assert_eq!((&found[0].marks, found[0].selected), (&bookmark(30).marks, bookmark(30).selected));
        assert!((found[0].camera.wanted.azimuth - 0.5).abs() < 1e-6 && found[0].robots_world);
    }

    #[test]
    fn a_match_is_saved_with_its_bookmarks() {
        let folder = tempfile::tempdir().unwrap();
        let trace = folder.path().join("match.jsonl.zst");
        let mut bookmarks = Bookmarks::default();
        bookmarks.take_in(vec![bookmark(30)], &Keyframes::default());
        let mut app = App::new();
        app.add_message::<TraceSaved>().init_resource::<Notice>().insert_resource(bookmarks);
        app.add_systems(Update, keep_beside_trace);
        app.world_mut().write_message(TraceSaved(trace.clone()));
        app.update();
        assert_eq!(read(&file_of(Some(&trace), None).unwrap()).unwrap().len(), 1);
    }

    #[test]
    fn a_file_that_is_wrong_says_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bookmarks.json");
        std::fs::write(&path, "{ \"bookmarks\": [\n  { \"cycle\": -1 } ] }").unwrap();
        let error = read(&path).unwrap_err();
        assert!(error.contains("a.bookmarks.json:2:"), "{error}");
    }

    #[test]
    fn the_file_is_beside_the_match() {
        let (trace, scenario) = (Path::new("a/match.jsonl"), (Path::new("b/test.json"), 7));
        assert_eq!(file_of(Some(trace), Some(scenario)), Some("a/match.jsonl.bookmarks.json".into()));
        assert_eq!(file_of(None, Some(scenario)), Some("b/test.json.seed7.bookmarks.json".into()));
        assert_eq!(file_of(None, None), None);
    }
}
