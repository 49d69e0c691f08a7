//! The reasons for a swing: the mistakes of the team that lost by it, and the kicks before its end.

use crate::viewer::event_log::{LogEntry, LogKind};
use naoisis_record::record::mistakes::Mistake;
use naoisis_record::whatif::chances::Swing;

/// The greatest number of mistakes and of kicks of a swing that are listed: the last ones.
const MOST: usize = 4;

/// The listed mistakes and kicks of a swing in the order of their times, and the number of earlier ones. `mistakes` have their
/// entries, `log` is the whole log.
pub(super) fn reasons<'a>(
    swing: &Swing,
    mistakes: impl Iterator<Item = (&'a Mistake, &'a LogEntry)>,
    log: &'a [LogEntry],
) -> (Vec<&'a LogEntry>, usize) {
    let costs = |mistake: &Mistake| {
        mistake.robot.team != swing.team && mistake.from_s <= swing.until_s && mistake.until_s >= swing.from_s
    };
    let mistakes: Vec<&LogEntry> = mistakes.filter(|(mistake, _)| costs(mistake)).map(|(_, entry)| entry).collect();
    let is_then = |entry: &&LogEntry| (swing.from_s..=swing.until_s).contains(&entry.time_s);
    let kicks: Vec<&LogEntry> = log.iter().filter(|entry| entry.kind == LogKind::Kick).filter(is_then).collect();
    let mut reasons = [last(&mistakes), last(&kicks)].concat();
    reasons.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
    let earlier = mistakes.len() + kicks.len() - reasons.len();
    (reasons, earlier)
}

fn last<'a, 'b>(entries: &'b [&'a LogEntry]) -> &'b [&'a LogEntry] {
    &entries[entries.len().saturating_sub(MOST)..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::*;
    use naoisis_core::team::{PerTeam, RobotId, Team};
    use naoisis_record::record::mistakes::MistakeKind;
    use naoisis_record::whatif::chances::{Chance, swings};

    #[test]
    fn mistakes_of_the_team_that_lost_by_a_swing_and_kicks_in_it_are_its_reasons() {
        let score = PerTeam { blue: 0, pink: 0 };
        let chance = |time_s, blue| Chance { time_s, score, times: 100, first: PerTeam { blue, pink: 0 } };
        let swings = swings(&[chance(10.0, 0), chance(15.0, 90)], &[]);
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
        let entries = mistakes.map(|mistake| entry(mistake.from_s, LogKind::Mistake));
        let log = [(9.0, LogKind::Kick), (12.0, LogKind::Kick), (13.0, LogKind::Fall)];
        let log = log.map(|(time_s, kind)| entry(time_s, kind));
        let of = |times: usize| {
            let mistakes = (0..times).flat_map(|_| mistakes.iter().zip(&entries));
            let (reasons, earlier) = reasons(&swings[0], mistakes, &log);
            (reasons.iter().map(|entry| entry.time_s).collect::<Vec<_>>(), earlier)
        };
        assert_eq!(of(1), (vec![8.0, 12.0, 14.0], 0));
        assert_eq!(of(3), (vec![8.0, 8.0, 12.0, 14.0, 14.0], 2));
    }
}
