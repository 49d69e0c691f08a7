//! Converts the samples of a frame to a picture.

use super::frame::Frame;
use super::shadow::SHADED;
use crate::appearance::view::View;
use crate::sensing::camera::image::{Image, Layers};

/// Writes the picture of a frame.
#[inline(always)]
pub(super) fn develop(frame: &Frame, view: &View, layers: Layers, image: &mut Image) {
    let [width, height] = view.size();
    let samples = view.supersampling.max(1) as usize;
    (image.width, image.height) = (width as u32, height as u32);
    image.rgb.resize(3 * width * height, 0);
    if samples == 1 {
        pack(&frame.pixels, &mut image.rgb);
    } else {
        develop_window(frame, samples, &mut image.rgb);
    }
    image.labels.clear();
    image.depth_m.clear();
    if !layers.labels && !layers.depth {
        return;
    }
    // Of several samples, the middle one is taken.
    for row in 0..height {
        let row = row * samples + samples / 2;
        for column in 0..width {
            let column = column * samples + samples / 2;
            let index = row * frame.width + column;
            if layers.labels {
                image.labels.push(((frame.pixels[index] & !SHADED) >> 24) as u8);
            }
            if layers.depth {
                image.depth_m.push(depth(frame, view, index, [column, row]));
            }
        }
    }
}

/// Copies pixels without their labels.
#[inline(always)]
fn pack(pixels: &[u32], rgb: &mut [u8]) {
    // Four pixels are three words.
    let (groups, rest) = pixels.as_chunks::<4>();
    let (packed, packed_rest) = rgb.as_chunks_mut::<12>();
    for (&[a, b, c, d], packed) in groups.iter().zip(packed) {
        let words = [a & 0x00ff_ffff | b << 24, (b >> 8) & 0x0000_ffff | c << 16, (c >> 16) & 0x0000_00ff | d << 8];
        packed[0..4].copy_from_slice(&words[0].to_le_bytes());
        packed[4..8].copy_from_slice(&words[1].to_le_bytes());
        packed[8..12].copy_from_slice(&words[2].to_le_bytes());
    }
    for (pixel, packed) in rest.iter().zip(packed_rest.chunks_exact_mut(3)) {
        packed.copy_from_slice(&pixel.to_le_bytes()[..3]);
    }
}

/// Writes the pixels of the frame's window, with `samples` samples across and down each.
#[inline(always)]
pub(super) fn develop_window(frame: &Frame, samples: usize, rgb: &mut [u8]) {
    // Division by a constant compiles to a multiplication.
    match samples {
        1 => average::<1>(frame, 1, rgb),
        2 => average::<2>(frame, 2, rgb),
        3 => average::<3>(frame, 3, rgb),
        _ => average::<0>(frame, samples, rgb),
    }
}

/// Averages the samples of each pixel: `SAMPLES` across and down, or `samples` if `SAMPLES` is 0.
#[inline(always)]
fn average<const SAMPLES: usize>(frame: &Frame, samples: usize, rgb: &mut [u8]) {
    let samples = if SAMPLES > 0 { SAMPLES } else { samples };
    let count = (samples * samples) as u32;
    let [columns, rows] = [&frame.window.columns, &frame.window.rows];
    let width = 3 * (frame.width / samples);
    for row in rows.start / samples..rows.end / samples {
        let pixels = row * width + columns.start / samples * 3..row * width + columns.end / samples * 3;
        for (column, pixel) in rgb[pixels].chunks_exact_mut(3).enumerate() {
            let mut sums = [count / 2; 3];
            for down in 0..samples {
                let first = (row * samples + down) * frame.width + columns.start + column * samples;
                for sample in &frame.pixels[first..first + samples] {
                    sums[0] += sample & 0xff;
                    sums[1] += (sample >> 8) & 0xff;
                    sums[2] += (sample >> 16) & 0xff;
                }
            }
            for (channel, sum) in pixel.iter_mut().zip(sums) {
                *channel = (sum / count) as u8;
            }
        }
    }
}

/// The depth of a sample, m.
#[inline(always)]
fn depth(frame: &Frame, view: &View, index: usize, [column, row]: [usize; 2]) -> f32 {
    let nearness = frame.nearness[index];
    if nearness > 0.0 {
        return 1.0 / nearness;
    }
    let down = view.forward.z + frame.slope(column, 0) * view.right.z + frame.slope(row, 1) * view.down.z;
    if down < 0.0 && view.eye.z > 0.0 { -view.eye.z / down } else { 0.0 }
}
