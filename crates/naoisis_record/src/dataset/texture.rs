//! The textures of turf, lines, floor and walls, and the colour of the light. They are laid over a drawn picture, pixel by pixel, depending
//! on the place on the ground or the direction of the wall.

use bevy::math::{Vec2, Vec3};

use super::looks::MatchLooks;
use naoisis_core::random::RandomStream;
use naoisis_sensing::appearance::Label;
use naoisis_sensing::appearance::turf::{coarse, smooth};
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::Image;

/// The offsets of textures are up to this number of their details.
const MOST_SHIFT: f32 = 256.0;
/// The sizes of blades of grass and of mottles, m.
const BLADE_M: f32 = 0.012;
const MOTTLE_M: f32 = 0.35;

/// The textures of a match. They are fixed to the ground in all of its images.
#[derive(Clone, Copy, Debug)]
pub struct Texture {
    /// The offset of each kind of texture.
    shifts: [Vec2; 3],
    /// The direction of stripes: along or across the pitch.
    stripe_axis: Vec2,
}

impl Texture {
    /// Draws the textures of a match.
    pub fn draw(stream: &mut RandomStream) -> Self {
        let mut shift = || Vec2::new(stream.uniform(), stream.uniform()) * MOST_SHIFT;
        let shifts = [shift(), shift(), shift()];
        Self { shifts, stripe_axis: if stream.chance(0.5) { Vec2::X } else { Vec2::Y } }
    }

    /// Lays the textures over a picture. Its labels are those of the ground, and larger numbers for everything else. `gains` are the
    /// factors on red, green and blue.
    pub fn paint(&self, image: &mut Image, view: &View, looks: &MatchLooks, gains: [f32; 3]) {
        let width = image.width.max(1) as usize;
        let focal_length = view.intrinsics.focal_length;
        let turf = looks.turf.map(f32::from);
        for (row, (pixels, labels)) in
            image.rgb.chunks_exact_mut(3 * width).zip(image.labels.chunks_exact(width)).enumerate()
        {
            let start = view.ray(Vec2::new(0.5, row as f32 + 0.5));
            let step = view.right / focal_length;
            for (column, (pixel, label)) in pixels.chunks_exact_mut(3).zip(labels).enumerate() {
                let ray = start + step * column as f32;
                let mut colour = [f32::from(pixel[0]), f32::from(pixel[1]), f32::from(pixel[2])];
                let factor = match *label {
                    SKY => wall(ray, looks.wall_contrast),
                    FLOOR | CARPET | LINE => {
                        let far = -view.eye.z / ray.z.min(-1e-4);
                        let place = view.eye.truncate() + far * ray.truncate();
                        if *label == LINE {
                            let worn = 0.5 + 0.5 * smooth(place / 0.15 + self.shifts[1]);
                            let wear = looks.wear * worn * worn;
                            for (channel, below) in colour.iter_mut().zip(turf) {
                                *channel += wear * (below - *channel);
                            }
                        }
                        let floor = *label == FLOOR;
                        self.on_ground(place, far / focal_length, floor, looks)
                    }
                    _ => 1.0,
                };
                for ((pixel, channel), gain) in pixel.iter_mut().zip(colour).zip(gains) {
                    // The conversion saturates.
                    *pixel = (channel * factor * gain + 0.5) as u8;
                }
            }
        }
    }

    /// Returns the brightness of a place on the ground, for a pixel that covers `pixel_m`.
    fn on_ground(&self, place: Vec2, pixel_m: f32, is_floor: bool, looks: &MatchLooks) -> f32 {
        let pool = 0.5 + 0.5 * smooth(place / looks.pool_m + self.shifts[0]);
        let light = 1.0 - looks.unevenness * pool;
        let mottle = smooth(place / MOTTLE_M + self.shifts[1]);
        if is_floor {
            return light * (1.0 + 0.05 * mottle);
        }
        // Details finer than a pixel blur.
        let grain = looks.grain * (BLADE_M / pixel_m).min(1.0) * coarse(place / BLADE_M + self.shifts[2]);
        let stripe = looks.stripes.map_or(0.0, |stripes| {
            let along = self.stripe_axis.dot(place) / stripes.width_m;
            if along.rem_euclid(2.0) < 1.0 { stripes.contrast } else { -stripes.contrast }
        });
        light * (1.0 + looks.mottling * mottle + grain + stripe)
    }
}

const SKY: u8 = Label::Sky as u8;
const FLOOR: u8 = Label::Floor as u8;
const CARPET: u8 = Label::Carpet as u8;
const LINE: u8 = Label::Line as u8;

/// Returns the brightness of the wall of a hall in a direction: panels from the floor to the roof, some windows and posters, and shades
/// across all of them.
fn wall(ray: Vec3, contrast: f32) -> f32 {
    let spread = (ray.x.abs() + ray.y.abs()).max(1e-4);
    // The direction around, from 0 to 4, and the slope.
    let quarter = ray.y / spread;
    let around = if ray.x >= 0.0 { 1.0 + quarter } else { 3.0 - quarter };
    let place = Vec2::new(around, ray.z / spread);
    let shade = smooth(place * Vec2::new(3.0, 2.5));
    let panel = coarse(place * Vec2::new(7.0, 1.6) + 13.0);
    let window = if (0.22..0.5).contains(&place.y) && coarse(place * Vec2::new(2.0, 0.0) + 77.0) > 0.0 {
        // The bars between the panes are dark.
        if (12.0 * around).fract() < 0.1 { -0.8 } else { 1.2 }
    } else {
        0.0
    };
    let is_poster = place.y < 0.2 && coarse(place * Vec2::new(9.0, 4.0) + 177.0) > 0.5;
    let poster = if is_poster { coarse(place * Vec2::new(60.0, 50.0) + 31.0) } else { 0.0 };
    // The surroundings are brighter above, where the lamps are.
    1.0 + contrast * (0.5 * shade + 0.4 * panel + 0.6 * poster + window) + 0.15 * place.y.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ranges::Ranges;
    use naoisis_core::pitch::GoalColour;

    #[test]
    fn turf_gets_a_texture_bodies_get_the_light_alone_and_it_repeats() {
        let mut stream = RandomStream::for_match(2, "test");
        let ranges = Ranges::read(None).unwrap();
        let looks = MatchLooks::draw(&ranges, [GoalColour::White; 2], &mut stream);
        let looks = MatchLooks { grain: 0.15, ..looks };
        let texture = Texture::draw(&mut stream);
        let view = View::looking_at(Vec3::new(0.0, 0.0, 1.0), Vec3::X, 0.8, [64, 48]);
        let painted = |label: u8| {
            let mut image = Image {
                width: 64,
                height: 48,
                rgb: vec![100; 3 * 64 * 48],
                labels: vec![label; 64 * 48],
                ..Image::default()
            };
            texture.paint(&mut image, &view, &looks, [1.5, 1.0, 0.5]);
            image
        };
        let body = painted(20);
        assert!(body.rgb.chunks(3).all(|pixel| pixel == [150, 100, 50]));
        let turf = painted(CARPET);
        assert_eq!(turf, painted(CARPET));
        let mean = turf.rgb.iter().skip(1).step_by(3).map(|&level| f32::from(level)).sum::<f32>() / (64.0 * 48.0);
        let spread = turf.rgb.iter().skip(1).step_by(3).map(|&level| (f32::from(level) - mean).powi(2)).sum::<f32>();
        assert!((40.0..110.0).contains(&mean) && (spread / (64.0 * 48.0)).sqrt() > 2.0, "{mean} {spread}");
    }
}
