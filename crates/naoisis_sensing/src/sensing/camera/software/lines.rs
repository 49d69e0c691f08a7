//! Drawing of the strings of the nets: transparent lines.

use bevy::math::Vec3;

use super::frame::{Frame, NEAR};
use super::light::NET_HIDES;
use super::prepared::PreparedScene;
use crate::appearance::colours::Colour;
use crate::appearance::field::STRING_M;

/// The greatest thickness of a string, samples.
const THICKEST: usize = 64;

/// Draws the nets, after everything else.
#[inline(always)]
pub(super) fn draw_nets(frame: &mut Frame, scene: &PreparedScene) {
    for net in &scene.nets {
        if frame.may_see(frame.to_camera(net.centre), net.reach) {
            for &ends in &net.strings {
                draw_string(frame, ends, scene.net_colour);
            }
        }
    }
}

#[inline(always)]
fn draw_string(frame: &mut Frame, ends: [Vec3; 2], colour: Colour) {
    let [mut one, mut other] = ends.map(|end| frame.to_camera(end));
    if one.z < NEAR && other.z < NEAR {
        return;
    }
    if one.z < NEAR {
        one = (other + (one - other) * ((other.z - NEAR) / (other.z - one.z))).with_z(NEAR);
    } else if other.z < NEAR {
        other = (one + (other - one) * ((one.z - NEAR) / (one.z - other.z))).with_z(NEAR);
    }
    let [one_at, other_at] = [one, other].map(|point| frame.project(point));
    let (mut from, mut to) = ([one_at, [1.0 / one.z, 0.0]], [other_at, [1.0 / other.z, 0.0]]);
    let is_steep = (to[0][1] - from[0][1]).abs() > (to[0][0] - from[0][0]).abs();
    let (major, minor) = if is_steep { (1, 0) } else { (0, 1) };
    if from[0][major] > to[0][major] {
        (from, to) = (to, from);
    }
    let sizes = [frame.width, frame.height];
    let window = [frame.window.columns.clone(), frame.window.rows.clone()];
    let (first, end) = super::frame::samples_between(from[0][major], to[0][major], sizes[major]);
    let (first, end) = (first.max(window[major].start), end.min(window[major].end));
    if first >= end {
        return;
    }
    let length_inverse = 1.0 / (to[0][major] - from[0][major]);
    let slope = (to[0][minor] - from[0][minor]) * length_inverse;
    let nearness_slope = (to[1][0] - from[1][0]) * length_inverse;
    for sample in first..end {
        let along = sample as f32 + 0.5 - from[0][major];
        let middle = from[0][minor] + along * slope;
        let here = from[1][0] + along * nearness_slope;
        let width = frame.focal_length * STRING_M * here;
        let count = (width as usize).clamp(1, THICKEST);
        let share = if width < 1.0 { width * NET_HIDES } else { NET_HIDES };
        let start = middle - count as f32 / 2.0 + 0.5;
        if start < 0.0 {
            continue;
        }
        for across in (start as usize).max(window[minor].start)..(start as usize + count).min(window[minor].end) {
            let index = if is_steep { sample * frame.width + across } else { across * frame.width + sample };
            if here > frame.nearness[index] {
                frame.pixels[index] = blend(frame.pixels[index], colour, share as u32);
            }
        }
    }
}

#[inline(always)]
fn blend(pixel: u32, Colour(colour): Colour, share: u32) -> u32 {
    let [red, green, blue] = colour.map(u32::from);
    let mix = |behind: u32, string: u32| (behind * (256 - share) + string * share) >> 8;
    let (low, middle, high) = (pixel & 0xff, (pixel >> 8) & 0xff, (pixel >> 16) & 0xff);
    mix(low, red) | mix(middle, green) << 8 | mix(high, blue) << 16 | pixel & 0xff00_0000
}
