//! Writes images as PNG files: their colours, labels or distances.

use std::io::{self, BufWriter};
use std::path::Path;

use naoisis_core::replace_file::replace_file;
use naoisis_sensing::appearance::Label;
use naoisis_sensing::sensing::camera::image::Image;

/// The layer of an image that is written to a PNG file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Layer {
    /// Its colours.
    Colours,
    /// The [`Label`] of each pixel, as an index into a palette of distinct colours.
    Labels,
    /// The distance of each pixel, mm in 16 bits: at most 65535, and 0 for the sky.
    Depth,
}

/// Writes a layer of an image as a PNG file, which replaces an earlier file.
///
/// # Errors
/// Errors of the file system.
pub fn write_png(path: &Path, layer: Layer, image: &Image) -> io::Result<()> {
    replace_file(path, |file| encode_png(BufWriter::new(file), layer, image))
}

/// Writes a layer of an image as PNG.
///
/// # Errors
/// Errors of the writer.
pub fn encode_png(out: impl io::Write, layer: Layer, image: &Image) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, image.width, image.height);
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

/// Colours of the labels, in the order of their numbers.
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
    [150, 110, 160], // thing beside the pitch
    [200, 160, 120], // person
];

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::default;
    use std::fs::File;
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
}
