//! A stable order of other robots in observations: each keeps its number while it is followed.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The greatest distance between two places of one robot in consecutive observations, m.
const GATE_M: f32 = 1.0;

/// A number in the list of other robots.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(crate) struct Track {
    /// The last place of its robot, m, in a frame that does not move with the observer.
    place_m: Vec2,
    /// The index of the robot in the current list; `None` if it is not in it.
    pub index: Option<usize>,
    /// The number of observations without the robot.
    missed: u32,
}

/// Updates `tracks`, at most `count`, by the current `places` of robots, m: near places are of the same robot, and a robot that is new gets the
/// first free number, or that of the robot that was missed for longest.
pub(super) fn follow(tracks: &mut Vec<Track>, places: &[Vec2], count: u8) {
    let mut pairs: Vec<(f32, usize, usize)> = Vec::new();
    for (number, track) in tracks.iter_mut().enumerate() {
        track.index = None;
        let near = places.iter().map(|place| place.distance(track.place_m)).enumerate();
        pairs.extend(near.filter(|(_, m)| *m <= GATE_M).map(|(index, m)| (m, number, index)));
    }
    pairs.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    let mut is_taken = vec![false; places.len()];
    for (_, number, index) in pairs {
        if tracks[number].index.is_none() && !is_taken[index] {
            tracks[number] = Track { place_m: places[index], index: Some(index), missed: 0 };
            is_taken[index] = true;
        }
    }
    for (index, place_m) in places.iter().enumerate().filter(|(index, _)| !is_taken[*index]) {
        let track = Track { place_m: *place_m, index: Some(index), missed: 0 };
        if tracks.len() < usize::from(count) {
            tracks.push(track);
            continue;
        }
        let free = tracks.iter_mut().filter(|track| track.index.is_none());
        // Of equal ones the first.
        if let Some(oldest) = free.reduce(|oldest, other| if other.missed > oldest.missed { other } else { oldest }) {
            *oldest = track;
        }
    }
    for track in tracks.iter_mut().filter(|track| track.index.is_none()) {
        track.missed = track.missed.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn indices(tracks: &[Track]) -> Vec<Option<usize>> {
        tracks.iter().map(|track| track.index).collect()
    }

    #[test]
    fn robots_keep_their_numbers_while_they_pass_each_other() {
        let mut tracks = Vec::new();
        for step in 0..=20 {
            let x = -2.0 + 0.2 * step as f32;
            // The nearer one is first in each list.
            let places = [Vec2::new(x, 0.3), Vec2::new(-x, -0.3)];
            let is_swapped = step > 10;
            let list = if is_swapped { [places[1], places[0]] } else { places };
            follow(&mut tracks, &list, 3);
            let expected = if is_swapped { [Some(1), Some(0)] } else { [Some(0), Some(1)] };
            assert_eq!(indices(&tracks), expected, "step {step}");
        }
    }

    #[test]
    fn a_robot_that_comes_back_has_its_number_and_a_new_one_gets_the_longest_missed() {
        let [a, b, c] = [Vec2::ZERO, Vec2::new(3.0, 0.0), Vec2::new(-3.0, 0.0)];
        let mut tracks = Vec::new();
        follow(&mut tracks, &[a, b], 2);
        follow(&mut tracks, &[b], 2);
        assert_eq!(indices(&tracks), [None, Some(0)]);
        follow(&mut tracks, &[b, a], 2);
        assert_eq!(indices(&tracks), [Some(1), Some(0)]);
        follow(&mut tracks, &[b], 2);
        follow(&mut tracks, &[c, b], 2);
        assert_eq!(indices(&tracks), [Some(0), Some(1)]);
        follow(&mut tracks, &[c, b, a], 2);
        assert_eq!(indices(&tracks), [Some(0), Some(1)], "there are no more numbers");
    }
}
