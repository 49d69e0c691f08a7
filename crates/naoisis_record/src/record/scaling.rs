//! Pictures in another size, by the cubic filter of Mitchell and Netravali (1988) with B = C = 1/3: between pixels it is
//! smooth, and edges stay sharp.

use core::ops::Range;
use pulp::Arch;

use naoisis_sensing::sensing::camera::image::Image;

/// The weights of four neighbours are in this many parts of a whole.
const WHOLE: i32 = 256;
/// Bits that numbers have more than a pixel's channel between the two directions.
const EXTRA_BITS: u32 = 6;

/// So many pixels beyond each edge are somebody's neighbours.
const BEYOND: usize = 2;

/// The four neighbours of a place between pixels.
#[derive(Clone, Copy, Debug)]
struct Neighbours {
    /// The first, counted from [`BEYOND`] before the first pixel: those beyond an edge are like the pixel at the edge.
    first: usize,
    /// How much each counts.
    weights: [i32; 4],
}

/// Calls `put` with every row of a picture, its number and the column of its first pixel and its colours, `scale` times as
/// large, with its top left corner at a place on an area of this size in pixels. What is beyond the area is left out.
pub(super) fn scaled(
    image: &Image,
    at: [f32; 2],
    scale: f32,
    size: [u32; 2],
    mut put: impl FnMut(usize, usize, &[u8]),
) {
    let [width, height] = [image.width, image.height].map(|side| side as usize);
    let [(columns, across), (rows, down)] =
        [(0, width), (1, height)].map(|(axis, count)| neighbours(count, at[axis], scale, size[axis] as usize));
    let (Some(top), Some(bottom)) = (down.first(), down.last()) else { return };
    if columns.is_empty() || image.rgb.len() < 3 * width * height {
        return;
    }
    Arch::new().dispatch(
        #[inline(always)]
        || {
            // The rows that count, scaled from left to right; each number has a place.
            let line = 3 * columns.len();
            let sources = top.first..bottom.first + 4;
            let mut lines = vec![0_i16; line * sources.len()];
            let mut padded = Vec::new();
            for (row, line) in sources.clone().zip(lines.chunks_exact_mut(line)) {
                let row = row.saturating_sub(BEYOND).min(height - 1);
                pad(&image.rgb[3 * width * row..3 * width * (row + 1)], &mut padded);
                scale_line(&padded, &across, line);
            }
            let mut colours = vec![0; line];
            for (row, Neighbours { first, weights }) in rows.zip(&down) {
                let from = (first - sources.start) * line;
                let above: [&[i16]; 4] = core::array::from_fn(|index| &lines[from + index * line..][..line]);
                mix(above, *weights, &mut colours);
                put(row, columns.start, &colours);
            }
        },
    );
}

/// Of every pixel in a range of `0..size`, the neighbours in a row of `count` pixels that is put at a place.
fn neighbours(count: usize, at: f32, scale: f32, size: usize) -> (Range<usize>, Vec<Neighbours>) {
    let place = |pixel: f32| (pixel.ceil().max(0.0) as usize).min(size);
    // Pixels whose middles are in the picture.
    let range = place(at - 0.5)..place(at + scale * count as f32 - 0.5);
    let neighbours = range.clone().map(|pixel| {
        let source = (pixel as f32 + 0.5 - at) / scale - 0.5;
        let before = source.floor().clamp(-1.0, count as f32 - 1.0);
        let share = (source - before).clamp(0.0, 1.0);
        let weight = |distance: f32| (cubic(distance) * WHOLE as f32).round() as i32;
        let [one, two, four] = [weight(1.0 + share), weight(share), weight(2.0 - share)];
        // Of even areas nothing is lost.
        let weights = [one, two, WHOLE - one - two - four, four];
        Neighbours { first: (before - 1.0 + BEYOND as f32) as usize, weights }
    });
    let neighbours = neighbours.collect();
    (range, neighbours)
}

/// The weight of a pixel at this distance, from 0 to 2.
fn cubic(x: f32) -> f32 {
    let sixths = if x < 1.0 {
        (7.0 * x - 12.0) * x * x + 16.0 / 3.0
    } else {
        ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0
    };
    sixths / 6.0
}

/// A row with the pixels at its edges [`BEYOND`] times more before and after.
fn pad(row: &[u8], padded: &mut Vec<u8>) {
    padded.clear();
    let [first, last] = [&row[..3], &row[row.len() - 3..]];
    (0..BEYOND).for_each(|_| padded.extend_from_slice(first));
    padded.extend_from_slice(row);
    (0..BEYOND).for_each(|_| padded.extend_from_slice(last));
}

#[inline(always)]
fn scale_line(padded: &[u8], across: &[Neighbours], line: &mut [i16]) {
    for (Neighbours { first, weights }, scaled) in across.iter().zip(line.as_chunks_mut::<3>().0) {
        let Some(pixels) = padded.get(3 * first..).and_then(|rest| rest.first_chunk::<12>()) else { continue };
        for channel in 0..3 {
            let sum: i32 = (0..4).map(|index| weights[index] * i32::from(pixels[3 * index + channel])).sum();
            scaled[channel] = (sum >> (WHOLE.ilog2() - EXTRA_BITS)) as i16;
        }
    }
}

#[inline(always)]
fn mix([one, two, three, four]: [&[i16]; 4], weights: [i32; 4], colours: &mut [u8]) {
    const BITS: u32 = WHOLE.ilog2() + EXTRA_BITS;
    let above = one.iter().zip(two).zip(three).zip(four);
    for (colour, (((one, two), three), four)) in colours.iter_mut().zip(above) {
        let sum = i32::from(*one) * weights[0]
            + i32::from(*two) * weights[1]
            + i32::from(*three) * weights[2]
            + i32::from(*four) * weights[3];
        *colour = ((sum + (1 << (BITS - 1))) >> BITS).clamp(0, 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The picture as rows of red, `scale` times as large, with its corner at a place on an area of 40 x 30 pixels.
    fn scaled_to(image: &Image, at: [f32; 2], scale: f32) -> Vec<(usize, usize, Vec<u8>)> {
        let mut rows = Vec::new();
        scaled(image, at, scale, [40, 30], |row, column, colours| {
            rows.push((row, column, colours.iter().copied().step_by(3).collect()));
        });
        rows
    }

    fn image(width: u32, height: u32, red: impl Fn(u32, u32) -> u8) -> Image {
        let places = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
        let rgb = places.flat_map(|(u, v)| [red(u, v), 0, 9]).collect();
        Image { width, height, rgb, ..Image::default() }
    }

    #[test]
    fn even_areas_stay_even_at_any_scale() {
        for scale in [0.4, 1.0, 1.7, 2.4] {
            let rows = scaled_to(&image(8, 6, |_, _| 77), [3.0, 2.0], scale);
            assert_eq!(rows.len(), (6.0 * scale).round() as usize);
            assert!(rows.iter().all(|(_, column, row)| *column == 3 && row.iter().all(|red| *red == 77)), "{rows:?}");
        }
    }

    #[test]
    fn a_slope_stays_a_slope() {
        // 10 more a pixel, 4 a pixel of the picture that is two and a half times as large: in the middle of pixel n, at
        // (n + 0.5) / 2.5 - 0.5 pixels of the first.
        let rows = scaled_to(&image(16, 4, |u, _| 40 + 10 * u as u8), [0.0, 0.0], 2.5);
        for (column, red) in rows[5].2.iter().enumerate().skip(5).take(30) {
            let expected = 40.0 + 10.0 * ((column as f32 + 0.5) / 2.5 - 0.5);
            assert!((f32::from(*red) - expected).abs() <= 1.0, "{column}: {red}, {expected}");
        }
    }

    #[test]
    fn what_is_beyond_the_area_is_left_out() {
        let rows = scaled_to(&image(8, 6, |u, _| 20 * u as u8), [-6.0, 26.0], 2.0);
        assert_eq!(
            rows.iter().map(|(row, column, colours)| (*row, *column, colours.len())).collect::<Vec<_>>(),
            [(26, 0, 10), (27, 0, 10), (28, 0, 10), (29, 0, 10)]
        );
        assert_eq!(scaled_to(&image(8, 6, |_, _| 1), [41.0, 0.0], 2.0), []);
    }
}
