//! Detection of a pose at the wrong end of a symmetric pitch, by the balls that team-mates report: landmarks cannot distinguish the ends.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The least distance of the ball from the centre mark, m: a nearer ball would be at almost the same position on the rotated pitch.
const LEAST_M: f32 = 0.7;
/// The greatest distance between the same ball seen by two robots, m, and as a share of its distance from the centre mark.
const SAME_PLACE_M: f32 = 1.0;
const SAME_PLACE_SHARE: f32 = 0.6;
/// The number of team-mates that must agree, as one may itself be wrong.
const WITNESSES: usize = 2;
/// The time for which they must agree, s.
const DECISION_S: f32 = 2.0;

/// The evidence that the pose of a robot is at the wrong end of the pitch.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct WrongEnd {
    /// The time for which team-mates have reported the ball where this robot would see it from the other end, s.
    evidence_s: f32,
}

impl WrongEnd {
    /// Compares the ball that the robot sees with the `reported` ones of team-mates (m, team frame) for a cycle of `period` seconds.
    /// Returns whether the pose is at the wrong end.
    pub fn weigh(&mut self, ball: Vec2, reported: impl Iterator<Item = Vec2>, period: f32) -> bool {
        match is_mirrored(ball, reported) {
            Some(true) => self.evidence_s += period,
            Some(false) => self.evidence_s = 0.0,
            None => {}
        }
        let is_sure = self.evidence_s >= DECISION_S;
        if is_sure {
            *self = Self::default();
        }
        is_sure
    }
}

/// Whether team-mates report the ball where this robot would see it from the other end; `None` if their reports are not sufficient.
fn is_mirrored(ball: Vec2, reported: impl Iterator<Item = Vec2>) -> Option<bool> {
    if ball.length() < LEAST_M {
        return None;
    }
    let same_m = SAME_PLACE_M.min(SAME_PLACE_SHARE * ball.length());
    let (mut here, mut there) = (0, 0);
    for place in reported {
        here += usize::from(place.distance(ball) < same_m);
        there += usize::from(place.distance(-ball) < same_m);
    }
    match (here, there) {
        (0, 0) => None,
        _ if there > here && there >= WITNESSES => Some(true),
        _ if here >= there => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Vec2 = Vec2::new(3.0, -1.0);

    #[test]
    fn several_team_mates_that_see_the_ball_at_the_other_end_are_believed_after_a_while() {
        let mut wrong_end = WrongEnd::default();
        let mut weigh = |told: &[Vec2]| wrong_end.weigh(BALL, told.iter().copied(), 0.5);
        let there = [-BALL, -BALL + Vec2::X * 0.4];
        // Three cycles of half a second are not enough, and a report that agrees with the robot resets the evidence.
        assert!(!(0..3).any(|_| weigh(&there)) && !weigh(&[BALL]) && !(0..3).any(|_| weigh(&there)));
        // A cycle without reports does not reset the evidence.
        assert!(!weigh(&[]) && weigh(&there));
        assert!(!weigh(&there), "the evidence starts from zero");
    }

    #[test]
    fn one_team_mate_may_be_wrong_itself_and_a_ball_in_the_middle_says_nothing() {
        assert_eq!(is_mirrored(BALL, [-BALL].into_iter()), None);
        assert_eq!(is_mirrored(BALL, [-BALL, -BALL, BALL].into_iter()), Some(true));
        assert_eq!(is_mirrored(BALL, [-BALL, BALL].into_iter()), Some(false));
        assert_eq!(is_mirrored(BALL, [Vec2::ZERO].into_iter()), None);
        let middle = Vec2::new(0.4, 0.3);
        assert_eq!(is_mirrored(middle, [-middle; 3].into_iter()), None);
    }
}
