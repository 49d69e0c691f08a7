//! Detection of goal posts: upright strips of a goal's colour.
//!
//! Lines and robots are white, too. A white strip is a post only if it has nearly the full height of a post, as far as that is in the image.

use bevy::math::Vec2;

use super::Look;
use super::blobs::Run;
use super::colour::ColourClass;
use super::strips::{LEAST_SLENDERNESS, Strip, Strips};
use crate::sensing::vision::GoalPostPercept;
use naoisis_core::pitch::GoalColour;

/// The width from which a short piece of a near post suffices, pixels.
const WIDE: f32 = 20.0;
/// The least ratio of height to width of such a piece.
const LEAST_SLENDERNESS_OF_WIDE: f32 = 0.6;

/// The greatest distance of a post that is located by one side, m.
const GREATEST_DISTANCE_BY_SIDE_M: f32 = 1.5;
/// The least width of the strip of such a post, pixels.
const LEAST_WIDTH_BY_SIDE: u16 = 6;

/// The tolerance of the width of a white strip, as a share of the expected width; a pixel is added.
const WIDTH_OF_WHITE: f32 = 0.3;
/// The least share of the expected height of a white post in the image.
const LEAST_OF_WHITE: f32 = 0.8;

/// The number of rows in which robots beside a strip are searched for.
const ROWS_BESIDE: u16 = 8;

/// The least difference between the heights of a post's top and of the lens at which the distance follows from the top, m.
const LEAST_HEIGHT_DIFFERENCE_M: f32 = 0.1;

/// The number of blurred rows between a strip and the carpet.
const BLURRED_ROWS: usize = 2;

impl Look<'_> {
    /// Finds goal posts, and whether their feet are in the image.
    pub(super) fn find_posts(&self, strips: &mut Strips, found: &mut Vec<(bool, GoalPostPercept)>) {
        let Strips { strips, runs } = strips;
        let classes = [(ColourClass::Yellow, GoalColour::Yellow), (ColourClass::SkyBlue, GoalColour::Blue)];
        for (class, colour) in classes {
            if !self.model.goal_colours.contains(&colour) {
                continue;
            }
            for blob in self.segmentation.blobs.iter().filter(|blob| blob.class == class && blob.area >= 10) {
                self.collect_strips(class, self.segmentation.runs(blob), strips);
                self.add_posts(colour, strips, found);
            }
        }
        if self.model.goal_colours.contains(&GoalColour::White) {
            self.segmentation.runs_of(ColourClass::White, runs);
            self.collect_white_strips(runs, strips);
            self.add_posts(GoalColour::White, strips, found);
        }
    }

    fn add_posts(&self, colour: GoalColour, strips: &[Strip], found: &mut Vec<(bool, GoalPostPercept)>) {
        for strip in strips {
            let post = if colour == GoalColour::White { self.white_post(strip) } else { self.post(strip) };
            if let Some((has_foot, pixel, position_m)) = post {
                insert(found, has_foot, GoalPostPercept::new(self.camera, colour, pixel, position_m));
            }
        }
    }

    /// Like [`Look::post`], for a white strip, which must have the height of a post at that position.
    fn white_post(&self, strip: &Strip) -> Option<(bool, Vec2, Vec2)> {
        let is_cut_above = strip.first.row == 0;
        let is_cut_below = usize::from(strip.last.row) + 1 == self.height();
        let (has_foot, pixel, place) = if is_cut_below {
            let place = if is_cut_above { self.by_width(strip)? } else { self.by_top(strip)? };
            (false, self.view.project_anywhere(place.extend(0.0)), place)
        } else {
            self.post(strip).filter(|(has_foot, ..)| *has_foot)?
        };
        // A nearer robot, or a line that leads away, may have the same height.
        let diameter = 2.0 * self.model.post_radius;
        let middle = f32::from(strip.first.row + strip.last.row + 1) / 2.0;
        let expected =
            self.view.intrinsics.focal.x * diameter / self.depth(place, self.height_at(place, middle)).max(diameter);
        let tolerance = WIDTH_OF_WHITE * expected + 1.0;
        let is_as_wide = match strip.whole_width() {
            Some(width) => (across(strip, width) - expected).abs() < tolerance,
            // One side of the strip is outside the image.
            None => (0.4 * expected..expected + tolerance).contains(&across(strip, strip.mean_width())),
        };
        let [top, foot] =
            [self.model.post_height, 0.0].map(|height| self.view.project_anywhere(place.extend(height)).y);
        let in_image = foot.min(self.height() as f32) - top.max(0.0);
        let is_as_high = strip.rows as f32 > LEAST_OF_WHITE * in_image;
        (is_as_wide && is_as_high && self.ends_at_top(strip, place)).then_some((has_foot, pixel, place))
    }

    /// Whether the foot of a strip is in the image, its pixel, and the position of the post.
    fn post(&self, strip: &Strip) -> Option<(bool, Vec2, Vec2)> {
        let foot = Vec2::new(strip.last.middle(), f32::from(strip.last.row + 1));
        if self.is_foot(strip)
            && let Some(front) = self.place(foot, 0.0)
            && let Some(place) = self.judge(strip, front, true)
        {
            return Some((true, self.view.clamp_to_image(foot), place));
        }
        let place = self.by_top(strip).or_else(|| self.by_width(strip)).or_else(|| self.by_side(strip))?;
        Some((false, self.view.project_anywhere(place.extend(0.0)), place))
    }

    /// The position of a post with its front at `front`, if the strip is as upright and as wide as a post at that position.
    fn judge(&self, strip: &Strip, front: Vec2, has_foot: bool) -> Option<Vec2> {
        // The image shows the front of the post.
        let place = front + front.normalize_or(Vec2::X) * self.model.post_radius;
        let diameter = 2.0 * self.model.post_radius;
        let middle = f32::from(strip.first.row + strip.last.row + 1) / 2.0;
        let height = self.height_at(place, middle);
        let expected = self.view.intrinsics.focal.x * diameter / self.depth(place, height).max(diameter);
        let is_as_wide = match strip.whole_width() {
            Some(width) => {
                let width = across(strip, width);
                width < 1.4 * expected + 1.0 && (!has_foot || width > 0.65 * expected - 1.0)
            }
            None => across(strip, strip.mean_width()) < 1.5 * expected + 1.0,
        };
        // If the foot is at the upper edge of the image, only the foot may be in it.
        let is_high = strip.rows as f32 > 0.4 * expected || (has_foot && strip.first.row == 0);
        (is_as_wide && is_high && self.is_upright(strip, place)).then_some(place)
    }

    /// The height above the ground at which a row of the image shows an upright object at `place`, m.
    fn height_at(&self, place: Vec2, row: f32) -> f32 {
        let foot = self.view.camera_from_robot(place.extend(0.0));
        let up = self.view.camera_from_robot(place.extend(1.0)) - foot;
        // (foot.y + h up.y) / (foot.z + h up.z) is the slope of the row's rays.
        let slope = self.view.intrinsics.slope(self.view.project_anywhere(place.extend(0.0)).with_y(row)).y;
        let height = (slope * foot.z - foot.y) / (up.y - slope * up.z);
        if height.is_finite() { height.clamp(0.0, self.model.post_height) } else { 0.0 }
    }

    /// Whether a strip is as upright as an object at `place`.
    fn is_upright(&self, strip: &Strip, place: Vec2) -> bool {
        let ends = [strip.last.row, strip.first.row].map(|row| self.height_at(place, f32::from(row) + 0.5));
        let [low, high] = ends.map(|height| self.view.project_anywhere(place.extend(height)));
        let slope = if low.y - high.y > 1.0 { (low.x - high.x) / (low.y - high.y) } else { 0.0 };
        let off = strip.last.middle() - strip.first.middle() - slope * (strip.rows as f32 - 1.0);
        strip.whole_width().is_none() || off.abs() < 0.2 * strip.rows as f32 + 0.5 * strip.mean_width()
    }

    /// The position of a post by its top, if the top is in the image.
    fn by_top(&self, strip: &Strip) -> Option<Vec2> {
        let height = self.model.post_height;
        if (height - self.view.lens.z).abs() < LEAST_HEIGHT_DIFFERENCE_M {
            return None;
        }
        let above = self.rows_above(strip)?;
        let from = usize::from(strip.first.row);
        if (above as f32) > 0.3 * strip.rows as f32 + 1.5 * strip.mean_width() {
            return None;
        }
        let top = self.place(Vec2::new(strip.first.middle(), (from - above) as f32), height)?;
        // The width must also be right, unless the strip is cut off at the side.
        let place = self.judge(strip, top, false)?;
        let seen = self.view.project_anywhere(place.extend(0.0)).y.min(self.height() as f32) - (from - above) as f32;
        let is_long_enough = (strip.rows + above as u32) as f32 > 0.25 * seen;
        (is_long_enough && strip.rows as f32 > strip.mean_width()).then_some(place)
    }

    /// The position of a post by its width.
    fn by_width(&self, strip: &Strip) -> Option<Vec2> {
        let width = strip.whole_width().filter(|&width| width >= 3.0)?;
        // Only a short piece of a near post may be in the image; it is wider than a bar.
        let least_slenderness = if width >= WIDE { LEAST_SLENDERNESS_OF_WIDE } else { LEAST_SLENDERNESS };
        if (strip.rows as f32) < least_slenderness * width || self.is_beside_white(strip) {
            return None;
        }
        let middle = Vec2::new(
            (strip.first.middle() + strip.last.middle()) / 2.0,
            f32::from(strip.first.row + strip.last.row + 1) / 2.0,
        );
        let distance = self.view.intrinsics.focal.x * 2.0 * self.model.post_radius / width;
        let point = self.view.lens + self.view.ray(middle) * distance;
        let place = point.truncate();
        // A post reaches from the ground to its top.
        let may_stand = (-0.2..self.model.post_height + 0.3).contains(&point.z)
            && place.length() < self.model.farthest
            && self.is_upright(strip, place)
            && self.ends_at_top(strip, place);
        may_stand.then_some(place)
    }

    /// The approximate position of a post of which only one side is in the image. The post is nearer than it would be if it were as narrow
    /// as the visible part, and nearer than it would be if its foot or its top were in the image.
    fn by_side(&self, strip: &Strip) -> Option<Vec2> {
        if strip.whole_width().is_some() || strip.widest < LEAST_WIDTH_BY_SIDE {
            return None;
        }
        let last_column = self.width() as u16;
        let is_cut_left = strip.first.from == 0 || strip.last.from == 0;
        let is_cut_right = strip.first.to == last_column || strip.last.to == last_column;
        let (is_cut_above, is_cut_below) = (strip.first.row == 0, usize::from(strip.last.row) + 1 == self.height());
        if !is_cut_below && strip.rows < 2 * u32::from(strip.widest) {
            return None;
        }
        // The visible side, and the direction from it to the middle of the post, to the left.
        let (side, leftwards): (fn(&Run) -> u16, f32) = match (is_cut_left, is_cut_right) {
            (true, false) => (|run| run.to, 1.0),
            (false, true) => (|run| run.from, -1.0),
            (true, true) => (|run| u16::midpoint(run.from, run.to), 0.0),
            (false, false) => return None,
        };
        let row = f32::from(strip.first.row + strip.last.row + 1) / 2.0;
        let column = f32::from(u16::midpoint(side(&strip.first), side(&strip.last)));
        let ray = self.view.ray(Vec2::new(column, row));
        let lens = self.view.lens.truncate();
        let as_wide = self.view.intrinsics.focal.x * 2.0 * self.model.post_radius / f32::from(strip.widest);
        let mut furthest = (ray.truncate() * as_wide).length();
        let mut limit = |is_cut: bool, run: &Run, row: f32, height: f32| {
            if is_cut && let Some(place) = self.place(Vec2::new(f32::from(side(run)), row), height) {
                furthest = furthest.min(place.distance(lens));
            }
        };
        limit(is_cut_below, &strip.last, self.height() as f32, 0.0);
        limit(is_cut_above && self.model.post_height > self.view.lens.z, &strip.first, 0.0, self.model.post_height);
        if furthest > GREATEST_DISTANCE_BY_SIDE_M {
            return None;
        }
        // Half of the area within the greatest distance is nearer than this.
        let direction = ray.truncate().normalize_or_zero();
        let place_of_side = lens + direction * (furthest * core::f32::consts::FRAC_1_SQRT_2);
        let place = place_of_side + direction.perp() * (leftwards * self.model.post_radius);
        // The side must be as upright as an edge at that position.
        let runs = f32::from(side(&strip.last)) - f32::from(side(&strip.first));
        let expected = self.slope_of_upright(place_of_side, row) * (strip.rows as f32 - 1.0);
        ((runs - expected).abs() < 0.1 * strip.rows as f32 + 2.0).then_some(place)
    }

    /// The slope of an upright edge at `place` in the image, columns per row downwards, where it crosses `row`.
    fn slope_of_upright(&self, place: Vec2, row: f32) -> f32 {
        let height = self.height_at(place, row);
        let [low, high] = [height - 0.01, height + 0.01].map(|height| self.view.project_anywhere(place.extend(height)));
        if low.y - high.y > 0.01 { (low.x - high.x) / (low.y - high.y) } else { 0.0 }
    }

    /// Whether a strip ends at the top of a post at `place`, or at the edge of the image.
    fn ends_at_top(&self, strip: &Strip, place: Vec2) -> bool {
        let Some(above) = self.rows_above(strip) else { return true };
        let [top, foot] =
            [self.model.post_height, 0.0].map(|height| self.view.project_anywhere(place.extend(height)).y);
        let seen = f32::from(strip.first.row) - above as f32;
        (seen - top).abs() < 0.12 * (foot - top) + 3.0
    }

    /// The number of rows of the same colour above a strip, which may end at the bar; `None` if they reach the edge of the image.
    fn rows_above(&self, strip: &Strip) -> Option<usize> {
        let column = (strip.first.middle() as usize).min(self.width() - 1);
        let from = usize::from(strip.first.row);
        let above = (0..from).rev().take_while(|&row| self.class(column, row) == strip.class).count();
        (above < from).then_some(above)
    }

    /// Whether a robot may hide a side of a strip: most of its rows have white beside them. A net, by contrast, has only strings.
    fn is_beside_white(&self, strip: &Strip) -> bool {
        let reach = strip.mean_width() / 2.0 + 2.0;
        let (top, rows) = (strip.first.row, strip.last.row - strip.first.row);
        let is_white = |share: f32, off: f32| {
            let column = strip.first.middle() + share * (strip.last.middle() - strip.first.middle()) + off;
            let column = (column.max(0.0) as usize).min(self.width() - 1);
            self.class(column, usize::from(top) + (share * f32::from(rows)) as usize) == ColourClass::White
        };
        [-reach, reach].into_iter().any(|off| {
            let shares = (0..ROWS_BESIDE).map(|index| (f32::from(index) + 0.5) / f32::from(ROWS_BESIDE));
            2 * shares.filter(|share| is_white(*share, off)).count() >= usize::from(ROWS_BESIDE)
        })
    }

    /// Whether there is carpet below a strip, or a line and then carpet.
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

/// The width of a strip perpendicular to its direction, pixels, for a `width` along a row.
fn across(strip: &Strip, width: f32) -> f32 {
    width / Vec2::new(1.0, strip.slope()).length()
}

/// Adds a post, or replaces the same post if this one is better.
fn insert(found: &mut Vec<(bool, GoalPostPercept)>, has_foot: bool, percept: GoalPostPercept) {
    let bearing = |place: Vec2| place.normalize_or(Vec2::X);
    let same = found.iter_mut().find(|(_, other)| {
        other.colour == percept.colour && bearing(other.position_m).dot(bearing(percept.position_m)) > 0.9985
    });
    match same {
        // Of two pieces of one post, the one with the foot is kept, or else the nearer one.
        Some(other) if (has_foot, -percept.position_m.length()) > (other.0, -other.1.position_m.length()) => {
            *other = (has_foot, percept);
        }
        Some(_) => {}
        None => found.push((has_foot, percept)),
    }
}
