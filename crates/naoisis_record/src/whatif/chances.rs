//! Finds what decided a match: the intervals in which the chance to score first changed most.
//!
//! A [`Chance`] counts which team scores first in continuations of a moment. [`swings`] compares the chances of neighbouring moments.

use serde::Serialize;

use super::{Continuation, Moment};
use naoisis_core::statistics::{self, Estimate};
use naoisis_core::team::{PerTeam, Team};

/// The longest time in which changes in the same direction count as one swing, s.
const LONGEST_S: f64 = 15.0;
/// The least share of a swing that its first and its last part have, if it has several parts.
const LEAST_END: f64 = 0.25;
/// The quantile of the standard normal distribution for a two-sided confidence of 95 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// How often each team scored first in continuations of a moment.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Chance {
    /// Time of the moment, s since the start of the match.
    pub time_s: f64,
    /// The score at that time.
    pub score: PerTeam<u32>,
    /// Number of continuations.
    pub times: usize,
    /// Number of continuations in which each team scored first.
    pub first: PerTeam<usize>,
}

impl Chance {
    /// The chance at `moment`, without continuations.
    pub fn of(moment: &Moment) -> Self {
        Self { time_s: moment.time_s, score: moment.score, times: 0, first: PerTeam { blue: 0, pink: 0 } }
    }

    /// Counts a continuation.
    pub fn note(&mut self, continuation: &Continuation) {
        self.times += 1;
        if let Some((team, _)) = continuation.first_goal {
            self.first[team] += 1;
        }
    }

    /// Returns the share of continuations in which `team` scored first, with its interval of 95 % confidence. Returns `None` without
    /// continuations.
    pub fn share(&self, team: Team) -> Option<Estimate> {
        statistics::share(self.first[team], self.times)
    }

    fn value(&self, team: Team) -> f64 {
        self.first[team] as f64 / self.times as f64
    }

    /// The variance of blue's share minus pink's.
    fn variance(&self) -> f64 {
        // Agresti and Min 2005: half a continuation is added to each outcome, so that few continuations of one outcome are not certainty.
        let [n, blue, pink] = [self.times as f64 + 2.0, self.first.blue as f64 + 0.5, self.first.pink as f64 + 0.5];
        ((blue + pink) - (blue - pink) * (blue - pink) / n) / (n * n)
    }
}

/// An event after which play starts again, so that chances before and after it are not compared.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Restart {
    /// Time of the event, s since the start of the match.
    pub time_s: f64,
    /// The team that scored; `None` for a break, such as between the halves.
    pub goal: Option<Team>,
}

/// A change of the chances that is larger than its statistical noise.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
#[non_exhaustive]
pub struct Swing {
    /// Time of its beginning, s since the start of the match.
    pub from_s: f64,
    /// Time of its end, s.
    pub until_s: f64,
    /// The score at its beginning.
    pub score: PerTeam<u32>,
    /// The team that gained.
    pub team: Team,
    /// The shares of continuations in which each team scores first, at the beginning.
    pub before: PerTeam<f64>,
    /// These shares at the end; 1 for the team that scored.
    pub after: PerTeam<f64>,
    /// Whether it ended with a goal.
    pub is_goal: bool,
    /// The gain: the change of the team's share minus the other's, with its interval of 95 % confidence.
    pub gain: Estimate,
}

/// A moment or a goal, with the chances there.
#[derive(Clone, Copy)]
struct Point {
    time_s: f64,
    score: PerTeam<u32>,
    share: PerTeam<f64>,
    variance: f64,
    is_goal: bool,
}

impl Point {
    fn of(chance: &Chance) -> Self {
        let share = PerTeam { blue: chance.value(Team::Blue), pink: chance.value(Team::Pink) };
        Self { time_s: chance.time_s, score: chance.score, share, variance: chance.variance(), is_goal: false }
    }

    fn goal(time_s: f64, team: Team) -> Self {
        let mut share = PerTeam { blue: 0.0, pink: 0.0 };
        share[team] = 1.0;
        Self { time_s, score: PerTeam { blue: 0, pink: 0 }, share, variance: 0.0, is_goal: true }
    }

    fn difference(&self) -> f64 {
        self.share.blue - self.share.pink
    }
}

/// Returns the swings of a match, the largest first, that do not overlap. A swing is the change between two neighbouring moments, or within
/// 15 s if all changes in between have the same direction. Changes within their interval of 95 % confidence are left out.
///
/// `chances` and `restarts` are in the order of their times. An interval with a goal ends at the goal, with certainty; the chances after a
/// restart are compared with each other only.
pub fn swings(chances: &[Chance], restarts: &[Restart]) -> Vec<Swing> {
    let mut found: Vec<Swing> = stretches(chances, restarts).iter().flat_map(|stretch| swings_of(stretch)).collect();
    let size = |swing: &Swing| swing.gain.value;
    found.sort_by(|one, other| size(other).total_cmp(&size(one)).then(one.from_s.total_cmp(&other.from_s)));
    let mut chosen: Vec<Swing> = Vec::new();
    for swing in found {
        let overlaps = |other: &Swing| swing.from_s < other.until_s && other.from_s < swing.until_s;
        if !chosen.iter().any(overlaps) {
            chosen.push(swing);
        }
    }
    chosen
}

/// The moments and goals between restarts.
fn stretches(chances: &[Chance], restarts: &[Restart]) -> Vec<Vec<Point>> {
    let mut chances = chances.iter().filter(|chance| chance.times > 0).peekable();
    let mut stretches = Vec::new();
    for restart in restarts {
        let mut stretch = Vec::new();
        while let Some(chance) = chances.next_if(|chance| chance.time_s < restart.time_s) {
            stretch.push(Point::of(chance));
        }
        stretch.extend(restart.goal.map(|team| Point::goal(restart.time_s, team)));
        stretches.push(stretch);
    }
    stretches.push(chances.map(Point::of).collect());
    stretches
}

/// All swings between moments of a stretch, which may overlap.
fn swings_of(points: &[Point]) -> Vec<Swing> {
    let mut found = Vec::new();
    for first in 0..points.len() {
        for last in first + 1..points.len() {
            if last > first + 1 && points[last].time_s - points[first].time_s > LONGEST_S {
                break;
            }
            found.extend(swing_of(&points[first..=last]));
        }
    }
    found
}

/// The swing from the first to the last of some points.
fn swing_of(points: &[Point]) -> Option<Swing> {
    let (first, last) = (points.first()?, points.last()?);
    let change = last.difference() - first.difference();
    let margin = Z_95 * (first.variance + last.variance).sqrt();
    let parts: Vec<f64> =
        points.windows(2).map(|pair| (pair[1].difference() - pair[0].difference()) / change).collect();
    let is_one = parts.iter().all(|part| *part >= 0.0)
        && [parts.first(), parts.last()].into_iter().flatten().all(|part| *part >= LEAST_END);
    if change.abs() <= margin || !is_one {
        return None;
    }
    let value = change.abs();
    Some(Swing {
        from_s: first.time_s,
        until_s: last.time_s,
        score: first.score,
        team: if change > 0.0 { Team::Blue } else { Team::Pink },
        before: first.share,
        after: last.share,
        is_goal: last.is_goal,
        gain: Estimate { value, low: value - margin, high: value + margin },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chances every 5 s, as (blue, pink) of 100 continuations.
    fn chances(first: &[(usize, usize)]) -> Vec<Chance> {
        let chance = |(index, &(blue, pink)): (usize, &(usize, usize))| Chance {
            time_s: 5.0 * index as f64,
            score: PerTeam { blue: 1, pink: 0 },
            times: 100,
            first: PerTeam { blue, pink },
        };
        first.iter().enumerate().map(chance).collect()
    }

    /// Beginning, end, team and gain in percent.
    fn found(chances: &[Chance], restarts: &[Restart]) -> Vec<(f64, f64, Team, f64)> {
        let numbers = |swing: &Swing| (swing.from_s, swing.until_s, swing.team, (100.0 * swing.gain.value).round());
        swings(chances, restarts).iter().map(numbers).collect()
    }

    #[test]
    fn the_interval_of_a_change_is_that_of_agresti_and_min() {
        let [swing] = swings(&chances(&[(10, 20), (70, 10)]), &[]).try_into().unwrap();
        // (10.5 + 20.5 - 10²/102) / 102² and (70.5 + 10.5 - 60²/102) / 102²; 1.96 times the root of their sum.
        let variances = (31.0 - 100.0 / 102.0 + 81.0 - 3600.0 / 102.0) / (102.0 * 102.0);
        assert!((swing.gain.value - 0.7).abs() < 1e-12);
        assert!((swing.gain.margin() - Z_95 * f64::sqrt(variances)).abs() < 1e-12);
        assert_eq!((swing.before.pink, swing.after.blue, swing.is_goal, swing.score.blue), (0.2, 0.7, false, 1));
    }

    #[test]
    fn changes_within_their_noise_are_no_swings() {
        // The margin is 0.14 here.
        assert_eq!(found(&chances(&[(20, 10), (30, 10)]), &[]), []);
        assert_eq!(found(&chances(&[(20, 10), (40, 10)]), &[]), [(0.0, 5.0, Team::Blue, 20.0)]);
        let few = chances(&[(0, 0), (2, 0)]).into_iter().map(|chance| Chance { times: 4, ..chance });
        assert_eq!(found(&few.collect::<Vec<_>>(), &[]), []);
        let mut unplayed = chances(&[(0, 0), (90, 0)]);
        unplayed[0].times = 0;
        assert_eq!(found(&unplayed, &[]), [], "nothing was played from the first moment");
    }

    #[test]
    fn a_goal_ends_its_interval_with_certainty_and_the_kick_off_is_no_swing() {
        let goal = Restart { time_s: 7.0, goal: Some(Team::Pink) };
        let chances = chances(&[(10, 10), (10, 30), (60, 0), (60, 0)]);
        // Pink's chance of 30 % - 10 % became a goal. The 60 % of blue's kick-off do not count.
        assert_eq!(found(&chances, &[goal]), [(5.0, 7.0, Team::Pink, 80.0), (0.0, 5.0, Team::Pink, 20.0)]);
        assert!(swings(&chances, &[goal])[0].is_goal);
        let half = Restart { time_s: 7.0, goal: None };
        assert_eq!(found(&chances, &[half]), [(0.0, 5.0, Team::Pink, 20.0)]);
        assert_eq!(
            found(&chances, &[Restart { time_s: 10.0, ..half }]).len(),
            1,
            "a moment at the restart is after it"
        );
    }

    #[test]
    fn a_build_up_is_one_swing_and_swings_do_not_overlap() {
        let rising = chances(&[(0, 0), (30, 0), (60, 0), (90, 0), (90, 0)]);
        assert_eq!(found(&rising, &[]), [(0.0, 15.0, Team::Blue, 90.0)]);
        // A step without a share in the swing is no part of it.
        assert_eq!(found(&chances(&[(0, 0), (3, 0), (60, 0)]), &[]), [(5.0, 10.0, Team::Blue, 57.0)]);
        let there_and_back = chances(&[(0, 0), (50, 0), (0, 0)]);
        assert_eq!(found(&there_and_back, &[]), [(0.0, 5.0, Team::Blue, 50.0), (5.0, 10.0, Team::Pink, 50.0)]);
        let long = chances(&[(0, 0), (25, 0), (50, 0), (75, 0), (95, 0)]);
        assert_eq!(found(&long, &[])[0], (0.0, 15.0, Team::Blue, 75.0), "longer than 15 s is not one swing");
    }
}
