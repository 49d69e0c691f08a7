//! The frame being drawn: its pixels, its depth buffer and its intrinsics, in samples.

use bevy::math::{Mat3, Vec3};
use core::ops::Range;

use crate::appearance::view::View;

/// Distance from the plane of the lens within which nothing is drawn, m.
pub const NEAR: f32 = 0.01;

/// A frame being drawn. Its pixels are samples: several per pixel of the picture for smooth edges.
#[derive(Default)]
pub(super) struct Frame {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Red, green and blue from the lowest byte up; the label is in the uppermost.
    pub(super) pixels: Vec<u32>,
    /// The inverse depth, 1/m; zero for the ground and the sky.
    pub(super) nearness: Vec<f32>,
    /// The window in which bodies, shadows and nets are drawn; outside, the frame does not change.
    pub(super) window: Window,
    pub(super) focal_length: f32,
    pub(super) centre: [f32; 2],
    pub(super) eye: Vec3,
    pub(super) camera_from_world: Mat3,
}

/// A rectangle of samples.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(super) struct Window {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Window {
    /// Returns the part of a span of samples in a row that is in the window, and the number of samples of the span before it.
    #[inline(always)]
    pub(super) fn clip(&self, from: usize, to: usize) -> (Range<usize>, usize) {
        let start = from.max(self.columns.start);
        (start..to.min(self.columns.end).max(start), start - from)
    }

    /// The smallest rectangle that contains both.
    pub(super) fn with(&self, other: &Window) -> Window {
        let both = |one: &Range<usize>, other: &Range<usize>| one.start.min(other.start)..one.end.max(other.end);
        Window { columns: both(&self.columns, &other.columns), rows: both(&self.rows, &other.rows) }
    }

    /// Whether they have samples in common.
    pub(super) fn overlaps(&self, other: &Window) -> bool {
        let meet = |one: &Range<usize>, other: &Range<usize>| one.start.max(other.start) < one.end.min(other.end);
        meet(&self.columns, &other.columns) && meet(&self.rows, &other.rows)
    }

    /// The number of samples.
    pub(super) fn area(&self) -> usize {
        self.columns.len() * self.rows.len()
    }
}

impl Frame {
    /// An empty frame for a view, to be drawn as a whole.
    pub(super) fn begin(&mut self, view: &View) {
        let [width, height] = view.size();
        let samples = view.supersampling.max(1);
        (self.width, self.height) = (width * samples as usize, height * samples as usize);
        let scale = samples as f32;
        self.focal_length = view.intrinsics.focal_length * scale;
        self.centre = [view.intrinsics.centre.x * scale, view.intrinsics.centre.y * scale];
        self.eye = view.eye;
        self.camera_from_world = view.camera_from_world();
        let count = self.width * self.height;
        self.pixels.resize(count, 0);
        self.nearness.clear();
        self.nearness.resize(count, 0.0);
        self.window = Window { columns: 0..self.width, rows: 0..self.height };
    }

    /// Sets the window in which to draw, and fills it with the samples `ground`, which show the ground alone.
    pub(super) fn open(&mut self, window: &Window, ground: &[u32]) {
        self.window.clone_from(window);
        for row in window.rows.clone() {
            let samples = row * self.width + window.columns.start..row * self.width + window.columns.end;
            self.pixels[samples.clone()].copy_from_slice(&ground[samples.clone()]);
            self.nearness[samples].fill(0.0);
        }
    }

    /// A point of the pitch frame to the right, down and ahead of the lens, m.
    #[inline(always)]
    pub(super) fn to_camera(&self, point: Vec3) -> Vec3 {
        self.camera_from_world * (point - self.eye)
    }

    /// The sample of a point ahead of the lens.
    #[inline(always)]
    pub(super) fn project(&self, in_camera: Vec3) -> [f32; 2] {
        let scale = self.focal_length / in_camera.z;
        [self.centre[0] + in_camera.x * scale, self.centre[1] + in_camera.y * scale]
    }

    /// Whether a sphere with its centre in the camera frame may be in the window.
    #[inline(always)]
    pub(super) fn may_see(&self, centre: Vec3, radius: f32) -> bool {
        let beyond = |offset: f32, half: f32| {
            // The distance to a side plane of the frustum is (f |x| - c z) / sqrt(f² + c²); f + c is more than the root.
            self.focal_length * offset > half * centre.z + (self.focal_length + half.abs()) * radius
        };
        let Window { columns, rows } = &self.window;
        centre.z > NEAR - radius
            && !beyond(centre.x, columns.end as f32 - self.centre[0])
            && !beyond(-centre.x, self.centre[0] - columns.start as f32)
            && !beyond(centre.y, rows.end as f32 - self.centre[1])
            && !beyond(-centre.y, self.centre[1] - rows.start as f32)
    }

    /// The slope of a sample's ray to the right or down, per unit of depth.
    #[inline(always)]
    pub(super) fn slope(&self, sample: usize, axis: usize) -> f32 {
        (sample as f32 + 0.5 - self.centre[axis]) / self.focal_length
    }
}

/// The range of the samples whose middles are between two coordinates, within 0..count.
#[inline(always)]
pub(super) fn samples_between(from: f32, to: f32, count: usize) -> (usize, usize) {
    (first_sample(from, count), first_sample(to, count))
}

/// The first sample whose middle is at or beyond a coordinate.
#[inline(always)]
pub(super) fn first_sample(coordinate: f32, count: usize) -> usize {
    // The smallest n with n + 0.5 >= coordinate. The cast saturates, and makes NaN zero.
    let shifted = coordinate - 0.5;
    let whole = shifted as i32;
    let above = whole.saturating_add(i32::from((whole as f32) < shifted));
    if above <= 0 { 0 } else { (above as usize).min(count) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_belongs_to_a_span_by_its_middle() {
        assert_eq!(samples_between(0.5, 2.5, 10), (0, 2));
        assert_eq!(samples_between(0.51, 2.51, 10), (1, 3));
        assert_eq!(samples_between(-7.0, 1e12, 10), (0, 10));
        assert_eq!(samples_between(-1e12, -3.2, 10), (0, 0));
        assert_eq!(first_sample(f32::NAN, 10), 0);
    }
}
