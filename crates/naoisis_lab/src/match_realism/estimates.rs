//! Computes values of all matches together, with their intervals.

use serde::Serialize;

use super::measures::MatchMeasures;
use naoisis_core::statistics::{self, Estimate, share};

/// The kind of a 95 % interval.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IntervalKind {
    /// The [bootstrap](statistics::bootstrap) over matches.
    Bootstrap,
    /// Wilson's score interval, for a share of matches.
    Wilson,
}

/// Returns the value of all matches together, or `None` if data are missing.
type Value = Box<dyn Fn(&[&MatchMeasures]) -> Option<f64>>;
/// Returns whether a match counts, or `None` if it is left out.
type Condition = fn(&MatchMeasures) -> bool;

/// A quantity by which simulated and real matches are compared.
pub struct Quantity {
    /// The name in files.
    pub key: String,
    /// The name as printed.
    pub name: String,
    /// The unit as printed; empty for a number.
    pub unit: &'static str,
    /// The definition, in a line.
    pub definition: String,
    statistic: Statistic,
}

enum Statistic {
    OfAll(Value),
    ShareOfMatches(Condition),
}

impl Quantity {
    /// Creates a quantity whose value is computed from all matches together.
    pub(super) fn new(
        [key, name, unit, definition]: [&'static str; 4],
        value: impl Fn(&[&MatchMeasures]) -> Option<f64> + 'static,
    ) -> Self {
        let statistic = Statistic::OfAll(Box::new(value));
        Self { key: key.to_owned(), name: name.to_owned(), unit, definition: definition.to_owned(), statistic }
    }

    /// Creates a quantity that is the share of matches for which `is_true` holds, %.
    pub(super) fn share_of_matches([key, name, definition]: [&'static str; 3], is_true: Condition) -> Self {
        let statistic = Statistic::ShareOfMatches(is_true);
        Self { key: key.to_owned(), name: name.to_owned(), unit: "%", definition: definition.to_owned(), statistic }
    }

    /// Changes the words, for one of several similar quantities.
    pub(super) fn named(self, key: String, name: String, definition: String) -> Self {
        Self { key, name, definition, ..self }
    }

    /// Returns the kind of the interval.
    pub fn interval(&self) -> IntervalKind {
        match self.statistic {
            Statistic::OfAll(_) => IntervalKind::Bootstrap,
            Statistic::ShareOfMatches(_) => IntervalKind::Wilson,
        }
    }

    /// Returns the value over `matches` with its 95 % interval. Returns `None` if the matches do not have it. For a single match the
    /// interval is infinite.
    pub fn estimate(&self, matches: &[&MatchMeasures]) -> Option<Estimate> {
        match &self.statistic {
            Statistic::OfAll(value) => {
                statistics::bootstrap(&[matches.to_vec()], |drawn| Some(vec![value(&drawn[0])?]))?.pop()
            }
            Statistic::ShareOfMatches(is_true) => {
                let share = share(matches.iter().filter(|one| is_true(one)).count(), matches.len())?;
                Some(Estimate { value: 100.0 * share.value, low: 100.0 * share.low, high: 100.0 * share.high })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::statistics::mean;
    use naoisis_core::team::PerTeam;

    fn matches(goals: &[u32]) -> Vec<MatchMeasures> {
        let of = |blue: &u32| MatchMeasures { goals: PerTeam { blue: *blue, pink: 0 }, ..MatchMeasures::default() };
        goals.iter().map(of).collect()
    }

    fn mean_goals(matches: &[&MatchMeasures]) -> Option<f64> {
        let goals: f64 = matches.iter().map(|one| f64::from(one.all_goals())).sum();
        (!matches.is_empty()).then(|| goals / matches.len() as f64)
    }

    #[test]
    fn the_bootstrap_of_a_mean_is_about_students_interval() {
        let goals: Vec<u32> = (0..40).map(|index| index % 9).collect();
        let played = matches(&goals);
        let played: Vec<&MatchMeasures> = played.iter().collect();
        let estimate = Quantity::new(["goals", "goals", "", ""], mean_goals).estimate(&played).unwrap();
        let expected = mean(&goals.iter().map(|goals| f64::from(*goals)).collect::<Vec<f64>>()).unwrap();
        assert_eq!(estimate.value, expected.value);
        assert!(
            (estimate.low - expected.low).abs() < 0.1 && (estimate.high - expected.high).abs() < 0.1,
            "{estimate:?}"
        );
    }

    #[test]
    fn a_single_match_says_nothing_of_others_and_none_has_no_value() {
        let goals = Quantity::new(["goals", "goals", "", ""], mean_goals);
        let one = matches(&[3]);
        assert_eq!(goals.estimate(&[&one[0]]).unwrap().high, f64::INFINITY);
        assert_eq!(goals.estimate(&[]), None);
    }

    #[test]
    fn shares_of_matches_are_percent() {
        let played = matches(&[0, 0, 1, 2]);
        let goalless = Quantity::share_of_matches(["goalless", "0:0", ""], |one| one.all_goals() == 0);
        let estimate = goalless.estimate(&played.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!((estimate.value, goalless.interval()), (50.0, IntervalKind::Wilson));
        assert!((estimate.low - 15.0).abs() < 0.1 && (estimate.high - 85.0).abs() < 0.1, "{estimate:?}");
    }
}
