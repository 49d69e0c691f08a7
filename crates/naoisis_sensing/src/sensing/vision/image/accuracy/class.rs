//! The accuracy for one class of objects.

use bevy::math::{Vec2, ops};

/// The least number of pixels with which an object is visible.
pub const LEAST_PIXELS: usize = 30;

/// An object that could be seen in a look.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SceneSighting {
    /// The true position, m, robot frame.
    pub real: Vec2,
    /// The measured position, m, robot frame; `None` if the object was not detected.
    pub seen: Option<Vec2>,
    /// Whether at least [`LEAST_PIXELS`] of the object are in an image; for a penalty cross, nearly all of it.
    pub is_visible: bool,
    /// Whether a [geometric vision](crate::sensing::vision) without errors detects the object.
    pub is_in_view: bool,
}

impl SceneSighting {
    /// The true distance, m.
    pub fn distance_m(&self) -> f32 {
        self.real.length()
    }

    /// The relative error of the measured distance; `None` if the object was not detected.
    pub fn range_error(&self) -> Option<f32> {
        Some(self.seen?.length() / self.distance_m().max(0.01) - 1.0)
    }

    /// The error of the measured direction, radians; `None` if the object was not detected.
    pub fn bearing_error(&self) -> Option<f32> {
        let seen = self.seen?;
        Some(ops::atan2(self.real.perp_dot(seen), self.real.dot(seen)))
    }
}

/// The accuracy for one class of objects.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ClassAccuracy {
    /// All objects of the class, look by look.
    pub sightings: Vec<SceneSighting>,
    /// The number of false detections in all looks.
    pub false_detections: usize,
}

impl ClassAccuracy {
    /// The visible objects at distances in this range, m.
    pub fn visible(&self, [from_m, to_m]: [f32; 2]) -> impl Iterator<Item = &SceneSighting> {
        self.sightings
            .iter()
            .filter(move |sighting| sighting.is_visible && (from_m..to_m).contains(&sighting.distance_m()))
    }

    /// The share of visible objects at distances in this range, m, that were detected; 1 if there were none.
    pub fn found_share(&self, distances_m: [f32; 2]) -> f32 {
        let (mut visible, mut found) = (0, 0);
        for sighting in self.visible(distances_m) {
            visible += 1;
            found += usize::from(sighting.seen.is_some());
        }
        if visible == 0 { 1.0 } else { found as f32 / visible as f32 }
    }

    /// The quantile `share` of the relative error of the distance, for detections at distances in this range, m.
    pub fn range_error(&self, distances_m: [f32; 2], share: f32) -> f32 {
        quantile(self.visible(distances_m).filter_map(SceneSighting::range_error), share)
    }

    /// The quantile `share` of the error of the direction, radians.
    pub fn bearing_error(&self, distances_m: [f32; 2], share: f32) -> f32 {
        quantile(self.visible(distances_m).filter_map(SceneSighting::bearing_error), share)
    }

    /// Compares the detections `seen` with the objects `there`. Each object is matched with the nearest detection within the tolerance. A
    /// detection far from all positions in `all` is false.
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

/// A true object.
#[derive(Clone, Copy, Debug)]
pub(super) struct There {
    /// Its position, m, robot frame.
    pub(super) place: Vec2,
    pub(super) is_visible: bool,
    pub(super) is_in_view: bool,
}

/// The greatest distance of a detection from its object, m: 20 cm and a quarter of the distance.
pub(super) fn tolerance_m(distance_m: f32) -> f32 {
    0.2 + 0.25 * distance_m
}

/// The quantile `share` of the magnitudes; zero without values.
fn quantile(values: impl Iterator<Item = f32>, share: f32) -> f32 {
    let mut sorted: Vec<f32> = values.map(f32::abs).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.get((share * (sorted.len() as f32 - 1.0)).round() as usize).copied().unwrap_or(0.0)
}
