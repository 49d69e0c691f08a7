//! The uneven colour of artificial turf: random numbers that are fixed to places on the ground.

use bevy::math::Vec2;

/// The distance between bright and dark places, m.
pub const MOTTLE_M: f32 = 0.6;
/// The distance between bright and dark tufts, m.
pub const TUFT_M: f32 = 0.1;
/// The shares of mottles and of tufts in the unevenness.
const SHARES: [f32; 2] = [0.6, 0.4];

/// The brightness of the turf at a place, m, pitch frame, as a multiple of the mean, for this [unevenness](naoisis_core::pitch::Pitch). Tufts
/// blur where a pixel covers `pixel_m` of the ground or more.
#[inline(always)]
pub fn brightness(place: Vec2, pixel_m: f32, unevenness: f32) -> f32 {
    let mottle = SHARES[0] * smooth(place / MOTTLE_M);
    let tuft = if pixel_m < TUFT_M { SHARES[1] * (1.0 - pixel_m / TUFT_M) * smooth(place / TUFT_M) } else { 0.0 };
    1.0 + unevenness * (mottle + tuft)
}

/// A random number from -1 to 1 that is constant in each square of side 1.
#[inline(always)]
pub fn coarse(place: Vec2) -> f32 {
    at(place.x.floor() as i32, place.y.floor() as i32)
}

/// Random numbers from -1 to 1 at the corners of squares of side 1, interpolated in between.
#[inline(always)]
pub fn smooth(place: Vec2) -> f32 {
    let whole = Vec2::new(place.x.floor(), place.y.floor());
    let share = place - whole;
    let share = share * share * (3.0 - 2.0 * share);
    let (x, y) = (whole.x as i32, whole.y as i32);
    let upper = at(x, y) + share.x * (at(x + 1, y) - at(x, y));
    let lower = at(x, y + 1) + share.x * (at(x + 1, y + 1) - at(x, y + 1));
    upper + share.y * (lower - upper)
}

/// A random number from -1 to 1 for two whole numbers.
#[inline(always)]
fn at(x: i32, y: i32) -> f32 {
    let mut bits = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    bits = (bits ^ bits >> 15).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ bits >> 12).wrapping_mul(0x297a_2d39);
    bits ^= bits >> 15;
    (bits >> 8) as i32 as f32 / (1 << 23) as f32 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turf_varies_around_its_mean_and_is_the_same_at_the_same_place() {
        let places = (0..100).flat_map(|x| (0..100).map(move |y| Vec2::new(x as f32, y as f32) * 0.1 - 5.0));
        let all: Vec<f32> = places.map(|place| brightness(place, 0.0, 0.2)).collect();
        let mean = all.iter().sum::<f32>() / all.len() as f32;
        assert!((mean - 1.0).abs() < 0.01 && all.iter().all(|light| (0.8..=1.2).contains(light)), "{mean}");
        let spread = all.iter().map(|light| (light - mean).powi(2)).sum::<f32>() / all.len() as f32;
        assert!(spread.sqrt() > 0.03, "{spread}");
        let place = Vec2::new(1.234, -2.5);
        assert_eq!(brightness(place, 0.0, 0.2), brightness(place, 0.0, 0.2));
        assert_eq!(brightness(place, 0.0, 0.0), 1.0);
    }

    #[test]
    fn brightness_changes_gradually() {
        let at = |x: f32| brightness(Vec2::new(x, 0.3), 0.0, 0.2);
        assert!((0..1000).all(|step| (at(step as f32 * 0.001) - at((step + 1) as f32 * 0.001)).abs() < 0.01));
    }
}
