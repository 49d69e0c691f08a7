//! What the robots are told of the game.
//!
//! They hear at once of penalties, of `set`, and of every whistle. What a whistle means, a goal or the start of play,
//! they are told [`Rules::status_delay_s`](super::Rules::status_delay_s) later, as by the real GameController (2025: 15
//! s): until then, whoever wants to know sooner goes by [`GameStatus::whistles`].

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::game::{Game, GameState, PenaltyReason, Score, SetPlay, SetPlayKind};
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::team::Team;

/// What a robot is told of the game at the start of a cycle, as by a GameController (2010 rule book, section 3.2). It is
/// a sensor: every robot has its own, and behaviours read nothing else of the match. `state`, `score`, `kick_off_team`,
/// `drop_ball` and `set_play` may come [late](crate::game::Rules::status_delay_s).
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[non_exhaustive]
pub struct GameStatus {
    /// The state of the game.
    pub state: GameState,
    /// Goals of both teams so far.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Seconds left in this half; none where the rules have no clock.
    pub time_left_s: Option<f32>,
    /// Seconds since the start of the match.
    pub time_s: f32,
    /// The end of the pitch that this robot's team defends.
    pub own_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// Whether play was last restarted by a drop ball instead: neither team has the kick-off.
    pub drop_ball: bool,
    /// The free kick, or the kick-off that is one team's own, that is under way.
    pub set_play: Option<SetPlayStatus>,
    /// The team that shoots, in a penalty shoot-out.
    pub shoot_out: Option<Team>,
    /// Whether this robot is penalised.
    pub penalised: bool,
    /// What for, if it is.
    pub penalty: Option<PenaltyReason>,
    /// How often this robot was placed for a restart: when it changes, the robot has been placed at its kick-off
    /// position, in its team's agreed formation.
    pub restarts: u32,
    /// How often this robot was placed by hand because it stood at an illegal place: when it changes, the robot has
    /// been placed at its position for the other team's kick-off, whoever kicks off.
    pub hand_placements: u32,
    /// How many whistles there have been. The whistle is heard at once, even if the change that it means is told
    /// later.
    pub whistles: u32,
}

/// What robots are told of a free kick.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct SetPlayStatus {
    /// What it is given for.
    pub kind: SetPlayKind,
    /// The team that the ball belongs to.
    pub team: Team,
}

/// The part of the game's state of which robots may hear late.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Announcement {
    /// The state of play.
    pub state: GameState,
    /// Goals of both teams so far.
    pub score: Score,
    /// The team that has the kick-off; none at a drop ball.
    pub kick_off: Option<Team>,
    /// The free kick under way.
    pub set_play: Option<SetPlayStatus>,
    /// Cycles for which a change has been withheld.
    pub withheld_cycles: u64,
}

impl Announcement {
    /// The whole truth.
    pub fn of(game: &Game) -> Self {
        let set_play = game.set_play.map(|SetPlay { kind, team, .. }| SetPlayStatus { kind, team });
        Self { state: game.state, score: game.score, kick_off: game.kick_off(), set_play, withheld_cycles: 0 }
    }

    /// After a cycle: a change that the referee whistles (a goal, and the end of `set`) is withheld for so many
    /// cycles, as robots have to hear the whistle; any other is told at once.
    pub fn follow(&mut self, game: &Game, delay_cycles: u64) {
        let truth = Self::of(game);
        let whistled = truth.score != self.score
            || matches!(
                (self.state, truth.state),
                (GameState::Set, GameState::Playing) | (GameState::Playing, GameState::Ready)
            );
        if whistled && self.withheld_cycles < delay_cycles {
            self.withheld_cycles += 1;
        } else {
            *self = truth;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whistled_change_is_withheld_for_its_time_and_others_are_not() {
        let mut game = Game { state: GameState::Set, ..Game::default() };
        let mut told = Announcement::of(&game);
        game.state = GameState::Playing;
        let heard = (0..10).find(|_| {
            told.follow(&game, 5);
            told.state == GameState::Playing
        });
        assert_eq!(heard, Some(5));
        game.score.blue = 1;
        told.follow(&game, 5);
        assert_eq!(told.score.blue, 0);
        let mut told = Announcement::of(&Game { state: GameState::Ready, ..Game::default() });
        told.follow(&Game { state: GameState::Set, ..Game::default() }, 5);
        assert_eq!(told.state, GameState::Set);
    }

    #[test]
    fn a_goal_becomes_known_together_with_what_follows() {
        let mut game = Game { state: GameState::Playing, ..Game::default() };
        let mut told = Announcement::of(&game);
        (game.state, game.score.pink, game.kick_off_team) = (GameState::Ready, 1, Team::Blue);
        for _ in 0..3 {
            told.follow(&game, 3);
            assert_eq!((told.state, told.score.pink), (GameState::Playing, 0));
        }
        told.follow(&game, 3);
        assert_eq!((told.state, told.score.pink), (GameState::Ready, 1));
    }
}
