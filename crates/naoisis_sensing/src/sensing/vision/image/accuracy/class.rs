//! What came of one class of things.

use bevy::math::{Vec2, ops};

/// A thing counts as visible with at least so many of its pixels in an image.
pub const LEAST_PIXELS: usize = 30;

/// A thing that was there to be seen in a look.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SceneSighting {
    /// Where it is, m, robot frame.
    pub real: Vec2,
    /// Where it was seen, m, robot frame; none if it was not.
    pub seen: Option<Vec2>,
    /// Whether at least [`LEAST_PIXELS`] of it are in an image; of a penalty cross, nearly all of it.
    pub is_visible: bool,
    /// Whether a [geometric vision](crate::sensing::vision) without errors sees it.
    pub is_in_view: bool,
}

impl SceneSighting {
    /// How far away it is, m.
    pub fn distance_m(&self) -> f32 {
        self.real.length()
    }

    /// By how much further away it was seen than it is, as a share of that; none if it was not seen.
    pub fn range_error(&self) -> Option<f32> {
        Some(self.seen?.length() / self.distance_m().max(0.01) - 1.0)
    }

    /// By how much its direction was seen wrongly, radians; none if it was not seen.
    pub fn bearing_error(&self) -> Option<f32> {
        let seen = self.seen?;
        Some(ops::atan2(self.real.perp_dot(seen), self.real.dot(seen)))
    }
}

/// What came of one class of things.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ClassAccuracy {
    /// Everything of it that was there, look by look.
    pub sightings: Vec<SceneSighting>,
    /// Things found where there are none, in all looks.
    pub false_detections: usize,
}

impl ClassAccuracy {
    /// Those that were visible and between two distances away, m.
    pub fn visible(&self, [from_m, to_m]: [f32; 2]) -> impl Iterator<Item = &SceneSighting> {
        self.sightings
            .iter()
            .filter(move |sighting| sighting.is_visible && (from_m..to_m).contains(&sighting.distance_m()))
    }

    /// Share of the visible ones at some distances, m, that were found; one if there were none.
    pub fn found_share(&self, distances_m: [f32; 2]) -> f32 {
        let (mut visible, mut found) = (0, 0);
        for sighting in self.visible(distances_m) {
            visible += 1;
            found += usize::from(sighting.seen.is_some());
        }
        if visible == 0 { 1.0 } else { found as f32 / visible as f32 }
    }

    /// The error of the distance that this share of those stays below that were found at some distances, m; as a share of it.
    pub fn range_error(&self, distances_m: [f32; 2], share: f32) -> f32 {
        quantile(self.visible(distances_m).filter_map(SceneSighting::range_error), share)
    }

    /// The same of the direction, radians.
    pub fn bearing_error(&self, distances_m: [f32; 2], share: f32) -> f32 {
        quantile(self.visible(distances_m).filter_map(SceneSighting::bearing_error), share)
    }

    /// Compares what was seen with what was there: a thing is found by what was seen nearest to it, if that is near. `all` are
    /// where seeing one is not false.
    pub(super) fn judge(&mut self, seen: &[Vec2], there: &[There], all: &[Vec2]) {
        for &There { place, is_visible, is_in_view } in there {
            let near = seen.iter().filter(|seen| seen.distance(place) < tolerance_m(place.length()));
            let nearest = near.min_by(|one, other| one.distance(place).total_cmp(&other.distance(place)));
            self.sightings.push(SceneSighting { real: place, seen: nearest.copied(), is_visible, is_in_view });
        }
        let is_false = |seen: &&Vec2| all.iter().all(|place| place.distance(**seen) >= tolerance_m(place.length()));
        self.false_detections += seen.iter().filter(is_false).count();
    }
}

/// A thing that is there.
#[derive(Clone, Copy, Debug)]
pub(super) struct There {
    /// Where, m, robot frame.
    pub(super) place: Vec2,
    pub(super) is_visible: bool,
    pub(super) is_in_view: bool,
}

/// What is found this far from where it is was found, m: 20 cm and a quarter of the distance.
pub(super) fn tolerance_m(distance_m: f32) -> f32 {
    0.2 + 0.25 * distance_m
}

/// What this share of the magnitudes stays below; nought without any.
fn quantile(values: impl Iterator<Item = f32>, share: f32) -> f32 {
    let mut sorted: Vec<f32> = values.map(f32::abs).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.get((share * (sorted.len() as f32 - 1.0)).round() as usize).copied().unwrap_or(0.0)
}
