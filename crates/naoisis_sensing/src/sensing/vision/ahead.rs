//! Candidates for markings in view. Whether each is recognised is drawn for all of them at once, before their visibility is computed, which
//! takes longer.

use bevy::prelude::*;

use super::LandmarkKind;

/// Candidates for markings in view. Reused from robot to robot, to save memory.
#[derive(Default)]
pub(super) struct LandmarksAhead {
    pub(super) stretches: Vec<StretchAhead>,
    pub(super) marks: Vec<MarkAhead>,
}

/// A line that may be in view of a camera.
#[derive(Clone, Copy)]
pub(super) struct StretchAhead {
    pub(super) camera: usize,
    /// The ends of the line, m, robot frame.
    pub(super) ends: [Vec2; 2],
    /// The least odds against the detection of the line; after the draw, the threshold.
    pub(super) odds: f32,
}

/// A mark that may be in view of the cameras.
#[derive(Clone, Copy)]
pub(super) struct MarkAhead {
    pub(super) kind: LandmarkKind,
    /// Its position, m, robot frame.
    pub(super) place: Vec2,
}

/// Keeps the elements for which `is_kept` returns true. Like `Vec::retain_mut`, but without a branch for each element, which would often be
/// mispredicted.
pub(super) fn keep<Thing: Copy>(things: &mut Vec<Thing>, mut is_kept: impl FnMut(&mut Thing) -> bool) {
    let mut kept = 0;
    for index in 0..things.len() {
        let mut thing = things[index];
        let keeps = is_kept(&mut thing);
        things[kept] = thing;
        kept += usize::from(keeps);
    }
    things.truncate(kept);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_stays_in_its_order_and_as_it_was_changed() {
        let mut numbers = vec![5, 2, 8, 1, 4];
        keep(&mut numbers, |number| {
            *number *= 10;
            *number > 30
        });
        assert_eq!(numbers, [50, 80, 40]);
        keep(&mut numbers, |_| false);
        assert!(numbers.is_empty());
    }
}
