//! Passes: where a player meets a rolling ball, and how it announces a pass.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use serde::{Deserialize, Serialize};

use naoisis_core::ball::Rolling;

/// The distance from a robot's place at which it stops the ball, m.
const REACH_M: f32 = 0.2;
/// The steps in which the place of a rolling ball is predicted, s.
const STEP_S: f32 = 0.2;
/// How far ahead it is predicted, s.
const HORIZON_S: f32 = 6.0;

/// An announced pass.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Pass {
    /// The jersey number of the receiver.
    pub to: u8,
    /// The place where the ball is meant to stop, m, team frame.
    pub place: Vec2,
}

/// The text that players send each other: `pass 3 1.20 -0.50`.
impl fmt::Display for Pass {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "pass {} {:.2} {:.2}", self.to, self.place.x, self.place.y)
    }
}

/// A message does not announce a pass.
#[derive(Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected `pass`, a jersey number, x and y in metres")]
pub struct NotAPass;

naoisis_core::debug_as_displayed!(NotAPass);

impl FromStr for Pass {
    type Err = NotAPass;

    fn from_str(text: &str) -> Result<Self, NotAPass> {
        let mut words = text.strip_prefix("pass ").ok_or(NotAPass)?.split(' ');
        let mut next = || words.next().ok_or(NotAPass);
        let (to, x, y) = (next()?, next()?, next()?);
        let number = |word: &str| word.parse::<f32>().ok().filter(|number| number.is_finite()).ok_or(NotAPass);
        Ok(Self { to: to.parse().map_err(|_| NotAPass)?, place: Vec2::new(number(x)?, number(y)?) })
    }
}

/// Returns the place of a freely rolling ball after `time_s`, m.
pub fn rolled(ball: Vec2, velocity: Vec2, rolling: Rolling, time_s: f32) -> Vec2 {
    let (distance, _) = rolling.advance(velocity.length(), time_s);
    ball + velocity.normalize_or_zero() * distance
}

/// Returns the first place, m, and time, s, at which a robot that starts at `from` and walks at `walk_mps` meets a rolling ball. A ball
/// that is too fast is met about where it stops.
pub fn meet(ball: Vec2, velocity: Vec2, rolling: Rolling, from: Vec2, walk_mps: f32) -> (Vec2, f32) {
    let walk_s = |place: Vec2| (place.distance(from) - REACH_M).max(0.0) / walk_mps.max(1e-3);
    if velocity.length_squared() < 0.05 * 0.05 {
        return (ball, walk_s(ball));
    }
    let steps = (HORIZON_S / STEP_S) as usize;
    let places = (0..=steps).map(|step| (step as f32 * STEP_S, rolled(ball, velocity, rolling, step as f32 * STEP_S)));
    for (time_s, place) in places {
        if walk_s(place) <= time_s {
            return (place, time_s);
        }
    }
    let rest = rolled(ball, velocity, rolling, HORIZON_S);
    (rest, walk_s(rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn an_announced_pass_reads_as_it_was_meant() {
        let pass = Pass { to: 3, place: Vec2::new(1.25, -0.5) };
        assert_eq!(pass.to_string(), "pass 3 1.25 -0.50");
        assert_eq!(pass.to_string().parse(), Ok(pass));
        for text in ["", "pass", "pass 3 1.0", "pass 3 1.0 x", "pass 3 1.0 inf", "pass 300 1 1", "shot 3 1 1"] {
            assert_eq!(text.parse::<Pass>(), Err(NotAPass), "{text}");
        }
    }

    #[test]
    fn a_ball_that_rolls_by_is_met_where_it_comes_near_and_a_fast_one_where_it_rests() {
        // Towards the player: it needs not walk.
        let (place, time_s) =
            meet(Vec2::new(2.0, 0.0), Vec2::new(-1.0, 0.0), Rolling::default(), Vec2::new(0.5, 0.0), 0.2);
        // 2 - (1 - exp(-t/2)) * 2 = 0.7 at t = -2 ln(0.35) = 2.1 s; walking there meanwhile, sooner.
        assert!(time_s < 2.1 && place.x > 0.7 && place.x < 1.2, "{place} {time_s}");
        // Away from it: it rolls 1 m / 0.5 = 2 m.
        let (place, _) = meet(Vec2::new(1.0, 0.0), Vec2::new(1.0, 0.0), Rolling::default(), Vec2::ZERO, 0.2);
        assert_abs_diff_eq!(place.x, 3.0, epsilon = 0.15);
        // (1 - 0.2) m at 0.2 m/s.
        assert_abs_diff_eq!(meet(Vec2::X, Vec2::ZERO, Rolling::default(), Vec2::ZERO, 0.2).1, 4.0, epsilon = 1e-5);
    }
}
