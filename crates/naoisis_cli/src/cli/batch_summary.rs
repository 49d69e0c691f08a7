//! The summary at the end of `naoisis batch`: results for each combination of settings.

use super::terminal::Printer;
use naoisis_core::team::RobotId;
use naoisis_record::batch::mistakes::{MistakeCounts, MistakeTable};
use naoisis_record::batch::summary::Summary;
use naoisis_record::batch::sweep::Sweep;
use naoisis_record::batch::{Batch, MatchOutcome, MatchRow, Variants};

/// Prints the results of each combination of settings that has been played. Sorts `rows` by variant.
pub(super) fn print_summaries(
    printer: &mut Printer,
    sweep: &Sweep,
    rows: &mut [MatchRow],
    mistakes: Option<&MistakeTable>,
) {
    let combination = |row: &MatchRow| row.variant / sweep.variants_of_combination();
    rows.sort_by_key(|row| (row.variant, row.index));
    for rows in rows.chunk_by(|one, other| combination(one) == combination(other)) {
        let settings = rows.first().map(|row| sweep.words(row.variant)).unwrap_or_default();
        // The realism is printed with every result.
        let realism = rows.first().map(|row| sweep.realism(row.variant)).unwrap_or_default();
        let settings = if settings.is_empty() { settings } else { format!("{settings}; ") };
        printer.print(format_args!("{settings}realism {realism}\n"));
        match sweep.pairs() {
            Some(pairs) => {
                let rows = rows.iter().filter_map(|row| Some((row, sweep.pairing(row.variant)?)));
                printer.print(pairs.table(rows));
            }
            None => printer.print(summary_text(&Summary::of(rows.iter()))),
        }
        if let Some(mistakes) = mistakes {
            printer.print(count_mistakes(sweep, rows, mistakes));
        }
        if printer.is_closed() {
            break;
        }
    }
}

/// Returns the numbers of mistakes in the matches of a combination: by robot, or by team with --pairs.
fn count_mistakes(sweep: &Sweep, rows: &[MatchRow], mistakes: &MistakeTable) -> MistakeCounts {
    let combination = |variant: usize| variant / sweep.variants_of_combination();
    let played = |row: &&MatchRow| !matches!(row.outcome, MatchOutcome::Refused | MatchOutcome::Panicked);
    let who = |variant: usize, robot: RobotId| match (sweep.pairs(), sweep.pairing(variant)) {
        (Some(pairs), Some(pairing)) => pairs.names(pairing)[robot.team as usize].to_owned(),
        _ => robot.to_string(),
    };
    let of_these = mistakes
        .counts()
        .filter(|(variant, ..)| rows.first().is_some_and(|row| combination(row.variant) == combination(*variant)))
        .map(|(variant, robot, kind, count)| (who(variant, robot), kind, count));
    // With --pairs, a team only played in the matches of its pairs.
    let is_of = |row: &MatchRow, name: &str| match (sweep.pairs(), sweep.pairing(row.variant)) {
        (Some(pairs), Some(pairing)) => pairs.names(pairing).contains(&name),
        _ => true,
    };
    MistakeCounts::of(of_these, |name| rows.iter().filter(played).filter(|row| is_of(row, name)).count())
}

/// Returns a text with the number of matches, and the speed of those that were played now.
pub(super) fn what_was_played(batch: &Batch<Sweep>, rows: &[MatchRow], earlier: usize, wall_s: f64) -> String {
    let of_all = format!("{} of {} matches", rows.len(), batch.len());
    let played = &rows[earlier.min(rows.len())..];
    if played.is_empty() {
        return match earlier {
            0 => format!("{of_all}\n"),
            _ => format!("{of_all}, all played earlier\n"),
        };
    }
    let simulated_s: f64 = played.iter().map(|row| row.duration_s).sum();
    let wall_s = wall_s.max(1e-9);
    format!(
        "{of_all}{} in {wall_s:.1} s on {} thread{}: {:.1} matches/s, {:.0} times real time\n",
        if earlier > 0 { format!(", {earlier} of them played earlier,") } else { String::new() },
        batch.threads,
        if batch.threads == 1 { "" } else { "s" },
        played.len() as f64 / wall_s,
        simulated_s / wall_s,
    )
}

fn summary_text(summary: &Summary) -> String {
    let failed = if summary.failed > 0 { format!(", {} failed", summary.failed) } else { String::new() };
    let mut text = format!("{:>24}  {}{failed}\n", "matches", summary.matches);
    for (name, value) in summary.lines() {
        text += &format!("{name:>24}  {value}\n");
    }
    text
}
