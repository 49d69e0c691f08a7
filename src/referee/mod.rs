//! The referee: game states, score, halves, goals and outs.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::robot::Team;

/// The state of the game (2010 rule book, section 3.2).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GameState {
    /// Before the match.
    #[default]
    Initial,
    /// Robots walk to their places for a kick-off.
    Ready,
    /// Robots stand and wait for the whistle.
    Set,
    /// The ball is in play.
    Playing,
    /// After the final whistle.
    Finished,
}

/// A number for each team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Score {
    /// Of the blue team.
    pub blue: u32,
    /// Of the pink team.
    pub pink: u32,
}

impl Score {
    /// The number of this team.
    pub fn of(self, team: Team) -> u32 {
        match team {
            Team::Blue => self.blue,
            Team::Pink => self.pink,
        }
    }

    /// The number of this team, to change it.
    pub fn of_mut(&mut self, team: Team) -> &mut u32 {
        match team {
            Team::Blue => &mut self.blue,
            Team::Pink => &mut self.pink,
        }
    }
}

/// The true state of the match.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Game {
    /// The state.
    pub state: GameState,
    /// Goals.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Cycles left in this half.
    pub cycles_left: u64,
    /// Which end the blue team defends.
    pub blue_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// How often the robots were placed for a restart.
    pub restarts: u32,
}

impl Game {
    /// The end that `team` defends.
    pub fn own_end(&self, team: Team) -> End {
        match team {
            Team::Blue => self.blue_end,
            Team::Pink => self.blue_end.opposite(),
        }
    }
}

/// What a robot is told of the game, as by a GameController.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct GameStatus {
    /// The state of the game.
    pub state: GameState,
    /// Goals.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Seconds left in this half.
    pub time_left_s: f32,
    /// Seconds since the start of the match.
    pub time_s: f32,
    /// The end of the pitch that this robot's team defends.
    pub own_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// Whether this robot is penalised.
    pub penalised: bool,
    /// How often the robots were placed for a restart: it changes when the robot has been placed at its
    /// kick-off position, in its team's agreed formation.
    pub restarts: u32,
}

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

/// The rules as data; presets are files in `assets/rules`.
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
