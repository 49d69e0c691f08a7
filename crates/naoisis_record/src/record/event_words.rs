//! Events in words, for pages and logs.

use naoisis_core::events::{KickResult, MatchEvent};
use naoisis_core::referee::report;

/// Describes `event` at `time_s` in a sentence, and the referee's reasons. Returns `None` for events that happen all the time.
pub(super) fn event_words(time_s: f64, event: &MatchEvent) -> Option<(String, Vec<String>)> {
    match event {
        MatchEvent::StateChanged { .. } => None,
        MatchEvent::Kick { robot, kick_type, result: KickResult::Kicked | KickResult::Reduced, .. } => {
            Some((format!("{robot} kicks: {}.", kick_type.words()), Vec::new()))
        }
        _ => {
            let sentence = report::headline(event)?;
            let lines = report::report(time_s, None, event)?;
            Some((sentence, lines.lines().skip(1).map(|line| line.trim().to_owned()).collect()))
        }
    }
}
