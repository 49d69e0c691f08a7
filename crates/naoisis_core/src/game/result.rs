//! The result of a match, and what decided it.

use bevy::prelude::*;
use core::fmt;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use super::{Game, Rules, Score};
use crate::team::Team;

/// What decided a match.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Reflect, Serialize, Deserialize, IntoStaticStr,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum DecidedBy {
    /// Play in its halves.
    #[default]
    Play,
    /// The extra time.
    ExtraTime,
    /// The shots of a shoot-out.
    ShootOut,
    /// A coin, after a shoot-out without a winner.
    Coin,
}

impl DecidedBy {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The result of a match: who has won, and how.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct MatchResult {
    /// Goals of both teams, without those of a shoot-out.
    pub score: Score,
    /// The winner; `None` for a draw.
    pub winner: Option<Team>,
    /// What decided the match, or ended it as a draw.
    pub decided_by: DecidedBy,
    /// Goals of both teams in a shoot-out, if there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shoot_out: Option<Score>,
}

impl Game {
    /// The result so far.
    pub fn result(&self, rules: &Rules) -> MatchResult {
        let by_play = if rules.is_extra_time(self.half) { DecidedBy::ExtraTime } else { DecidedBy::Play };
        let (winner, decided_by) = match self.shoot_out {
            Some(shoot_out) if shoot_out.coin => (shoot_out.winner, DecidedBy::Coin),
            Some(shoot_out) => (shoot_out.winner, DecidedBy::ShootOut),
            None => (self.score.leader(), by_play),
        };
        MatchResult { score: self.score, winner, decided_by, shoot_out: self.shoot_out.map(|shots| shots.goals) }
    }
}

impl MatchResult {
    /// Returns what there is to say besides the score: extra time, or a shoot-out with its goals and its winner.
    pub fn how(&self) -> Option<String> {
        let shots = self.shoot_out.map(|shots| format!("penalty shoot-out {} : {}", shots.blue, shots.pink));
        match (self.decided_by, self.winner, shots) {
            (DecidedBy::ExtraTime, ..) => Some("after extra time".to_owned()),
            (DecidedBy::ShootOut, Some(winner), Some(shots)) => {
                let as_many = self.shoot_out.is_some_and(|goals| goals.blue == goals.pink);
                let why = if as_many { ", whose last shot was the better one" } else { "" };
                Some(format!("{shots}, won by {winner}{why}"))
            }
            (DecidedBy::Coin, Some(winner), Some(shots)) => {
                Some(format!("{shots}, won by {winner} by the toss of a coin"))
            }
            (.., shots) => shots,
        }
    }
}

impl fmt::Display for MatchResult {
    /// Writes the score and, in parentheses, [`how`](Self::how) the match was decided.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = self.how().map(|how| format!(" ({how})")).unwrap_or_default();
        write!(formatter, "blue {} : {} pink{how}", self.score.blue, self.score.pink)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::game::ShootOut;

    #[test]
    fn a_result_says_how_it_came_about() {
        let (rules, score) = (Rules::default(), |blue, pink| Score { blue, pink });
        let told = |game: Game| game.result(&rules).to_string();
        let game = Game { score: score(2, 1), half: 2, ..Game::default() };
        assert_eq!(told(game.clone()), "blue 2 : 1 pink");
        assert_eq!(game.result(&rules).winner, Some(Team::Blue));
        assert_eq!(told(Game { half: 4, ..game }), "blue 2 : 1 pink (after extra time)");
        let drawn = |shoot_out| Game { score: score(1, 1), half: 2, shoot_out, ..Game::default() };
        assert_eq!(drawn(None).result(&rules), MatchResult { score: score(1, 1), ..default() });
        let shots = ShootOut { goals: score(2, 3), winner: Some(Team::Pink), ..default() };
        assert_eq!(told(drawn(Some(shots))), "blue 1 : 1 pink (penalty shoot-out 2 : 3, won by pink)");
        let better = ShootOut { goals: score(2, 2), winner: Some(Team::Blue), ..default() };
        assert!(told(drawn(Some(better))).ends_with("2 : 2, won by blue, whose last shot was the better one)"));
        let coin = ShootOut { goals: score(2, 2), winner: Some(Team::Blue), coin: true, ..default() };
        let told = told(drawn(Some(coin)));
        assert_eq!(told, "blue 1 : 1 pink (penalty shoot-out 2 : 2, won by blue by the toss of a coin)");
    }
}
