//! Reads drawn textures back from the graphics card into images.

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor, Extent3d, MapMode, TexelCopyBufferInfo,
    TexelCopyBufferLayout, TextureDimension, TextureFormat, TextureUsages,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::texture::GpuImage;

use super::material::MOST_DEPTH_M;
use super::{Camera3, GpuError};
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::Image;

/// Returns a texture to draw into, of `size` samples.
pub(super) fn texture(size: UVec2) -> bevy::image::Image {
    let extent = Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
    let usages = RenderAssetUsages::RENDER_WORLD;
    let format = TextureFormat::Rgba8UnormSrgb;
    let mut image = bevy::image::Image::new_uninit(extent, TextureDimension::D2, format, usages);
    image.texture_descriptor.usage =
        TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC | TextureUsages::RENDER_ATTACHMENT;
    image
}

/// Returns the pixels of the cameras' textures, four bytes each, without gaps.
pub(super) fn read_back(render: &World, cameras: &mut [Camera3]) -> Result<Vec<Vec<u8>>, GpuError> {
    let device = render.resource::<RenderDevice>().clone();
    let queue = render.resource::<RenderQueue>().clone();
    let images = render.resource::<RenderAssets<GpuImage>>();
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: Some("read back") });
    for camera in &mut *cameras {
        let Some(image) = images.get(&camera.target) else {
            return Err(GpuError::Failed("a texture is not there".to_owned()));
        };
        let stride = RenderDevice::align_copy_bytes_per_row(4 * camera.size.x as usize) as u32;
        let buffer = camera.buffer.get_or_insert_with(|| {
            device.create_buffer(&BufferDescriptor {
                label: Some("picture"),
                size: u64::from(stride) * u64::from(camera.size.y),
                usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        encoder.copy_texture_to_buffer(
            image.texture.as_image_copy(),
            TexelCopyBufferInfo {
                buffer,
                layout: TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(stride), rows_per_image: None },
            },
            Extent3d { width: camera.size.x, height: camera.size.y, depth_or_array_layers: 1 },
        );
    }
    queue.submit([encoder.finish()]);
    let buffers: Vec<&Buffer> = cameras.iter().filter_map(|camera| camera.buffer.as_ref()).collect();
    let (sender, results) = std::sync::mpsc::channel();
    for buffer in &buffers {
        let sender = sender.clone();
        buffer.slice(..).map_async(MapMode::Read, move |result| {
            let _ = sender.send(result);
        });
    }
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| GpuError::Failed(error.to_string()))?;
    for result in results.try_iter() {
        result.map_err(|error| GpuError::Failed(error.to_string()))?;
    }
    let mut pictures = Vec::with_capacity(cameras.len());
    for (camera, buffer) in cameras.iter().zip(buffers) {
        let row = 4 * camera.size.x as usize;
        let stride = RenderDevice::align_copy_bytes_per_row(row);
        let mapped = buffer.slice(..).get_mapped_range();
        let mut picture = Vec::with_capacity(row * camera.size.y as usize);
        for line in mapped.chunks_exact(stride) {
            picture.extend_from_slice(&line[..row]);
        }
        drop(mapped);
        buffer.unmap();
        pictures.push(picture);
    }
    Ok(pictures)
}

/// Fills the colours of an image.
pub(super) fn take_colours(samples: &[u8], view: &View, image: &mut Image) {
    let [width, height] = view.size();
    let count = view.supersampling.max(1) as usize;
    (image.width, image.height) = (width as u32, height as u32);
    image.rgb.clear();
    let sample = |column: usize, row: usize| {
        let first = 4 * (row * width * count + column);
        &samples[first..first + 4]
    };
    for row in 0..height {
        for column in 0..width {
            let mut sums = [(count * count / 2) as u32; 3];
            for down in 0..count {
                for right in 0..count {
                    let sample = sample(column * count + right, row * count + down);
                    for (sum, channel) in sums.iter_mut().zip(sample) {
                        *sum += u32::from(*channel);
                    }
                }
            }
            image.rgb.extend(sums.map(|sum| (sum / (count * count) as u32) as u8));
        }
    }
}

/// Fills the labels of an image.
pub(super) fn take_labels(samples: &[u8], view: &View, image: &mut Image) {
    let [width, height] = view.size();
    let count = view.supersampling.max(1) as usize;
    image.labels.clear();
    for row in 0..height {
        for column in 0..width {
            // The label of a pixel is that of its middle sample.
            let [column, row] = [column, row].map(|place| place * count + count / 2);
            image.labels.push(samples[4 * (row * width * count + column) + 3]);
        }
    }
}

/// Fills the distances of an image.
pub(super) fn take_depth(samples: &[u8], view: &View, image: &mut Image) {
    let [width, height] = view.size();
    let count = view.supersampling.max(1) as usize;
    image.depth_m.clear();
    for row in 0..height {
        for column in 0..width {
            let first = 4 * ((row * count + count / 2) * width * count + column * count + count / 2);
            let steps = u32::from_le_bytes([samples[first], samples[first + 1], samples[first + 2], 0]);
            image.depth_m.push(steps as f32 / 16_777_215.0 * MOST_DEPTH_M);
        }
    }
}
