//! Noise of camera images: changing light, colour shifts, pixel noise and blur.

use bevy::math::ops;
use bevy::prelude::*;
use rand::Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

use super::image::Image;
use naoisis_core::random::RandomStream;

/// Light and noise of camera images. By default there is no noise.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImageNoise {
    /// The factor on all channels.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub brightness: f32,
    /// Standard deviation of the factor from image to image.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub brightness_sd: f32,
    /// The shift of red, green and blue, in levels of 255.
    #[schemars(inner(range(min = -255.0, max = 255.0)), extend("unit" = ", of 255"))]
    pub colour_shift: [f32; 3],
    /// Standard deviation of each shift from image to image, in levels of 255.
    #[schemars(range(min = 0.0, max = 255.0), extend("unit" = ", of 255"))]
    pub colour_shift_sd: f32,
    /// Standard deviation of each channel of each pixel, in levels of 255.
    #[schemars(range(min = 0.0, max = 255.0), extend("unit" = ", of 255"))]
    pub pixel_sd: f32,
    /// Standard deviation of the blur, pixels.
    #[schemars(range(min = 0.0, max = 8.0))]
    pub blur_px: f32,
    /// Standard deviation of the depth of a pixel at a distance of 1 m, m; it grows with the square of the distance, as of stereo cameras.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub depth_sd_m: f32,
}

impl Default for ImageNoise {
    fn default() -> Self {
        Self {
            brightness: 1.0,
            brightness_sd: 0.0,
            colour_shift: [0.0; 3],
            colour_shift_sd: 0.0,
            pixel_sd: 0.0,
            blur_px: 0.0,
            depth_sd_m: 0.0,
        }
    }
}

impl ImageNoise {
    /// The greatest standard deviation of the blur, pixels.
    pub const MOST_BLUR_PX: f32 = 8.0;

    /// Draws the noise of one image.
    pub(crate) fn draw(&self, stream: &mut RandomStream) -> DrawnNoise {
        let gain = self.brightness + stream.gaussian(self.brightness_sd);
        let shift = self.colour_shift.map(|shift| shift + stream.gaussian(self.colour_shift_sd));
        let &Self { pixel_sd, blur_px, depth_sd_m, .. } = self;
        let seed = if pixel_sd > 0.0 || depth_sd_m > 0.0 { stream.next_u64() } else { 0 };
        DrawnNoise { gain: gain.max(0.0), shift, pixel_sd, blur_px, depth_sd_m, seed }
    }
}

/// The light and noise drawn for one image.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct DrawnNoise {
    gain: f32,
    shift: [f32; 3],
    pixel_sd: f32,
    blur_px: f32,
    depth_sd_m: f32,
    seed: u64,
}

/// Memory for blurring, reused from image to image.
#[derive(Default)]
pub(crate) struct NoiseBuffer {
    copy: Vec<u8>,
}

/// Normally distributed numbers with a standard deviation of 256. The pixels of a row use them in turn, from a random start.
static NORMAL: LazyLock<Vec<i32>> = LazyLock::new(|| {
    let mut stream = RandomStream::for_match(0, "pixel noise");
    (0..NORMAL_COUNT).map(|_| (stream.gaussian(256.0)).round() as i32).collect()
});
const NORMAL_COUNT: usize = 1 << 14;

impl DrawnNoise {
    /// Changes the colours and the depth of an image, but not its labels.
    pub fn apply(&self, image: &mut Image, buffer: &mut NoiseBuffer) {
        if self.blur_px > 0.0 {
            blur(image, &mut buffer.copy, self.blur_px);
        }
        if self.gain != 1.0 || self.shift != [0.0; 3] {
            let tables = self.shift.map(|shift| {
                core::array::from_fn::<u8, 256, _>(|level| (level as f32 * self.gain + shift).round() as u8)
            });
            for pixel in image.rgb.chunks_exact_mut(3) {
                for (channel, table) in pixel.iter_mut().zip(&tables) {
                    *channel = table[usize::from(*channel)];
                }
            }
        }
        if self.pixel_sd > 0.0 {
            self.add_pixel_noise(image);
        }
        if self.depth_sd_m > 0.0 {
            self.add_depth_noise(image);
        }
    }

    fn add_depth_noise(&self, image: &mut Image) {
        let scale = self.depth_sd_m / 256.0;
        let mut state = !self.seed;
        for stretch in image.depth_m.chunks_mut(NORMAL_COUNT / 2) {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let start = (mixed(state) % (NORMAL_COUNT / 2) as u64) as usize;
            for (depth_m, noise) in stretch.iter_mut().zip(&NORMAL[start..]) {
                *depth_m = (*depth_m + *depth_m * *depth_m * scale * *noise as f32).max(0.0);
            }
        }
    }

    fn add_pixel_noise(&self, image: &mut Image) {
        let scale = (self.pixel_sd * 256.0) as i32;
        let mut state = self.seed;
        let normal = NORMAL.as_slice();
        for row in image.rgb.chunks_exact_mut(3 * image.width.max(1) as usize) {
            let mut rest = row;
            while !rest.is_empty() {
                // The generator of SplitMix64 chooses where in the table a run of numbers begins.
                state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let start = (mixed(state) % NORMAL_COUNT as u64) as usize;
                let (stretch, next) = rest.split_at_mut(rest.len().min(NORMAL_COUNT - start));
                for (channel, noise) in stretch.iter_mut().zip(&normal[start..]) {
                    *channel = (i32::from(*channel) + ((noise * scale + (1 << 15)) >> 16)).clamp(0, 255) as u8;
                }
                rest = next;
            }
        }
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
fn mixed(value: u64) -> u64 {
    let z = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The greatest number of samples of the kernel to each side of its middle.
const MOST_REACH: usize = 20;

/// Blurs along rows and columns with a Gaussian kernel of the standard deviation `sd`, pixels.
fn blur(image: &mut Image, copy: &mut Vec<u8>, sd: f32) {
    let sd = sd.min(ImageNoise::MOST_BLUR_PX);
    let reach = (2.5 * sd).ceil() as usize;
    let mut bell = [0.0; MOST_REACH + 1];
    for (offset, weight) in bell[..=reach].iter_mut().enumerate() {
        *weight = ops::exp(-((offset * offset) as f32) / (2.0 * sd * sd));
    }
    let sum = 2.0 * bell.iter().sum::<f32>() - bell[0];
    // In 65536ths; the middle has the remainder, so that uniform areas do not change.
    let mut weights = bell.map(|weight| (weight / sum * 65536.0) as u32);
    weights[0] = 65536 - 2 * weights[1..].iter().sum::<u32>();
    let weights = &weights[..=reach];
    let (width, height) = (image.width as usize, image.height as usize);
    copy.clear();
    copy.extend_from_slice(&image.rgb);
    convolve(copy, &mut image.rgb, weights, [width, height], [3, 3 * width]);
    core::mem::swap(copy, &mut image.rgb);
    convolve(copy, &mut image.rgb, weights, [height, width], [3 * width, 3]);
}

/// Convolves `count` lines of `length` pixels. Pixels are `step` bytes apart, lines `stride` bytes.
fn convolve(from: &[u8], to: &mut [u8], weights: &[u32], [length, count]: [usize; 2], [step, stride]: [usize; 2]) {
    for line in 0..count {
        for place in 0..length {
            let index = |place: usize| line * stride + place * step;
            for channel in 0..3 {
                let at = |place: usize| u32::from(from[index(place) + channel]);
                let mut sum = weights[0] * at(place) + (1 << 15);
                for (offset, weight) in weights.iter().enumerate().skip(1) {
                    sum += weight * (at(place.saturating_sub(offset)) + at((place + offset).min(length - 1)));
                }
                to[index(place) + channel] = (sum >> 16) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(level: u8) -> Image {
        Image { width: 64, height: 48, rgb: vec![level; 3 * 64 * 48], ..Image::default() }
    }

    fn with_noise(noise: &ImageNoise, image: &Image) -> Image {
        let mut image = image.clone();
        noise.draw(&mut RandomStream::for_match(5, "test")).apply(&mut image, &mut NoiseBuffer::default());
        image
    }

    #[test]
    fn the_error_of_the_depth_grows_with_the_square_of_the_distance() {
        for depth_m in [1.0_f32, 2.0, 4.0] {
            let image = Image { depth_m: vec![depth_m; 64 * 48], ..grey(100) };
            let noisy = with_noise(&ImageNoise { depth_sd_m: 0.01, ..ImageNoise::default() }, &image);
            let square = |depth: &f32| (depth - depth_m).powi(2);
            let deviation = (noisy.depth_m.iter().map(square).sum::<f32>() / 3072.0).sqrt();
            // Four standard errors of a deviation by 3072 numbers are 5 %.
            assert!((deviation / (0.01 * depth_m * depth_m) - 1.0).abs() < 0.06, "{deviation}");
            assert_eq!(noisy.rgb, image.rgb);
        }
    }

    #[test]
    fn without_noise_an_image_stays_as_it_is_and_nothing_is_drawn() {
        let mut stream = RandomStream::for_match(5, "test");
        let before = stream.clone();
        let drawn = ImageNoise::default().draw(&mut stream);
        assert_eq!(stream, before);
        let mut image = grey(100);
        drawn.apply(&mut image, &mut NoiseBuffer::default());
        assert_eq!(image, grey(100));
    }

    #[test]
    fn light_multiplies_and_colours_shift() {
        let noise = ImageNoise { brightness: 0.5, colour_shift: [10.0, 0.0, -60.0], ..default() };
        // 100 / 2 + 10, + 0, - 60 and not below 0.
        assert_eq!(with_noise(&noise, &grey(100)).colour(3, 4), Some([60, 50, 0]));
    }

    #[test]
    fn pixel_noise_has_the_deviation_asked_for_and_repeats() {
        let noise = ImageNoise { pixel_sd: 8.0, ..default() };
        let image = with_noise(&noise, &grey(128));
        assert_eq!(image, with_noise(&noise, &grey(128)));
        let count = image.rgb.len() as f64;
        let mean = image.rgb.iter().map(|&level| f64::from(level)).sum::<f64>() / count;
        let variance = image.rgb.iter().map(|&level| (f64::from(level) - mean).powi(2)).sum::<f64>() / count;
        // 9216 draws: the mean is known to 8 / 96 = 0.08, the deviation to 0.06.
        assert!((mean - 128.0).abs() < 0.4 && (variance.sqrt() - 8.0).abs() < 0.3, "{mean} {}", variance.sqrt());
    }

    #[test]
    fn blur_spreads_a_point_and_keeps_even_areas() {
        let noise = ImageNoise { blur_px: 1.5, ..default() };
        assert_eq!(with_noise(&noise, &grey(77)), grey(77));
        let mut point = grey(0);
        point.rgb[3 * (20 * 64 + 30)] = 255;
        let image = with_noise(&noise, &point);
        let red = |u, v| image.colour(u, v).unwrap()[0];
        // The middle of the bell is 255 / (2 pi sd²) = 18.
        assert!((i32::from(red(30, 20)) - 18).abs() <= 1, "{}", red(30, 20));
        assert!(red(31, 20) == red(29, 20) && red(30, 21) == red(30, 19) && red(31, 20) < red(30, 20));
    }
}
