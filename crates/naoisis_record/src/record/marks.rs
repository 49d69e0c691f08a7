//! Draws marks on pictures: measures, sectors, confidence ellipses, paths.

use bevy::math::Vec2;

use super::canvas::{Anchor, Canvas, INK, PAPER, arrow_head, ellipse, width_of_words};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::geometry::{Pose, unit};
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::belief::PlaceCovariance;
use naoisis_sensing::belief::covariance::half_axes_95;

/// Orange, of the [palette](DrawColour) that people with any colour vision can tell apart.
pub const ORANGE: Colour = Colour(DrawColour::Orange.rgb());
/// Blue.
pub const BLUE: Colour = Colour(DrawColour::Blue.rgb());
/// Light blue.
pub const SKY_BLUE: Colour = Colour(DrawColour::Sky.rgb());
/// Red.
pub const VERMILION: Colour = Colour(DrawColour::Vermilion.rgb());
/// Yellow.
pub const YELLOW: Colour = Colour(DrawColour::Yellow.rgb());

/// Draws a measured distance between two places, with words in its middle or, if they do not fit, beside it.
pub fn measure(canvas: &mut Canvas, [from, to]: [Vec2; 2], words: &str, colour: Colour, patch: Option<Colour>) {
    const HEIGHT: f32 = 18.0;
    let middle = (from + to) / 2.0;
    let along = (to - from).normalize_or(Vec2::X);
    canvas.arrow(middle, from, colour, 1.6);
    canvas.arrow(middle, to, colour, 1.6);
    for end in [from, to] {
        let side = along.perp() * 7.0;
        canvas.line(&[end - side, end + side], colour, 1.6);
    }
    let width = width_of_words(words, HEIGHT);
    let is_upright = along.y.abs() > 0.7;
    let half = Vec2::new(width / 2.0 + 5.0, HEIGHT * 0.62);
    let half = if is_upright { Vec2::new(half.y, half.x) } else { half };
    if let Some(patch) = patch {
        canvas.rectangle(middle - half, 2.0 * half, patch, 1.0);
    }
    if is_upright {
        canvas.words_upwards(words, middle + Vec2::X * 0.34 * HEIGHT, HEIGHT, Anchor::Middle, colour);
    } else {
        canvas.words(words, middle + Vec2::Y * 0.34 * HEIGHT, HEIGHT, Anchor::Middle, colour);
    }
}

/// Returns the outline of the sector between distances `near` and `far` (m), within `half_angle` of `direction`, seen from `pose`.
pub fn sector(pose: Pose, direction: f32, half_angle: f32, [near, far]: [f32; 2]) -> Vec<Vec2> {
    let mut outline = arc(pose, direction, half_angle, far);
    outline.extend(arc(pose, direction, half_angle, near).into_iter().rev());
    outline
}

/// Returns points at `distance` (m) from `pose`, within `half_angle` on either side of `direction`, from right to left.
pub fn arc(pose: Pose, direction: f32, half_angle: f32, distance: f32) -> Vec<Vec2> {
    const STEPS: u8 = 24;
    let angle = |step: u8| direction + half_angle * (2.0 * f32::from(step) / f32::from(STEPS) - 1.0);
    (0..=STEPS).map(|step| pose.transform_point(distance * unit(angle(step)))).collect()
}

/// Returns the outline of the 95 % confidence ellipse. Empty if `covariance` is not a valid covariance.
pub fn confidence_ellipse(mean: Vec2, covariance: PlaceCovariance) -> Vec<Vec2> {
    half_axes_95(covariance).map(|[long, short]| ellipse(mean, long, short)).unwrap_or_default()
}

/// Returns the standard deviations of a place along and across the line from `eye` to it.
pub fn sd_along_and_across([xx, xy, yy]: PlaceCovariance, eye: Vec2, place: Vec2) -> [f32; 2] {
    let along = (place - eye).normalize_or(Vec2::X);
    [along, along.perp()].map(|axis| {
        let variance = axis.x * axis.x * xx + 2.0 * axis.x * axis.y * xy + axis.y * axis.y * yy;
        variance.max(0.0).sqrt()
    })
}

/// Draws a line that is visible on any background.
pub fn bright_line(canvas: &mut Canvas, places: &[Vec2], colour: Colour, width: f32) {
    canvas.line(places, INK, width + 2.0);
    canvas.line(places, colour, width);
}

/// Draws an arrow that is visible on any background.
pub fn bright_arrow(canvas: &mut Canvas, [from, to]: [Vec2; 2], colour: Colour, width: f32) {
    let head = arrow_head(from, to, width);
    canvas.line(&[from, (head[1] + head[2]) / 2.0], INK, width + 2.0);
    canvas.outline(&head, INK, 2.4);
    canvas.arrow(from, to, colour, width);
}

/// Draws a dot that is visible on any background.
pub fn bright_dot(canvas: &mut Canvas, place: Vec2, radius: f32, colour: Colour) {
    canvas.disc(place, radius + 1.2, INK, 1.0);
    canvas.disc(place, radius, colour, 1.0);
}

/// Draws a key to colours: a stroke of each colour and its meaning, one below the other.
pub fn key(canvas: &mut Canvas, entries: &[(Colour, &str)], at: Vec2) {
    for (row, (colour, words)) in entries.iter().enumerate() {
        let left = at + Vec2::Y * 26.0 * row as f32;
        canvas.line(&[left, left + Vec2::X * 34.0], *colour, 5.0);
        canvas.words(words, left + Vec2::new(46.0, 6.0), 18.0, Anchor::Left, INK);
    }
}

/// Draws white words with a dark edge, for pictures.
pub fn bright_words(canvas: &mut Canvas, words: &str, at: Vec2, height: f32, anchor: Anchor) {
    for offset in [Vec2::X, Vec2::Y, Vec2::NEG_X, Vec2::NEG_Y, Vec2::ONE, Vec2::NEG_ONE] {
        canvas.words(words, at + 1.2 * offset, height, anchor, INK);
    }
    canvas.words(words, at, height, anchor, PAPER);
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::ops;
    use core::f32::consts::FRAC_PI_2;

    #[test]
    fn a_sector_is_between_its_distances_and_directions() {
        let pose = Pose::new(1.0, 2.0, FRAC_PI_2);
        let outline = sector(pose, 0.3, 0.2, [0.15, 0.75]);
        for corner in &outline {
            let local = pose.inverse_transform_point(*corner);
            let distance = local.length();
            assert!((distance - 0.15).abs() < 1e-5 || (distance - 0.75).abs() < 1e-5);
            assert!((ops::atan2(local.y, local.x) - 0.3).abs() < 0.2 + 1e-5);
        }
        // Twice its area by Gauss: (0.75² - 0.15²) times the angle.
        let area: f32 = outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| a.perp_dot(*b)).sum();
        assert!((area - 0.4 * (0.75 * 0.75 - 0.15 * 0.15)).abs() < 2e-3, "{area}");
    }

    #[test]
    fn uncertainty_is_told_along_and_across_the_line_of_sight() {
        let [along, across] = sd_along_and_across([0.05, 0.04, 0.05], Vec2::ZERO, Vec2::ONE);
        assert!((along - 0.3).abs() < 1e-6 && (across - 0.1).abs() < 1e-6);
    }
}
