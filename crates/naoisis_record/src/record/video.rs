//! A video of a match: the field, or several pictures side by side.

use bevy::math::Vec2;
use bevy::prelude::World;
use std::path::Path;
use std::sync::Arc;

use super::canvas::{Anchor, Canvas, PAPER, width_of_words};
use super::encoder::{EncoderThreads, RecordError, VideoWork};
use super::match_renderer::MatchRenderer;
use super::output_file::OutputFile;
use super::picture::{FIELD_SIZE, Picture};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::sensing::camera::image::Image;

/// Ending of the file names of videos.
pub const EXTENSION: &str = "mp4";
/// Colour behind the pictures.
const BACKGROUND: Colour = Colour([24, 26, 30]);
/// Samples of a pixel of the field, across and down: fewer than in single pictures, as each is seen for a moment only.
const FILM_SAMPLES: u32 = 2;
/// Width and height of a camera's tile beside the field. Two tiles are as high as the field.
const TILE: [u32; 2] = [360, 270];

/// A video that is being written.
pub struct VideoRecorder {
    every: u64,
    /// The pictures with their places: left, top, width and height, pixels.
    pictures: Vec<(Picture, [u32; 4])>,
    /// The canvas on which the pictures of every cycle are drawn, over those of the previous one.
    canvas: Canvas,
    output: OutputFile,
    encoder: EncoderThreads<VideoWork>,
    written: u64,
}

impl VideoRecorder {
    /// Creates a video of these pictures side by side, by default of the field, in real time: one picture every `every` cycles of `cycle_s`
    /// seconds. An existing file is replaced when the match is over.
    ///
    /// # Errors
    /// When the file's name does not end in `.mp4`, or it cannot be written.
    pub fn create(path: &Path, every: u64, mut pictures: Vec<Picture>, cycle_s: f64) -> Result<Self, RecordError> {
        check_extension(path, EXTENSION)?;
        let output = OutputFile::create(path)?;
        let every = every.max(1);
        if pictures.is_empty() {
            pictures.push(Picture::Field);
        }
        let (places, size) = layout(&pictures);
        let pictures = pictures.into_iter().zip(places).collect();
        let canvas = Canvas::new(size, BACKGROUND);
        let encoder = EncoderThreads::for_video(path, output.writer()?, cycle_s * every as f64);
        Ok(Self { every, pictures, canvas, output, encoder, written: 0 })
    }

    /// Adds the cycle that has just ended, if it is one of every `every` cycles.
    pub fn record(&mut self, world: &mut World, renderer: &mut MatchRenderer) {
        let clock = *world.resource::<CycleClock>();
        if !clock.cycle.is_multiple_of(self.every) || self.has_failed() {
            return;
        }
        let score = world.resource::<Game>().score;
        let words = format!("{:.1} s    blue {} : {} pink", clock.end_time_s(), score.blue, score.pink);
        for (picture, place) in &self.pictures {
            let image = picture.take(renderer, world, FILM_SAMPLES);
            let words = if *picture == Picture::Field { words.clone() } else { picture.to_string() };
            put(&mut self.canvas, *place, image.as_ref(), &words);
        }
        if self.encoder.send((Arc::new(self.canvas.image()), 1)) {
            self.written += 1;
        }
    }

    /// Returns whether writing has failed. Nothing more is written then.
    pub fn has_failed(&self) -> bool {
        self.encoder.has_failed()
    }

    /// Waits until the last pictures are written, and returns their number.
    ///
    /// # Errors
    /// The first error that occurred while writing. Pictures written before can be played.
    pub fn finish(self) -> Result<u64, RecordError> {
        let written = self.encoder.finish();
        self.output.close_after(written).map(|()| self.written)
    }
}

/// Checks that a file name has this extension.
pub(super) fn check_extension(path: &Path, extension: &'static str) -> Result<(), RecordError> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case(extension) => Ok(()),
        _ => Err(RecordError::Extension { path: path.to_owned(), extension }),
    }
}

/// Returns the place of each picture (left, top, width, height) and the size of the whole, pixels.
fn layout(pictures: &[Picture]) -> (Vec<[u32; 4]>, [u32; 2]) {
    let [field_width, field_height] = FIELD_SIZE;
    let cameras = pictures.iter().filter(|picture| **picture != Picture::Field).count() as u32;
    let fields = pictures.len() as u32 - cameras;
    let [tile_width, tile_height] = match (fields, cameras) {
        // The cameras are large without the field, and if there is only one beside it.
        (0, _) | (_, 1) => [2 * TILE[0], 2 * TILE[1]],
        _ => TILE,
    };
    let rows = if fields == 0 { (cameras as f32).sqrt().floor().max(1.0) as u32 } else { field_height / tile_height };
    let (mut field, mut camera) = (0, 0);
    let places = pictures.iter().map(|picture| match picture {
        Picture::Field => {
            field += 1;
            [0, (field - 1) * field_height, field_width, field_height]
        }
        Picture::Camera(..) => {
            let [column, row] = [camera / rows, camera % rows];
            camera += 1;
            let left = if fields == 0 { 0 } else { field_width };
            [left + column * tile_width, row * tile_height, tile_width, tile_height]
        }
    });
    let places: Vec<[u32; 4]> = places.collect();
    let end = |axis: usize| places.iter().map(|place| place[axis] + place[axis + 2]).max().unwrap_or(2);
    let size = [end(0), end(1)];
    (places, size)
}

/// Returns how many times as large a picture is shown in a place: as large as fits, but enlarged by whole numbers only, which shows each
/// of its pixels.
fn scale_to_fit(picture: Vec2, place: Vec2) -> f32 {
    let scale = (place / picture).min_element();
    if scale >= 1.0 { scale.floor() } else { scale }
}

/// Draws a picture as large as possible in the middle of its place, and words into the corner.
fn put(canvas: &mut Canvas, [left, top, width, height]: [u32; 4], image: Option<&Image>, words: &str) {
    let corner = Vec2::new(left as f32, top as f32);
    let size = Vec2::new(width as f32, height as f32);
    match image {
        Some(image) if image.width > 0 && image.height > 0 => {
            let picture = Vec2::new(image.width as f32, image.height as f32);
            let scale = scale_to_fit(picture, size);
            let drawn = picture * scale;
            if drawn != size {
                canvas.rectangle(corner, size, BACKGROUND, 1.0);
            }
            canvas.picture(image, corner + (size - drawn) / 2.0, scale);
        }
        _ => {
            canvas.rectangle(corner, size, BACKGROUND, 1.0);
            canvas.words("not on the pitch", corner + size / 2.0, 18.0, Anchor::Middle, PAPER);
        }
    }
    let width = width_of_words(words, 18.0);
    canvas.rectangle(corner + Vec2::splat(6.0), Vec2::new(width + 16.0, 26.0), BACKGROUND, 0.6);
    canvas.words(words, corner + Vec2::new(14.0, 25.0), 18.0, Anchor::Left, PAPER);
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::UVec2;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::team::{RobotId, Team};

    #[test]
    fn pictures_do_not_overlap_and_sizes_are_even() {
        let camera = |number| Picture::Camera(RobotId::new(Team::Blue, number), CameraName::TOP);
        for fields in 0..2 {
            for cameras in 0..12u8 {
                let mut pictures = vec![Picture::Field; fields];
                pictures.extend((0..cameras).map(|number| camera(number + 1)));
                if pictures.is_empty() {
                    continue;
                }
                let (places, size) = layout(&pictures);
                assert!(size[0] % 2 == 0 && size[1] % 2 == 0);
                for (index, [left, top, width, height]) in places.iter().enumerate() {
                    assert!(left + width <= size[0] && top + height <= size[1]);
                    for [other_left, other_top, other_width, other_height] in &places[..index] {
                        let apart_across = left + width <= *other_left || other_left + other_width <= *left;
                        let apart_down = top + height <= *other_top || other_top + other_height <= *top;
                        assert!(apart_across || apart_down, "{fields} {cameras} {index}");
                    }
                }
            }
        }
    }

    #[test]
    fn pictures_fit_and_are_enlarged_by_whole_numbers() {
        let place = Vec2::new(720.0, 540.0);
        for (size, expected) in [([640, 480], 1.0), ([320, 240], 2.0), ([1280, 960], 0.5625), ([160, 120], 4.0)] {
            assert_eq!(scale_to_fit(UVec2::from(size).as_vec2(), place), expected, "{size:?}");
        }
    }

    #[test]
    fn a_file_that_is_there_stays_until_the_video_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("match.mp4");
        std::fs::write(&path, "precious").unwrap();
        let create = |path: &Path| VideoRecorder::create(path, 1, vec![], 1.0 / 30.0);
        let video = create(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"precious");
        assert_eq!(video.finish().unwrap(), 0);
        assert_ne!(std::fs::read(&path).unwrap(), b"precious");
        assert!(matches!(create(&folder.path().join("match.avi")), Err(RecordError::Extension { .. })));
        assert!(matches!(create(&folder.path().join("no/match.mp4")), Err(RecordError::NoFolder { .. })));
    }
}
