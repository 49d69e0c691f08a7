//! The columns of a batch's table, and how the table of another batch differs from it.

use super::csv_lines::{as_text, cells_of, cells_of_row, line_of};
use super::observer::MatchRow;
use super::variants::fingerprint;
use super::{Batch, Variants};
use naoisis_sim::scenario::Scenario;

/// Columns before the settings.
const LEADING_COLUMNS: [&str; 2] = ["match", "seed"];

/// Columns after the settings: the fields of a row, in their order, and the last two of the scenario.
const COLUMNS: [&str; 33] = [
    "outcome", "winner", "decided_by", "blue_shoot_out_goals", "pink_shoot_out_goals", "duration_s", "blue_goals",
    "pink_goals", "blue_own_goals", "pink_own_goals", "blue_kicks", "pink_kicks", "blue_kept", "pink_kept",
    "blue_given_away", "pink_given_away", "blue_penalties", "pink_penalties", "outs", "blue_possession",
    "ball_in_blue_half", "messages_lost", "blue_belief_error_m", "pink_belief_error_m", "blue_belief_over_0_5_m",
    "pink_belief_over_0_5_m", "blue_belief_over_1_m", "pink_belief_over_1_m", "mistakes", "digest", "note", "realism",
    SCENARIO,
];

/// Number of columns at the end that describe the scenario.
const COLUMNS_OF_SCENARIO: usize = 2;
/// Name of the column with the scenario's fingerprint.
const SCENARIO: &str = "scenario";

/// Error message for a file that is no table of matches.
pub(super) const NO_TABLE: &str = "this is no table of matches";

/// Returns the column names of a batch's settings. A setting with the name of another column gets the prefix `set.`.
pub(super) fn setting_columns<V: Variants>(batch: &Batch<V>) -> Vec<String> {
    let is_taken = |column: &str| LEADING_COLUMNS.contains(&column) || COLUMNS.contains(&column);
    let unlike_others = |column: String| if is_taken(&column) { format!("set.{column}") } else { column };
    batch.variants.columns().into_iter().map(unlike_others).collect()
}

/// The columns of a batch's table. The columns of the settings differ from batch to batch.
pub(super) struct Columns(Vec<String>);

impl Columns {
    /// The columns of the table of `batch`.
    pub(super) fn of<V: Variants>(batch: &Batch<V>) -> Self {
        Self(setting_columns(batch))
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        LEADING_COLUMNS.into_iter().chain(self.0.iter().map(String::as_str)).chain(COLUMNS)
    }

    /// Returns the header line of the table.
    pub(super) fn header(&self) -> String {
        line_of(self.names())
    }

    /// Describes how the columns of a table with the header `first_line` differ from these columns.
    pub(super) fn difference(&self, first_line: &str) -> String {
        let theirs = cells_of(first_line);
        if !theirs.iter().map(String::as_str).take(LEADING_COLUMNS.len()).eq(LEADING_COLUMNS) {
            return NO_TABLE.to_owned();
        }
        let ours: Vec<&str> = self.names().collect();
        let list = |names: Vec<&str>| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let more: Vec<&str> = theirs.iter().map(String::as_str).filter(|name| !ours.contains(name)).collect();
        if theirs == ours {
            return "another program saved the table, with other ends of lines, quotes, or a mark at its beginning"
                .to_owned();
        }
        let fewer: Vec<&str> = ours.into_iter().filter(|name| theirs.iter().all(|other| other != name)).collect();
        match (more.is_empty(), fewer.is_empty()) {
            (false, false) => format!("the table has {} where this batch has {}", list(more), list(fewer)),
            (false, true) => format!("the table has {}, which this batch has not", list(more)),
            (true, false) => format!("the table has no {}, which this batch has", list(fewer)),
            (true, true) => "the columns are in another order than in this batch".to_owned(),
        }
    }

    /// Reads the row of a line. The error says how the line differs from what this batch would write there.
    pub(super) fn read_row<V: Variants>(&self, batch: &Batch<V>, index: usize, line: &str) -> Result<MatchRow, String> {
        if index >= batch.len() {
            return Err(format!("the table has more matches than the {} of this batch", batch.len()));
        }
        let theirs = cells_of(line);
        let (variant, seed) = batch.job(index);
        let no_row = || "this is no row of the table".to_owned();
        let row = self.row_of(&theirs, index, variant).ok_or_else(no_row)?;
        let ours = cells(batch, &MatchRow { seed, ..row.clone() });
        let different = self.names().zip(theirs.iter().zip(&ours)).find(|(_, (theirs, ours))| theirs != ours);
        match different {
            None if theirs.len() == ours.len() => Ok(row),
            Some((SCENARIO, (theirs, _))) => Err(difference_of_scenarios(batch, &row, theirs)),
            Some((name, (theirs, ours))) => Err(format!("`{name}` is {theirs}, and {ours} in this batch")),
            None => Err(no_row()),
        }
    }

    fn row_of(&self, cells: &[String], index: usize, variant: usize) -> Option<MatchRow> {
        let first = LEADING_COLUMNS.len() + self.0.len();
        let own = cells.get(first..first + COLUMNS.len() - COLUMNS_OF_SCENARIO)?;
        let row: MatchRow = csv::StringRecord::from(own).deserialize(None).ok()?;
        Some(MatchRow { index, variant, seed: cells.get(1)?.parse().ok()?, ..row })
    }
}

/// Describes how the scenario of a row differs from this batch's: in its duration alone, or otherwise.
fn difference_of_scenarios<V: Variants>(batch: &Batch<V>, row: &MatchRow, theirs: &str) -> String {
    let duration = |duration_s: Option<f32>| duration_s.map_or("not given".to_owned(), |s| format!("{s} s"));
    let difference = batch.variants.scenario(row.variant).ok().and_then(|ours| {
        let with = |duration_s| fingerprint(&Scenario { duration_s, ..ours.clone() });
        let played = [None, Some(row.duration_s as f32)].into_iter().find(|played| with(*played) == theirs)?;
        Some(format!("the duration is {}, and {} in this batch", duration(played), duration(ours.duration_s)))
    });
    difference.unwrap_or_else(|| {
        "the scenario, `--duration` or a `--set` that is the same for all is another than in this batch".to_owned()
    })
}

/// Returns the cells of the row of a match in this batch.
pub(super) fn cells<V: Variants>(batch: &Batch<V>, row: &MatchRow) -> Vec<String> {
    let mut cells = vec![(row.index + 1).to_string(), row.seed.to_string()];
    cells.extend(batch.variants.values(row.variant).into_iter().map(as_text));
    cells.extend(cells_of_row(row));
    cells.extend([batch.variants.realism(row.variant), batch.variants.fingerprint(row.variant)]);
    cells
}
