//! Lens and exposure of a real camera: distortion, vignetting, and motion blur and rolling shutter while the camera turns.
//!
//! Blur of the lens and wrong exposure are part of the [noise](super::noise).

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::image::Image;
use naoisis_core::camera_model::{CameraIntrinsics, Distortion};
use naoisis_core::knowledge::Knowledge;

/// Lens and exposure. By default those of a pinhole camera with an instantaneous exposure. Labels and depth are distorted like the colours,
/// and vision knows the distortion, like a robot with calibrated cameras.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Lens {
    /// Distortion of cameras that have no `intrinsics`.
    pub distortion: Distortion,
    /// Vignetting: the share of the level of each channel that is lost in the corners, and in proportion to the square of the distance from
    /// the middle elsewhere.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = ", a share of the light"))]
    pub vignetting: f32,
    /// Exposure time, s: the image is blurred by the turn of the camera in this time.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub exposure_s: f32,
    /// Time between the exposures of the first and the last row (rolling shutter), s: while the camera turns, the rows above the middle show
    /// an earlier direction and those below it a later one. Labels and depth are displaced like the colours.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub readout_s: f32,
}

/// The direction of a robot's cameras at their last image.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub(crate) struct LastLook(Option<Look>);

#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
struct Look {
    cycle: u64,
    /// Yaw in the pitch frame, and pitch, radians.
    angles: Vec2,
}

impl LastLook {
    /// Returns the mean angular velocity since the last image, yaw and pitch, rad/s. `angles` is the direction in this cycle.
    pub fn turn(&mut self, cycle: u64, angles: Vec2, period: f32) -> Vec2 {
        let before = self.0.replace(Look { cycle, angles });
        let Some(before) = before.filter(|before| before.cycle < cycle) else { return Vec2::ZERO };
        let turned = angles - before.angles;
        Vec2::new(naoisis_core::geometry::wrap_angle(turned.x), turned.y) / ((cycle - before.cycle) as f32 * period)
    }
}

/// The effect of lens and exposure on one image.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct LensEffect {
    lens: Lens,
    /// The intrinsics of the final image.
    intrinsics: CameraIntrinsics,
    /// The motion of the image during the exposure, pixels.
    smear: Vec2,
    /// The motion of the image from the first row to the last, pixels.
    skew: Vec2,
}

/// Memory reused from image to image.
#[derive(Default)]
pub(crate) struct LensBuffer {
    copy: Image,
    /// The intrinsics for which `sources` were computed.
    of: Option<CameraIntrinsics>,
    /// The position of each pixel in the drawn image.
    sources: Vec<Vec2>,
}

impl Lens {
    /// The effect on an image with these `intrinsics`, while the camera turns at this speed (yaw and pitch, rad/s).
    pub(crate) fn effect(self, intrinsics: CameraIntrinsics, turn: Vec2) -> LensEffect {
        // A turn to the left moves the image to the right, a turn downwards moves it up.
        let speed = intrinsics.focal * Vec2::new(turn.x, -turn.y);
        LensEffect { lens: self, intrinsics, smear: self.exposure_s * speed, skew: self.readout_s * speed }
    }

    /// Returns whether images depend on the turn of the camera.
    pub(crate) fn sees_turns(self) -> bool {
        self.exposure_s > 0.0 || self.readout_s > 0.0
    }
}

impl LensEffect {
    /// Applies the effect to a drawn image.
    pub fn apply(&self, image: &mut Image, buffer: &mut LensBuffer) {
        if self.smear.abs().max_element() >= 1.0 {
            smear(image, &mut buffer.copy, self.smear);
        }
        if self.skew.abs().max_element() >= 1.0 {
            skew(image, &mut buffer.copy, self.skew);
        }
        if !self.intrinsics.is_pinhole() {
            self.distort(image, buffer);
        }
        if self.lens.vignetting > 0.0 {
            self.darken(image);
        }
    }

    fn distort(&self, image: &mut Image, buffer: &mut LensBuffer) {
        let LensBuffer { copy, of, sources } = buffer;
        let size = self.intrinsics.size;
        let [width, height] = [size.x as usize, size.y as usize];
        if *of != Some(self.intrinsics) {
            sources.clear();
            for index in 0..width * height {
                let pixel = Vec2::new((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
                sources.push(self.intrinsics.in_drawn(pixel));
            }
            *of = Some(self.intrinsics);
        }
        core::mem::swap(image, copy);
        image.clear();
        (image.width, image.height) = (width as u32, height as u32);
        for source in sources.iter() {
            image.rgb.extend(between_pixels(copy, *source));
            let [column, row] = nearest_pixel(copy, *source);
            let index = row * copy.width as usize + column;
            image.labels.extend(copy.labels.get(index));
            image.depth_m.extend(copy.depth_m.get(index));
        }
    }

    fn darken(&self, image: &mut Image) {
        let centre = self.intrinsics.size / 2.0;
        let lost = 256.0 * self.lens.vignetting.min(1.0) / centre.length_squared();
        let width = image.width.max(1) as usize;
        for (index, pixel) in image.rgb.chunks_exact_mut(3).enumerate() {
            let place = Vec2::new((index % width) as f32 + 0.5, (index / width) as f32 + 0.5);
            let left = 256 - (lost * place.distance_squared(centre)).min(256.0) as u32;
            for channel in pixel {
                *channel = ((u32::from(*channel) * left) >> 8) as u8;
            }
        }
    }
}

/// Averages each pixel along `way`, pixels, centred on it.
fn smear(image: &mut Image, copy: &mut Image, way: Vec2) {
    /// The greatest number of steps: more make no visible difference.
    const MOST_STEPS: f32 = 64.0;

    let steps = way.abs().max_element().ceil().min(MOST_STEPS) as i32;
    let offsets: Vec<[i32; 2]> = (0..=steps)
        .map(|step| {
            let offset = way * (step as f32 / steps as f32 - 0.5);
            [offset.x.round() as i32, offset.y.round() as i32]
        })
        .collect();
    let count = offsets.len() as u32;
    copy.rgb.clone_from(&image.rgb);
    let [width, height] = [image.width as i32, image.height as i32];
    for (index, pixel) in image.rgb.chunks_exact_mut(3).enumerate() {
        let [column, row] = [index as i32 % width, index as i32 / width];
        let mut sums = [count / 2; 3];
        for [right, down] in &offsets {
            let [column, row] = [(column + right).clamp(0, width - 1), (row + down).clamp(0, height - 1)];
            let first = 3 * (row * width + column) as usize;
            for (sum, channel) in sums.iter_mut().zip(&copy.rgb[first..first + 3]) {
                *sum += u32::from(*channel);
            }
        }
        for (channel, sum) in pixel.iter_mut().zip(sums) {
            *channel = (sum / count) as u8;
        }
    }
}

/// Moves each row by its share of `way`, pixels: the first by half of it backwards, the last by half of it forwards.
fn skew(image: &mut Image, copy: &mut Image, way: Vec2) {
    core::mem::swap(image, copy);
    image.clear();
    (image.width, image.height) = (copy.width, copy.height);
    let last_row = copy.height.max(2) as f32 - 1.0;
    for row in 0..copy.height {
        let offset = way * (row as f32 / last_row - 0.5);
        for column in 0..copy.width {
            let [column, row] = nearest_pixel(copy, Vec2::new(column as f32, row as f32) + 0.5 - offset);
            let index = row * copy.width as usize + column;
            image.rgb.extend(&copy.rgb[3 * index..3 * index + 3]);
            image.labels.extend(copy.labels.get(index));
            image.depth_m.extend(copy.depth_m.get(index));
        }
    }
}

/// The colour at a position in an image, interpolated between the four pixels around it.
fn between_pixels(image: &Image, place: Vec2) -> [u8; 3] {
    let corner = place - 0.5;
    let whole = corner.floor();
    let share = corner - whole;
    let colour = |right: f32, down: f32| {
        let [column, row] = nearest_pixel(image, whole + Vec2::new(right, down) + 0.5);
        image.colour(column as u32, row as u32).unwrap_or_default().map(f32::from)
    };
    let [above, above_right] = [colour(0.0, 0.0), colour(1.0, 0.0)];
    let [below, below_right] = [colour(0.0, 1.0), colour(1.0, 1.0)];
    core::array::from_fn(|channel| {
        let upper = above[channel] + share.x * (above_right[channel] - above[channel]);
        let lower = below[channel] + share.x * (below_right[channel] - below[channel]);
        (upper + share.y * (lower - upper)).round() as u8
    })
}

fn nearest_pixel(image: &Image, place: Vec2) -> [usize; 2] {
    // The casts saturate.
    let within = |place: f32, count: u32| (place as usize).min(count.saturating_sub(1) as usize);
    [within(place.x, image.width), within(place.y, image.height)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::to_radians;

    fn pinhole() -> CameraIntrinsics {
        CameraIntrinsics::new(Vec2::new(320.0, 240.0), to_radians(58.0))
    }

    /// An image of a pinhole that is grey, with a white dot around a pixel.
    fn dot(size: Vec2, at: Vec2) -> Image {
        let [width, height] = [size.x as usize, size.y as usize];
        let mut image =
            Image { width: width as u32, height: height as u32, rgb: vec![100; 3 * width * height], ..default() };
        let [column, row] = nearest_pixel(&image, at);
        for (u, v) in (column - 1..=column + 1).flat_map(|u| (row - 1..=row + 1).map(move |v| (u, v))) {
            image.rgb[3 * (v * width + u)..][..3].fill(255);
        }
        image
    }

    /// The middle of the pixels that are brighter than the rest.
    fn bright(image: &Image) -> Vec2 {
        let (mut sum, mut weights) = (Vec2::ZERO, 0.0);
        for (index, pixel) in image.rgb.chunks(3).enumerate() {
            let weight = f32::from(pixel[0].saturating_sub(100));
            let column = index % image.width as usize;
            sum += weight * Vec2::new(column as f32 + 0.5, (index / image.width as usize) as f32 + 0.5);
            weights += weight;
        }
        sum / weights
    }

    #[test]
    fn a_barrel_pulls_inwards_what_a_pinhole_sees() {
        let calibrated =
            |size, lens| CameraIntrinsics::calibrated(size, Vec2::new(350.0, 360.0), Vec2::new(164.0, 117.0), lens);
        for (k1, p1, is_calibrated) in [(-0.3, 0.0, false), (0.2, 0.0, false), (0.1, 0.01, true), (0.0, 0.0, true)] {
            let distortion = Distortion::new([k1, 0.05, 0.0], [p1, 0.0]);
            let plain = pinhole().with_distortion(distortion);
            let camera = if is_calibrated { calibrated(plain.size, distortion) } else { plain };
            let effect = Lens::default().effect(camera, Vec2::ZERO);
            let drawn = camera.drawn();
            assert_eq!(drawn.size.x > 320.0, k1 < 0.0 || is_calibrated);
            for slope in [Vec2::new(0.3, 0.2), Vec2::new(-0.35, 0.1), Vec2::new(0.05, -0.25)] {
                let mut image = dot(drawn.size, drawn.centre + drawn.focal_length * slope);
                let exact = (bright(&image) - drawn.centre) / drawn.focal_length;
                effect.apply(&mut image, &mut LensBuffer::default());
                assert_eq!((image.width, image.height, image.rgb.len()), (320, 240, 3 * 320 * 240));
                let expected = camera.pixel(exact);
                assert!(bright(&image).distance(expected) < 0.3, "{} {expected}", bright(&image));
            }
        }
    }

    #[test]
    fn corners_are_darker_by_the_share_and_the_middle_is_not() {
        let lens = Lens { vignetting: 0.4, ..default() };
        let mut image = Image { width: 320, height: 240, rgb: vec![200; 3 * 320 * 240], ..default() };
        lens.effect(pinhole(), Vec2::ZERO).apply(&mut image, &mut LensBuffer::default());
        let [middle, corner, side] = [(160, 120), (0, 0), (0, 120)].map(|(u, v)| image.colour(u, v).unwrap()[0]);
        // In the middle of the left edge, at 160 of 200 pixels: 0.64 * 0.4 are lost.
        assert!(middle == 200 && corner.abs_diff(120) <= 1 && side.abs_diff(149) <= 1, "{middle} {corner} {side}");
    }

    #[test]
    fn a_turn_during_the_exposure_smears_along_it() {
        let lens = Lens { exposure_s: 0.01, ..default() };
        let mut last = LastLook::default();
        assert_eq!(last.turn(3, Vec2::new(3.1, 0.0), 0.05), Vec2::ZERO);
        // 0.2 rad further, across the half turn, in two cycles: 2 rad/s.
        let turn = last.turn(5, Vec2::new(-2.983_185, 0.0), 0.05);
        assert!((turn.x - 2.0).abs() < 1e-3);
        let effect = lens.effect(pinhole(), turn);
        // 0.02 rad are 7.2 pixels: eight, with the one in the middle nine, of which three are white.
        let mut image = dot(pinhole().size, Vec2::new(100.5, 60.5));
        effect.apply(&mut image, &mut LensBuffer::default());
        let row: Vec<u8> = (90..112).map(|u| image.colour(u, 60).unwrap()[0]).collect();
        assert!((9..=11).contains(&row.iter().filter(|level| **level > 100).count()), "{row:?}");
        assert_eq!(image.colour(100, 58).unwrap(), [100; 3]);
        assert!((bright(&image) - Vec2::new(100.5, 60.5)).length() < 0.6);
        // With a rolling shutter it is also displaced: row 60 of 240 is read a quarter of the readout before the middle one.
        let rolling = Lens { readout_s: 0.05, ..default() };
        let mut image = dot(pinhole().size, Vec2::new(100.5, 60.5));
        rolling.effect(pinhole(), turn).apply(&mut image, &mut LensBuffer::default());
        let expected = Vec2::new(100.5 - 0.249 * 0.1 * pinhole().focal.x, 60.5);
        assert!(bright(&image).distance(expected) < 0.6, "{} {expected}", bright(&image));
        // Slow turns have no visible effect.
        let mut still = dot(pinhole().size, Vec2::new(100.5, 60.5));
        lens.effect(pinhole(), 0.1 * turn).apply(&mut still, &mut LensBuffer::default());
        assert_eq!(still, dot(pinhole().size, Vec2::new(100.5, 60.5)));
    }
}
