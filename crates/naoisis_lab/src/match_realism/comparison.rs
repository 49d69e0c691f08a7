//! Compares simulated and real figures.

use serde::Serialize;
use serde_json::{Value, json};
use std::io;

use super::estimates::{IntervalKind, Quantity};
use super::measures::MatchMeasures;
use super::quantities::quantities;
use super::real_figures::{Bound, Certainty, RealFigure, RealFigures};
use naoisis_core::statistics::Estimate;

/// The columns of the table in CSV.
const CSV_COLUMNS: [&str; 15] = [
    "key", "name", "unit", "value", "low", "high", "real", "real_low", "real_high", "year", "n", "source", "ratio",
    "mark", "is_off",
];

/// The certainty of a row's real figure, as a mark.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// The figure was counted in a primary source: no mark.
    Hard,
    /// The figure is of one match, or derived: `~`.
    Derived,
    /// There is no real figure: `?`.
    Unknown,
}

impl Mark {
    /// Returns the mark as printed.
    pub fn sign(self) -> &'static str {
        match self {
            Mark::Hard => "",
            Mark::Derived => "~",
            Mark::Unknown => "?",
        }
    }
}

/// A real figure, with the name and the year of its matches.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[non_exhaustive]
pub struct ComparedFigure {
    /// The figure.
    #[serde(flatten)]
    pub figure: RealFigure,
    /// The matches of the figure.
    pub name: String,
    /// The year of these matches.
    pub year: String,
}

/// A quantity of simulated matches, compared with real matches.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[non_exhaustive]
pub struct ComparedRow {
    /// The key of the quantity.
    pub key: String,
    /// The name, as printed.
    pub name: String,
    /// The unit; empty for a number.
    pub unit: &'static str,
    /// The definition of the quantity.
    pub definition: String,
    /// The value for all matches, with its 95 % interval.
    #[serde(serialize_with = "finite")]
    pub estimate: Option<Estimate>,
    /// The kind of the interval.
    pub interval: IntervalKind,
    /// The real figure.
    pub real: Option<ComparedFigure>,
}

/// Writes the ends of infinite intervals as `null`.
fn finite<S: serde::Serializer>(estimate: &Option<Estimate>, serializer: S) -> Result<S::Ok, S::Error> {
    let number = |value: f64| value.is_finite().then_some(value);
    let value = estimate.map(
        |Estimate { value, low, high }| json!({ "value": number(value), "low": number(low), "high": number(high) }),
    );
    value.serialize(serializer)
}

impl ComparedRow {
    fn of(quantity: Quantity, matches: &[&MatchMeasures], real: Option<ComparedFigure>) -> Self {
        let (estimate, interval) = (quantity.estimate(matches), quantity.interval());
        let Quantity { key, name, unit, definition, .. } = quantity;
        Self { key, name, unit, definition, estimate, interval, real }
    }

    /// Returns the mark of the real figure's certainty.
    pub fn mark(&self) -> Mark {
        match self.real.as_ref().map(|real| real.figure.certainty) {
            Some(Certainty::Hard) => Mark::Hard,
            Some(Certainty::Derived) => Mark::Derived,
            None => Mark::Unknown,
        }
    }

    /// Returns the simulated value divided by the real one. Returns `None` if one of them is missing, if the real figure is a bound, or if
    /// it is 0.
    pub fn ratio(&self) -> Option<f64> {
        let real = &self.real.as_ref()?.figure;
        let ratio = self.estimate?.value / real.value;
        (real.bound == Bound::Exact && ratio.is_finite()).then_some(ratio)
    }

    /// Returns whether the values differ at 95 % confidence, or the simulated interval is beyond a bound. Returns `None` if a value or the
    /// interval of an exact real value is missing.
    ///
    /// The standard error of a difference is the root of the sum of the squares of both standard errors. So the values differ when they are
    /// further apart than that root of the halves of their intervals which lie between them.
    pub fn is_off(&self) -> Option<bool> {
        let real = &self.real.as_ref()?.figure;
        let Estimate { value, low, high } = self.estimate?;
        match real.bound {
            Bound::AtLeast => Some(high < real.value),
            Bound::AtMost => Some(low > real.value),
            Bound::Exact => {
                let halves = if value < real.value {
                    (high - value).hypot(real.value - real.low?)
                } else {
                    (value - low).hypot(real.high? - real.value)
                };
                Some((value - real.value).abs() > halves)
            }
        }
    }
}

/// Simulated matches compared with real ones.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct Comparison {
    /// The rows, in the order of the quantities.
    pub rows: Vec<ComparedRow>,
}

impl Comparison {
    /// Compares `matches` of the scenario with this name with `real` figures. If a quantity has several figures, the first is used.
    pub fn of(matches: &[MatchMeasures], real: &[RealFigures], scenario: &str) -> Self {
        let figure = |key: &str| {
            let mut of_scenario = real.iter().filter(|figures| figures.are_of(scenario));
            of_scenario.find_map(|figures| {
                let figure = figures.figures.get(key)?.clone();
                Some(ComparedFigure { figure, name: figures.name.clone(), year: figures.year.clone() })
            })
        };
        let played: Vec<&MatchMeasures> = matches.iter().collect();
        let row = |quantity: Quantity| {
            let real = figure(&quantity.key);
            ComparedRow::of(quantity, &played, real)
        };
        Self { rows: quantities(matches).into_iter().map(row).collect() }
    }

    /// Returns the row of a quantity.
    pub fn row(&self, key: &str) -> Option<&ComparedRow> {
        self.rows.iter().find(|row| row.key == key)
    }

    /// Returns the rows as JSON, with ratio, mark and verdict.
    pub fn to_json(&self) -> Value {
        let row = |row: &ComparedRow| {
            let mut value = json!(row);
            value["ratio"] = json!(row.ratio());
            value["mark"] = json!(row.mark());
            value["is_off"] = json!(row.is_off());
            value
        };
        self.rows.iter().map(row).collect()
    }

    /// Writes the rows as CSV, one line each.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn write_csv(&self, writer: impl io::Write) -> io::Result<()> {
        let mut table = csv::Writer::from_writer(writer);
        table.write_record(CSV_COLUMNS)?;
        let number = |value: Option<f64>| {
            value.filter(|value| value.is_finite()).map_or_else(String::new, |value| value.to_string())
        };
        for row in &self.rows {
            let real = row.real.as_ref();
            let figure = real.map(|real| &real.figure);
            let estimate = row.estimate;
            table.write_record([
                row.key.clone(),
                row.name.trim().to_owned(),
                row.unit.to_owned(),
                number(estimate.map(|estimate| estimate.value)),
                number(estimate.map(|estimate| estimate.low)),
                number(estimate.map(|estimate| estimate.high)),
                number(figure.map(|figure| figure.value)),
                number(figure.and_then(|figure| figure.low)),
                number(figure.and_then(|figure| figure.high)),
                real.map_or_else(String::new, |real| real.year.clone()),
                figure.and_then(|figure| figure.n).map_or_else(String::new, |n| n.to_string()),
                figure.map_or_else(String::new, |figure| figure.source.clone()),
                number(row.ratio()),
                row.mark().sign().to_owned(),
                row.is_off().map_or_else(String::new, |is_off| is_off.to_string()),
            ])?;
        }
        table.flush()
    }

    /// Returns the values as figures of real matches, for a file. `name`, `year` and `source` describe the matches. Quantities that were
    /// not measured are left out.
    pub fn to_real_figures(&self, name: &str, year: &str, source: &str, matches: u32) -> RealFigures {
        let figure = |row: &ComparedRow| {
            let Estimate { value, low, high } = row.estimate?;
            // An interval without width is that of a single match, or of a value that never varied: it says nothing.
            let end = |end: f64| (end.is_finite() && low < high).then_some(end);
            let figure = RealFigure {
                value,
                low: end(low),
                high: end(high),
                n: Some(matches),
                of: "matches".to_owned(),
                certainty: if matches > 1 { Certainty::Hard } else { Certainty::Derived },
                bound: Bound::Exact,
                source: source.to_owned(),
            };
            Some((row.key.clone(), figure))
        };
        let (name, year) = (name.to_owned(), year.to_owned());
        RealFigures {
            name,
            year,
            scenarios: Vec::new(),
            spread: None,
            figures: self.rows.iter().filter_map(figure).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::PerTeam;

    fn figures(value: f64, low: f64, high: f64, certainty: Certainty, bound: Bound) -> RealFigures {
        let (low, high) = (Some(low), Some(high));
        let source = "a test".to_owned();
        let figure = RealFigure { value, low, high, n: Some(9), of: "matches".to_owned(), certainty, bound, source };
        RealFigures {
            name: "real".to_owned(),
            year: "2024".to_owned(),
            scenarios: vec!["spl2025".to_owned()],
            spread: None,
            figures: [("goals".to_owned(), figure)].into(),
        }
    }

    fn matches() -> Vec<MatchMeasures> {
        let of = |blue| MatchMeasures { goals: PerTeam { blue, pink: 1 }, ..MatchMeasures::default() };
        [1, 2, 3, 1, 2, 3, 1, 3].map(of).into()
    }

    fn goals(real: &[RealFigures], scenario: &str) -> ComparedRow {
        Comparison::of(&matches(), real, scenario).row("goals").unwrap().clone()
    }

    #[test]
    fn a_value_is_off_when_it_differs_by_more_than_both_intervals_explain() {
        let exact = |value, low, high| goals(&[figures(value, low, high, Certainty::Hard, Bound::Exact)], "spl2025");
        // 3.0 ± 0.6 and 3.9 ± 0.5: the intervals overlap, but √(0.6² + 0.5²) is less than 0.9.
        assert_eq!(exact(3.9, 3.4, 4.4).is_off(), Some(true));
        let [near, far] = [exact(3.5, 3.2, 3.9), exact(6.0, 5.5, 6.5)];
        assert_eq!((near.is_off(), near.mark(), near.mark().sign()), (Some(false), Mark::Hard, ""));
        assert_eq!((far.is_off(), far.ratio()), (Some(true), Some(0.5)));
        let bound = |value, bound| goals(&[figures(value, value, value, Certainty::Hard, bound)], "spl2025");
        assert_eq!(bound(2.0, Bound::AtLeast).is_off(), Some(false));
        assert_eq!(bound(2.0, Bound::AtMost).is_off(), Some(true));
        assert_eq!(bound(9.0, Bound::AtLeast).is_off(), Some(true));
        assert_eq!(bound(9.0, Bound::AtMost).ratio(), None);
    }

    #[test]
    fn a_figure_is_of_its_scenarios_and_the_first_counts() {
        let derived = figures(1.0, 1.0, 1.0, Certainty::Derived, Bound::Exact);
        let hard = figures(2.0, 2.0, 2.0, Certainty::Hard, Bound::Exact);
        let value = |row: ComparedRow| row.real.map(|real| real.figure.value);
        assert_eq!(value(goals(&[hard.clone(), derived.clone()], "spl2025")), Some(2.0));
        assert_eq!(goals(&[derived, hard.clone()], "spl2025").mark(), Mark::Derived);
        let other = goals(&[hard], "spl2010");
        assert_eq!((other.mark(), other.ratio(), other.is_off()), (Mark::Unknown, None, None));
    }

    #[test]
    fn json_has_what_is_printed_and_what_is_written_is_compared_with() {
        let real = [figures(6.0, 5.5, 6.5, Certainty::Hard, Bound::Exact)];
        let comparison = Comparison::of(&matches(), &real, "spl2025");
        let json = comparison.to_json();
        assert_eq!((json[0]["key"].as_str(), json[0]["ratio"].as_f64()), (Some("goals"), Some(0.5)));
        assert_eq!((json[0]["real"]["year"].as_str(), json[0]["is_off"].as_bool()), (Some("2024"), Some(true)));
        let mut table = Vec::new();
        comparison.write_csv(&mut table).unwrap();
        let table = String::from_utf8(table).unwrap();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), comparison.rows.len() + 1);
        assert!(lines[1].starts_with("goals,goals a match,,3,") && lines[1].ends_with(",0.5,,true"), "{}", lines[1]);
        let written = comparison.to_real_figures("mine", "2026", "counted by a test", 8);
        assert_eq!(written.figures["goals"].value, 3.0);
        assert!(!written.figures.contains_key("kicks"), "a quantity without a value");
    }
}
