//! The tables and maps of a [summary](MatchSummary), for its page, its picture and the viewer.

use bevy::prelude::*;

use super::match_counts::{KickOutcome, PlayedKick};
use super::match_summary::{HeatMap, MatchSummary};
use super::mistakes::{Mistake, MistakeKind};
use naoisis_core::team::Team;
use naoisis_sensing::appearance::colours::Colour;

/// Colour of the blue team on paper.
pub const BLUE: Colour = Colour([36, 88, 184]);
/// Colour of the pink team on paper.
pub const PINK: Colour = Colour([192, 47, 120]);
/// Colour of the ball on paper.
pub const BALL: Colour = Colour([210, 105, 30]);
/// Columns of tables of teams.
pub const TEAM_COLUMNS: [&str; 3] = ["", "blue", "pink"];
/// Columns of the table of robots.
pub const ROBOT_COLUMNS: [&str; 8] =
    ["", "kicks", "shots", "goals", "passes completed", "walked", "falls", "penalties"];

/// Returns the heat maps, each with its title and its colour.
pub fn maps(summary: &MatchSummary) -> [(&'static str, &HeatMap, Colour); 3] {
    [("the ball", &summary.ball, BALL), ("blue", &summary.places.blue, BLUE), ("pink", &summary.places.pink, PINK)]
}

/// A pass or a shot on a map.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct KickLine {
    /// The robot's team.
    pub team: Team,
    /// The position of the ball before the kick, m.
    pub from_m: Vec2,
    /// The position of the ball at its end, m.
    pub to_m: Vec2,
    /// Whether the pass was completed, or the shot was on target.
    pub is_success: bool,
}

/// Returns the maps of passes and shots, each with its title.
pub fn kick_maps(summary: &MatchSummary) -> [(&'static str, Vec<KickLine>); 2] {
    let mut maps = [("passes (completed with a dot)", Vec::new()), ("shots (on target with a dot)", Vec::new())];
    for kick in &summary.counts.passes_and_shots {
        let (map, is_success) = match kick.outcome {
            KickOutcome::PassCompleted => (0, true),
            KickOutcome::PassFailed { .. } => (0, false),
            KickOutcome::ShotOnTarget { .. } => (1, true),
            KickOutcome::ShotOffTarget => (1, false),
            KickOutcome::Neither => continue,
        };
        let PlayedKick { robot, from_m, to_m, .. } = *kick;
        maps[map].1.push(KickLine { team: robot.team, from_m, to_m, is_success });
    }
    maps
}

/// A share from 0 to 1 in whole percent; those below half a percent, but not 0, with tenths and never as 0.
fn percent_words(share: f64) -> String {
    match 100.0 * share {
        percent if percent > 0.0 && percent < 0.05 => "< 0.1 %".to_owned(),
        percent if percent > 0.0 && percent < 0.5 => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    }
}

/// Returns the table of teams: a row for each quantity, with its name and the values of blue and pink.
pub fn team_rows(summary: &MatchSummary) -> Vec<Vec<String>> {
    let counts = &summary.counts;
    let percent = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), percent_words);
    let columns = Team::BOTH.map(|team| {
        let own = counts.team(team);
        let passes = match own.passes {
            0 => "0".to_owned(),
            all => format!(
                "{} of {all} ({:.0} %)",
                own.passes_completed,
                100.0 * f64::from(own.passes_completed) / f64::from(all)
            ),
        };
        let mut rows = vec![
            ("possession", percent(counts.possession(team))),
            ("kicks", own.kicks.to_string()),
            ("shots", own.shots.to_string()),
            ("shots on target", own.shots_on_target.to_string()),
            ("saves", own.saves.to_string()),
            ("passes completed", passes),
            ("duels won", counts.duels_won[team].to_string()),
            ("walked", format!("{:.0} m", own.distance_m)),
            ("falls", own.falls.to_string()),
            ("penalties", own.penalty_count().to_string()),
        ];
        if Team::BOTH.iter().any(|team| counts.median_pose_error_m(*team).is_some()) {
            let median = counts.median_pose_error_m(team);
            rows.push((
                "pose error, median",
                median.map_or_else(|| "-".to_owned(), |error_m| format!("{error_m:.3} m")),
            ));
            rows.push(("pose error over 0.5 m", percent(own.pose_errors.over_half_m())));
            rows.push(("pose error over 1 m", percent(own.pose_errors.over_1_m())));
        }
        rows
    });
    let [blue, pink] = columns;
    blue.into_iter().zip(pink).map(|((words, blue), (_, pink))| vec![words.to_owned(), blue, pink]).collect()
}

/// Returns the table of robots, a row for each.
pub fn robot_rows(summary: &MatchSummary) -> Vec<Vec<String>> {
    let rows = summary.counts.robots.iter().map(|(id, robot)| {
        let penalties = robot.penalties.iter().map(|(reason, count)| match count {
            1 => reason.words().into_owned(),
            count => format!("{count} x {}", reason.words()),
        });
        vec![
            id.to_string(),
            robot.kicks.to_string(),
            robot.shots.to_string(),
            robot.goals.to_string(),
            robot.passes_completed.to_string(),
            format!("{:.0} m", robot.distance_m),
            robot.falls.to_string(),
            penalties.collect::<Vec<_>>().join(", "),
        ]
    });
    rows.collect()
}

/// Returns the number of mistakes: a row for each kind, with its name and the values of blue and pink.
pub fn mistake_rows(mistakes: &[Mistake]) -> Vec<Vec<String>> {
    let count = |team: Team, kind: MistakeKind| {
        let is_it = |mistake: &&Mistake| mistake.robot.team == team && mistake.kind == kind;
        mistakes.iter().filter(is_it).count().to_string()
    };
    let row = |kind: MistakeKind| vec![kind.to_string(), count(Team::Blue, kind), count(Team::Pink, kind)];
    MistakeKind::ALL.into_iter().map(row).collect()
}
