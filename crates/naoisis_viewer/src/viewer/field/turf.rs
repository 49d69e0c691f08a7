//! The picture of the carpet: mown stripes and the uneven colour of turf.

use bevy::asset::RenderAssetUsages;
use bevy::image::{ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

use naoisis_core::pitch::Pitch;
use naoisis_sensing::appearance::{colours, turf};

/// The wanted side of a pixel of the picture, m.
const PIXEL_M: f32 = 0.02;
/// The greatest width and height of the picture, pixels.
const MOST_PIXELS: u32 = 2048;
/// The number of mown stripes between the goal lines. It is even, so that stripes meet at the halfway line.
const STRIPES: f32 = 12.0;
/// How much brighter and darker than the carpet the stripes are, as a share.
const CONTRAST: f32 = 0.045;
/// The least unevenness that is drawn. Robots' cameras see that of the pitch.
const LEAST_UNEVENNESS: f32 = 0.08;

/// Returns the picture of the whole carpet, with +x of the pitch frame to the right and +y up, and with smaller
/// versions for places far away.
pub(super) fn picture(pitch: &Pitch) -> Image {
    let size_m = 2.0 * pitch.carpet_half_extents();
    let size = (size_m / PIXEL_M).ceil().as_uvec2().clamp(UVec2::ONE, UVec2::splat(MOST_PIXELS));
    let pixel_m = size_m / size.as_vec2();
    let places = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y).as_vec2() + 0.5));
    let whole: Vec<[u8; 4]> =
        places.map(|pixel| colour((pixel * pixel_m - size_m / 2.0) * Vec2::new(1.0, -1.0), pitch)).collect();
    let mut image = Image::new(
        Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        TextureDimension::D2,
        whole.as_flattened().to_vec(),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    let levels = smaller_versions(whole, size);
    image.texture_descriptor.mip_level_count += levels.len() as u32;
    if let Some(data) = &mut image.data {
        data.extend(levels.concat().as_flattened());
    }
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::ClampToEdge,
        address_mode_v: ImageAddressMode::ClampToEdge,
        anisotropy_clamp: 4,
        mipmap_filter: ImageFilterMode::Linear,
        ..ImageSamplerDescriptor::linear()
    });
    image
}

/// Returns the colour of the carpet at a place, m, pitch frame, as sRGB with alpha.
fn colour(place: Vec2, pitch: &Pitch) -> [u8; 4] {
    let unevenness = pitch.unevenness.max(LEAST_UNEVENNESS);
    let brightness = stripe(place.x, pitch) * turf::brightness(place, PIXEL_M, unevenness);
    let [red, green, blue] = colours::CARPET.0.map(|channel| (f32::from(channel) * brightness).round() as u8);
    [red, green, blue, u8::MAX]
}

/// Returns the brightness of the mown stripe at `x_m`, as a multiple of that of the carpet.
fn stripe(x_m: f32, pitch: &Pitch) -> f32 {
    let index = (x_m / (pitch.length_m / STRIPES)).floor() as i32;
    if index.rem_euclid(2) == 0 { 1.0 + CONTRAST } else { 1.0 - CONTRAST }
}

/// Returns versions of a picture of this size with half the pixels along each side, down to a single pixel.
fn smaller_versions(whole: Vec<[u8; 4]>, mut size: UVec2) -> Vec<Vec<[u8; 4]>> {
    let mut versions = Vec::new();
    let mut last = whole;
    while size.max_element() > 1 {
        let half = (size / 2).max(UVec2::ONE);
        let mean = |x: u32, y: u32| {
            let of = |dx: u32, dy: u32| {
                let pixel = (UVec2::new(2 * x + dx, 2 * y + dy)).min(size - 1);
                last[(pixel.y * size.x + pixel.x) as usize].map(u16::from)
            };
            let [a, b, c, d] = [of(0, 0), of(1, 0), of(0, 1), of(1, 1)];
            core::array::from_fn(|channel| ((a[channel] + b[channel] + c[channel] + d[channel] + 2) / 4) as u8)
        };
        last = (0..half.y).flat_map(|y| (0..half.x).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect();
        versions.push(last.clone());
        size = half;
    }
    versions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_meet_at_the_halfway_line_and_are_as_bright_as_the_carpet_on_average() {
        let pitch = Pitch::default();
        let width_m = pitch.length_m / STRIPES;
        assert!(stripe(-0.01, &pitch) < 1.0 && stripe(0.01, &pitch) > 1.0);
        assert_eq!(stripe(0.5 * width_m, &pitch), stripe(2.5 * width_m, &pitch));
        let mean = (0..12).map(|index| stripe((index as f32 + 0.5) * width_m, &pitch)).sum::<f32>() / 12.0;
        assert!((mean - 1.0).abs() < 1e-6);
    }

    #[test]
    fn smaller_versions_keep_the_mean_and_end_with_one_pixel() {
        let whole = vec![[0, 100, 200, 255], [100, 100, 200, 255], [100, 100, 200, 255], [200, 100, 200, 255]];
        assert_eq!(smaller_versions(whole, UVec2::new(2, 2)), [[[100, 100, 200, 255]]]);
        let sizes: Vec<usize> =
            smaller_versions(vec![[0; 4]; 35], UVec2::new(7, 5)).iter().map(|level| level.len()).collect();
        assert_eq!(sizes, [6, 1]);
    }

    #[test]
    fn a_picture_has_the_pixels_of_all_its_versions() {
        let adult = Pitch { length_m: 104.0, width_m: 68.0, ..Pitch::default() };
        for pitch in [Pitch::default(), adult] {
            let image = picture(&pitch);
            let Extent3d { width, height, .. } = image.texture_descriptor.size;
            assert!(width <= MOST_PIXELS && height <= MOST_PIXELS);
            let pixels: u32 = (0..image.texture_descriptor.mip_level_count)
                .map(|level| (width >> level).max(1) * (height >> level).max(1))
                .sum();
            assert_eq!(image.data.unwrap().len(), 4 * pixels as usize);
        }
    }
}
