//! The reasons for a swing: the mistakes, falls, penalties and failures of the team that lost by it, the kicks before its end, and
//! whatever was done by hand.

use crate::viewer::event_log::{LogEntry, LogKind};
use naoisis_record::record::mistakes::Mistake;
use naoisis_record::whatif::chances::Swing;

/// The greatest number of mistakes, of kicks, of failures, and of interventions of a swing that are listed: the last ones.
const MOST: usize = 4;

/// The listed mistakes, kicks and other events of a swing in the order of their times, and the number of earlier ones. `mistakes` have their
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
    let is_of_loser = |entry: &&LogEntry| entry.robot.is_some_and(|robot| robot.team != swing.team);
    let has_failed = |entry: &&LogEntry| matches!(entry.kind, LogKind::Fall | LogKind::Penalty) && !entry.is_recovery;
    let failures: Vec<&LogEntry> = log.iter().filter(has_failed).filter(is_of_loser).filter(is_then).collect();
    let by_hand: Vec<&LogEntry> = log.iter().filter(|entry| entry.kind == LogKind::Hand).filter(is_then).collect();
    let mut reasons = [&mistakes, &kicks, &failures, &by_hand].map(|entries| last(entries)).concat();
    reasons.sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
    let earlier = mistakes.len() + kicks.len() + failures.len() + by_hand.len() - reasons.len();
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
    fn mistakes_and_falls_of_the_team_that_lost_by_a_swing_and_kicks_and_interventions_in_it_are_its_reasons() {
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
            let (reasons, earlier) = reasons(&swings[0], mistakes, &log);
            (reasons.iter().map(|entry| entry.time_s).collect::<Vec<_>>(), earlier)
        };
        assert_eq!(of(1), (vec![8.0, 10.0, 12.0, 13.0, 14.0], 0));
        assert_eq!(of(3), (vec![8.0, 8.0, 10.0, 12.0, 13.0, 14.0, 14.0], 2));
    }
}
