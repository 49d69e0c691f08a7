//! Writes frames: PNG files of the field in one folder and of each robot's cameras in folders of their own. Labels and depths, for images
//! that have them, go into further folders.

use bevy::prelude::*;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::encoder::{EncoderThreads, Layer, PngWork, RecordError};
use super::match_renderer::{MatchRenderer, newest_image};
use super::picture::{FIELD_SAMPLES, Picture};
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;

/// Writes frames of a match.
pub struct FrameRecorder {
    folder: PathBuf,
    every: u64,
    /// The pictures that are recorded. If empty: the field and the robots' camera images.
    pictures: Vec<Picture>,
    encoders: EncoderThreads<PngWork>,
    folders: Vec<PathBuf>,
    /// The last cycle that was recorded.
    recorded: Option<u64>,
    written: u64,
}

impl FrameRecorder {
    /// Creates a recorder that writes frames into `folder` every few cycles. If `pictures` is empty, it records the field and the robots'
    /// camera images.
    ///
    /// # Errors
    /// If the folder cannot be created or is not empty.
    pub fn create(folder: &Path, every: u64, pictures: Vec<Picture>) -> Result<Self, RecordError> {
        make_empty_folder(folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            every: every.max(1),
            pictures,
            encoders: EncoderThreads::for_png(),
            folders: Vec::new(),
            recorded: None,
            written: 0,
        })
    }

    /// Writes the frames of the last cycle, if it is due. A camera image is named after the cycle in which it was taken, and written only
    /// once.
    pub fn record(&mut self, world: &mut World, renderer: &mut MatchRenderer) {
        let cycle = world.resource::<CycleClock>().cycle;
        if !cycle.is_multiple_of(self.every) || self.has_failed() {
            return;
        }
        let pictures = if self.pictures.is_empty() { what_there_is(world) } else { self.pictures.clone() };
        let before = self.recorded.replace(cycle);
        for picture in pictures {
            let [cycle, arrived] = match picture {
                Picture::Camera(robot, side) => {
                    newest_image(world, robot, side).map_or([cycle; 2], |(cycles, _)| cycles)
                }
                Picture::Field => [cycle; 2],
            };
            if before.is_some_and(|before| arrived <= before) {
                continue;
            }
            if let Some(image) = picture.take(renderer, world, FIELD_SAMPLES) {
                let (name, image) = (folder_name(picture), Arc::new(image));
                if !image.labels.is_empty() {
                    self.write(&format!("{name}_labels"), cycle, Layer::Labels, &image);
                }
                if !image.depth_m.is_empty() {
                    self.write(&format!("{name}_depth"), cycle, Layer::Depth, &image);
                }
                self.write(&name, cycle, Layer::Colours, &image);
            }
        }
    }

    /// Returns whether writing has failed. Nothing more is written then.
    pub fn has_failed(&self) -> bool {
        self.encoders.has_failed()
    }

    /// Waits for the last frames and returns their number.
    ///
    /// # Errors
    /// The first error that occurred while writing. Frames written before are complete.
    pub fn finish(self) -> Result<u64, RecordError> {
        self.encoders.finish().map(|()| self.written)
    }

    fn write(&mut self, name: &str, cycle: u64, layer: Layer, image: &Arc<Image>) {
        let folder = self.folder.join(name);
        if !self.folders.contains(&folder) {
            if let Err(error) = fs::create_dir_all(&folder) {
                self.encoders.fail(RecordError::Io { path: folder.clone(), error });
            }
            self.folders.push(folder.clone());
        }
        if self.encoders.send((folder.join(format!("{cycle:06}.png")), layer, Arc::clone(image))) {
            self.written += 1;
        }
    }
}

/// Removes the frames of an earlier match: PNG files with a number as their name, in the folder and its subfolders, and the subfolders that
/// are empty then.
///
/// # Errors
/// If something cannot be read or removed.
pub fn remove_frames(folder: &Path) -> Result<(), RecordError> {
    if !folder.is_dir() {
        return Ok(());
    }
    let is_frame = |path: &Path| {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        path.extension().is_some_and(|extension| extension == "png")
            && !stem.is_empty()
            && stem.bytes().all(|byte| byte.is_ascii_digit())
    };
    for inner in paths_in(folder)? {
        if is_frame(&inner) {
            fs::remove_file(&inner).map_err(RecordError::io(&inner))?;
        }
        if !inner.is_symlink() && inner.is_dir() {
            for frame in paths_in(&inner)?.iter().filter(|path| is_frame(path)) {
                fs::remove_file(frame).map_err(RecordError::io(frame))?;
            }
            if paths_in(&inner)?.is_empty() {
                fs::remove_dir(&inner).map_err(RecordError::io(&inner))?;
            }
        }
    }
    Ok(())
}

fn paths_in(folder: &Path) -> Result<Vec<PathBuf>, RecordError> {
    let entries = fs::read_dir(folder).and_then(Iterator::collect::<io::Result<Vec<_>>>);
    Ok(entries.map_err(RecordError::io(folder))?.iter().map(fs::DirEntry::path).collect())
}

/// Creates an empty folder in a folder that exists, and checks that it can be written to.
///
/// # Errors
/// If it cannot be created, is not empty or cannot be written to.
pub(super) fn make_empty_folder(folder: &Path) -> Result<(), RecordError> {
    if folder.is_file() {
        return Err(RecordError::NotAFolder(folder.to_owned()));
    }
    match fs::create_dir(folder) {
        Err(error) if !folder.is_dir() => return Err(RecordError::io(folder)(error)),
        _ => {}
    }
    if fs::read_dir(folder).map_err(RecordError::io(folder))?.next().is_some() {
        return Err(RecordError::NotEmpty(folder.to_owned()));
    }
    // Test now whether it can be written to, not in the middle of the match.
    let probe = folder.join(".naoisis");
    fs::write(&probe, []).and_then(|()| fs::remove_file(&probe)).map_err(RecordError::io(folder))
}

/// Returns the field, and the cameras of robots that have an image.
fn what_there_is(world: &World) -> Vec<Picture> {
    let cameras = world.resource::<Roster>().iter().flat_map(|(id, robot)| {
        let mounts = world.get::<CameraSettings>(robot).map(|settings| settings.mounts).unwrap_or_default();
        mounts.names().map(|camera| (id, camera)).collect::<Vec<_>>()
    });
    let cameras = cameras.filter(|(id, side)| newest_image(world, *id, *side).is_some());
    core::iter::once(Picture::Field).chain(cameras.map(|(id, side)| Picture::Camera(id, side))).collect()
}

fn folder_name(picture: Picture) -> String {
    match picture {
        Picture::Field => "field".to_owned(),
        Picture::Camera(robot, camera) => format!("{robot}_{camera}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn a_folder_with_something_in_it_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("diary.txt"), "dear diary").unwrap();
        assert!(matches!(FrameRecorder::create(folder.path(), 1, vec![]), Err(RecordError::NotEmpty(_))));
        let file = folder.path().join("diary.txt");
        assert!(matches!(FrameRecorder::create(&file, 1, vec![]), Err(RecordError::NotAFolder(_))));
        let new = folder.path().join("new");
        let in_missing = new.join("folder");
        let refused = FrameRecorder::create(&in_missing, 1, vec![]).err();
        assert!(matches!(refused, Some(RecordError::NoFolder { folder, .. }) if folder == new));
        assert!(FrameRecorder::create(&new, 1, vec![]).is_ok());
        assert_eq!(fs::read_dir(new).unwrap().count(), 0);
    }

    /// The numbers of the frames of each folder of a robot with the settings of cameras, after 12 cycles.
    #[test]
    fn earlier_frames_are_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let inside = |name: &str| folder.path().join(name);
        for name in ["field", "blue1_top"] {
            fs::create_dir(inside(name)).unwrap();
            fs::write(inside(name).join("000003.png"), "").unwrap();
        }
        fs::write(inside("blue1_top/000003_best.png"), "").unwrap();
        fs::write(inside("000001.png"), "").unwrap();
        fs::write(inside("diary.txt"), "dear diary").unwrap();
        remove_frames(folder.path()).unwrap();
        assert!(!inside("field").exists() && !inside("000001.png").exists());
        assert_eq!(paths_in(&inside("blue1_top")).unwrap(), [inside("blue1_top/000003_best.png")]);
        assert!(inside("diary.txt").exists());
        assert!(remove_frames(&inside("not there")).is_ok());
    }

    fn numbers(cameras: &str, every: u64, pictures: Vec<Picture>) -> Vec<(String, Vec<u64>)> {
        let folder = tempfile::tempdir().unwrap();
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        let scenario = format!(r#"{{ "rules": "free", "robots": [{{ "number": 1 }}], "cameras": {cameras} }}"#);
        app.start_match(&Scenario::from_json(&scenario).unwrap()).unwrap();
        let mut frames = FrameRecorder::create(folder.path(), every, pictures).unwrap();
        let mut renderer = MatchRenderer::default();
        for cycle in 0..13 {
            if cycle > 0 {
                app.run_cycles(1);
            }
            renderer.look(app.world_mut());
            frames.record(app.world_mut(), &mut renderer);
        }
        frames.finish().unwrap();
        let sorted = |folder: &Path| {
            let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
            paths.sort();
            paths
        };
        let folders = sorted(folder.path()).into_iter().map(|folder| {
            let stem = |path: &PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
            let numbers = sorted(&folder).iter().map(|path| stem(path).parse().unwrap()).collect();
            (stem(&folder), numbers)
        });
        folders.collect()
    }

    #[test]
    fn every_image_of_a_slow_camera_is_written_once_under_the_cycle_in_which_it_was_taken() {
        let cameras = r#"{ "render": "software", "which": "top", "width": 8, "height": 6, "every_cycles": 3 }"#;
        // Its images are of cycles 1, 4, 7 and 10.
        let all = numbers(cameras, 1, vec![]);
        assert_eq!(all, [("blue1_top".to_owned(), vec![1, 4, 7, 10]), ("field".to_owned(), (0..=12).collect())]);
        let some = numbers(cameras, 6, vec![]);
        assert_eq!(some, [("blue1_top".to_owned(), vec![4, 10]), ("field".to_owned(), vec![0, 6, 12])]);
    }

    #[test]
    fn what_a_robot_would_see_is_drawn_where_it_has_no_images() {
        let picture = "blue1.bottom".parse().unwrap();
        assert_eq!(numbers("{}", 5, vec![picture]), [("blue1_bottom".to_owned(), vec![0, 5, 10])]);
    }
}
