//! Writes images as a video file: H.264 in fragmented MP4.

use muxide::codec::h264::{annexb_to_avcc, extract_avc_config, is_h264_keyframe};
use muxide::fragmented::{FragmentConfig, FragmentedMuxer};
use pulp::Arch;
use rusty_h264_common::YuvFrame;
use rusty_h264_encoder::{Encoder, EncoderConfig, Preset};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::colour_description;
use super::error::RecordError;
use naoisis_sensing::sensing::camera::image::Image;

/// Ticks of the video's clock per second, 1/s.
const TICKS_PER_S: f64 = 90_000.0;
/// Number of pictures from one that can be decoded by itself to the next.
const KEY_INTERVAL: u32 = 60;
/// Quantiser, from 0 to 51: low enough that the loss is hardly visible.
const QUANTISER: u8 = 22;

/// An unfinished video: H.264 in fragmented MP4.
pub(super) struct VideoFile {
    path: PathBuf,
    file: Arc<File>,
    /// Length of the written fragments, bytes.
    length: u64,
    encoder: Encoder,
    muxer: Option<FragmentedMuxer>,
    frame_s: f64,
    count: u64,
    frame: YuvFrame,
}

impl VideoFile {
    pub(super) fn new(path: &Path, file: Arc<File>, image: &Image, frame_s: f64) -> Result<Self, RecordError> {
        // Chroma has half the resolution, so sizes are even.
        let [width, height] = [image.width, image.height].map(|size| (size & !1) as usize);
        let mut settings = EncoderConfig::new(width, height);
        settings.qp = QUANTISER;
        settings.gop_size = KEY_INTERVAL;
        settings.framerate = (1.0 / frame_s) as f32;
        // Every picture is encoded at once, without waiting for later ones.
        settings.mbtree = false;
        settings.scenecut = 0;
        // Motion in whole pixels takes a quarter less time for a third more bytes.
        settings.preset = Preset::Fast;
        // These settings are twice as fast for 20 % more bytes: variable-length codes instead of arithmetic ones, and prediction from the
        // previous picture only, without weights for changing light.
        settings.cabac = false;
        settings.num_ref_frames = 1;
        settings.weightp = false;
        let encoder = Encoder::new(settings)
            .map_err(|error| RecordError::Encoding { path: path.to_owned(), message: format!("{error:?}") })?;
        let plane = |share: usize| vec![0; width * height / share];
        let frame = YuvFrame { width, height, y: plane(1), u: plane(4), v: plane(4) };
        Ok(Self { path: path.to_owned(), file, length: 0, encoder, muxer: None, frame_s, count: 0, frame })
    }

    pub(super) fn add(&mut self, image: &Image) -> Result<(), RecordError> {
        to_yuv(image, &mut self.frame);
        let unit = self
            .encoder
            .try_encode(&self.frame)
            .map_err(|error| RecordError::Encoding { path: self.path.clone(), message: format!("{error:?}") })?;
        let unit = colour_description::add_to(unit);
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

    pub(super) fn finish(mut self) -> Result<(), RecordError> {
        if let Some(fragment) = self.muxer.as_mut().and_then(FragmentedMuxer::flush_segment) {
            append(&self.file, &mut self.length, &fragment).map_err(RecordError::io(&self.path))?;
        }
        Ok(())
    }
}

/// Appends `bytes` to a file of `length` bytes. If only a part can be written, the file is cut back: players reject half a fragment.
fn append(mut file: &File, length: &mut u64, bytes: &[u8]) -> io::Result<()> {
    file.write_all(bytes).inspect_err(|_| {
        // If this fails, too, the first error is reported.
        let _ = file.set_len(*length);
    })?;
    *length += bytes.len() as u64;
    Ok(())
}

/// Converts an image to luma and chroma of limited range (ITU-R BT.601), with chroma at half the resolution.
fn to_yuv(image: &Image, frame: &mut YuvFrame) {
    let (width, stride) = (frame.width, 3 * image.width as usize);
    let pairs = image.rgb.chunks_exact(2 * stride).zip(frame.y.chunks_exact_mut(2 * width));
    let colours = frame.u.chunks_exact_mut(width / 2).zip(frame.v.chunks_exact_mut(width / 2));
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for ((rgb, y), (u, v)) in pairs.zip(colours) {
                let (upper, lower) = rgb.split_at(stride);
                let (y_upper, y_lower) = y.split_at_mut(width);
                brightness(upper, y_upper);
                brightness(lower, y_lower);
                differences(upper, lower, u, v);
            }
        },
    );
}

#[inline(always)]
fn brightness(rgb: &[u8], y: &mut [u8]) {
    for (y, pixel) in y.iter_mut().zip(rgb.as_chunks::<3>().0) {
        let [red, green, blue] = pixel.map(u16::from);
        *y = (16 + ((66 * red + 129 * green + 25 * blue + 128) >> 8)) as u8;
    }
}

/// Computes the chroma of squares of four pixels.
#[inline(always)]
fn differences(upper: &[u8], lower: &[u8], u: &mut [u8], v: &mut [u8]) {
    let squares = upper.as_chunks::<6>().0.iter().zip(lower.as_chunks::<6>().0);
    for ((upper, lower), (u, v)) in squares.zip(u.iter_mut().zip(v)) {
        let mean = |channel: usize| {
            let four = [upper[channel], upper[channel + 3], lower[channel], lower[channel + 3]];
            (four.map(i16::from).iter().sum::<i16>() + 2) >> 2
        };
        let [red, green, blue] = [0, 1, 2].map(mean);
        *u = (128 + ((-38 * red - 74 * green + 112 * blue + 128) >> 8)) as u8;
        *v = (128 + ((112 * red - 94 * green - 18 * blue + 128) >> 8)) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::default;

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
}
