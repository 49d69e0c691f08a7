//! Mistakes as entries of the list of events. Those shortly before a goal for the other team stand out.

use bevy::prelude::*;

use super::Lanes;
use crate::viewer::event_filter::{COSTLY_S, FoundMistakes};
use crate::viewer::event_log::{LogEntry, LogKind};
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::Team;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::MarkKind;
use naoisis_record::record::mistakes::{Mistake, MistakeKind};

/// Passes the mistakes to the list of events.
pub(super) fn tell_mistakes(
    lanes: Res<Lanes>,
    history: Res<History>,
    clock: Res<CycleClock>,
    found: Option<ResMut<FoundMistakes>>,
    mut told: Local<(Vec<Mistake>, Vec<(f64, Team)>)>,
) {
    let mistakes = lanes.tracks.mistakes();
    let goals = goals_of(&history, clock.period_s);
    // A branch may have as many of them as the match that was shown before.
    if let Some(mut found) = found.filter(|_| told.0 != mistakes || told.1 != goals) {
        found.0 = mistakes.iter().map(|mistake| entry_of(mistake, &goals)).collect();
        *told = (mistakes.to_vec(), goals);
    }
}

/// The times of all goals, s, and who scored.
pub(super) fn goals_of(history: &History, period_s: f64) -> Vec<(f64, Team)> {
    let goals = history.marks().iter().filter(|mark| mark.kind == MarkKind::Goal);
    goals.filter_map(|goal| Some((goal.cycle as f64 * period_s, goal.team?))).collect()
}

/// A mistake as an entry; `goals` are the times of all goals, s, and who scored.
pub(super) fn entry_of(mistake: &Mistake, goals: &[(f64, Team)]) -> LogEntry {
    let team = mistake.robot.team;
    let is_cost =
        |(time_s, scored): &&(f64, Team)| *scored != team && (0.0..=COSTLY_S).contains(&(time_s - mistake.from_s));
    let cost = goals.iter().find(is_cost);
    let words = mistake_words(mistake);
    LogEntry {
        time_s: mistake.from_s,
        team: Some(team),
        text: cost.map_or(words.clone(), |(time_s, scored)| {
            format!("{words}, {:.0} s before a goal for {scored}", time_s - mistake.from_s)
        }),
        important: cost.is_some(),
        robot: Some(mistake.robot),
        place: Some(mistake.position_m),
        kind: LogKind::Mistake,
        ..default()
    }
}

/// The cycle in which a mistake began.
pub(super) fn cycle_of(mistake: &Mistake, period_s: f64) -> u64 {
    (mistake.from_s / period_s).round() as u64
}

/// A mistake in a line.
pub(super) fn mistake_words(mistake: &Mistake) -> String {
    let joins = if mistake.kind == MistakeKind::BallGivenAway { "to" } else { "with" };
    let other = mistake.other.map_or_else(String::new, |other| format!(" {joins} {other}"));
    // The time of a pass to the other team says nothing about the mistake.
    let length_s = if mistake.kind == MistakeKind::BallGivenAway { 0.0 } else { mistake.until_s - mistake.from_s };
    let at_most = if length_s > 0.0 { "up to " } else { "" };
    let worst = mistake.worst.map_or_else(String::new, |worst| format!(", {at_most}{worst:.2} {}", mistake.unit()));
    let length = if length_s > 0.0 { format!(", for {length_s:.1} s") } else { String::new() };
    format!("{}: {}{other}{worst}{length}", mistake.robot, mistake.kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::RobotId;
    use naoisis_record::record::mistakes::MistakeKind;

    #[test]
    fn mistakes_before_a_goal_of_the_others_stand_out() {
        let robot = RobotId::new(Team::Pink, 1);
        let mistake = |from_s| Mistake {
            kind: MistakeKind::KickMissed,
            robot,
            other: None,
            from_s,
            until_s: from_s,
            position_m: Vec2::ZERO,
            worst: None,
        };
        let goals = [(30.0, Team::Blue), (60.0, Team::Pink)];
        let costly = [19.0, 26.0, 31.0, 55.0].map(|from_s| entry_of(&mistake(from_s), &goals).important);
        assert_eq!(costly, [false, true, false, false]);
        assert_eq!(entry_of(&mistake(26.0), &goals).text, "pink1: kick missed, 4 s before a goal for blue");
    }
}
