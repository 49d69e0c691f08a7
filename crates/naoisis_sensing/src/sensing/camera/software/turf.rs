//! The uneven colour of the carpet, laid over the ground before anything else is drawn.

use bevy::math::Vec2;

use super::frame::Frame;
use crate::appearance::Label;
use crate::appearance::turf;
use crate::appearance::view::View;

/// Lays the unevenness over the samples of the carpet. Only the ground may have been drawn before.
#[inline(always)]
pub(super) fn draw(frame: &mut Frame, view: &View, unevenness: f32) {
    if unevenness == 0.0 || view.eye.z <= 0.0 {
        return;
    }
    let width = frame.width;
    let per_sample = view.right / frame.focal_length;
    for row in 0..frame.height {
        let first = view.forward + frame.slope(row, 1) * view.down + frame.slope(0, 0) * view.right;
        for column in 0..width {
            let pixel = frame.pixels[row * width + column];
            if pixel >> 24 != Label::Carpet as u32 {
                continue;
            }
            let ray = first + per_sample * (column as i32 as f32);
            let far = view.eye.z / if ray.z < -1e-4 { -ray.z } else { 1e-4 };
            let place = Vec2::new(view.eye.x + far * ray.x, view.eye.y + far * ray.y);
            // A sample covers more ground along the line of sight.
            let covers_m = far * far / (view.eye.z * frame.focal_length);
            let brightness = (256.0 * turf::brightness(place, covers_m, unevenness)) as i32 as u32;
            let channel = |shift: u32| {
                let bright = (((pixel >> shift) & 0xff) * brightness) >> 8;
                (if bright < 255 { bright } else { 255 }) << shift
            };
            frame.pixels[row * width + column] = channel(0) | channel(8) | channel(16) | pixel & 0xff00_0000;
        }
    }
}
