//! The light: a directional sun, and ambient light, more of it from above.

use bevy::math::Vec3;

/// The direction of the sun, unit vector, pitch frame.
pub const SUN: Vec3 = Vec3::new(-0.390_360_03, -0.487_950_04, 0.780_720_06);

/// The ambient light.
pub const AMBIENT: f32 = 0.72;
/// The light of the sun on a surface that faces it.
pub const FROM_SUN: f32 = 0.30;
/// The gradient of the ambient light: more from above, and from the windows of the hall.
pub const GRADIENT: Vec3 = Vec3::new(0.075, -0.045, 0.07);
/// Share of the light that is left in a shadow, of 256.
pub const IN_SHADOW: u32 = 160;

/// The greatest opacity of a net's string, of 256.
pub const NET_HIDES: f32 = 230.0;

/// Full light, in the units of `intensity`.
pub const FULL: f32 = 256.0;

/// The light of a scene. The default is that of all matches.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Light {
    /// The direction of the sun, unit vector above the horizon, pitch frame.
    pub sun: Vec3,
    /// The light of the sun on a surface that faces it, as a share of full light.
    pub from_sun: f32,
    /// The ambient light, as a share of full light.
    pub ambient: f32,
    /// The gradient of the ambient light, which is added in proportion to its product with the normal of a surface.
    pub gradient: Vec3,
    /// Share of the light that is left in a shadow, of 256.
    pub in_shadow: u32,
}

impl Default for Light {
    fn default() -> Self {
        Self { sun: SUN, from_sun: FROM_SUN, ambient: AMBIENT, gradient: GRADIENT, in_shadow: IN_SHADOW }
    }
}

impl Light {
    /// The light on a surface with this unit normal, from 0 to [`FULL`].
    #[inline(always)]
    pub(super) fn intensity(&self, normal: Vec3) -> f32 {
        self.of_cosines(normal.dot(self.gradient), normal.dot(self.sun))
    }

    /// The light on a surface, given the scalar products of its unit normal with the gradient and with the direction of the sun.
    #[inline(always)]
    pub(super) fn of_cosines(&self, gradient: f32, sun: f32) -> f32 {
        let sun = if sun > 0.0 { sun } else { 0.0 };
        let light = self.ambient + gradient + self.from_sun * sun;
        let light = if light < 1.0 { light } else { 1.0 };
        light * FULL
    }

    /// The point on the ground that lies in the shadow of `point`.
    #[inline(always)]
    pub(super) fn on_ground(&self, point: Vec3) -> Vec3 {
        point - self.sun * (point.z / self.sun.z)
    }
}

/// A colour as stored in a pixel, with the number of its label in the uppermost byte.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Paint {
    pub(super) rgb: [u32; 3],
    pub(super) label: u32,
}

impl Paint {
    pub(super) fn new(colour: crate::appearance::colours::Colour, label: crate::appearance::Label) -> Self {
        Self { rgb: colour.0.map(u32::from), label: u32::from(label as u8) << 24 }
    }

    /// The pixel under this light, from 0 to 256.
    #[inline(always)]
    pub(super) fn lit(self, light: u32) -> u32 {
        let [red, green, blue] = self.rgb;
        ((red * light) >> 8) | (green * light) & 0xff00 | ((blue * light) & 0xff00) << 8 | self.label
    }

    /// The pixel in full light.
    #[inline(always)]
    pub(super) fn full(self) -> u32 {
        self.lit(256)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::{Label, colours::Colour};

    #[test]
    fn the_sun_is_a_unit_vector() {
        assert!((SUN.length() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn light_scales_each_channel_and_leaves_the_label() {
        let paint = Paint::new(Colour([255, 100, 10]), Label::Ball);
        assert_eq!(paint.full().to_le_bytes(), [255, 100, 10, Label::Ball as u8]);
        assert_eq!(paint.lit(128).to_le_bytes(), [127, 50, 5, Label::Ball as u8]);
    }
}
