//! The rules as data. Presets are files in `assets/rules`.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

/// What follows when the ball has left the pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BallOutRestart {
    /// Ball and robots are placed for a kick-off, as in the paper's match mode (section 3.4).
    #[default]
    KickOff,
    /// Play runs on; the ball is thrown in (2010 rule book, section 3.9).
    ThrowIn,
}

/// Where a robot comes back after a penalty.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReturnPlace {
    /// On the halfway line, at the side line farther from the ball (2010).
    #[default]
    HalfwayLine,
    /// Where it waited, level with its own penalty mark (2025).
    PenaltyMark,
}

/// The rules as data; presets are files in `assets/rules`. The default is the preset `naoisis`: the paper's match
/// mode (section 3.4).
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Rules {
    /// The preset's name, for display.
    pub name: String,
    /// Duration of a half, s.
    pub half_s: f32,
    /// Number of halves.
    pub halves: u32,
    /// Robots of a team when a scenario lines up whole teams.
    pub team_size: u8,
    /// Whether goals count and are followed by a kick-off.
    pub goals: bool,
    /// Whether a ball outside the lines is out.
    pub ball_out: bool,
    /// What follows then.
    pub ball_out_restart: BallOutRestart,
    /// Whether the halves end, sides are changed and the match is finished by the clock.
    pub clock: bool,

    /// How long a penalised robot is off the pitch, s of play: 30 (2010 rule book, section 4.3).
    pub penalty_s: f32,
    /// Whether penalties are over when play is stopped for a kick-off (2010 rule book, section 4). They always are
    /// at half time.
    pub penalties_end_at_kick_off: bool,
    /// Where robots come back.
    pub return_place: ReturnPlace,

    /// Whether the robot that is responsible for a collision is penalised.
    pub collisions: bool,
    /// A robot that walks towards the other no faster than this is not responsible, m/s.
    pub collision_speed_mps: f32,
    /// Whether that goes for collisions of team-mates, too.
    pub collisions_between_team_mates: bool,
    /// Whether the keeper, number 1, is never responsible in its own penalty area.
    pub keeper_may_push: bool,
    /// From this collision of a team on in a half, the responsible robot is removed for the rest of the half.
    pub pushing_limit: Option<u32>,

    /// Whether a robot that stands near the ball for too long is penalised.
    pub stalling: bool,
    /// For how long it may, s.
    pub stall_s: f32,
    /// How near is near, m, from the robot's origin to the ball's centre.
    pub stall_radius_m: f32,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            name: "naoisis".to_owned(),
            half_s: 600.0,
            halves: 2,
            team_size: 3,
            goals: true,
            ball_out: true,
            ball_out_restart: BallOutRestart::KickOff,
            clock: true,
            penalty_s: 30.0,
            penalties_end_at_kick_off: false,
            return_place: ReturnPlace::HalfwayLine,
            collisions: true,
            collision_speed_mps: 0.05,
            collisions_between_team_mates: false,
            keeper_may_push: false,
            pushing_limit: None,
            stalling: true,
            stall_s: 15.0,
            stall_radius_m: 0.5,
        }
    }
}

/// What is wrong with rules.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}: expected {expected}")]
pub struct RulesError {
    /// The field of [`Rules`] at fault.
    pub field: &'static str,
    /// What is wrong.
    pub message: String,
    /// What would be right.
    pub expected: String,
}

/// The longest duration that rules may have, s.
const LONGEST_S: f32 = 1e5;

impl Rules {
    /// Checks that the rules do not contradict themselves.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), RulesError> {
        in_range("halves", self.halves as f32, 1.0, 10.0, "")?;
        in_range("team_size", f32::from(self.team_size), 1.0, 11.0, " robots")?;
        // At least a thousandth of a second, so that "positive" has a limit that can be written.
        in_range("half_s", self.half_s, 1e-3, LONGEST_S, " s")?;
        in_range("penalty_s", self.penalty_s, 0.0, LONGEST_S, " s")?;
        in_range("collision_speed_mps", self.collision_speed_mps, 0.0, 10.0, " m/s")?;
        in_range("pushing_limit", self.pushing_limit.unwrap_or(1) as f32, 1.0, 1000.0, "")?;
        in_range("stall_s", self.stall_s, 1e-3, LONGEST_S, " s")?;
        in_range("stall_radius_m", self.stall_radius_m, 1e-3, 100.0, " m")
    }
}

fn in_range(field: &'static str, value: f32, least: f32, most: f32, unit: &str) -> Result<(), RulesError> {
    // A value that is no number is in no range.
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(RulesError { field, message: format!("`{field}` is {value}"), expected: format!("{least} to {most}{unit}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_that_contradict_themselves_name_the_field() {
        assert_eq!(Rules::default().validate(), Ok(()));
        let wrong = [
            ("halves", Rules { halves: 0, ..Rules::default() }),
            ("team_size", Rules { team_size: 0, ..Rules::default() }),
            ("half_s", Rules { half_s: -1.0, ..Rules::default() }),
            ("half_s", Rules { half_s: f32::NAN, ..Rules::default() }),
            ("penalty_s", Rules { penalty_s: -0.1, ..Rules::default() }),
            ("pushing_limit", Rules { pushing_limit: Some(0), ..Rules::default() }),
            ("stall_radius_m", Rules { stall_radius_m: 0.0, ..Rules::default() }),
        ];
        for (field, rules) in wrong {
            assert_eq!(rules.validate().map_err(|error| error.field), Err(field));
        }
    }
}
