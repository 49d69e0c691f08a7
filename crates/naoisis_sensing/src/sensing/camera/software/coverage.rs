//! Anti-aliased areas of the ground, which may cover only a part of a pixel. A sensor integrates the light over each pixel: the colours are
//! mixed by the share that each covers, so that distant lines remain continuous. The label of a pixel is that of the area at its middle.

use bevy::math::ops;
use std::sync::LazyLock;

/// Number of sub-rows of a row of pixels; the middle one contains the pixels' middles. Along the row shares are exact.
pub(super) const SUB_ROWS: usize = 5;

/// The start and end of a span, in pixels; empty unless the end is greater than the start.
pub(super) type Span = [f32; 2];

/// The spans of an area in a row of pixels, one for each of its [`SUB_ROWS`].
pub(super) type Spans = [Span; SUB_ROWS];

/// No spans.
pub(super) const NOTHING: Spans = [[0.0; 2]; SUB_ROWS];

/// The transfer curve of sRGB, from levels to light and back.
pub(super) struct Levels {
    /// Light in 65535ths, by the level.
    light: [u16; 256],
    /// Levels, by the light in 4096ths.
    level: [u8; 4097],
}

static LEVELS: LazyLock<Levels> = LazyLock::new(|| {
    let light = |level: f32| if level <= 0.040_45 { level / 12.92 } else { ops::powf((level + 0.055) / 1.055, 2.4) };
    let level =
        |light: f32| if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * ops::powf(light, 1.0 / 2.4) - 0.055 };
    Levels {
        light: core::array::from_fn(|index| (light(index as f32 / 255.0) * 65535.0).round() as u16),
        level: core::array::from_fn(|index| (level(index as f32 / 4096.0).min(1.0) * 255.0).round() as u8),
    }
});

impl Levels {
    /// The shared curve.
    pub(super) fn get() -> &'static Levels {
        &LEVELS
    }

    /// The colour of a pixel of which the `share`, in 256ths, is covered by `before` and the rest shows `behind`.
    #[inline(always)]
    fn mix(&self, behind: u32, before: u32, share: u32) -> u32 {
        let mix = |shift: u32| {
            let [behind, before] =
                [behind, before].map(|pixel| u32::from(self.light[(pixel >> shift) as usize & 0xff]));
            let light = (behind * (256 - share) + before * share) >> 8;
            u32::from(self.level[((light + 8) >> 4) as usize]) << shift
        };
        mix(0) | mix(8) | mix(16)
    }
}

/// The ranges of pixels that spans touch, and that they cover completely.
#[derive(Clone, Copy)]
struct Extent {
    touched: [usize; 2],
    whole: [usize; 2],
}

impl Extent {
    #[inline(always)]
    fn of(spans: &Spans, width: usize) -> Self {
        let (mut least, mut latest, mut first_end, mut most) = (f32::INFINITY, 0.0_f32, f32::INFINITY, 0.0_f32);
        for &[from, to] in spans {
            if from < to {
                least = least.min(from);
                most = most.max(to);
                latest = latest.max(from);
                first_end = first_end.min(to);
            } else {
                first_end = 0.0;
            }
        }
        if least > most {
            return Self { touched: [0, 0], whole: [0, 0] };
        }
        let up = |place: f32| {
            let whole = place as usize;
            (whole + usize::from((whole as f32) < place)).min(width)
        };
        let touched = [least as usize, up(most)];
        let from = up(latest);
        let to = (first_end as usize).min(width).max(from);
        Self { touched, whole: [from, to] }
    }
}

#[inline(always)]
fn is_in([from, to]: [usize; 2], pixel: usize) -> bool {
    from <= pixel && pixel < to
}

/// Paints the part of a row of pixels that an area covers, except its holes. All spans lie within the row.
#[inline(always)]
pub(super) fn paint(pixels: &mut [u32], area: &Spans, holes: &[Spans], paint: u32, levels: &Levels) {
    /// The greatest number of ends of an area and two holes.
    const MOST_ENDS: usize = 12;

    let width = pixels.len();
    let extent = Extent::of(area, width);
    if extent.touched[0] >= extent.touched[1] {
        return;
    }
    let mut hole_extents = [Extent { touched: [0, 0], whole: [0, 0] }; 2];
    let mut ends = [usize::MAX; MOST_ENDS];
    let mut count = 0;
    let mut add = |extent: &Extent| {
        for end in extent.touched.into_iter().chain(extent.whole) {
            // As there are few ends, they are sorted by insertion.
            let mut place = count;
            while place > 0 && ends[place - 1] > end {
                ends[place] = ends[place - 1];
                place -= 1;
            }
            ends[place] = end;
            count += 1;
        }
    };
    add(&extent);
    for (hole, spans) in hole_extents.iter_mut().zip(holes) {
        *hole = Extent::of(spans, width);
        add(hole);
    }
    for index in 1..count {
        let [from, to] = [ends[index - 1], ends[index]];
        if from >= to || !is_in(extent.touched, from) || hole_extents.iter().any(|hole| is_in(hole.whole, from)) {
            continue;
        }
        if is_in(extent.whole, from) && !hole_extents.iter().any(|hole| is_in(hole.touched, from)) {
            pixels[from..to].fill(paint);
            continue;
        }
        for (column, pixel) in pixels[from..to].iter_mut().enumerate() {
            let left = (from + column) as f32;
            let share = holes.iter().fold(share_of(area, left), |share, hole| share - share_of(hole, left));
            let is_label = |spans: &Spans| {
                let [from, to] = spans[SUB_ROWS / 2];
                from <= left + 0.5 && left + 0.5 < to
            };
            let label = if is_label(area) && !holes.iter().any(is_label) { paint } else { *pixel } & 0xff00_0000;
            let share = (share * (256.0 / SUB_ROWS as f32) + 0.5) as u32;
            *pixel = levels.mix(*pixel, paint, share.min(256)) | label;
        }
    }
}

/// The share of the pixel at `left` that spans cover, in sub-rows.
#[inline(always)]
fn share_of(spans: &Spans, left: f32) -> f32 {
    let mut sum = 0.0;
    for &[from, to] in spans {
        let from = if from > left { from } else { left };
        let to = if to < left + 1.0 { to } else { left + 1.0 };
        sum += if to > from { to - from } else { 0.0 };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: u32 = 0x02ff_ffff;
    const BLACK: u32 = 0x0100_0000;

    fn painted(area: Spans, holes: &[Spans]) -> [u32; 10] {
        let mut pixels = [BLACK; 10];
        paint(&mut pixels, &area, holes, WHITE, Levels::get());
        pixels
    }

    #[test]
    fn whole_pixels_have_the_colour_and_others_the_light_of_their_share() {
        let pixels = painted([[1.5, 4.25]; 5], &[]);
        assert_eq!(pixels[2..4], [WHITE; 2]);
        assert_eq!((pixels[0], pixels[5]), (BLACK, BLACK));
        // Half the light is level 188, a quarter 137. The middle of pixel 1 belongs to the area, that of pixel 4 does not.
        assert_eq!((pixels[1], pixels[4]), (0x02bc_bcbc, 0x0189_8989));
    }

    #[test]
    fn a_line_thinner_than_a_row_is_as_bright_all_along() {
        let mut area = NOTHING;
        area[3] = [0.0, 10.0];
        // A fifth of the light, in 256ths: 51.
        assert_eq!(painted(area, &[]), [0x017b_7b7b; 10]);
    }

    #[test]
    fn holes_stay_as_they_were() {
        let pixels = painted([[0.0, 10.0]; 5], &[[[2.0, 5.5]; 5], [[8.0, 9.0]; 5]]);
        let bright: Vec<bool> = pixels.iter().map(|pixel| *pixel == WHITE).collect();
        assert_eq!(bright, [true, true, false, false, false, false, true, true, false, true]);
        assert_eq!((pixels[3], pixels[8], pixels[5] & 0xff), (BLACK, BLACK, 188));
    }

    #[test]
    fn no_light_and_all_light_leave_levels_as_they_are() {
        for level in 0..256 {
            let grey = level << 16 | level << 8 | level;
            assert_eq!(Levels::get().mix(grey, 0, 0), grey);
            assert_eq!(Levels::get().mix(0, grey, 256), grey);
        }
    }
}
