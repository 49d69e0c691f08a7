//! Strips: runs of one colour below each other, as upright objects form them in an image.

use super::Look;
use super::blobs::Run;
use super::colour::ColourClass;

/// The least number of rows of a post.
const LEAST_ROWS: u32 = 4;

/// The least mean width of a post, pixels, unless it is cut off at the side of the image.
const LEAST_WIDTH: f32 = 1.5;
/// The least number of rows of a strip that is narrower because it is cut off.
const LEAST_ROWS_OF_NARROW: u32 = 12;

/// The least ratio of height to width of a strip without a foot.
pub(super) const LEAST_SLENDERNESS: f32 = 1.3;

/// The movement of a strip's middle from which it is a slanting bar, columns per row.
const SLANT: f32 = 0.6;
/// The movement below which a slanting bar has ended and the post below it begins, columns per row.
const END_OF_SLANT: f32 = 0.45;
/// The weight of the newest row in the mean movement.
const WEIGHT_OF_ROW: f32 = 0.2;

/// The width, as a multiple of that of the white strip, from which a run contains an object that touches the strip from the side.
const TOUCHED: f32 = 1.4;
/// The displacement from one row to the next, in widths of the strip, from which a run contains such an object.
const ASIDE: f32 = 0.2;
/// The greatest number of successive rows that may be touched, in addition to one and a half times the width of the strip.
const ROWS_TOUCHED: u32 = 3;

/// The least number of rows from which the slope of a strip is computed.
const ROWS_FOR_SLOPE: u16 = 8;
/// Rows at least this many times as wide as a white strip are not counted for its width.
const WIDENED: f32 = 1.1;

/// Runs of about the same width below each other.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Strip {
    pub(super) class: ColourClass,
    pub(super) first: Run,
    pub(super) last: Run,
    /// The last run that was not touched.
    clear: Run,
    pub(super) rows: u32,
    pixels: u32,
    /// The number of rows that do not reach the left or right edge of the image.
    whole_rows: u32,
    /// The number of these rows that are counted for its width, and their pixels.
    counted_rows: u32,
    counted_pixels: u32,
    pub(super) widest: u16,
    /// The mean movement of its middle in the last rows, columns per row, and whether the strip is a slanting bar.
    movement: f32,
    is_slanting: bool,
}

impl Strip {
    fn new(class: ColourClass, run: Run) -> Self {
        Self {
            class,
            first: run,
            last: run,
            clear: run,
            rows: 0,
            pixels: 0,
            whole_rows: 0,
            counted_rows: 0,
            counted_pixels: 0,
            widest: 0,
            movement: 0.0,
            is_slanting: false,
        }
    }

    fn add(&mut self, run: Run, image_width: u16) {
        self.movement += WEIGHT_OF_ROW * (run.middle() - self.last.middle() - self.movement);
        // Strings of nets also move the middle of white strips.
        let is_bar = self.class != ColourClass::White && self.movement.abs() > SLANT;
        if is_bar {
            self.is_slanting = true;
        } else if self.is_slanting && self.movement.abs() < END_OF_SLANT {
            *self = Self::new(self.class, run);
        }
        (self.last, self.clear) = (run, run);
        self.rows += 1;
        self.pixels += u32::from(run.width());
        self.widest = self.widest.max(run.width());
        if run.from > 0 && run.to < image_width {
            self.whole_rows += 1;
            let is_widened = self.class == ColourClass::White
                && self.counted_rows > 0
                && f32::from(run.width()) > WIDENED * (self.counted_pixels as f32 / self.counted_rows as f32) + 1.0;
            if !is_widened {
                self.counted_rows += 1;
                self.counted_pixels += u32::from(run.width());
            }
        }
    }

    /// Adds the part of a touched run that continues the strip.
    fn go_on_behind(&mut self, run: Run, image_width: u16) {
        let rows = self.clear.row - self.first.row;
        let slope =
            if rows >= ROWS_FOR_SLOPE { (self.clear.middle() - self.first.middle()) / f32::from(rows) } else { 0.0 };
        let half = f32::from(self.clear.width()) / 2.0;
        let middle = self.clear.middle() + slope * f32::from(run.row - self.clear.row);
        let mut own = run;
        own.from = ((middle - half).round().max(0.0) as u16).max(run.from);
        own.to = ((middle + half).round().max(0.0) as u16).min(run.to);
        let clear = self.clear;
        if own.from < own.to {
            self.add(own, image_width);
        }
        self.clear = clear;
    }

    /// The slope of the strip, columns per row.
    pub(super) fn slope(&self) -> f32 {
        (self.last.middle() - self.first.middle()) / f32::from((self.last.row - self.first.row).max(1))
    }

    pub(super) fn mean_width(&self) -> f32 {
        self.pixels as f32 / self.rows as f32
    }

    /// The width of the strip in rows that do not reach the edge of the image; `None` if most rows reach it.
    pub(super) fn whole_width(&self) -> Option<f32> {
        (2 * self.whole_rows > self.rows).then(|| self.counted_pixels as f32 / self.counted_rows as f32)
    }
}

/// Memory for the strips of one image.
#[derive(Default)]
pub(super) struct Strips {
    pub(super) strips: Vec<Strip>,
    /// The white runs.
    pub(super) runs: Vec<Run>,
}

impl Look<'_> {
    /// Follows the runs of a blob downwards.
    pub(super) fn collect_strips(&self, class: ColourClass, runs: &[Run], strips: &mut Vec<Strip>) {
        strips.clear();
        let width = self.width() as u16;
        for run in runs {
            let above = strips.iter_mut().find(|strip| {
                let last = strip.last;
                let (mean, here) = (strip.mean_width(), f32::from(run.width()));
                last.row + 1 == run.row
                    && last.from < run.to
                    && run.from < last.to
                    && here < 1.6 * mean + 2.0
                    && mean < 1.6 * here + 2.0
            });
            match above {
                Some(strip) => strip.add(*run, width),
                None => {
                    let mut strip = Strip::new(class, *run);
                    strip.add(*run, width);
                    strips.push(strip);
                }
            }
        }
        round_off(strips);
        strips.retain(|strip| {
            let is_cut_off = strip.whole_width().is_none() && strip.rows >= LEAST_ROWS_OF_NARROW;
            strip.rows >= LEAST_ROWS && (strip.mean_width() >= LEAST_WIDTH || is_cut_off)
        });
    }

    /// Follows white runs downwards. Nets, bars and lines touch white posts from the side.
    pub(super) fn collect_white_strips(&self, runs: &[Run], strips: &mut Vec<Strip>) {
        strips.clear();
        let width = self.width() as u16;
        // Strips that may continue, from the left, with the number of touched rows.
        let (mut above, mut here): (Vec<(usize, u32)>, Vec<(usize, u32)>) = (Vec::new(), Vec::new());
        for row in runs.chunk_by(|one, other| one.row == other.row) {
            above.retain(|(index, _)| strips[*index].last.row + 1 == row[0].row);
            here.clear();
            let mut next = 0;
            for run in row {
                while next < above.len() && strips[above[next].0].last.to <= run.from {
                    next += 1;
                }
                let mut goes_on = false;
                for &(index, touched) in &above[next..] {
                    let strip = &mut strips[index];
                    if strip.last.from >= run.to {
                        break;
                    }
                    let mean = strip.mean_width();
                    if strip.last.row == run.row
                        || strip.last.to <= run.from
                        || mean > TOUCHED * f32::from(run.width()) + 1.0
                    {
                        continue;
                    }
                    let aside = (run.middle() - strip.last.middle()).abs();
                    let is_touched = f32::from(run.width()) > TOUCHED * mean + 1.0 || aside > ASIDE * mean + 1.0;
                    let shared = run.to.min(strip.last.to) - run.from.max(strip.last.from);
                    if 2 * shared < strip.last.width() {
                        continue;
                    }
                    if !is_touched {
                        strip.add(*run, width);
                        here.push((index, 0));
                        goes_on = true;
                    } else if touched < ROWS_TOUCHED + (1.5 * mean) as u32 {
                        strip.go_on_behind(*run, width);
                        here.push((index, touched + 1));
                    }
                }
                if !goes_on {
                    let mut strip = Strip::new(ColourClass::White, *run);
                    strip.add(*run, width);
                    here.push((strips.len(), 0));
                    strips.push(strip);
                }
            }
            here.sort_unstable_by_key(|(index, _)| strips[*index].last.from);
            core::mem::swap(&mut above, &mut here);
        }
        strips.retain(|strip| {
            let mean = strip.mean_width();
            strip.rows >= LEAST_ROWS && mean >= LEAST_WIDTH && strip.rows as f32 >= LEAST_SLENDERNESS * mean
        });
    }
}

/// Joins the round ends of feet, where runs quickly become narrower, to the strips above them.
fn round_off(strips: &mut [Strip]) {
    for index in 1..strips.len() {
        let (before, rest) = strips.split_at_mut(index);
        let end = rest[0];
        let above = before.iter_mut().find(|strip| {
            let width = strip.mean_width();
            strip.last.row + 1 == end.first.row
                && (end.rows as f32) < 0.5 * width + 2.0
                && strip.rows > end.rows
                && (strip.last.middle() - end.first.middle()).abs() < 0.15 * width + 1.0
        });
        if let Some(strip) = above {
            strip.last = end.last;
            strip.rows += end.rows;
            strip.pixels += end.pixels;
        }
    }
}
