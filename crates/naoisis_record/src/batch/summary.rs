//! The results of a batch, summarised for each variant.

use serde::Serialize;

use super::observer::MatchRow;
use naoisis_core::game::DecidedBy;
use naoisis_core::statistics::{Estimate, mean, rounded, share};
use naoisis_core::team::{PerTeam, Team};

/// The result of the valid matches of one variant, with 95 % confidence.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Summary {
    /// Valid matches.
    pub matches: usize,
    /// Matches that failed.
    pub failed: usize,
    /// Whether all seeds played the same match: nothing was random, and the intervals mean nothing.
    pub repeated: bool,
    /// Matches that extra time decided.
    pub by_extra_time: usize,
    /// Matches that a shoot-out decided.
    pub by_shoot_out: usize,
    /// Matches that a coin toss decided.
    pub by_coin: usize,
    /// The share of matches that blue won, including by a shoot-out or a coin toss.
    pub blue_wins: Option<Estimate>,
    /// The share of draws.
    pub draws: Option<Estimate>,
    /// The share of matches that pink won.
    pub pink_wins: Option<Estimate>,
    /// Blue's share of the wins.
    pub blue_share_of_wins: Option<Estimate>,
    /// Blue's goals in a match.
    pub blue_goals: Option<Estimate>,
    /// Pink's goals in a match.
    pub pink_goals: Option<Estimate>,
    /// Blue's goals minus pink's.
    pub goal_difference: Option<Estimate>,
    /// The share of blue's passes that were completed.
    pub blue_kept: Option<Estimate>,
    /// The share of pink's passes that were completed.
    pub pink_kept: Option<Estimate>,
    /// Penalties against blue in a match.
    pub blue_penalties: Option<Estimate>,
    /// Penalties against pink in a match.
    pub pink_penalties: Option<Estimate>,
    /// Blue's share of the possession.
    pub blue_possession: Option<Estimate>,
    /// Share of the time with the ball in blue's half.
    pub ball_in_blue_half: Option<Estimate>,
    /// The median pose error of blue's robots, m.
    pub blue_belief_error_m: Option<Estimate>,
    /// The median pose error of pink's robots, m.
    pub pink_belief_error_m: Option<Estimate>,
    /// The share of the time in which the pose error of a robot of blue is over 0.5 m.
    pub blue_belief_over_half_m: Option<Estimate>,
    /// The share of the time in which the pose error of a robot of pink is over 0.5 m.
    pub pink_belief_over_half_m: Option<Estimate>,
    /// The share of the time in which the pose error of a robot of blue is over 1 m.
    pub blue_belief_over_1_m: Option<Estimate>,
    /// The share of the time in which the pose error of a robot of pink is over 1 m.
    pub pink_belief_over_1_m: Option<Estimate>,
}

impl Summary {
    /// Summarises the rows of one variant.
    pub fn of<'a>(rows: impl Iterator<Item = &'a MatchRow>) -> Self {
        let (valid, failed): (Vec<&MatchRow>, Vec<&MatchRow>) = rows.partition(|row| row.outcome.is_valid());
        let wins = |team: Team| valid.iter().filter(|row| row.winner == Some(team)).count();
        let decided = |by: DecidedBy| valid.iter().filter(|row| row.decided_by == by).count();
        let (blue_wins, pink_wins) = (wins(Team::Blue), wins(Team::Pink));
        let mean_of = |value: &dyn Fn(&MatchRow) -> Option<f64>| {
            mean(&valid.iter().filter_map(|row| value(row)).collect::<Vec<f64>>())
        };
        let share_of = |value: &dyn Fn(&MatchRow) -> Option<f64>| mean_of(value).map(Estimate::of_share);
        Self {
            matches: valid.len(),
            failed: failed.len(),
            repeated: MatchRow::are_repetitions(&valid),
            by_extra_time: decided(DecidedBy::ExtraTime),
            by_shoot_out: decided(DecidedBy::ShootOut),
            by_coin: decided(DecidedBy::Coin),
            blue_wins: share(blue_wins, valid.len()),
            draws: share(valid.len() - blue_wins - pink_wins, valid.len()),
            pink_wins: share(pink_wins, valid.len()),
            blue_share_of_wins: share(blue_wins, blue_wins + pink_wins),
            blue_goals: mean_of(&|row| Some(f64::from(row.goals.blue))),
            pink_goals: mean_of(&|row| Some(f64::from(row.goals.pink))),
            goal_difference: mean_of(&|row| Some(f64::from(row.goals.blue) - f64::from(row.goals.pink))),
            blue_kept: kept_share(&valid, Team::Blue),
            pink_kept: kept_share(&valid, Team::Pink),
            blue_penalties: mean_of(&|row| Some(f64::from(row.penalties.blue))),
            pink_penalties: mean_of(&|row| Some(f64::from(row.penalties.pink))),
            blue_possession: share_of(&|row| row.blue_possession),
            ball_in_blue_half: share_of(&|row| row.ball_in_blue_half),
            blue_belief_error_m: mean_of(&|row| row.belief_error_m.blue),
            pink_belief_error_m: mean_of(&|row| row.belief_error_m.pink),
            blue_belief_over_half_m: share_of(&|row| row.belief_over_half_m.blue),
            pink_belief_over_half_m: share_of(&|row| row.belief_over_half_m.pink),
            blue_belief_over_1_m: share_of(&|row| row.belief_over_1_m.blue),
            pink_belief_over_1_m: share_of(&|row| row.belief_over_1_m.pink),
        }
    }

    /// Returns the lines of the summary: a name, and a value with its interval.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let percent = |estimate: &Option<Estimate>| match estimate {
            Some(Estimate { value, low, high }) => {
                format!("{:5.1} %  ({:.1} to {:.1})", 100.0 * value, 100.0 * low, 100.0 * high)
            }
            None => "-".to_owned(),
        };
        let number = |estimate: &Option<Estimate>, digits: usize, unit: &str| match estimate {
            Some(estimate) => {
                let (value, margin) = (rounded(estimate.value, digits as u32), estimate.margin());
                let margin = if margin.is_finite() { format!(" ± {margin:.digits$}") } else { String::new() };
                format!("{value:6.digits$}{unit}{margin}")
            }
            None => "-".to_owned(),
        };
        let mut lines = vec![
            ("blue wins", percent(&self.blue_wins)),
            ("draws", percent(&self.draws)),
            ("pink wins", percent(&self.pink_wins)),
            ("blue's goals", number(&self.blue_goals, 2, "")),
            ("pink's goals", number(&self.pink_goals, 2, "")),
            ("goal difference", number(&self.goal_difference, 2, "")),
            ("passes completed, blue", percent(&self.blue_kept)),
            ("passes completed, pink", percent(&self.pink_kept)),
            ("penalties of blue", number(&self.blue_penalties, 2, "")),
            ("penalties of pink", number(&self.pink_penalties, 2, "")),
            ("possession of blue", percent(&self.blue_possession)),
            ("ball in blue's half", percent(&self.ball_in_blue_half)),
        ];
        for (name, matches) in [
            ("... after extra time", self.by_extra_time),
            ("... by a shoot-out", self.by_shoot_out),
            ("... by a coin", self.by_coin),
        ] {
            if matches > 0 {
                let of = if self.matches == 1 { "match" } else { "matches" };
                lines.insert(3, (name, format!("{matches:5} of {} {of}", self.matches)));
            }
        }
        for (name, error) in
            [("belief error of blue", &self.blue_belief_error_m), ("belief error of pink", &self.pink_belief_error_m)]
        {
            if error.is_some() {
                lines.push((name, number(error, 3, " m")));
            }
        }
        for (name, share) in [
            ("... over 0.5 m, blue", &self.blue_belief_over_half_m),
            ("... over 0.5 m, pink", &self.pink_belief_over_half_m),
            ("... over 1 m, blue", &self.blue_belief_over_1_m),
            ("... over 1 m, pink", &self.pink_belief_over_1_m),
        ] {
            if share.is_some() {
                lines.push((name, percent(share)));
            }
        }
        if self.repeated {
            lines.push(("every seed", "plays the same match: the intervals say nothing".to_owned()));
        }
        lines
    }
}

/// Returns the share of the passes of `team` that were completed.
fn kept_share(rows: &[&MatchRow], team: Team) -> Option<Estimate> {
    let sum = |counts: fn(&MatchRow) -> PerTeam<u32>| rows.iter().map(|row| counts(row)[team] as usize).sum::<usize>();
    let kept = sum(|row| row.kept);
    share(kept, kept + sum(|row| row.given_away))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::observer::MatchOutcome;

    fn row(blue: u32, pink: u32, outcome: MatchOutcome) -> MatchRow {
        let goals = PerTeam { blue, pink };
        MatchRow { goals, winner: goals.leader(), ..MatchRow::failed(1, outcome, String::new()) }
    }

    #[test]
    fn only_valid_matches_count() {
        use MatchOutcome::{FinalWhistle, InvariantBroken, Panicked};
        let rows = [
            row(2, 1, FinalWhistle),
            row(0, 0, FinalWhistle),
            row(1, 3, FinalWhistle),
            row(4, 0, FinalWhistle),
            row(9, 0, Panicked),
            row(0, 9, InvariantBroken),
        ];
        let summary = Summary::of(rows.iter());
        assert_eq!((summary.matches, summary.failed), (4, 2));
        assert_eq!(summary.blue_wins.unwrap().value, 0.5);
        assert_eq!(summary.draws.unwrap().value, 0.25);
        assert_eq!(summary.blue_share_of_wins.unwrap().value, 2.0 / 3.0);
        assert_eq!(summary.goal_difference.unwrap().value, 0.75);
        assert_eq!(summary.blue_possession, None);
        assert!(!summary.repeated);
    }

    #[test]
    fn the_same_match_again_and_again_is_told_of() {
        let same = |seed: u64| MatchRow { seed, index: seed as usize, ..row(2, 1, MatchOutcome::FinalWhistle) };
        let lines = |rows: &[MatchRow]| Summary::of(rows.iter()).lines();
        let is_told = |rows: &[MatchRow]| lines(rows).iter().any(|(name, _)| *name == "every seed");
        assert!(is_told(&[same(1), same(2), same(3)]));
        assert!(!is_told(&[same(1)]));
        assert!(!is_told(&[same(1), MatchRow { outs: 1, ..same(2) }, same(3)]));
    }
}
