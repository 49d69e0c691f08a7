//! The reasons for a swing: the mistakes of the team that lost by it, and the kicks before its end.

use crate::viewer::event_log::{LogEntry, LogKind};
use naoisis_record::record::mistakes::Mistake;
use naoisis_record::whatif::chances::Swing;

/// The greatest number of mistakes and of kicks of a swing that are listed: the last ones.
const MOST: usize = 4;

/// The mistakes and kicks of a swing, in the order of their times. `mistakes` have their entries, `log` is the whole log.
pub(super) fn reasons<'a>(
    swing: &Swing,
    mistakes: impl Iterator<Item = (&'a Mistake, &'a LogEntry)>,
    log: &'a [LogEntry],
) -> Vec<&'a LogEntry> {
    let costs = |mistake: &Mistake| {
        mistake.robot.team != swing.team && mistake.from_s <= swing.until_s && mistake.until_s >= swing.from_s
    };
    let mistakes: Vec<&LogEntry> = mistakes.filter(|(mistake, _)| costs(mistake)).map(|(_, entry)| entry).collect();
    let is_then = |entry: &&LogEntry| (swing.from_s..=swing.until_s).contains(&entry.time_s);
    let kicks: Vec<&LogEntry> = log.iter().filter(|entry| entry.kind == LogKind::Kick).filter(is_then).collect();
    let mut reasons = [last(&mistakes), last(&kicks)].concat();
    reasons.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
    reasons
}

fn last<'a, 'b>(entries: &'b [&'a LogEntry]) -> &'b [&'a LogEntry] {
    &entries[entries.len().saturating_sub(MOST)..]
}
