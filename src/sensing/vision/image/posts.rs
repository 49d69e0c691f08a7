//! Goal posts: upright strips of a goal's colour.

use bevy::math::Vec2;

use super::Look;
use super::blobs::Run;
use super::colour::ColourClass;
use crate::pitch::GoalColour;
use crate::sensing::vision::GoalPostPercept;

/// Fewer rows are no post.
const LEAST_ROWS: u32 = 4;

/// Strips that are narrower on average are no posts, pixels.
const LEAST_WIDTH: f32 = 1.5;

/// A strip without a foot must be so many times as high as wide.
const LEAST_SLENDERNESS: f32 = 1.3;

/// A strip as wide as that may be a short piece of a near post, pixels.
const WIDE: f32 = 20.0;
/// It must be so many times as high as wide.
const LEAST_SLENDERNESS_OF_WIDE: f32 = 0.6;

/// The distance of a post cannot be told from its top when that is nearer than this to the height of the lens, m.
const LEAST_HEIGHT_DIFFERENCE_M: f32 = 0.1;

/// Rows below a strip that may be neither it nor the carpet, where its edge is blurred.
const BLURRED_ROWS: usize = 2;

/// Runs one below the other that are about as wide.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Strip {
    class: ColourClass,
    first: Run,
    last: Run,
    rows: u32,
    pixels: u32,
    /// Rows in which it does not reach the left or right edge of the image, and its pixels in those.
    whole_rows: u32,
    whole_pixels: u32,
}

impl Strip {
    fn new(class: ColourClass, run: Run) -> Self {
        Self { class, first: run, last: run, rows: 0, pixels: 0, whole_rows: 0, whole_pixels: 0 }
    }

    fn add(&mut self, run: Run, image_width: u16) {
        self.last = run;
        self.rows += 1;
        self.pixels += u32::from(run.width());
        if run.from > 0 && run.to < image_width {
            self.whole_rows += 1;
            self.whole_pixels += u32::from(run.width());
        }
    }

    fn mean_width(&self) -> f32 {
        self.pixels as f32 / self.rows as f32
    }

    /// Its width where it does not reach the edge of the image; none if it does in most rows.
    fn whole_width(&self) -> Option<f32> {
        (2 * self.whole_rows > self.rows).then(|| self.whole_pixels as f32 / self.whole_rows as f32)
    }
}

/// Memory for the strips of one image.
#[derive(Default)]
pub(super) struct Strips(Vec<Strip>);

impl Look<'_> {
    /// The goal posts, and whether their feet are seen.
    pub(super) fn find_posts(&self, strips: &mut Strips, found: &mut Vec<(bool, GoalPostPercept)>) {
        let classes = [(ColourClass::Yellow, GoalColour::Yellow), (ColourClass::SkyBlue, GoalColour::Blue)];
        for (class, colour) in classes {
            if !self.known.goal_colours.contains(&colour) {
                continue;
            }
            for blob in self.segmentation.blobs.iter().filter(|blob| blob.class == class && blob.area >= 10) {
                self.collect_strips(class, self.segmentation.runs(blob), &mut strips.0);
                for strip in &strips.0 {
                    let Some((has_foot, pixel, position_m)) = self.post(strip) else { continue };
                    let percept = GoalPostPercept { camera: self.side, colour, pixel, position_m };
                    insert(found, has_foot, percept);
                }
            }
        }
    }

    /// Follows the runs of a blob downwards.
    fn collect_strips(&self, class: ColourClass, runs: &[Run], strips: &mut Vec<Strip>) {
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
        strips.retain(|strip| strip.rows >= LEAST_ROWS && strip.mean_width() >= LEAST_WIDTH);
    }

    /// Whether a strip's foot is seen, its pixel, and its place.
    fn post(&self, strip: &Strip) -> Option<(bool, Vec2, Vec2)> {
        let foot = Vec2::new(strip.last.middle(), f32::from(strip.last.row + 1));
        if self.is_foot(strip)
            && let Some(front) = self.place(foot, 0.0)
            && let Some(place) = self.judge(strip, front, true)
        {
            return Some((true, self.view.clamp_to_image(foot), place));
        }
        let place = self.by_top(strip).or_else(|| self.by_width(strip))?;
        Some((false, self.view.project_anywhere(place.extend(0.0)), place))
    }

    /// The place of a post whose front is there, if its strip looks like one there: as upright and as wide.
    fn judge(&self, strip: &Strip, front: Vec2, has_foot: bool) -> Option<Vec2> {
        // What is seen of it is its front.
        let place = front + front.normalize_or(Vec2::X) * self.known.post_radius;
        let diameter = 2.0 * self.known.post_radius;
        let middle = f32::from(strip.first.row + strip.last.row + 1) / 2.0;
        let height = self.height_at(place, middle);
        let expected = self.view.intrinsics.focal_length * diameter / self.depth(place, height).max(diameter);
        let is_as_wide = match strip.whole_width() {
            Some(width) => width < 1.4 * expected + 1.0 && (!has_foot || width > 0.65 * expected - 1.0),
            None => strip.mean_width() < 1.5 * expected + 1.0,
        };
        let is_high = strip.rows as f32 > 0.4 * expected;
        (is_as_wide && is_high && self.is_upright(strip, place)).then_some(place)
    }

    /// How high above the ground a row of the image looks at an upright thing at this place, m.
    fn height_at(&self, place: Vec2, row: f32) -> f32 {
        let foot = self.view.camera_from_robot(place.extend(0.0));
        let up = self.view.camera_from_robot(place.extend(1.0)) - foot;
        // (foot.y + h up.y) / (foot.z + h up.z) is the slope of the row's rays.
        let slope = (row - self.view.intrinsics.centre.y) / self.view.intrinsics.focal_length;
        let height = (slope * foot.z - foot.y) / (up.y - slope * up.z);
        if height.is_finite() { height.clamp(0.0, self.known.post_height) } else { 0.0 }
    }

    /// Whether a strip runs as an upright thing at this place does.
    fn is_upright(&self, strip: &Strip, place: Vec2) -> bool {
        let ends = [strip.last.row, strip.first.row].map(|row| self.height_at(place, f32::from(row) + 0.5));
        let [low, high] = ends.map(|height| self.view.project_anywhere(place.extend(height)));
        let slope = if low.y - high.y > 1.0 { (low.x - high.x) / (low.y - high.y) } else { 0.0 };
        let off = strip.last.middle() - strip.first.middle() - slope * (strip.rows as f32 - 1.0);
        strip.whole_width().is_none() || off.abs() < 0.2 * strip.rows as f32 + 0.5 * strip.mean_width()
    }

    /// Where a post stands by its top, if that is seen.
    fn by_top(&self, strip: &Strip) -> Option<Vec2> {
        let height = self.known.post_height;
        if (height - self.view.lens.z).abs() < LEAST_HEIGHT_DIFFERENCE_M {
            return None;
        }
        let above = self.rows_above(strip)?;
        let from = usize::from(strip.first.row);
        if (above as f32) > 0.3 * strip.rows as f32 + 1.5 * strip.mean_width() {
            return None;
        }
        let top = self.place(Vec2::new(strip.first.middle(), (from - above) as f32), height)?;
        // A strip that is cut at the side has lost a part of its width; of others, that must be right too.
        let place = self.judge(strip, top, false)?;
        let seen = self.view.project_anywhere(place.extend(0.0)).y.min(self.height() as f32) - (from - above) as f32;
        let is_long_enough = (strip.rows + above as u32) as f32 > 0.25 * seen;
        (is_long_enough && strip.rows as f32 > strip.mean_width()).then_some(place)
    }

    /// Where a post stands by its width.
    fn by_width(&self, strip: &Strip) -> Option<Vec2> {
        let width = strip.whole_width().filter(|&width| width >= 3.0)?;
        // Of a near post only a short piece may be in the image; that is wide enough to be no bar.
        let least_slenderness = if width >= WIDE { LEAST_SLENDERNESS_OF_WIDE } else { LEAST_SLENDERNESS };
        if (strip.rows as f32) < least_slenderness * width || self.is_beside_white(strip) {
            return None;
        }
        let middle = Vec2::new(
            (strip.first.middle() + strip.last.middle()) / 2.0,
            f32::from(strip.first.row + strip.last.row + 1) / 2.0,
        );
        let distance = self.view.intrinsics.focal_length * 2.0 * self.known.post_radius / width;
        let point = self.view.lens + self.view.ray(middle) * distance;
        let place = point.truncate();
        // A post reaches from the ground to its top.
        let may_stand = (-0.2..self.known.post_height + 0.3).contains(&point.z)
            && place.length() < super::GREATEST_DISTANCE_M
            && self.is_upright(strip, place)
            && self.ends_at_top(strip, place);
        may_stand.then_some(place)
    }

    /// Whether a strip ends above where a post at this place does, or where the image does.
    fn ends_at_top(&self, strip: &Strip, place: Vec2) -> bool {
        let Some(above) = self.rows_above(strip) else { return true };
        let [top, foot] =
            [self.known.post_height, 0.0].map(|height| self.view.project_anywhere(place.extend(height)).y);
        let seen = f32::from(strip.first.row) - above as f32;
        (seen - top).abs() < 0.12 * (foot - top) + 3.0
    }

    /// How many rows of the same colour are above a strip, which may end where the bar begins; none if they reach the edge
    /// of the image.
    fn rows_above(&self, strip: &Strip) -> Option<usize> {
        let column = (strip.first.middle() as usize).min(self.width() - 1);
        let from = usize::from(strip.first.row);
        let above = (0..from).rev().take_while(|&row| self.class(column, row) == strip.class).count();
        (above < from).then_some(above)
    }

    /// Whether a robot may hide a side of a strip.
    fn is_beside_white(&self, strip: &Strip) -> bool {
        let row = usize::from(u16::midpoint(strip.first.row, strip.last.row));
        let column = (strip.first.middle() + strip.last.middle()) / 2.0;
        let class_at = |column: f32| {
            let column = (column.max(0.0) as usize).min(self.width() - 1);
            self.class(column, row)
        };
        let reach = strip.mean_width() / 2.0 + 2.0;
        [column - reach, column + reach].into_iter().any(|column| class_at(column) == ColourClass::White)
    }

    /// Whether the carpet is below a strip, or a line and then the carpet.
    fn is_foot(&self, strip: &Strip) -> bool {
        let column = (strip.last.middle() as usize).min(self.width() - 1);
        let below = usize::from(strip.last.row) + 1;
        let end = self.height().min(below + BLURRED_ROWS + strip.mean_width() as usize + 2);
        let mut other = 0;
        for row in below..end {
            match self.class(column, row) {
                ColourClass::Green => return true,
                // A line is not as wide as a post; a robot is.
                ColourClass::White => {}
                _ if other < BLURRED_ROWS => other += 1,
                _ => return false,
            }
        }
        false
    }
}

/// Puts the round ends of feet, where runs get narrower quickly, to the strips above them.
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

/// Adds a post, unless it is one that was found already: the better one stays.
fn insert(found: &mut Vec<(bool, GoalPostPercept)>, has_foot: bool, percept: GoalPostPercept) {
    let bearing = |place: Vec2| place.normalize_or(Vec2::X);
    let same = found.iter_mut().find(|(_, other)| {
        other.colour == percept.colour && bearing(other.position_m).dot(bearing(percept.position_m)) > 0.9985
    });
    match same {
        // Of two pieces of one post, that with the foot, or the nearer one.
        Some(other) if (has_foot, -percept.position_m.length()) > (other.0, -other.1.position_m.length()) => {
            *other = (has_foot, percept);
        }
        Some(_) => {}
        None => found.push((has_foot, percept)),
    }
}
