//! The state of a penalty shoot-out, and when it is decided (2010 rule book, section 3.8; 2025 rule book, section 3.19).
//! [`referee::shoot_out`](crate::referee::shoot_out) judges the shots.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Rules, Score, ShootOutProcedure};
use crate::team::Team;

/// Least advantage in time by which one of two goals wins in sudden death, s.
const FASTER_S: f32 = 2.0;
/// Least advantage in distance by which one of two balls wins in sudden death without goals, m.
const NEARER_M: f32 = 0.05;

/// A shoot-out under way.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct ShootOut {
    /// The team that shoots.
    pub team: Team,
    /// Shots that each team has taken.
    pub taken: Score,
    /// Goals of each team.
    pub goals: Score,
    /// The shot under way.
    pub shot: Shot,
    /// The last shot of each team, blue first.
    pub last: [Shot; 2],
    /// The winner, once there is one.
    pub winner: Option<Team>,
    /// Whether a coin decided.
    pub coin: bool,
}

/// The rank of a shot, the worst first (2025 rule book, section 3.19.2).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotRank {
    /// The attacker did not play the ball.
    #[default]
    NoKick,
    /// The attacker played the ball.
    Kick,
    /// The ball crossed the goal line beside the goal.
    BesideGoal,
    /// The ball hit a post.
    Post,
    /// The keeper blocked the ball.
    Blocked,
    /// Goal.
    Goal,
}

/// A shot of the shoot-out, under way or over.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Shot {
    /// Whether it scored.
    pub scored: bool,
    /// Its rank.
    pub rank: ShotRank,
    /// Duration in cycles.
    pub cycles: u64,
    /// Least distance of the ball's centre from the line between the posts, m.
    pub nearest_m: f32,
}

impl Default for Shot {
    fn default() -> Self {
        // No ball is farther away than this, and every number in a trace is finite.
        Self { scored: false, rank: ShotRank::NoKick, cycles: 0, nearest_m: 1000.0 }
    }
}

/// The outcome of a shoot-out so far.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Standing {
    /// Undecided.
    Open,
    /// This team has won.
    Won(Team),
    /// Sudden death is over undecided: a coin decides.
    Coin,
}

impl ShootOut {
    /// Longest duration of the shot under way, s.
    pub fn shot_s(&self, rules: &Rules) -> f32 {
        let sudden_death = self.taken.blue.min(self.taken.pink) >= rules.shoot_out_shots;
        rules.sudden_death_s.filter(|_| sudden_death).unwrap_or(rules.shoot_out_s)
    }

    /// The outcome after a shot, with cycles of `period_s`.
    pub fn standing(&self, rules: &Rules, period_s: f64) -> Standing {
        let shots = rules.shoot_out_shots;
        let (blue, pink) = (self.goals.blue, self.goals.pink);
        if self.taken.blue.min(self.taken.pink) < shots {
            // Decided as soon as one team cannot draw level any more.
            let most = |team: Team| self.goals[team] + shots.saturating_sub(self.taken[team]);
            let beyond_reach = Team::BOTH.into_iter().find(|team| self.goals[*team] > most(team.opponent()));
            return beyond_reach.map_or(Standing::Open, Standing::Won);
        }
        if self.taken.blue != self.taken.pink {
            return Standing::Open;
        }
        if blue != pink {
            return Standing::Won(if blue > pink { Team::Blue } else { Team::Pink });
        }
        if self.taken.blue == shots {
            return Standing::Open;
        }
        let [first, second] = self.last;
        let lead = match rules.shoot_out_procedure {
            ShootOutProcedure::Spl2025 => f32::from(first.rank as i8 - second.rank as i8),
            ShootOutProcedure::Spl2010 if first.scored => {
                let seconds = |shot: Shot| (shot.cycles as f64 * period_s) as f32;
                (seconds(second) - seconds(first)) / FASTER_S
            }
            ShootOutProcedure::Spl2010 => (second.nearest_m - first.nearest_m) / NEARER_M,
        };
        if lead >= 1.0 {
            Standing::Won(Team::Blue)
        } else if lead <= -1.0 {
            Standing::Won(Team::Pink)
        } else if self.taken.blue >= shots + rules.sudden_death_shots {
            Standing::Coin
        } else {
            Standing::Open
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 1.0 / 30.0;

    fn after(taken: [u32; 2], goals: [u32; 2]) -> ShootOut {
        let score = |[blue, pink]: [u32; 2]| Score { blue, pink };
        ShootOut { taken: score(taken), goals: score(goals), ..ShootOut::default() }
    }

    #[test]
    fn it_is_decided_when_one_team_cannot_be_reached() {
        let standing = |taken, goals| after(taken, goals).standing(&Rules::default(), PERIOD_S);
        assert_eq!(standing([3, 3], [3, 0]), Standing::Won(Team::Blue));
        assert_eq!(standing([3, 3], [2, 0]), Standing::Open);
        assert_eq!(standing([3, 2], [0, 2]), Standing::Open);
        assert_eq!(standing([5, 4], [2, 3]), Standing::Won(Team::Pink));
        assert_eq!(standing([5, 5], [2, 2]), Standing::Open);
        assert_eq!(standing([6, 5], [3, 2]), Standing::Open);
        assert_eq!(standing([6, 6], [3, 2]), Standing::Won(Team::Blue));
    }

    #[test]
    fn sudden_death_is_decided_by_time_then_by_distance_then_by_a_coin() {
        let shot = |scored, cycles, nearest_m| Shot { scored, cycles, nearest_m, ..Shot::default() };
        let standing = |taken, blue, pink| {
            let goals = if taken == 6 { [3, 3] } else { [5, 5] };
            ShootOut { last: [blue, pink], ..after([taken; 2], goals) }.standing(&Rules::default(), PERIOD_S)
        };
        // 2 s are 60 cycles.
        assert_eq!(standing(6, shot(true, 300, 0.0), shot(true, 361, 0.0)), Standing::Won(Team::Blue));
        assert_eq!(standing(6, shot(true, 300, 0.0), shot(true, 359, 0.0)), Standing::Open);
        assert_eq!(standing(6, shot(false, 9, 0.4), shot(false, 9, 0.34)), Standing::Won(Team::Pink));
        assert_eq!(standing(6, shot(false, 9, 0.4), shot(false, 9, 0.36)), Standing::Open);
        assert_eq!(standing(10, shot(false, 9, 0.4), shot(false, 9, 0.4)), Standing::Coin);
    }

    #[test]
    fn by_the_rules_of_2025_the_better_of_two_shots_decides_sudden_death() {
        let rules = Rules {
            shoot_out_procedure: ShootOutProcedure::Spl2025,
            shoot_out_shots: 3,
            sudden_death_shots: 3,
            sudden_death_s: Some(20.0),
            ..Rules::default()
        };
        let standing = |taken, ranks: [ShotRank; 2]| {
            let last = ranks.map(|rank| Shot { rank, ..Shot::default() });
            ShootOut { last, ..after([taken; 2], [1, 1]) }.standing(&rules, PERIOD_S)
        };
        assert_eq!(standing(3, [ShotRank::Post, ShotRank::NoKick]), Standing::Open);
        assert_eq!(standing(4, [ShotRank::Post, ShotRank::BesideGoal]), Standing::Won(Team::Blue));
        assert_eq!(standing(4, [ShotRank::Kick, ShotRank::Blocked]), Standing::Won(Team::Pink));
        assert_eq!(standing(5, [ShotRank::Goal, ShotRank::Goal]), Standing::Open);
        assert_eq!(standing(6, [ShotRank::Goal, ShotRank::Goal]), Standing::Coin);
        assert_eq!([after([3, 2], [0, 0]).shot_s(&rules), after([3, 3], [0, 0]).shot_s(&rules)], [60.0, 20.0]);
    }
}
