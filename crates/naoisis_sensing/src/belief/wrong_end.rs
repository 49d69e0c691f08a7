//! Taking one end of the pitch for the other: where both look the same, nothing that a robot sees of the pitch tells it, but
//! what team-mates say of the ball does.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// A ball nearer to the centre mark than this is too near to where it would be on a pitch that is turned, m.
const LEAST_M: f32 = 1.5;
/// What a team-mate says of the ball is about the same place if it is so near, m.
const SAME_PLACE_M: f32 = 1.0;
/// So many team-mates must agree: one may itself be wrong.
const WITNESSES: usize = 2;
/// For so long they must, s: they say it more than once.
const DECISION_S: f32 = 2.0;

/// How much there is to be said for a robot's having taken one end of the pitch for the other.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct WrongEnd {
    /// For so long team-mates have said that the ball is where this robot would see it from the other end, s.
    evidence_s: f32,
}

impl WrongEnd {
    /// Compares where the robot sees the ball with where team-mates see it (m, team frame) for a cycle of `period` seconds. Returns
    /// whether it is at the other end than it thinks.
    pub fn weigh(&mut self, ball: Vec2, told: impl Iterator<Item = Vec2>, period: f32) -> bool {
        match is_mirrored(ball, told) {
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

/// Whether team-mates see the ball where this robot would see it if the pitch were turned by half a turn; none if they do not
/// say enough to tell.
fn is_mirrored(ball: Vec2, told: impl Iterator<Item = Vec2>) -> Option<bool> {
    if ball.length() < LEAST_M {
        return None;
    }
    let (mut here, mut there) = (0, 0);
    for place in told {
        here += usize::from(place.distance(ball) < SAME_PLACE_M);
        there += usize::from(place.distance(-ball) < SAME_PLACE_M);
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
    fn several_team_mates_who_see_the_ball_at_the_other_end_are_believed_after_a_while() {
        let mut wrong_end = WrongEnd::default();
        let mut weigh = |told: &[Vec2]| wrong_end.weigh(BALL, told.iter().copied(), 0.5);
        let there = [-BALL, -BALL + Vec2::X * 0.4];
        // Three cycles of half a second are not enough, nor is what was said before somebody agreed.
        assert!(!(0..3).any(|_| weigh(&there)) && !weigh(&[BALL]) && !(0..3).any(|_| weigh(&there)));
        // Who says nothing does not make it undone.
        assert!(!weigh(&[]) && weigh(&there));
        assert!(!weigh(&there), "it begins anew");
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
