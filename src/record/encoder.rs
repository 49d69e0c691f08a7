//! Pictures into files, beside the simulation: PNG files, and H.264 video in MP4.
//!
//! Encoders have threads of their own and a bounded queue: a simulation that is faster waits for them. Whatever was written
//! is whole, whenever the program ends: a PNG file has another name until it is complete, and a video grows by fragments of
//! a second that can each be played.

use bevy::prelude::*;
use muxide::codec::h264::{annexb_to_avcc, extract_avc_config, is_h264_keyframe};
use muxide::fragmented::{FragmentConfig, FragmentedMuxer};
use rusty_h264_common::YuvFrame;
use rusty_h264_encoder::{Encoder, EncoderConfig};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::appearance::Label;
use crate::sensing::camera::image::Image;

/// Pictures that wait for an encoder, at most.
const QUEUE: usize = 24;

/// Why a picture is not written.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Something is there already.
    #[error("{0}: the folder is not empty; expected a new or an empty one")]
    NotEmpty(PathBuf),
    /// Something is there already.
    #[error("{0}: there is such a file already; expected a new name")]
    Exists(PathBuf),
    /// A file is there.
    #[error("{0}: this is a file; expected a folder, new or empty")]
    NotAFolder(PathBuf),
    /// Its name does not say what it is.
    #[error("{path}: expected a file name that ends in .{extension}")]
    Extension {
        /// The file.
        path: PathBuf,
        /// How it should end.
        extension: &'static str,
    },
    /// It cannot be made, or written to.
    #[error("{path}: {error}")]
    Io {
        /// The folder or file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// It cannot be encoded.
    #[error("{path}: {message}")]
    Encoding {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
}

impl RecordError {
    pub(super) fn io(path: &Path) -> impl FnOnce(io::Error) -> RecordError {
        move |error| RecordError::Io { path: path.to_owned(), error }
    }
}

/// What a PNG file shows of an image.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Layer {
    /// Its colours.
    Colours,
    /// What each pixel is: the number of its [`Label`] as an index into a palette in which they can be told apart.
    Labels,
    /// How far away each pixel is, in millimetres of 16 bits: 65535 where that is more, 0 for the sky.
    Depth,
}

/// Threads that encode what they are sent.
#[derive(Debug)]
pub(super) struct EncoderThreads<T> {
    queue: Option<SyncSender<T>>,
    threads: Vec<JoinHandle<()>>,
    failure: Arc<Mutex<Option<RecordError>>>,
    waiting: Arc<AtomicUsize>,
}

/// One thread's end of the queue.
pub(super) struct Work<T> {
    queue: Arc<Mutex<Receiver<T>>>,
    failure: Arc<Mutex<Option<RecordError>>>,
    waiting: Arc<AtomicUsize>,
}

impl<T> Work<T> {
    /// Does what comes, until nothing more does; after a failure, nothing.
    fn carry_out(&self, mut encode: impl FnMut(T) -> Result<(), RecordError>) {
        loop {
            let next = match self.queue.lock() {
                Ok(queue) => queue.recv(),
                Err(_) => return,
            };
            let Ok(next) = next else { return };
            if !has_failed(&self.failure)
                && let Err(error) = encode(next)
            {
                fail(&self.failure, error);
            }
            self.waiting.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

fn has_failed(failure: &Mutex<Option<RecordError>>) -> bool {
    failure.lock().is_ok_and(|failure| failure.is_some())
}

fn fail(failure: &Mutex<Option<RecordError>>, error: RecordError) {
    if let Ok(mut failure) = failure.lock() {
        failure.get_or_insert(error);
    }
}

impl<T: Send + 'static> EncoderThreads<T> {
    fn start(count: usize, work: impl Fn(Work<T>) + Send + Sync + Clone + 'static) -> Self {
        let (queue, receiver) = sync_channel::<T>(QUEUE);
        let receiver = Arc::new(Mutex::new(receiver));
        let failure = Arc::new(Mutex::new(None));
        let waiting = Arc::new(AtomicUsize::new(0));
        let threads = (0..count).map(|_| {
            let work = work.clone();
            let end =
                Work { queue: Arc::clone(&receiver), failure: Arc::clone(&failure), waiting: Arc::clone(&waiting) };
            thread::spawn(move || work(end))
        });
        let threads = threads.collect();
        Self { queue: Some(queue), threads, failure, waiting }
    }

    /// Hands something over. Waits while the queue is full.
    pub(super) fn send(&self, work: T) -> bool {
        self.waiting.fetch_add(1, Ordering::Relaxed);
        self.queue.as_ref().is_some_and(|queue| queue.send(work).is_ok())
    }

    /// Whether encoding has failed: nothing more is written then.
    pub(super) fn has_failed(&self) -> bool {
        has_failed(&self.failure)
    }

    /// Notes a failure.
    pub(super) fn fail(&self, error: RecordError) {
        fail(&self.failure, error);
    }

    /// Waits until everything is written.
    pub(super) fn finish(mut self) -> Result<(), RecordError> {
        self.queue = None;
        for thread in core::mem::take(&mut self.threads) {
            // An encoder does not panic; if it did, its pictures are missing.
            if thread.join().is_err() {
                self.fail(RecordError::Encoding { path: PathBuf::new(), message: "an encoder stopped".to_owned() });
            }
        }
        self.failure.lock().ok().and_then(|mut failure| failure.take()).map_or(Ok(()), Err)
    }
}

/// A PNG file to be written.
pub(super) type PngWork = (PathBuf, Layer, Arc<Image>);

impl EncoderThreads<PngWork> {
    /// Writes pictures to PNG files, on all cores.
    pub(super) fn for_png() -> Self {
        let threads = thread::available_parallelism().map_or(1, usize::from);
        Self::start(threads, |work| {
            work.carry_out(|(path, layer, image): PngWork| {
                write_png(&path, layer, &image).map_err(RecordError::io(&path))
            });
        })
    }
}

impl EncoderThreads<Image> {
    /// Writes pictures into a video with so many seconds between them.
    pub(super) fn for_video(path: &Path, file: File, frame_s: f64) -> Self {
        let (path, file) = (path.to_owned(), Arc::new(file));
        Self::start(1, move |work| {
            let mut video: Option<VideoFile> = None;
            work.carry_out(|image: Image| {
                let video = match &mut video {
                    Some(video) => video,
                    none => none.insert(VideoFile::new(&path, Arc::clone(&file), &image, frame_s)?),
                };
                video.add(&image)
            });
            // After a failure, what is still to be written has lost what it follows.
            if !has_failed(&work.failure)
                && let Some(Err(error)) = video.map(VideoFile::finish)
            {
                fail(&work.failure, error);
            }
        })
    }
}

/// Writes a layer of an image as PNG, under another name until it is whole.
///
/// # Errors
/// Those of the file system.
pub fn write_png(path: &Path, layer: Layer, image: &Image) -> io::Result<()> {
    let unfinished = path.with_extension("png.part");
    let written = File::create(&unfinished).and_then(|file| encode_png(file, layer, image));
    written.and_then(|()| fs::rename(&unfinished, path)).inspect_err(|_| {
        // What is left of it is of use to nobody. If that cannot be removed either, the first error says enough.
        let _ = fs::remove_file(&unfinished);
    })
}

fn encode_png(file: File, layer: Layer, image: &Image) -> io::Result<()> {
    let mut encoder = png::Encoder::new(BufWriter::new(file), image.width, image.height);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_depth(png::BitDepth::Eight);
    let millimetres: Vec<u8>;
    let data = match layer {
        Layer::Colours => {
            encoder.set_color(png::ColorType::Rgb);
            &image.rgb
        }
        Layer::Labels => {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(LABEL_COLOURS.as_flattened());
            &image.labels
        }
        Layer::Depth => {
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(png::BitDepth::Sixteen);
            // The conversion saturates.
            millimetres =
                image.depth_m.iter().flat_map(|depth_m| ((1e3 * depth_m).round() as u16).to_be_bytes()).collect();
            &millimetres
        }
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(data)?;
    writer.finish()?;
    Ok(())
}

/// How labels are shown, in the order of their numbers.
const LABEL_COLOURS: [[u8; 3]; Label::ALL.len()] = [
    [140, 190, 240], // sky
    [110, 110, 110], // floor
    [30, 120, 50],   // carpet
    [255, 255, 255], // line
    [255, 120, 0],   // ball
    [240, 220, 30],  // yellow goal
    [0, 150, 230],   // blue goal
    [220, 220, 200], // white goal
    [170, 150, 120], // frame of a goal
    [120, 60, 20],   // post
    [120, 130, 200], // robot of the blue team
    [230, 160, 190], // robot of the pink team
    [20, 30, 200],   // waistband of the blue team
    [220, 20, 130],  // waistband of the pink team
];

/// Ticks of a video's clock, 1/s.
const TICKS_PER_S: f64 = 90_000.0;
/// Pictures between two that can be decoded by themselves.
const KEY_INTERVAL: u32 = 60;
/// How coarsely pictures are quantised, 0 to 51: so that hardly anything is to be seen of it.
const QUANTISER: u8 = 22;

/// A video under way: H.264 in fragmented MP4.
struct VideoFile {
    path: PathBuf,
    file: Arc<File>,
    /// What is written of it, bytes: whole fragments.
    length: u64,
    encoder: Encoder,
    muxer: Option<FragmentedMuxer>,
    frame_s: f64,
    count: u64,
    frame: YuvFrame,
}

impl VideoFile {
    fn new(path: &Path, file: Arc<File>, image: &Image, frame_s: f64) -> Result<Self, RecordError> {
        // Chroma has half the resolution, so sizes are even.
        let [width, height] = [image.width, image.height].map(|size| (size & !1) as usize);
        let mut settings = EncoderConfig::new(width, height);
        settings.qp = QUANTISER;
        settings.gop_size = KEY_INTERVAL;
        settings.framerate = (1.0 / frame_s) as f32;
        // Every picture comes out as soon as it is in.
        settings.mbtree = false;
        settings.scenecut = 0;
        let encoder = Encoder::new(settings)
            .map_err(|error| RecordError::Encoding { path: path.to_owned(), message: format!("{error:?}") })?;
        let plane = |share: usize| vec![0; width * height / share];
        let frame = YuvFrame { width, height, y: plane(1), u: plane(4), v: plane(4) };
        Ok(Self { path: path.to_owned(), file, length: 0, encoder, muxer: None, frame_s, count: 0, frame })
    }

    fn add(&mut self, image: &Image) -> Result<(), RecordError> {
        to_yuv(image, &mut self.frame);
        let unit = self
            .encoder
            .try_encode(&self.frame)
            .map_err(|error| RecordError::Encoding { path: self.path.clone(), message: format!("{error:?}") })?;
        let muxer = match &mut self.muxer {
            Some(muxer) => muxer,
            none => {
                let mut settings =
                    FragmentConfig::new(self.frame.width as u32, self.frame.height as u32, TICKS_PER_S as u32)
                        .with_fragment_duration_ms(1000);
                if let Some(parameters) = extract_avc_config(&unit) {
                    (settings.sps, settings.pps) = (parameters.sps, parameters.pps);
                }
                let mut muxer = FragmentedMuxer::new(settings)
                    .map_err(|error| RecordError::Encoding { path: self.path.clone(), message: error.to_string() })?;
                append(&self.file, &mut self.length, &muxer.init_segment()).map_err(RecordError::io(&self.path))?;
                none.insert(muxer)
            }
        };
        let time = (self.count as f64 * self.frame_s * TICKS_PER_S).round() as u64;
        self.count += 1;
        muxer
            .write_video(time, time, &annexb_to_avcc(&unit), is_h264_keyframe(&unit))
            .map_err(|error| RecordError::Encoding { path: self.path.clone(), message: error.to_string() })?;
        if muxer.ready_to_flush()
            && let Some(fragment) = muxer.flush_segment()
        {
            append(&self.file, &mut self.length, &fragment).map_err(RecordError::io(&self.path))?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(), RecordError> {
        if let Some(fragment) = self.muxer.as_mut().and_then(FragmentedMuxer::flush_segment) {
            append(&self.file, &mut self.length, &fragment).map_err(RecordError::io(&self.path))?;
        }
        Ok(())
    }
}

/// Adds to a file that is so long. What can be written of it only in part is taken back: no player likes half a fragment.
fn append(mut file: &File, length: &mut u64, bytes: &[u8]) -> io::Result<()> {
    file.write_all(bytes).inspect_err(|_| {
        // If not even that can be done, the first error says enough.
        let _ = file.set_len(*length);
    })?;
    *length += bytes.len() as u64;
    Ok(())
}

/// To brightness and colour differences of limited range (ITU-R BT.601), the latter at half the resolution.
fn to_yuv(image: &Image, frame: &mut YuvFrame) {
    let (width, height, stride) = (frame.width, frame.height, 3 * image.width as usize);
    let pixel = |column: usize, row: usize| -> [i32; 3] {
        let first = row * stride + 3 * column;
        image.rgb.get(first..first + 3).map_or([0; 3], |pixel| [0, 1, 2].map(|channel| i32::from(pixel[channel])))
    };
    for row in 0..height {
        for column in 0..width {
            let [red, green, blue] = pixel(column, row);
            frame.y[row * width + column] = (16 + ((66 * red + 129 * green + 25 * blue + 128) >> 8)) as u8;
        }
    }
    for row in 0..height / 2 {
        for column in 0..width / 2 {
            let mut sum = [0; 3];
            for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let pixel = pixel(2 * column + right, 2 * row + down);
                sum.iter_mut().zip(pixel).for_each(|(sum, channel)| *sum += channel);
            }
            let [red, green, blue] = sum.map(|sum| (sum + 2) / 4);
            let index = row * (width / 2) + column;
            frame.u[index] = (128 + ((-38 * red - 74 * green + 112 * blue + 128) >> 8)) as u8;
            frame.v[index] = (128 + ((112 * red - 94 * green - 18 * blue + 128) >> 8)) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::BufReader;

    #[test]
    fn a_picture_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let image = Image { width: 3, height: 2, rgb: (0..18).collect(), ..default() };
        write_png(&path, Layer::Colours, &image).unwrap();
        let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        assert_eq!(rgb, image.rgb);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing unfinished is left");
    }

    #[test]
    fn labels_and_depth_keep_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layer.png");
        let image = Image {
            width: 2,
            height: 1,
            labels: vec![Label::Ball as u8, Label::PinkWaistband as u8],
            depth_m: vec![1.2345, f32::INFINITY],
            ..default()
        };
        for (layer, expected) in [(Layer::Labels, vec![4, 13]), (Layer::Depth, vec![0x04, 0xd3, 0xff, 0xff])] {
            write_png(&path, layer, &image).unwrap();
            let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut bytes).unwrap();
            // 1.2345 m are 1235 mm, 0x04d3.
            assert_eq!(bytes, expected);
        }
    }

    #[test]
    fn colours_become_what_the_standard_says() {
        // BT.601, limited range: white is (235, 128, 128), black (16, 128, 128), red (82, 90, 240).
        for (colour, expected) in [([255; 3], [235, 128, 128]), ([0; 3], [16, 128, 128]), ([255, 0, 0], [82, 90, 240])]
        {
            let image = Image { width: 2, height: 2, rgb: colour.repeat(4), ..default() };
            let mut frame = YuvFrame { width: 2, height: 2, y: vec![0; 4], u: vec![0], v: vec![0] };
            to_yuv(&image, &mut frame);
            assert_eq!([frame.y[0], frame.u[0], frame.v[0]], expected);
        }
    }

    #[test]
    fn a_video_grows_by_fragments_of_a_second() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.mp4");
        let threads = EncoderThreads::for_video(&path, File::create(&path).unwrap(), 0.1);
        for index in 0..25u8 {
            let image = Image { width: 33, height: 16, rgb: vec![10 * index; 3 * 33 * 16], ..default() };
            assert!(threads.send(image));
        }
        threads.finish().unwrap();
        let bytes = fs::read(&path).unwrap();
        // A file of boxes, each with its length before its name: one header, then pairs of moof and mdat.
        let mut names = Vec::new();
        let mut rest = bytes.as_slice();
        while let Some((head, _)) = rest.split_first_chunk::<8>() {
            let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
            names.push(String::from_utf8_lossy(&head[4..]).into_owned());
            rest = &rest[length..];
        }
        assert!(rest.is_empty(), "the last box is whole");
        // 2.5 seconds are two whole fragments and one of the rest.
        assert_eq!(names.iter().filter(|name| *name == "moof").count(), 3, "{names:?}");
        assert_eq!(names[..2], ["ftyp", "moov"]);
    }
}
