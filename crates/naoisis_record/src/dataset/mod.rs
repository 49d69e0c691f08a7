//! Data sets of labelled images for training the vision of robots: images of played matches and of randomly drawn situations, with looks
//! that differ from match to match.
//!
//! [`make()`] plays matches, takes images with the software renderer, and writes them with boxes, outlines and key points of ball, robots,
//! goal posts, people and crossings of lines. The looks are drawn from [`Ranges`]: light, turf, lines, ball, shirts, goals, surroundings of
//! the pitch, and the errors of cameras. Everything that is drawn is in the metadata.
//!
//! The same settings give the same files on any number of threads. All images of a match are in one split. The same settings also continue
//! an interrupted data set, match by match.
//!
//! **What is missing.** Bodies have plain colours without textures, and reflect no light onto each other. Shadows and uneven light appear
//! on the ground alone. The shutter is global. People stand still.

use bevy::app::App;
use core::sync::atomic::AtomicBool;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

mod annotate;
mod coco;
mod folder;
mod looks;
mod making;
mod moments;
mod names;
mod outline;
mod ranges;
mod record;
mod shot;
mod staging;
mod surroundings;
mod tar;
mod texture;
mod yolo;

pub use folder::SETTINGS_FILE;
pub use names::{Class, ClassNames};
pub use ranges::Ranges;
pub use yolo::YoloTask;

use folder::{Folder, Found};
use naoisis_sim::scenario::{Scenario, ScenarioFault};
use naoisis_sim::simulation::play_in_order;

/// A layout of the files of a data set.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DatasetFormat {
    /// COCO, as Roboflow lays it out: `train`, `valid` and `test`, each with `_annotations.coco.json` beside its images.
    Coco,
    /// Ultralytics' YOLO: `images`, `labels` and `data.yaml`.
    Yolo,
    /// `WebDataset`: an archive for each match.
    Webdataset,
}

impl DatasetFormat {
    /// All layouts, with their names on the command line.
    pub const ALL: [(&'static str, DatasetFormat); 3] =
        [("coco", DatasetFormat::Coco), ("yolo", DatasetFormat::Yolo), ("webdataset", DatasetFormat::Webdataset)];
}

/// The settings of a data set, besides its scenario.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct DatasetSettings {
    /// The number of images.
    pub images: u32,
    /// The seed of the first match; it grows by one from match to match.
    pub seed: u64,
    /// The layouts of the files.
    pub formats: Vec<DatasetFormat>,
    /// The names of classes.
    pub names: ClassNames,
    /// The kind of YOLO labels.
    pub yolo: YoloTask,
    /// Whether masks are written: images with the label of each pixel.
    pub masks: bool,
    /// Whether depth images are written.
    pub depth: bool,
    /// Width and height of the images, pixels. `None` for those of the robots' cameras.
    pub size: Option<[u32; 2]>,
    /// The ranges from which looks are drawn.
    pub ranges: Ranges,
}

impl DatasetSettings {
    /// Creates settings for `images` images in COCO's layout, with looks drawn from `ranges`.
    pub fn new(images: u32, ranges: Ranges) -> Self {
        Self {
            images,
            seed: 1,
            formats: vec![DatasetFormat::Coco],
            names: ClassNames::default(),
            yolo: YoloTask::default(),
            masks: false,
            depth: false,
            size: None,
            ranges,
        }
    }

    /// Returns the number of images of a match: at most 20, and few enough that there are about 20 matches or more.
    fn images_of_match(&self) -> u32 {
        (self.images / 20).clamp(1, 20)
    }

    /// Returns the number of matches.
    pub fn matches(&self) -> usize {
        self.images.div_ceil(self.images_of_match()) as usize
    }
}

/// Why a data set cannot be made.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The path of the folder is a file.
    #[error("{0}: this is a file; expected a folder, new, empty, or with a data set")]
    NotAFolder(PathBuf),
    /// The parent folder does not exist.
    #[error("{path}: there is no folder {missing}; expected a folder in one that is there")]
    NoParent {
        /// The folder that was asked for.
        path: PathBuf,
        /// The outermost folder that is missing.
        missing: PathBuf,
    },
    /// The folder has other contents.
    #[error("{0}: the folder is not empty, and no data set is in it; expected a new or an empty one")]
    Foreign(PathBuf),
    /// A data set with other settings is in the folder.
    #[error(
        "{path}: there is a data set with other settings ({field}); expected the same settings to continue it, another folder, \
         or --force to replace it"
    )]
    OtherSettings {
        /// The folder.
        path: PathBuf,
        /// The first setting that differs.
        field: String,
    },
    /// The file system reports an error.
    #[error("{path}: {error}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The match cannot be started.
    #[error("the match does not start: {}", .0.in_words())]
    Match(ScenarioFault),
    /// No robot of the scenario has a camera.
    #[error("no robot of the scenario has a camera; expected one that has")]
    NoCameras,
}

naoisis_core::debug_as_displayed!(DatasetError);

impl DatasetError {
    /// Returns whether the request itself is wrong. False for errors of the file system.
    pub fn is_usage(&self) -> bool {
        !matches!(self, DatasetError::Io { .. })
    }
}

/// The result of making a data set.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Made {
    /// The number of images.
    pub images: u32,
    /// The number of images that were there before.
    pub earlier: u32,
    /// Whether all images are there.
    pub is_complete: bool,
}

/// Makes a data set in `folder`, or continues one that was interrupted. With `force`, a data set with other settings is replaced.
/// `simulator` makes an app without a match. `progress` is called with the number of images so far. When `stop` becomes true, the matches
/// under way are finished. The annotations are written again whenever there are a quarter more images, and at the end.
///
/// # Errors
/// Faults of the folder or the scenario, and errors of the file system.
pub fn make(
    folder: &Path,
    scenario: &Scenario,
    settings: &DatasetSettings,
    force: bool,
    threads: usize,
    stop: &AtomicBool,
    simulator: impl Fn() -> App + Sync,
    mut progress: impl FnMut(u32),
) -> Result<Made, DatasetError> {
    let text = serde_json::to_value(scenario).unwrap_or_default();
    making::check(&mut simulator(), scenario)?;
    let folder = match Folder::open(folder, settings, text, force)? {
        Found::Ready(folder) => folder,
        Found::Complete => {
            return Ok(Made { images: settings.images, earlier: settings.images, is_complete: true });
        }
    };
    let matches = settings.matches();
    let (mut images, mut earlier, mut annotated) = (0, 0, 0);
    let play = |worker: &mut making::Worker, index: usize| {
        let count = making::count_of(settings, index);
        if folder.has_match(index) {
            return Ok((count, true));
        }
        worker.make_match(&folder, scenario, settings, index).map(|()| (count, false))
    };
    play_in_order(
        0..matches,
        threads,
        stop,
        || making::Worker::new(simulator()),
        play,
        |made| {
            let (count, was_there) = made?;
            images += count;
            earlier += if was_there { count } else { 0 };
            // If the program is killed, at least four fifths of the images have their annotations.
            if 4 * images > 5 * annotated {
                annotated = folder.annotate(settings, matches)?;
            }
            progress(images);
            Ok(())
        },
    )?;
    let images = folder.finish(settings, matches)?;
    Ok(Made { images, earlier, is_complete: images == settings.images })
}

#[cfg(test)]
mod tests;
