//! What is painted on the ground and may be in view, of what is recognised at random: the dice are thrown for all of it at once, before it
//! is asked what is in view indeed, which takes longer.

use bevy::prelude::*;

use super::LandmarkKind;

/// What may be in view. Kept from robot to robot, so that its memory is.
#[derive(Default)]
pub(super) struct LandmarksAhead {
    pub(super) stretches: Vec<StretchAhead>,
    pub(super) marks: Vec<MarkAhead>,
}

/// A line that a camera may see a stretch of.
#[derive(Clone, Copy)]
pub(super) struct StretchAhead {
    pub(super) side: usize,
    /// Its ends, m, robot frame.
    pub(super) ends: [Vec2; 2],
    /// How much is against it at least, and later how much may be.
    pub(super) odds: f32,
}

/// A mark that the cameras may see.
#[derive(Clone, Copy)]
pub(super) struct MarkAhead {
    pub(super) kind: LandmarkKind,
    /// Where it is, m, robot frame.
    pub(super) place: Vec2,
}

/// Keeps those things which `is_kept`, as `Vec::retain_mut` does, but without a branch on each: it is at random.
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
