//! The events that led to a goal, or to a better chance of a team: the mistakes, falls, penalties and failures of the other team, the
//! kicks, and whatever was done by hand.

use bevy_egui::egui::{self, RichText};
use core::ops::RangeInclusive;

use super::event_log::{LogEntry, LogKind};
use super::theme::{dim, link, minutes, team_colour, text_size};
use naoisis_core::team::Team;
use naoisis_record::record::mistakes::Mistake;

/// The greatest number of mistakes, of kicks, of failures, and of interventions that are listed: the last ones.
const MOST: usize = 4;

/// Returns the events in an interval of time, s, that helped `team`, in the order of their times, and the number of earlier ones that are left
/// out. `mistakes` have their entries, `log` is the whole log.
pub(super) fn reasons<'a, 'b>(
    team: Team,
    interval_s: &RangeInclusive<f64>,
    mistakes: impl Iterator<Item = (&'b Mistake, &'a LogEntry)>,
    log: &'a [LogEntry],
) -> (Vec<&'a LogEntry>, usize) {
    let costs = |mistake: &Mistake| {
        mistake.robot.team != team && mistake.from_s <= *interval_s.end() && mistake.until_s >= *interval_s.start()
    };
    let mistakes: Vec<&LogEntry> = mistakes.filter(|(mistake, _)| costs(mistake)).map(|(_, entry)| entry).collect();
    let is_then = |entry: &&LogEntry| interval_s.contains(&entry.time_s);
    let kicks: Vec<&LogEntry> = log.iter().filter(|entry| entry.kind == LogKind::Kick).filter(is_then).collect();
    let is_of_loser = |entry: &&LogEntry| entry.robot.is_some_and(|robot| robot.team != team);
    let has_failed = |entry: &&LogEntry| matches!(entry.kind, LogKind::Fall | LogKind::Penalty) && !entry.is_recovery;
    let failures: Vec<&LogEntry> = log.iter().filter(has_failed).filter(is_of_loser).filter(is_then).collect();
    let by_hand: Vec<&LogEntry> = log.iter().filter(|entry| entry.kind == LogKind::Hand).filter(is_then).collect();
    let mut reasons = [&mistakes, &kicks, &failures, &by_hand].map(|entries| last(entries)).concat();
    reasons.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
    let earlier = mistakes.len() + kicks.len() + failures.len() + by_hand.len() - reasons.len();
    (reasons, earlier)
}

/// Shows events line by line, and marks those that began before `from_s`. Returns the event that was clicked.
pub(super) fn show<'a>(ui: &mut egui::Ui, events: &[&'a LogEntry], from_s: f64) -> Option<&'a LogEntry> {
    let mut clicked = None;
    for entry in events {
        ui.horizontal(|ui| {
            ui.add_space(10.0);
            ui.label(dim(minutes(entry.time_s as f32)).monospace().size(text_size::SMALL));
            let colour = entry.side().map_or(ui.visuals().text_color(), |team| team_colour(ui, team));
            let began = if entry.time_s < from_s { ", from before" } else { "" };
            let text = RichText::new(format!("{}{began}", entry.text)).color(colour).size(text_size::ENTRY);
            if link(ui, egui::Label::new(text).wrap(), &entry.text)
                .on_hover_text("Click: show the moment and the place")
                .clicked()
            {
                clicked = Some(*entry);
            }
        });
    }
    clicked
}

fn last<'a, 'b>(entries: &'b [&'a LogEntry]) -> &'b [&'a LogEntry] {
    &entries[entries.len().saturating_sub(MOST)..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::*;
    use naoisis_core::team::RobotId;
    use naoisis_record::record::mistakes::MistakeKind;

    #[test]
    fn mistakes_and_falls_of_the_other_team_and_kicks_and_interventions_in_the_interval_are_reasons() {
        let mistake = |team, from_s, until_s| Mistake {
            kind: MistakeKind::BallMisplaced,
            robot: RobotId::new(team, 2),
            other: None,
            from_s,
            until_s,
            position_m: Vec2::ZERO,
            worst: None,
        };
        let mistakes = [
            mistake(Team::Pink, 2.0, 9.0),
            mistake(Team::Pink, 8.0, 11.0),
            mistake(Team::Blue, 11.0, 12.0),
            mistake(Team::Pink, 14.0, 20.0),
            mistake(Team::Pink, 16.0, 16.0),
        ];
        let entry = |time_s, kind| LogEntry { time_s, kind, ..default() };
        let robot = |team| Some(RobotId::new(team, 2));
        let fall = |time_s, team| LogEntry { robot: robot(team), ..entry(time_s, LogKind::Fall) };
        let entries = mistakes.map(|mistake| entry(mistake.from_s, LogKind::Mistake));
        let log = [
            entry(9.0, LogKind::Kick),
            entry(10.0, LogKind::Hand),
            entry(12.0, LogKind::Kick),
            fall(12.5, Team::Blue),
            fall(13.0, Team::Pink),
            LogEntry { is_recovery: true, ..fall(14.5, Team::Pink) },
            fall(15.5, Team::Pink),
        ];
        let of = |times: usize| {
            let mistakes = (0..times).flat_map(|_| mistakes.iter().zip(&entries));
            let (reasons, earlier) = reasons(Team::Blue, &(10.0..=15.0), mistakes, &log);
            (reasons.iter().map(|entry| entry.time_s).collect::<Vec<_>>(), earlier)
        };
        assert_eq!(of(1), (vec![8.0, 10.0, 12.0, 13.0, 14.0], 0));
        assert_eq!(of(3), (vec![8.0, 8.0, 10.0, 12.0, 13.0, 14.0, 14.0], 2));
    }
}
