//! Matches of every team against every other team, with changed sides.

use core::fmt::{self, Write};

use super::observer::MatchRow;
use super::ratings::ratings;
use naoisis_core::game::DecidedBy;
use naoisis_core::statistics::{Estimate, bootstrap, mean, rounded, share};
use naoisis_core::team::{PerTeam, Team};

/// The result of the matches of two teams, as the first team sees it, with 95 % confidence.
#[derive(Clone, PartialEq, Debug)]
pub struct PairSummary {
    /// Valid matches.
    pub matches: usize,
    /// Matches that failed.
    pub failed: usize,
    /// Whether all seeds played the same match for each colour: nothing was random, and the intervals mean nothing.
    pub repeated: bool,
    /// Number of matches that a shoot-out or a coin toss decided.
    pub shot_out: usize,
    /// The share of matches that the first team won, including by a shoot-out or a coin toss.
    pub wins: Option<Estimate>,
    /// The share of draws.
    pub draws: Option<Estimate>,
    /// The share of matches that the second team won.
    pub losses: Option<Estimate>,
    /// The first team's share of the wins.
    pub share_of_wins: Option<Estimate>,
    /// The probability of improvement: that the first team does better in a match than the second, a draw being half of that.
    pub improvement: Option<Estimate>,
    /// The first team's goals in a match.
    pub goals: Option<Estimate>,
    /// The second team's goals in a match.
    pub goals_against: Option<Estimate>,
    /// The first team's goals minus the second's.
    pub goal_difference: Option<Estimate>,
    /// The share of completed passes, of the first and of the second team.
    pub kept: [Option<Estimate>; 2],
}

impl PairSummary {
    /// Summarises matches, each with the colour in which the first team played it.
    pub fn of<'a>(rows: impl Iterator<Item = (&'a MatchRow, Team)>) -> Self {
        let (valid, failed): (Vec<_>, Vec<_>) = rows.partition(|(row, _)| row.outcome.is_valid());
        let goals: Vec<[f64; 2]> = valid
            .iter()
            .map(|(row, first)| [*first, first.opponent()].map(|team| f64::from(row.goals[team])))
            .collect();
        let kept = |whose: fn(Team) -> Team| {
            let sum = |counts: fn(&MatchRow) -> PerTeam<u32>| {
                valid.iter().map(|(row, first)| counts(row)[whose(*first)] as usize).sum::<usize>()
            };
            let kept = sum(|row| row.kept);
            share(kept, kept + sum(|row| row.given_away))
        };
        let scores: Vec<f64> = valid.iter().map(|(row, first)| score(row, *first)).collect();
        let count = |wanted: f64| scores.iter().filter(|score| **score == wanted).count();
        let [wins, losses] = [1.0, 0.0].map(count);
        let mean_score = |scores: &[Vec<f64>]| Some(vec![mean(&scores[0])?.value]);
        let shot_out = valid.iter().filter(|(row, _)| row.decided_by >= DecidedBy::ShootOut).count();
        let mean_of = |value: fn(&[f64; 2]) -> f64| mean(&goals.iter().map(value).collect::<Vec<f64>>());
        Self {
            matches: valid.len(),
            failed: failed.len(),
            repeated: MatchRow::are_repetitions(&valid.iter().map(|(row, _)| *row).collect::<Vec<_>>()),
            shot_out,
            wins: share(wins, valid.len()),
            draws: share(valid.len() - wins - losses, valid.len()),
            losses: share(losses, valid.len()),
            share_of_wins: share(wins, wins + losses),
            improvement: bootstrap(&[scores], mean_score).and_then(|mut means| means.pop()),
            goals: mean_of(|goals| goals[0]),
            goals_against: mean_of(|goals| goals[1]),
            goal_difference: mean_of(|goals| goals[0] - goals[1]),
            kept: [kept(|first| first), kept(Team::opponent)],
        }
    }

    /// Returns whether the first team is better (true) or worse (false) with 95 % confidence, by its share of the wins. Returns `None` if
    /// that is uncertain, as it is for repetitions of one match.
    pub fn is_first_better(&self) -> Option<bool> {
        let share = self.share_of_wins?;
        if self.repeated {
            None
        } else if share.low > 0.5 {
            Some(true)
        } else if share.high < 0.5 {
            Some(false)
        } else {
            None
        }
    }

    /// Returns the same results as the second team sees them.
    pub fn reversed(&self) -> Self {
        let complement = |estimate: Estimate| Estimate {
            value: 1.0 - estimate.value,
            low: 1.0 - estimate.high,
            high: 1.0 - estimate.low,
        };
        let negative =
            |estimate: Estimate| Estimate { value: -estimate.value, low: -estimate.high, high: -estimate.low };
        Self {
            wins: self.losses,
            losses: self.wins,
            share_of_wins: self.share_of_wins.map(complement),
            improvement: self.improvement.map(complement),
            goals: self.goals_against,
            goals_against: self.goals,
            goal_difference: self.goal_difference.map(negative),
            kept: [self.kept[1], self.kept[0]],
            ..self.clone()
        }
    }
}

/// All pairs of a list of teams.
#[derive(Clone, PartialEq, Debug)]
pub struct Pairs {
    teams: Vec<String>,
}

/// A match of two teams.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pairing {
    /// The indices of the two teams, the smaller one first.
    pub teams: [usize; 2],
    /// The colour in which the first of the two teams plays.
    pub first: Team,
}

impl Pairs {
    /// Creates the pairs of these teams.
    pub fn of(teams: Vec<String>) -> Self {
        Self { teams }
    }

    /// Returns all pairings: each pair of teams twice, with changed colours.
    pub fn pairings(&self) -> impl Iterator<Item = Pairing> {
        self.pairs().flat_map(|teams| Team::BOTH.map(|first| Pairing { teams, first }))
    }

    /// Returns the names of the blue and the pink team.
    pub fn names(&self, pairing: Pairing) -> [&str; 2] {
        let [first, second] = pairing.teams.map(|team| self.teams[team].as_str());
        match pairing.first {
            Team::Blue => [first, second],
            Team::Pink => [second, first],
        }
    }

    fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        let count = self.teams.len();
        (0..count).flat_map(move |first| (first + 1..count).map(move |second| [first, second]))
    }

    /// Summarises the matches of all pairs, each given with its pairing.
    pub fn table<'a>(&self, rows: impl Iterator<Item = (&'a MatchRow, Pairing)>) -> PairTable {
        let rows: Vec<(&MatchRow, Pairing)> = rows.collect();
        let of_pair = |teams| {
            let matches = rows.iter().filter(move |(_, pairing)| pairing.teams == teams);
            matches.map(|(row, pairing)| (*row, pairing.first))
        };
        let pairs: Vec<_> = self.pairs().map(|teams| (teams, PairSummary::of(of_pair(teams)))).collect();
        let valid = |teams| of_pair(teams).filter(|(row, _)| row.outcome.is_valid());
        let scores = |teams| (teams, valid(teams).map(|(row, first)| score(row, first)).collect());
        let scores: Vec<([usize; 2], Vec<f64>)> = self.pairs().map(scores).collect();
        // Two teams are compared by their matches alone, and repetitions of one match have no intervals.
        let are_rated = self.teams.len() > 2 && pairs.iter().all(|(_, summary)| !summary.repeated);
        let ratings = are_rated.then(|| ratings(self.teams.len(), &scores)).flatten().unwrap_or_default();
        PairTable { teams: self.teams.clone(), pairs, ratings }
    }
}

/// The score of the team that played in the colour `first`: 1 for a win, 0.5 for a draw, 0 for a loss.
fn score(row: &MatchRow, first: Team) -> f64 {
    row.winner.map_or(0.5, |winner| f64::from(u8::from(winner == first)))
}

/// Shows which team beats which: a table of the teams, a line for each pair, and the ratings of three or more teams.
#[derive(Clone, PartialEq, Debug)]
pub struct PairTable {
    teams: Vec<String>,
    pairs: Vec<([usize; 2], PairSummary)>,
    /// The rating of each team, Elo points; empty if they are not known.
    ratings: Vec<Estimate>,
}

impl PairTable {
    /// Returns the result of the matches of two teams as `first` sees it. Returns `None` if they did not play each other.
    pub fn summary(&self, first: &str, second: &str) -> Option<PairSummary> {
        self.pairs.iter().find_map(|([one, other], summary)| {
            let names = [self.teams[*one].as_str(), self.teams[*other].as_str()];
            if names == [first, second] {
                Some(summary.clone())
            } else if names == [second, first] {
                Some(summary.reversed())
            } else {
                None
            }
        })
    }
}

impl fmt::Display for PairTable {
    fn fmt(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        const CELL: usize = 16;
        let widest = self.teams.iter().map(String::len).max().unwrap_or_default().max(4);
        write!(text, "{:widest$}", "wins")?;
        for team in &self.teams {
            write!(text, " {:>CELL$}", format!("against {team}"))?;
        }
        writeln!(text)?;
        for row in &self.teams {
            write!(text, "{row:widest$}")?;
            for column in &self.teams {
                let cell = self.summary(row, column).and_then(|summary| {
                    let mark = if summary.is_first_better() == Some(true) { '*' } else { ' ' };
                    Some(format!("{:.1} %{mark}", 100.0 * summary.wins?.value))
                });
                write!(text, " {:>CELL$}", cell.unwrap_or_else(|| "- ".to_owned()))?;
            }
            writeln!(text)?;
        }
        for ([first, second], summary) in &self.pairs {
            // The better team is named first.
            let first_is_better = summary.share_of_wins.is_none_or(|share| share.value >= 0.5);
            let (names, summary) = if first_is_better {
                ([first, second], summary.clone())
            } else {
                ([second, first], summary.reversed())
            };
            writeln!(text, "{}", in_words(names.map(|team| self.teams[*team].as_str()), &summary)?)?;
        }
        if self.pairs.iter().any(|(_, summary)| summary.is_first_better().is_some()) {
            writeln!(text, "* The row's team beats the column's, with 95 % confidence.")?;
        }
        let mut rated: Vec<_> = self.teams.iter().zip(&self.ratings).collect();
        rated.sort_by(|(_, one), (_, other)| other.value.total_cmp(&one.value));
        if !rated.is_empty() {
            writeln!(text, "Ratings in Elo points, with the mean 0 and 95 % intervals:")?;
        }
        for (team, rating) in rated {
            write!(text, "{team:widest$} {:>+6.0}", rounded(rating.value, 0))?;
            if rating.margin().is_finite() {
                write!(text, " ({:+.0} to {:+.0})", rounded(rating.low, 0), rounded(rating.high, 0))?;
            }
            writeln!(text)?;
        }
        Ok(())
    }
}

/// Returns a sentence on the matches of two teams, from the side of the first.
fn in_words([first, second]: [&str; 2], summary: &PairSummary) -> Result<String, fmt::Error> {
    let mut line = String::new();
    match summary.is_first_better() {
        Some(_) => write!(line, "{first} beats {second}")?,
        None if summary.repeated => write!(line, "{first} and {second}: every seed plays the same match")?,
        None => write!(line, "{first} and {second}: no difference that is sure")?,
    }
    write!(line, ": {} matches", summary.matches)?;
    for (what, share) in [("wins", summary.wins), ("draws", summary.draws), ("losses", summary.losses)] {
        if let Some(share) = share {
            write!(line, ", {:.1} % {what}", 100.0 * share.value)?;
        }
    }
    if summary.shot_out > 0 {
        write!(line, " ({} by a shoot-out or a coin)", summary.shot_out)?;
    }
    if let Some(share) = summary.share_of_wins {
        let [value, low, high] = [share.value, share.low, share.high].map(|share| 100.0 * share);
        write!(line, "; of those that somebody won, {value:.1} %")?;
        if !summary.repeated {
            write!(line, " ({low:.1} to {high:.1})")?;
        }
    }
    if let Some(improvement) = summary.improvement {
        write!(line, "; probability of improvement {:.2}", improvement.value)?;
        if !summary.repeated && improvement.margin().is_finite() {
            write!(line, " ({:.2} to {:.2})", improvement.low, improvement.high)?;
        }
    }
    if let (Some(own), Some(other), Some(difference)) = (summary.goals, summary.goals_against, summary.goal_difference)
    {
        let [own, other, value] = [own.value, other.value, rounded(difference.value, 2)];
        write!(line, "; goals {own:.2} : {other:.2}, difference {value:+.2}")?;
        if !summary.repeated {
            write!(line, " ± {:.2}", difference.margin())?;
        }
    }
    if let [Some(own), Some(other)] = summary.kept.map(|kept| kept.map(|kept| 100.0 * kept.value)) {
        write!(line, "; passes completed {own:.0} % : {other:.0} %")?;
    }
    if summary.failed > 0 {
        write!(line, "; {} failed", summary.failed)?;
    }
    Ok(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::observer::MatchOutcome;

    fn row(blue: u32, pink: u32) -> MatchRow {
        let goals = PerTeam { blue, pink };
        MatchRow { goals, winner: goals.leader(), ..MatchRow::failed(1, MatchOutcome::FinalWhistle, String::new()) }
    }

    fn teams(names: &[&str]) -> Pairs {
        Pairs::of(names.iter().map(|name| (*name).to_owned()).collect())
    }

    #[test]
    fn every_two_teams_play_in_both_colours() {
        let pairs = teams(&["a", "b", "c"]);
        let names: Vec<[&str; 2]> = pairs.pairings().map(|pairing| pairs.names(pairing)).collect();
        assert_eq!(names, [["a", "b"], ["b", "a"], ["a", "c"], ["c", "a"], ["b", "c"], ["c", "b"]]);
    }

    #[test]
    fn a_win_is_a_win_in_either_colour() {
        // Two wins, one in each colour, a draw, and a loss in pink.
        let rows = [(row(2, 0), Team::Blue), (row(0, 1), Team::Pink), (row(1, 1), Team::Blue), (row(3, 0), Team::Pink)];
        let summary = PairSummary::of(rows.iter().map(|(row, first)| (row, *first)));
        assert_eq!([summary.wins, summary.draws, summary.losses].map(|share| share.unwrap().value), [0.5, 0.25, 0.25]);
        assert_eq!(summary.share_of_wins.unwrap().value, 2.0 / 3.0);
        assert_eq!(summary.improvement.unwrap().value, 2.5 / 4.0);
        assert_eq!([summary.goals, summary.goals_against].map(|goals| goals.unwrap().value), [1.0, 1.0]);
        assert_eq!(summary.is_first_better(), None, "three matches tell nothing");
    }

    #[test]
    fn the_other_side_of_a_pair_is_its_mirror() {
        let rows = [(row(2, 0), Team::Blue), (row(1, 0), Team::Blue), (row(0, 0), Team::Blue), (row(0, 1), Team::Blue)];
        let summary = PairSummary::of(rows.iter().map(|(row, first)| (row, *first)));
        let other = PairSummary::of(rows.iter().map(|(row, first)| (row, first.opponent())));
        assert_eq!(summary.reversed().wins, other.wins);
        assert_eq!(summary.reversed().goals, other.goals);
        let [reversed, other] = [summary.reversed(), other].map(|summary| summary.share_of_wins.unwrap());
        assert!((reversed.low - other.low).abs() < 1e-9 && (reversed.high - other.high).abs() < 1e-9);
    }

    #[test]
    fn a_team_that_nearly_always_wins_beats_the_other_and_the_table_says_so() {
        let pairs = teams(&["weak", "strong"]);
        let rows: Vec<(MatchRow, Pairing)> = (0..20)
            .flat_map(|outs| pairs.pairings().map(move |pairing| (outs, pairing)))
            .map(|(outs, pairing)| {
                let row = if pairing.first == Team::Blue { row(0, 1) } else { row(2, 0) };
                (MatchRow { outs, ..row }, pairing)
            })
            .collect();
        let table = pairs.table(rows.iter().map(|(row, pairing)| (row, *pairing)));
        assert_eq!(table.summary("strong", "weak").unwrap().is_first_better(), Some(true));
        assert_eq!(table.summary("weak", "strong").unwrap().is_first_better(), Some(false));
        assert_eq!(table.summary("strong", "strong"), None);
        let text = table.to_string();
        assert!(text.contains("strong beats weak: 40 matches, 100.0 % wins"), "{text}");
        assert!(text.contains("100.0 %*") && text.contains("improvement 1.00 (1.00 to 1.00)"), "{text}");
        assert!(!text.contains("Elo"), "two teams are compared without ratings: {text}");
        // If the teams are equal, none beats another.
        let even = rows.iter().enumerate().map(|(index, (row, _))| {
            (row, Pairing { teams: [0, 1], first: if index % 4 < 2 { Team::Blue } else { Team::Pink } })
        });
        let text = pairs.table(even).to_string();
        assert!(text.contains("no difference that is sure") && !text.contains('*'), "{text}");
    }

    #[test]
    fn three_teams_are_rated_the_best_first() {
        let pairs = teams(&["weak", "strong", "middle"]);
        let strength = |name: &str| ["weak", "middle", "strong"].iter().position(|team| *team == name);
        let rows: Vec<(MatchRow, Pairing)> = (0..12)
            .flat_map(|outs| pairs.pairings().map(move |pairing| (outs, pairing)))
            .map(|(outs, pairing)| {
                let [blue, pink] = pairs.names(pairing).map(strength);
                // Every fourth match is a draw.
                let row = if outs % 4 == 0 { row(1, 1) } else { row(u32::from(blue > pink), u32::from(pink > blue)) };
                (MatchRow { outs, ..row }, pairing)
            })
            .collect();
        let text = pairs.table(rows.iter().map(|(row, pairing)| (row, *pairing))).to_string();
        let rated: Vec<&str> = text.lines().skip_while(|line| !line.contains("Elo")).skip(1).collect();
        let names: Vec<&str> = rated.iter().filter_map(|line| line.split_whitespace().next()).collect();
        assert_eq!(names, ["strong", "middle", "weak"], "{text}");
        assert!(rated[0].contains('+') && rated[2].contains('-'), "{text}");
    }

    #[test]
    fn a_match_that_every_seed_plays_again_makes_nobody_sure() {
        let pairs = teams(&["weak", "strong"]);
        let rows: Vec<(MatchRow, Pairing)> = (0..40)
            .flat_map(|seed| pairs.pairings().zip(0..).map(move |(pairing, variant)| (seed, variant, pairing)))
            .map(|(seed, variant, pairing)| {
                let row = if pairing.first == Team::Blue { row(0, 1) } else { row(2, 0) };
                (MatchRow { seed, variant, ..row }, pairing)
            })
            .collect();
        let text = pairs.table(rows.iter().map(|(row, pairing)| (row, *pairing))).to_string();
        assert!(text.contains("strong and weak: every seed plays the same match: 80 matches, 100.0 % wins"), "{text}");
        assert!(!text.contains('*') && !text.contains('±') && !text.contains(" to "), "{text}");
    }
}
