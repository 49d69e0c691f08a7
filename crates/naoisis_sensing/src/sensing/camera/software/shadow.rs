//! Shadows on the ground.

use bevy::math::{Vec3, Vec3A};

use super::frame::Frame;
use super::light::Light;
use super::polygon::Outline;
use super::prepared::PreparedScene;

/// The mark of a sample in a shadow, in the label's byte.
pub(super) const SHADED: u32 = 1 << 31;

/// Number of corners of a round shadow.
const CORNERS: usize = 24;

/// Darkens the ground in the shadows of bodies that `has_shadow` chooses by index. Only the ground may have been drawn before.
#[inline(always)]
pub(super) fn draw(
    frame: &mut Frame,
    outline: &mut Outline,
    scene: &PreparedScene,
    has_shadow: impl Fn(usize) -> bool,
) {
    let light = &scene.light;
    for (_, body) in scene.bodies.iter().enumerate().filter(|(index, _)| has_shadow(*index)) {
        for face in &scene.faces[body.faces.clone()] {
            // The shadow of a body is that of its faces towards the sun.
            if face.normal.dot(light.sun) > 0.0 {
                let corners = &scene.corners[face.first as usize..(face.first + face.count) as usize];
                darken(frame, outline, light, corners.iter().map(|corner| corner.position));
            }
        }
        for round in &scene.rounds[body.rounds.clone()] {
            // On the unit sphere, the edge of the shadow is the great circle perpendicular to the direction of the sun there.
            let world_from_unit = round.unit_from_world.inverse();
            let sun = Vec3::from(round.unit_from_world.matrix3 * Vec3A::from(light.sun));
            let (one, other) = sun.normalize_or(Vec3::Z).any_orthonormal_pair();
            let circle = super::model::unit_circle(CORNERS);
            let rim = circle.map(|at| world_from_unit.transform_point3(at.x * one + at.y * other));
            darken(frame, outline, light, rim);
        }
    }
}

#[inline(always)]
fn darken(frame: &mut Frame, outline: &mut Outline, light: &Light, corners: impl Iterator<Item = Vec3>) {
    if !outline.project(frame, corners.map(|corner| (light.on_ground(corner), 0.0))) {
        return;
    }
    let (width, height) = (frame.width, frame.height);
    let (first, end) = outline.scan(width, height, &frame.window.rows);
    for row in first..end {
        let (from, to) = outline.span(row, width);
        let (columns, _) = frame.window.clip(from, to);
        for pixel in &mut frame.pixels[row * width + columns.start..row * width + columns.end] {
            let [low, middle, high] = [0, 8, 16].map(|shift| (((*pixel >> shift) & 0xff) * light.in_shadow) >> 8);
            let dark = low | middle << 8 | high << 16 | *pixel & 0xff00_0000 | SHADED;
            *pixel = if *pixel & SHADED == 0 { dark } else { *pixel };
        }
    }
}
