//! Films of pictures that arrive at irregular times, such as those of a window: the film plays them at the pace at which they arrived. It
//! is a video or a folder of PNG files.

use bevy::prelude::Resource;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::encoder::{EncoderThreads, Layer, PngWork, RecordError, VideoWork};
use super::frames::make_empty_folder;
use super::video::{EXTENSION, check_extension};
use naoisis_sensing::sensing::camera::image::Image;

/// Time between the pictures of a film, s.
pub const FRAME_S: f64 = 1.0 / 30.0;
/// Longest pause in a film, in pictures: longer pauses are cut.
const LONGEST_GAP: u64 = 150;

/// A film that is being written.
#[derive(Resource, Debug)]
pub struct Film {
    path: PathBuf,
    encoders: Encoders,
    size: Option<[u32; 2]>,
    last: Option<Arc<Image>>,
    written: u64,
}

/// Writer of the film.
#[derive(Debug)]
enum Encoders {
    Video(EncoderThreads<VideoWork>),
    Frames(EncoderThreads<PngWork>),
}

impl Film {
    /// Creates a film as a video.
    ///
    /// # Errors
    /// When the file already exists, its name does not end in `.mp4`, or it cannot be written.
    pub fn create_video(path: &Path) -> Result<Self, RecordError> {
        check_extension(path, EXTENSION)?;
        let file = File::create_new(path).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => RecordError::Exists(path.to_owned()),
            _ => RecordError::Io { path: path.to_owned(), error },
        })?;
        Ok(Self::of(path, Encoders::Video(EncoderThreads::for_video(path, file, FRAME_S))))
    }

    /// Creates a film as a folder of PNG files, `000000.png` and so on, one every [`FRAME_S`].
    ///
    /// # Errors
    /// When the folder cannot be created or is not empty.
    pub fn create_frames(folder: &Path) -> Result<Self, RecordError> {
        make_empty_folder(folder)?;
        Ok(Self::of(folder, Encoders::Frames(EncoderThreads::for_png())))
    }

    fn of(path: &Path, encoders: Encoders) -> Self {
        Self { path: path.to_owned(), encoders, size: None, last: None, written: 0 }
    }

    /// Returns the path of the file or folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a picture that is shown from `at_s`, s since the start of the film, until the next one. Pictures that arrive faster than those
    /// of the film are skipped. Returns false if the picture is not added because its size differs from the first one's, in a video.
    pub fn add(&mut self, at_s: f64, image: Image) -> bool {
        let image = with_even_sides(image);
        let size = [image.width, image.height];
        let first_size = *self.size.get_or_insert(size);
        if size != first_size && matches!(self.encoders, Encoders::Video(_)) {
            return false;
        }
        let image = Arc::new(image);
        let due = missing(self.written, at_s);
        if due > 0 {
            let picture = Arc::clone(self.last.as_ref().unwrap_or(&image));
            self.written += self.offer(&picture, due);
        }
        self.last = Some(image);
        true
    }

    /// Sends a picture to the encoder, to be written `times` times, and returns how often it will be written. The display does not wait for
    /// the encoder: a picture for which the queue has no room is replaced by a later one.
    fn offer(&self, picture: &Arc<Image>, times: u64) -> u64 {
        match &self.encoders {
            Encoders::Video(encoder) => {
                let is_sent = encoder.try_send((Arc::clone(picture), times));
                if is_sent { times } else { 0 }
            }
            Encoders::Frames(encoders) => {
                let work = |number| (self.frame(number), Layer::Colours, Arc::clone(picture));
                (0..times).take_while(|more| encoders.try_send(work(self.written + more))).count() as u64
            }
        }
    }

    fn frame(&self, number: u64) -> PathBuf {
        self.path.join(format!("{number:06}.png"))
    }

    /// Returns whether no picture has been added yet.
    pub fn is_empty(&self) -> bool {
        self.last.is_none()
    }

    /// Returns whether writing has failed. Nothing more is written then.
    pub fn has_failed(&self) -> bool {
        match &self.encoders {
            Encoders::Video(encoder) => encoder.has_failed(),
            Encoders::Frames(encoders) => encoders.has_failed(),
        }
    }

    /// Waits until the last pictures are written, and returns their number. A film without pictures is removed.
    ///
    /// # Errors
    /// The first error that occurred while writing. Earlier fragments can be played.
    pub fn finish(mut self) -> Result<u64, RecordError> {
        let is_empty = self.is_empty();
        if let Some(last) = self.last.take() {
            let is_sent = match &self.encoders {
                Encoders::Video(encoder) => encoder.send((last, 1)),
                Encoders::Frames(encoders) => encoders.send((self.frame(self.written), Layer::Colours, last)),
            };
            self.written += u64::from(is_sent);
        }
        let remove: fn(&Path) -> io::Result<()> = match self.encoders {
            Encoders::Video(encoder) => {
                encoder.finish()?;
                |file| fs::remove_file(file)
            }
            Encoders::Frames(encoders) => {
                encoders.finish()?;
                |folder| fs::remove_dir(folder)
            }
        };
        if is_empty {
            remove(&self.path).map_err(RecordError::io(&self.path))?;
        }
        Ok(self.written)
    }
}

/// Returns the number of pictures that are missing until a moment, when `written` ones are there.
fn missing(written: u64, at_s: f64) -> u64 {
    // Half a picture is added for rounding, so that a steady stream loses none.
    let due = (at_s / FRAME_S + 0.5).floor().max(0.0) as u64;
    due.saturating_sub(written).min(LONGEST_GAP)
}

/// Returns the picture without its last row or column if their number is odd: the encoder needs even sizes.
fn with_even_sides(image: Image) -> Image {
    let [width, height] = [image.width & !1, image.height & !1];
    if [width, height] == [image.width, image.height] {
        return image;
    }
    let row = 3 * image.width as usize;
    let rgb = image.rgb.chunks(row).take(height as usize).flat_map(|line| &line[..3 * width as usize]).copied();
    Image { width, height, rgb: rgb.collect(), ..Image::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32) -> Image {
        let rgb = (0..3 * width * height).map(|value| value as u8).collect();
        Image { width, height, rgb, ..Image::default() }
    }

    #[test]
    fn a_film_has_thirty_pictures_a_second_whenever_they_come() {
        assert_eq!(missing(0, 0.0), 0);
        assert_eq!(missing(10, 0.5), 5);
        assert_eq!(missing(20, 0.5), 0, "ahead");
        assert_eq!(missing(0, 1e6), LONGEST_GAP);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.mp4");
        let mut film = Film::create_video(&path).unwrap();
        for at_s in [0.0, 0.02, 0.5, 1.0] {
            assert!(film.add(at_s, picture(64, 48)));
        }
        assert!(!film.add(1.5, picture(48, 64)), "another size does not fit");
        // One second of pictures, and the last one.
        assert_eq!(film.finish().unwrap(), 31);
        let written = fs::read(&path).unwrap();
        assert_eq!(&written[4..8], b"ftyp");
        assert!(matches!(Film::create_video(&path), Err(RecordError::Exists(_))));
    }

    #[test]
    fn a_film_can_be_a_folder_of_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        let mut film = Film::create_frames(&path).unwrap();
        // PNG files may differ in size.
        for (at_s, width) in [(0.0, 8), (0.02, 10), (0.1, 12)] {
            assert!(film.add(at_s, picture(width, 6)));
        }
        // Three pictures in 0.1 s, and the last one.
        assert_eq!(film.finish().unwrap(), 4);
        let mut names: Vec<_> = fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["000000.png", "000001.png", "000002.png", "000003.png"]);
        assert!(matches!(Film::create_frames(&path), Err(RecordError::NotEmpty(_))));
    }

    #[test]
    fn of_a_film_without_pictures_nothing_remains() {
        let folder = tempfile::tempdir().unwrap();
        let [video, frames] = ["film.mp4", "film"].map(|name| folder.path().join(name));
        for film in [Film::create_video(&video), Film::create_frames(&frames)] {
            assert_eq!(film.unwrap().finish().unwrap(), 0);
        }
        assert!(!video.exists() && !frames.exists());
    }

    #[test]
    fn a_gap_is_filled_with_the_picture_from_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        let mut film = Film::create_frames(&path).unwrap();
        let [dark, bright] =
            [0, 250].map(|level| Image { width: 2, height: 2, rgb: vec![level; 12], ..Image::default() });
        assert!(film.add(0.0, dark) && film.add(0.2, bright));
        assert_eq!(film.finish().unwrap(), 7);
        let bytes = |number: u64| fs::read(path.join(format!("{number:06}.png"))).unwrap();
        assert_eq!(bytes(0), bytes(5));
        assert_ne!(bytes(5), bytes(6));
    }

    #[test]
    fn odd_rows_and_columns_are_left_out() {
        let even = with_even_sides(picture(3, 3));
        assert_eq!((even.width, even.height), (2, 2));
        assert_eq!(even.rgb, [0, 1, 2, 3, 4, 5, 9, 10, 11, 12, 13, 14]);
    }
}
