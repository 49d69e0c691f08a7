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
        }
    }
}
