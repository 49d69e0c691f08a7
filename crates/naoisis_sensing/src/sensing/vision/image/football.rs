//! Detection of a black and white ball: a disc of white with dark patches, with the size of a ball at its position and an outline on a
//! circle.
//!
//! The image is searched in steps of half a radius for discs that are white and black, and not green. From each of them, rays are followed
//! to the outline; a circle of the expected radius is fitted to their ends. The disc with the roundest outline is the ball. Lines, posts and
//! feet have no dark patches or no round outline.

use bevy::math::Vec2;

use super::Look;
use super::colour::ColourClass;
use crate::sensing::vision::{BallPercept, RobotPercept};
use naoisis_core::geometry::unit;

/// The least radius of a ball, pixels.
const LEAST_RADIUS: f32 = 2.2;
/// The number of rays from the centre of a ball to its outline.
const RAYS: usize = 32;
/// The least number of rays that end at the outline, and of points of the circle in the image.
const LEAST_ENDS: usize = 6;
const LEAST_RAYS: usize = 9;
/// The greatest number of pixels between black and white, whose colour is mixed.
const BLURRED: usize = 2;
/// The least share of the outline on the circle: of discs in general, and of those with patches on all sides.
const LEAST_ON_CIRCLE: [f32; 2] = [0.6, 0.45];
/// The same for a disc of which half or more is out of the image, and for a small one.
const LEAST_ON_SHORT_CIRCLE: [f32; 2] = [0.8, 0.6];
/// The radius below which a disc is small, pixels.
const SMALL: f32 = 4.0;
/// The least radius of a ball of which patches on all sides are seen, pixels, and the least shares of black and white on each side.
const LEAST_PATCHED: f32 = 6.0;
const LEAST_BLACK_ASIDE: f32 = 0.05;
const LEAST_WHITE_ASIDE: f32 = 0.25;
/// The least share of white in the disc, and the range of the share of black.
const LEAST_WHITE: f32 = 0.3;
const BLACK: core::ops::Range<f32> = 0.12..0.37;
/// The greatest share of carpet in the disc.
const MOST_GREEN: f32 = 0.06;
/// The greatest share of all other colours in the disc, at its edge and between its patches.
const MOST_OTHER: f32 = 0.35;

/// The numbers of pixels of the classes of a ball, from the start of each row to each column.
#[derive(Default)]
pub(super) struct Football {
    /// Black, white and green.
    sums: Vec<[u16; 3]>,
    outline: Vec<Vec2>,
}

/// The shares of black, white and green in a disc.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Shares {
    black: f32,
    white: f32,
    green: f32,
    /// The number of pixels of the disc in the image.
    pixels: u32,
}

impl Shares {
    /// Whether a disc that a ball does not fill exactly may be one.
    fn may_be_ball(self) -> bool {
        self.green < 0.35 && self.white > 0.8 * LEAST_WHITE && self.black > BLACK.start / 2.0
    }
}

impl Football {
    /// Counts the pixels of an image.
    fn count(&mut self, classes: &[ColourClass], width: usize) {
        self.sums.clear();
        for row in classes.chunks_exact(width) {
            self.sums.push([0; 3]);
            let mut sum = [0; 3];
            self.sums.extend(row.iter().map(|class| {
                let is = |other: ColourClass| u16::from(*class == other);
                let [black, white, green] = sum;
                sum = [black + is(ColourClass::Black), white + is(ColourClass::White), green + is(ColourClass::Green)];
                sum
            }));
        }
    }

    /// The shares of the classes in a disc, as far as it is in the image.
    fn shares(&self, centre: Vec2, radius: f32, [width, height]: [usize; 2]) -> Option<Shares> {
        // The nearest whole number; `round` is slow.
        let nearest = |pixel: f32, most: usize| ((pixel.max(0.0) + 0.5) as usize).min(most);
        let (first, end) = (nearest(centre.y - radius, height), nearest(centre.y + radius, height));
        let (mut pixels, mut sums) = (0, [0; 3]);
        for row in first..end {
            let up = row as f32 + 0.5 - centre.y;
            let half = (radius * radius - up * up).max(0.0).sqrt();
            let [from, to] = [centre.x - half, centre.x + half].map(|u| nearest(u, width));
            let [before, until] = [from, to].map(|column| self.sums[row * (width + 1) + column]);
            pixels += (to - from) as u32;
            for (sum, (until, before)) in sums.iter_mut().zip(until.into_iter().zip(before)) {
                *sum += u32::from(until - before);
            }
        }
        let [black, white, green] = sums.map(|sum| sum as f32 / pixels.max(1) as f32);
        (pixels > 0).then_some(Shares { black, white, green, pixels })
    }
}

impl Look<'_> {
    /// The black and white disc that fits a ball best, with its number of pixels. Discs within the body of a robot are parts of it.
    pub(super) fn find_football(
        &self,
        robots: &[(bool, RobotPercept)],
        football: &mut Football,
    ) -> Option<(u32, BallPercept)> {
        football.count(&self.segmentation.classes, self.width());
        let size = [self.width(), self.height()];
        let mut best: Option<(f32, u32, BallPercept)> = None;
        let mut found: Vec<(Vec2, f32)> = Vec::new();
        let mut v = 0.5;
        while v < self.height() as f32 {
            let Some(radius) = self.radius_at(Vec2::new(self.width() as f32 / 2.0, v)) else {
                v += 1.0;
                continue;
            };
            let step = (radius / 2.0).max(1.0);
            let mut u = 0.5;
            while radius >= LEAST_RADIUS && u < self.width() as f32 {
                let start = Vec2::new(u, v);
                u += step;
                let may_be = football.shares(start, 0.8 * radius, size).is_some_and(Shares::may_be_ball);
                if !may_be || found.iter().any(|(centre, radius)| centre.distance(start) < *radius) {
                    continue;
                }
                let Some((centre, radius)) = self.circle_about(start, radius, football) else { continue };
                let Some((score, pixels)) = self.score(centre, radius, football) else { continue };
                found.push((centre, radius));
                let Some(position_m) = self.place(centre, self.model.ball_radius) else { continue };
                let is_free = robots.iter().all(|(_, robot)| {
                    robot.position_m.distance(position_m) > self.model.robot_reach / 2.0 + self.model.ball_radius / 2.0
                });
                if is_free && best.is_none_or(|(other, ..)| score > other) {
                    let pixel = self.view.clamp_to_image(centre);
                    best = Some((score, pixels, BallPercept::new(self.camera, pixel, position_m)));
                }
            }
            v += step;
        }
        best.map(|(_, pixels, ball)| (pixels, ball))
    }

    /// Centre and radius of the circle of a ball that fits the black and white area about `start`.
    fn circle_about(&self, start: Vec2, radius: f32, football: &mut Football) -> Option<(Vec2, f32)> {
        let (mut centre, mut radius) = (start, radius);
        for is_first in [true, false] {
            let from = if self.ball_class(centre).is_some() { centre } else { start };
            football.outline.clear();
            let ends = (0..RAYS).filter_map(|ray| self.end_of_ray(from, ray, 2.0 * radius + 2.0));
            football.outline.extend(ends);
            if football.outline.len() < LEAST_ENDS {
                return None;
            }
            (centre, radius) = self.fit(from, &football.outline)?;
            if centre.distance(start) > 1.5 * radius || radius < LEAST_RADIUS {
                return None;
            }
            if is_first {
                let shares = football.shares(centre, 0.8 * radius, [self.width(), self.height()])?;
                if !shares.may_be_ball() {
                    return None;
                }
            }
        }
        Some((centre, radius))
    }

    /// The share of the outline of a disc on its circle, and its number of pixels, if it may be a ball.
    fn score(&self, centre: Vec2, radius: f32, football: &Football) -> Option<(f32, u32)> {
        let size = [self.width(), self.height()];
        let tolerance = (0.1 * radius).max(0.9);
        let (mut rays, mut on_circle) = (0_usize, 0_usize);
        for ray in 0..RAYS {
            let at = |distance: f32| self.ball_class(centre + distance * direction(ray));
            if let (Some(inside), Some(outside)) = (at(radius - tolerance), at(radius + tolerance + 0.5)) {
                rays += 1;
                on_circle += usize::from(inside && !outside);
            }
        }
        let score = on_circle as f32 / rays.max(1) as f32;
        let Shares { black, white, green, pixels } = football.shares(centre, (0.9 * radius).max(radius - 1.0), size)?;
        let other = 1.0 - black - white - green;
        let is_ball = white >= LEAST_WHITE && BLACK.contains(&black) && green <= MOST_GREEN && other <= MOST_OTHER;
        // Patches on all sides are hardly anything but a ball's, so that more of its outline may be hidden.
        let has_patches = |side: Vec2| {
            let shares = football.shares(centre + 0.5 * radius * side, 0.5 * radius, size);
            shares.is_none_or(|shares| shares.black > LEAST_BLACK_ASIDE && shares.white > LEAST_WHITE_ASIDE)
        };
        let is_patched = radius >= LEAST_PATCHED && [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y].into_iter().all(has_patches);
        let is_short = rays < RAYS / 2 || radius < SMALL;
        let least = if is_short { LEAST_ON_SHORT_CIRCLE } else { LEAST_ON_CIRCLE }[usize::from(is_patched)];
        (is_ball && rays >= LEAST_RAYS && score >= least).then_some((score, pixels))
    }

    /// Whether a pixel is black or white; `None` outside the image.
    fn ball_class(&self, point: Vec2) -> Option<bool> {
        let is_inside = point.min_element() >= 0.0 && point.x < self.width() as f32 && point.y < self.height() as f32;
        let class = is_inside.then(|| self.class(point.x as usize, point.y as usize));
        class.map(|class| matches!(class, ColourClass::Black | ColourClass::White))
    }

    /// The point where a ray from a pixel leaves the black and white area, if it does so within `reach` and in the image.
    fn end_of_ray(&self, from: Vec2, ray: usize, reach: f32) -> Option<Vec2> {
        let step_px = (reach / 40.0).max(0.5);
        let step = step_px * direction(ray);
        let mut end = from;
        let mut outside = 0;
        for index in 0..(reach / step_px) as usize {
            let point = from + step * index as f32;
            if self.ball_class(point)? {
                (end, outside) = (point + step / 2.0, 0);
            } else if self.class(point.x as usize, point.y as usize) == ColourClass::Green
                || outside as f32 * step_px >= BLURRED as f32
            {
                return Some(end);
            } else {
                outside += 1;
            }
        }
        None
    }
}

/// The direction of a ray in the image.
fn direction(ray: usize) -> Vec2 {
    unit(core::f32::consts::TAU * ray as f32 / RAYS as f32)
}
