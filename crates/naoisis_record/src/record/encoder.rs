//! Encodes pictures on separate threads: PNG files, and H.264 video in MP4.
//!
//! The queue of an encoder is bounded: a faster simulation waits. Files are valid even if the program is killed: a PNG file has a temporary
//! name until it is complete, and a video grows by fragments of a second, which can be played.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

pub use super::error::RecordError;
pub use super::png_file::{Layer, write_png};
use super::video_file::VideoFile;
use naoisis_sensing::sensing::camera::image::Image;

/// Number of pictures in an encoder's queue at most.
const QUEUE: usize = 24;

/// Threads that encode the work sent to them.
#[derive(Debug)]
pub(super) struct EncoderThreads<T> {
    queue: Option<SyncSender<T>>,
    threads: Vec<JoinHandle<()>>,
    failure: Arc<Mutex<Option<RecordError>>>,
}

/// A thread's end of the queue.
pub(super) struct Work<T> {
    queue: Arc<Mutex<Receiver<T>>>,
    failure: Arc<Mutex<Option<RecordError>>>,
}

impl<T> Work<T> {
    /// Encodes everything in the queue until it is closed. After a failure it only empties the queue.
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
        let threads = (0..count).map(|_| {
            let work = work.clone();
            let end = Work { queue: Arc::clone(&receiver), failure: Arc::clone(&failure) };
            thread::spawn(move || work(end))
        });
        let threads = threads.collect();
        Self { queue: Some(queue), threads, failure }
    }

    /// Sends work to the threads. Waits while the queue is full. Returns false if the threads have stopped.
    pub(super) fn send(&self, work: T) -> bool {
        self.queue.as_ref().is_some_and(|queue| queue.send(work).is_ok())
    }

    /// Sends work to the threads. Returns false if the queue is full or the threads have stopped.
    pub(super) fn try_send(&self, work: T) -> bool {
        self.queue.as_ref().is_some_and(|queue| queue.try_send(work).is_ok())
    }

    /// Returns whether encoding has failed. Nothing more is written then.
    pub(super) fn has_failed(&self) -> bool {
        has_failed(&self.failure)
    }

    /// Notes a failure, unless there was one before.
    pub(super) fn fail(&self, error: RecordError) {
        fail(&self.failure, error);
    }

    /// Waits until everything is written.
    pub(super) fn finish(mut self) -> Result<(), RecordError> {
        self.queue = None;
        for thread in core::mem::take(&mut self.threads) {
            // An encoder should not panic. If it does, its pictures are missing.
            if thread.join().is_err() {
                self.fail(RecordError::Encoding { path: PathBuf::new(), message: "an encoder stopped".to_owned() });
            }
        }
        self.failure.lock().ok().and_then(|mut failure| failure.take()).map_or(Ok(()), Err)
    }
}

/// A PNG file to write: its path, and a layer of an image.
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

/// A picture of a video, and the number of frames that show it.
pub(super) type VideoWork = (Arc<Image>, u64);

impl EncoderThreads<VideoWork> {
    /// Creates the thread of a video with `frame_s` seconds from picture to picture.
    pub(super) fn for_video(path: &Path, file: File, frame_s: f64) -> Self {
        let (path, file) = (path.to_owned(), Arc::new(file));
        Self::start(1, move |work| {
            let mut video: Option<VideoFile> = None;
            work.carry_out(|(image, times): VideoWork| {
                let video = match &mut video {
                    Some(video) => video,
                    none => none.insert(VideoFile::new(&path, Arc::clone(&file), &image, frame_s)?),
                };
                (0..times).try_for_each(|_| video.add(&image))
            });
            // After a failure, the rest of the video would not fit what was written.
            if !has_failed(&work.failure)
                && let Some(Err(error)) = video.map(VideoFile::finish)
            {
                fail(&work.failure, error);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::default;
    use std::fs;

    #[test]
    fn a_video_grows_by_fragments_of_a_second() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("video.mp4");
        let threads = EncoderThreads::for_video(&path, File::create(&path).unwrap(), 0.1);
        for index in 0..25u8 {
            let image = Image { width: 33, height: 16, rgb: vec![10 * index; 3 * 33 * 16], ..default() };
            assert!(threads.send((Arc::new(image), 1)));
        }
        threads.finish().unwrap();
        let bytes = fs::read(&path).unwrap();
        // The file is a sequence of boxes, each with its length before its name: one header, then pairs of moof and mdat.
        let mut names = Vec::new();
        let mut rest = bytes.as_slice();
        while let Some((head, _)) = rest.split_first_chunk::<8>() {
            let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
            names.push(String::from_utf8_lossy(&head[4..]).into_owned());
            rest = &rest[length..];
        }
        assert!(rest.is_empty(), "the last box is whole");
        // 2.5 seconds are two whole fragments and a rest.
        assert_eq!(names.iter().filter(|name| *name == "moof").count(), 3, "{names:?}");
        assert_eq!(names[..2], ["ftyp", "moov"]);
    }
}
