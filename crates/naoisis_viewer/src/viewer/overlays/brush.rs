//! Draws lines and words on the pitch.

use bevy::ecs::system::SystemParam;
use bevy::gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::geometry::arc;
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::pitch_frame::world_from_pitch;
use naoisis_core::geometry::Pose;
use naoisis_sensing::belief::PlaceCovariance;
use naoisis_sensing::belief::covariance::half_axes_95;

/// The height of drawings on the ground, m.
const GROUND_M: f32 = 0.012;
/// The width of lines, and of those for a projector, logical pixels.
const LINE_WIDTH: f32 = 2.5;
const PROJECTED_WIDTH: f32 = 5.0;

/// The lines of all overlays.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct OverlayLines;

/// The words on the pitch in this frame.
#[derive(Resource, Default, Debug)]
pub struct OverlayWords(pub Vec<Words>);

/// Words at a position.
#[derive(Clone, PartialEq, Debug)]
pub struct Words {
    /// The position, m, in Bevy's world.
    pub place: Vec3,
    /// The words.
    pub text: String,
    /// Their colour.
    pub colour: Color,
}

/// Sets the width of lines, and keeps them above the ground.
pub(super) fn set_lines(display: Res<DisplaySettings>, mut store: ResMut<GizmoConfigStore>) {
    let (config, _) = store.config_mut::<OverlayLines>();
    config.line.width = if display.projector { PROJECTED_WIDTH } else { LINE_WIDTH };
    config.depth_bias = -0.000_05;
}

/// Draws in the pitch frame.
#[derive(SystemParam)]
pub struct Brush<'w, 's> {
    lines: Gizmos<'w, 's, OverlayLines>,
    words: ResMut<'w, OverlayWords>,
}

fn on_ground(place: Vec2) -> Vec3 {
    world_from_pitch() * place.extend(GROUND_M)
}

impl Brush<'_, '_> {
    /// Draws a line on the ground, m.
    pub fn line(&mut self, start: Vec2, end: Vec2, colour: Color) {
        self.lines.line(on_ground(start), on_ground(end), colour);
    }

    /// Draws a line in space, m.
    pub fn line_in_space(&mut self, start: Vec3, end: Vec3, colour: Color) {
        self.lines.line(world_from_pitch() * start, world_from_pitch() * end, colour);
    }

    /// Draws an open polygon on the ground, m.
    pub fn path(&mut self, places: impl IntoIterator<Item = Vec2>, colour: Color) {
        self.lines.linestrip(places.into_iter().map(on_ground), colour);
    }

    /// Draws a closed polygon on the ground, m.
    pub fn outline(&mut self, places: impl IntoIterator<Item = Vec2>, colour: Color) {
        self.outline_at(places, GROUND_M, colour);
    }

    /// Draws a closed polygon at a height, m.
    pub fn outline_at(&mut self, places: impl IntoIterator<Item = Vec2>, height: f32, colour: Color) {
        let mut places = places.into_iter().map(|place| world_from_pitch() * place.extend(height));
        let Some(first) = places.next() else { return };
        self.lines.linestrip(core::iter::once(first).chain(places).chain([first]), colour);
    }

    /// Draws a circle on the ground, m.
    pub fn circle(&mut self, centre: Vec2, radius: f32, colour: Color) {
        self.path(arc(centre, radius, [0.0, TAU]), colour);
    }

    /// Draws a cross of this length on the ground, m.
    pub fn cross(&mut self, centre: Vec2, length: f32, colour: Color) {
        for arm in [Vec2::new(0.5, 0.5), Vec2::new(0.5, -0.5)] {
            self.line(centre - length * arm, centre + length * arm, colour);
        }
    }

    /// Draws an arrow on the ground, m.
    pub fn arrow(&mut self, start: Vec2, end: Vec2, colour: Color) {
        let way = end - start;
        self.line(start, end, colour);
        let barb = 0.15_f32.min(0.3 * way.length()) * way.normalize_or_zero();
        for side in [1.0, -1.0] {
            self.line(end, end - barb + side * 0.6 * barb.perp(), colour);
        }
    }

    /// Draws a robot's position and heading on the ground: a circle with a nose.
    pub fn pose(&mut self, pose: Pose, radius: f32, colour: Color) {
        self.circle(pose.position, radius, colour);
        self.arrow(pose.position, pose.transform_point(Vec2::new(2.0 * radius, 0.0)), colour);
    }

    /// Draws the 95 % ellipse of a position.
    pub fn ellipse(&mut self, centre: Vec2, covariance: PlaceCovariance, colour: Color) {
        let Some([long, short]) = half_axes_95(covariance) else { return };
        let turn = arc(Vec2::ZERO, 1.0, [0.0, TAU]);
        self.path(turn.map(|corner| centre + corner.x * long + corner.y * short), colour);
    }

    /// Writes words above a position on the ground.
    pub fn words(&mut self, place: Vec2, text: impl Into<String>, colour: Color) {
        self.words_above(place, GROUND_M, text, colour);
    }

    /// Writes words above something of this height, m, at a position.
    pub(in crate::viewer) fn words_above(
        &mut self,
        place: Vec2,
        height_m: f32,
        text: impl Into<String>,
        colour: Color,
    ) {
        let place = world_from_pitch() * place.extend(height_m);
        self.words.0.push(Words { place, text: text.into(), colour });
    }
}

pub(super) fn forget_words(mut words: ResMut<OverlayWords>) {
    words.0.clear();
}
