//! Frames: a match as PNG files, the field in one folder and each robot's cameras in folders of their own.
//!
//! Pictures are encoded beside the simulation, by threads of their own. The queue to them is bounded: a simulation that is
//! faster than its encoders waits for them. Every file is written under another name first, so that whatever a folder has
//! is whole, whenever the program ends.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::appearance::gait::Gait;
use crate::appearance::posing::JointAngles;
use crate::appearance::scene::{SceneDescription, SceneRobot, world_from_body};
use crate::appearance::view::View;
use crate::ball::{Ball, BallPhysics};
use crate::cycle::CycleClock;
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::referee::Penalty;
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::robot::{RobotId, Roster, Velocity};
use crate::sensing::camera::image::{Image, Layers};
use crate::sensing::camera::software::{Detail, PreparedScene, Renderer};
use crate::sensing::camera::{CameraImages, CameraSide};

/// The size of the picture of the field, pixels.
const FIELD_SIZE: [u32; 2] = [960, 540];
/// Pictures that wait for an encoder, at most.
const QUEUE: usize = 32;

/// Why a folder is not written to.
#[derive(Debug, thiserror::Error)]
pub enum FramesError {
    /// Something is there already.
    #[error("{0}: the folder is not empty; expected a new or an empty one")]
    NotEmpty(PathBuf),
    /// It cannot be made, or written to.
    #[error("{path}: {error}")]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
}

/// Frames that are being written.
#[derive(Resource)]
pub struct FrameRecorder {
    folder: PathBuf,
    every: u64,
    queue: Option<SyncSender<(PathBuf, Image)>>,
    encoders: Vec<JoinHandle<()>>,
    failure: Arc<Mutex<Option<FramesError>>>,
    scene: SceneDescription,
    prepared: PreparedScene,
    renderer: Renderer,
    /// How the robots step, apart from what their own cameras show: recording changes nothing of the match.
    gaits: BTreeMap<RobotId, Gait>,
    folders: Vec<PathBuf>,
    written: u64,
}

impl FrameRecorder {
    /// Frames into a folder, every so many cycles.
    ///
    /// # Errors
    /// When the folder cannot be made or is not empty.
    pub fn create(folder: &Path, every: u64) -> Result<Self, FramesError> {
        let io_error = |error| FramesError::Io { path: folder.to_owned(), error };
        fs::create_dir_all(folder).map_err(io_error)?;
        if fs::read_dir(folder).map_err(io_error)?.next().is_some() {
            return Err(FramesError::NotEmpty(folder.to_owned()));
        }
        let failure = Arc::new(Mutex::new(None));
        let (queue, pictures) = sync_channel::<(PathBuf, Image)>(QUEUE);
        let pictures = Arc::new(Mutex::new(pictures));
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let encoders = (0..threads).map(|_| {
            let (pictures, failure) = (Arc::clone(&pictures), Arc::clone(&failure));
            thread::spawn(move || {
                loop {
                    let next = match pictures.lock() {
                        Ok(pictures) => pictures.recv(),
                        Err(_) => return,
                    };
                    let Ok((path, image)) = next else { return };
                    if let Err(error) = write_png(&path, &image)
                        && let Ok(mut failure) = failure.lock()
                    {
                        failure.get_or_insert(FramesError::Io { path, error });
                    }
                }
            })
        });
        Ok(Self {
            folder: folder.to_owned(),
            every: every.max(1),
            queue: Some(queue),
            encoders: encoders.collect(),
            failure,
            scene: SceneDescription::default(),
            prepared: PreparedScene::default(),
            renderer: Renderer::default(),
            gaits: BTreeMap::new(),
            folders: Vec::new(),
            written: 0,
        })
    }

    /// Writes the frames of the cycle that has just ended, if it is one of those that are wanted: the field as it is now,
    /// and the images that the robots had in it.
    pub fn record(&mut self, world: &mut World) {
        let clock = *world.resource::<CycleClock>();
        self.gather(world, clock.end_time_s());
        if !clock.cycle.is_multiple_of(self.every) || self.has_failed() {
            return;
        }
        self.prepared.prepare(&self.scene, Detail { segments: 20, ..Detail::FINE });
        let mut image = Image::default();
        self.renderer.draw(&self.prepared, &view_of_field(&self.scene.pitch), Layers::default(), &mut image);
        self.write("field", clock.cycle, image);
        let robots: Vec<(RobotId, Entity)> = world.resource::<Roster>().iter().collect();
        for (id, entity) in robots {
            let Some(images) = world.get::<CameraImages>(entity).filter(|images| images.cycle == Some(clock.cycle))
            else {
                continue;
            };
            let pictures = CameraSide::BOTH.map(|side| (side, images.side(side).clone()));
            for (side, image) in pictures.into_iter().filter(|(_, image)| !image.is_empty()) {
                let side = if side == CameraSide::Top { "top" } else { "bottom" };
                self.write(&format!("{id}_{side}"), clock.cycle, image);
            }
        }
    }

    /// Whether writing has failed: nothing more is written then.
    pub fn has_failed(&self) -> bool {
        self.failure.lock().is_ok_and(|failure| failure.is_some())
    }

    /// Waits for the last frames. How many there are.
    ///
    /// # Errors
    /// The first error that occurred while writing; what was written before is whole.
    pub fn finish(mut self) -> Result<u64, FramesError> {
        self.queue = None;
        for encoder in self.encoders.drain(..) {
            // An encoder does not panic; if it did, its frames are missing.
            let _ = encoder.join();
        }
        let failure = self.failure.lock().ok().and_then(|mut failure| failure.take());
        failure.map_or(Ok(self.written), Err)
    }

    fn write(&mut self, name: &str, cycle: u64, image: Image) {
        let folder = self.folder.join(name);
        if !self.folders.contains(&folder) {
            if let Err(error) = fs::create_dir_all(&folder)
                && let Ok(mut failure) = self.failure.lock()
            {
                failure.get_or_insert(FramesError::Io { path: folder.clone(), error });
            }
            self.folders.push(folder.clone());
        }
        if let Some(queue) = &self.queue
            && queue.send((folder.join(format!("{cycle:06}.png")), image)).is_ok()
        {
            self.written += 1;
        }
    }

    fn gather(&mut self, world: &mut World, now_s: f64) {
        let scene = &mut self.scene;
        scene.pitch.clone_from(world.resource::<Pitch>());
        scene.robots.clear();
        for (id, entity) in world.resource::<Roster>().iter() {
            if world.get::<Penalty>(entity).is_some_and(Penalty::is_active) {
                continue;
            }
            let Some(pose) = world.get::<Pose>(entity).copied() else { continue };
            let head = world.get::<HeadAngles>(entity).copied().unwrap_or_default();
            let gait = self.gaits.entry(id).or_default();
            gait.follow(pose, world.get::<Velocity>(entity).copied().unwrap_or_default(), now_s);
            let joints: JointAngles = gait.joints(id, head);
            let posture = world.get::<Posture>(entity).copied().unwrap_or_default();
            scene.robots.push(SceneRobot { id, world_from_robot: world_from_body(pose, posture), joints });
        }
        scene.posts.clear();
        let mut posts = world.query::<(&Post, &Pose)>();
        scene.posts.extend(posts.iter(world).map(|(post, pose)| (*post, pose.position)));
        let mut balls = world.query_filtered::<(&Pose, &BallPhysics), With<Ball>>();
        scene.ball = balls.iter(world).next().map(|(pose, physics)| (pose.position, physics.radius_m));
    }
}

/// The whole pitch, from above one side line.
pub fn view_of_field(pitch: &Pitch) -> View {
    let carpet = pitch.carpet_half_extents();
    // Far enough for the length to fill the picture's width at a field of view of 35 degrees from top to bottom.
    let eye = Vec3::new(0.0, -1.25 * carpet.x - 0.6 * carpet.y, 1.15 * carpet.x);
    View::looking_at(eye, Vec3::new(0.0, -0.2 * carpet.y, 0.0), 0.61, FIELD_SIZE)
}

/// Writes a picture as PNG, under another name until it is whole.
fn write_png(path: &Path, image: &Image) -> io::Result<()> {
    let unfinished = path.with_extension("png.part");
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(&unfinished)?), image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.rgb)?;
    writer.finish()?;
    fs::rename(unfinished, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_pitch_is_in_the_picture() {
        for pitch in ["naoisis", "spl2025"].map(|name| Pitch::preset(name).unwrap()) {
            let (view, corner) = (view_of_field(&pitch), pitch.outer_half_extents());
            for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let pixel = view.project(Vec3::new(x * corner.x, y * corner.y, 0.0)).unwrap();
                let size = Vec2::new(FIELD_SIZE[0] as f32, FIELD_SIZE[1] as f32);
                assert!(pixel.cmpgt(Vec2::ZERO).all() && pixel.cmplt(size).all(), "{}: {pixel}", pitch.name);
            }
        }
    }

    #[test]
    fn a_picture_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let image = Image { width: 3, height: 2, rgb: (0..18).collect(), ..default() };
        write_png(&path, &image).unwrap();
        let mut reader = png::Decoder::new(io::BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        assert_eq!(rgb, image.rgb);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
    }

    #[test]
    fn a_folder_with_something_in_it_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("diary.txt"), "dear diary").unwrap();
        assert!(matches!(FrameRecorder::create(folder.path(), 1), Err(FramesError::NotEmpty(_))));
        assert!(FrameRecorder::create(&folder.path().join("new/folder"), 1).is_ok());
    }
}
