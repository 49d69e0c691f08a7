//! The table of `naoisis realism --match`.

use core::fmt::Write as _;

use naoisis_core::statistics::Estimate;
use naoisis_lab::match_realism::{Bound, ComparedFigure, ComparedRow, Comparison, Mark, Quantity};

/// What the marks and the intervals mean.
const LEGEND: &str = "\
real figures: no mark: counted in a primary source; ~ of one match, or derived; ? none is known
! off: the values differ by more than both intervals explain, at 95 %, or the simulated interval is beyond the bound
intervals of 95 %: of simulated values by bootstrap over matches (1000 samples), of shares of matches by Wilson's score; of real values as their sources give them
";

/// Returns the table of a comparison.
pub(super) fn table(comparison: &Comparison) -> String {
    let names: Vec<String> = comparison.rows.iter().map(name_and_unit).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or_default();
    let mut text =
        format!("  {:width$}  {:>22}    {:>22}  {:>5}    source\n", "quantity", "simulated", "real", "ratio");
    for (row, name) in comparison.rows.iter().zip(&names) {
        let simulated = row.estimate.map_or_else(|| "-".to_owned(), with_interval);
        let ratio = row.ratio().map_or_else(String::new, |ratio| format!("{ratio:.2}"));
        let off = if row.is_off() == Some(true) { "!" } else { " " };
        let (real, source) = match &row.real {
            Some(real) => (figure(real), source(real)),
            None => (String::new(), String::new()),
        };
        let mark = match row.mark() {
            Mark::Hard => " ",
            mark => mark.sign(),
        };
        let line = format!("  {name:width$}  {simulated:>22}  {mark} {real:>22}  {ratio:>5} {off}  {source}");
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text + LEGEND
}

/// Returns the rows that have a value, without real figures.
pub(super) fn measured(comparison: &Comparison) -> String {
    let rows = comparison.rows.iter().filter_map(|row| Some((name_and_unit(row), with_interval(row.estimate?))));
    let rows: Vec<(String, String)> = rows.collect();
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or_default();
    rows.iter().fold(String::new(), |text, (name, value)| text + &format!("  {name:width$}  {value:>22}\n"))
}

/// Returns the definitions of quantities, a line each.
pub(super) fn definitions(quantities: &[Quantity]) -> String {
    let mut text = String::new();
    for quantity in quantities {
        let unit = if quantity.unit.is_empty() { String::new() } else { format!(", {}", quantity.unit) };
        let _ = writeln!(text, "{}: {}{unit}: {}", quantity.key, quantity.name.trim(), quantity.definition);
    }
    text
}

fn name_and_unit(row: &ComparedRow) -> String {
    match row.unit {
        "" => row.name.clone(),
        unit => format!("{}, {unit}", row.name),
    }
}

/// A value with its interval.
fn with_interval(Estimate { value, low, high }: Estimate) -> String {
    if low.is_finite() && high.is_finite() {
        let [value, low, high] = [value, low, high].map(|number| digits(number, value));
        format!("{value} ({low} to {high})")
    } else {
        digits(value, value)
    }
}

fn figure(real: &ComparedFigure) -> String {
    let figure = &real.figure;
    let bound = match figure.bound {
        Bound::Exact => "",
        Bound::AtLeast => ">= ",
        Bound::AtMost => "<= ",
    };
    let number = |number: f64| digits(number, figure.value);
    match (figure.low, figure.high) {
        (Some(low), Some(high)) => format!("{bound}{} ({} to {})", number(figure.value), number(low), number(high)),
        _ => format!("{bound}{}", number(figure.value)),
    }
}

fn source(real: &ComparedFigure) -> String {
    let of = match (real.figure.n, real.figure.of.as_str()) {
        (Some(n), of) if !of.is_empty() => format!(", {n} {of}"),
        (Some(n), _) => format!(", n {n}"),
        (None, _) => String::new(),
    };
    format!("{}{of}: {}", real.year, real.figure.source)
}

/// A number with as many digits as a value of this `size` needs.
fn digits(number: f64, size: f64) -> String {
    match size.abs() {
        size if size >= 100.0 => format!("{number:.0}"),
        size if size >= 10.0 => format!("{number:.1}"),
        size if size >= 0.2 || size == 0.0 => format!("{number:.2}"),
        _ => format!("{number:.3}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::PerTeam;
    use naoisis_lab::match_realism::{MatchMeasures, RealFigures, quantities};

    #[test]
    fn a_row_has_value_interval_real_figure_ratio_and_mark() {
        let mut drawn = MatchMeasures::default();
        drawn.goals = PerTeam { blue: 1, pink: 1 };
        let comparison = Comparison::of(&[drawn.clone(), drawn], &RealFigures::built_in(), "spl2025");
        let text = table(&comparison);
        let line = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_default();
        let goals = line("goals a match");
        assert!(goals.contains("2.00 (2.00 to 2.00)") && goals.contains("4.88 (4.44 to 5.34)"), "{goals}");
        assert!(goals.contains("0.41 !  2022-2024, 172 matches: RoboCup-SPL/Ratings"), "{goals}");
        assert!(line("falls a km walked").contains("~"), "{text}");
        assert!(line("kicks a match").ends_with('?'), "{text}");
        assert!(line("messages a team").contains("<= 1200"), "{text}");
        assert!(text.ends_with(LEGEND));
    }

    #[test]
    fn every_quantity_is_explained_in_a_line() {
        let quantities = quantities(&[]);
        let text = definitions(&quantities);
        assert_eq!(text.lines().count(), quantities.len());
        assert!(text.starts_with("goals: goals a match: goals of both teams"), "{text}");
    }
}
