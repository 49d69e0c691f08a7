//! Frames: a match as PNG files, the field in one folder and each robot's cameras in folders of their own; and beside those,
//! where images carry them, their labels and depths.

use bevy::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::encoder::{EncoderThreads, Layer, PngWork, RecordError};
use super::photographer::Photographer;
use super::picture::Picture;
use crate::cycle::CycleClock;
use crate::robot::{RobotId, Roster};
use crate::sensing::camera::image::Image;
use crate::sensing::camera::{CameraImages, CameraSide};

/// Frames that are being written.
pub struct FrameRecorder {
    folder: PathBuf,
    every: u64,
    /// What is recorded; if nothing is said, the field and the images that robots have.
    pictures: Vec<Picture>,
    encoders: EncoderThreads<PngWork>,
    folders: Vec<PathBuf>,
    written: u64,
}

impl FrameRecorder {
    /// Frames into a folder, every so many cycles: of these pictures, or if there are none, of the field and of the camera
    /// images that robots have.
    ///
    /// # Errors
    /// When the folder cannot be made or is not empty.
    pub fn create(folder: &Path, every: u64, pictures: Vec<Picture>) -> Result<Self, RecordError> {
        make_empty_folder(folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            every: every.max(1),
            pictures,
            encoders: EncoderThreads::for_png(),
            folders: Vec::new(),
            written: 0,
        })
    }

    /// Writes the frames of the cycle that has just ended, if it is one of those that are wanted.
    pub fn record(&mut self, world: &mut World, photographer: &mut Photographer) {
        let cycle = world.resource::<CycleClock>().cycle;
        if !cycle.is_multiple_of(self.every) || self.has_failed() {
            return;
        }
        let pictures = if self.pictures.is_empty() { what_there_is(world) } else { self.pictures.clone() };
        for picture in pictures {
            if let Some(image) = picture.take(photographer, world) {
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

    /// Whether writing has failed: nothing more is written then.
    pub fn has_failed(&self) -> bool {
        self.encoders.has_failed()
    }

    /// Waits for the last frames. How many there are.
    ///
    /// # Errors
    /// The first error that occurred while writing; what was written before is whole.
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

/// Makes a folder in which nothing is and which can be written to.
///
/// # Errors
/// When it cannot be made or is not empty.
pub(super) fn make_empty_folder(folder: &Path) -> Result<(), RecordError> {
    fs::create_dir_all(folder).map_err(RecordError::io(folder))?;
    if fs::read_dir(folder).map_err(RecordError::io(folder))?.next().is_some() {
        return Err(RecordError::NotEmpty(folder.to_owned()));
    }
    // That it can be written to is found out now, not in the middle of the match.
    let probe = folder.join(".naoisis");
    fs::write(&probe, []).and_then(|()| fs::remove_file(&probe)).map_err(RecordError::io(folder))
}

/// The field, and the images that robots had in the cycle that has just ended.
fn what_there_is(world: &World) -> Vec<Picture> {
    let cycle = world.resource::<CycleClock>().cycle;
    let mut pictures = vec![Picture::Field];
    let robots: Vec<(RobotId, Entity)> = world.resource::<Roster>().iter().collect();
    for (id, entity) in robots {
        if let Some(images) = world.get::<CameraImages>(entity).filter(|images| images.cycle == Some(cycle)) {
            let sides = CameraSide::BOTH.into_iter().filter(|side| !images.side(*side).is_empty());
            pictures.extend(sides.map(|side| Picture::Camera(id, side)));
        }
    }
    pictures
}

fn folder_name(picture: Picture) -> String {
    match picture {
        Picture::Field => "field".to_owned(),
        Picture::Camera(robot, CameraSide::Top) => format!("{robot}_top"),
        Picture::Camera(robot, CameraSide::Bottom) => format!("{robot}_bottom"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_something_in_it_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("diary.txt"), "dear diary").unwrap();
        assert!(matches!(FrameRecorder::create(folder.path(), 1, vec![]), Err(RecordError::NotEmpty(_))));
        let new = folder.path().join("new/folder");
        assert!(FrameRecorder::create(&new, 1, vec![]).is_ok());
        assert_eq!(fs::read_dir(new).unwrap().count(), 0);
    }
}
