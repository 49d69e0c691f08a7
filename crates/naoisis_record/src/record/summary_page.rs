//! The [summary](MatchSummary) of a match as a page in HTML, which needs nothing else.

use bevy::prelude::*;
use core::fmt::Write as _;

use super::match_summary::{CELLS_ALONG, HeatMap, MatchSummary};
use super::mistakes::MistakeKind;
use naoisis_core::pitch::Pitch;
use naoisis_core::team::Team;

const STYLE: &str = "body{font-family:system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color:#202226}\
h1{font-size:1.5em}h2{font-size:1.1em;margin:1.6em 0 .4em}.score{font-size:3em;font-weight:300}\
table{border-collapse:collapse}td,th{padding:.25em .8em;text-align:right;border-bottom:1px solid #ddd;font-weight:400}\
th{color:#666}td:first-child,th:first-child{text-align:left}.maps{display:flex;flex-wrap:wrap;gap:1.5em}\
figure{margin:0}figcaption{color:#666;margin-top:.3em}.blue{color:#2458b8}.pink{color:#c02f78}";
/// Pixels to a metre of a map of the pitch that is this long; others are as large.
const MAP_WIDTH: f32 = 340.0;

/// The page of a match.
pub fn page(summary: &MatchSummary) -> String {
    let mut html = String::new();
    let title = escaped(&summary.name);
    // Writing to a string cannot fail.
    _ = write!(
        html,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}, seed {seed}</title>\
         <style>{STYLE}</style></head><body><h1>{title}, seed {seed}</h1>\
         <div class=\"score\"><span class=\"blue\">{} {}</span> : <span class=\"pink\">{} {}</span></div>\
         <p>{} min played, {} min of them in play, realism {}.</p>",
        team_name(summary, Team::Blue),
        summary.score.blue,
        summary.score.pink,
        team_name(summary, Team::Pink),
        minutes(summary.duration_s),
        minutes(summary.counts.play_s()),
        escaped(&summary.realism),
        seed = summary.seed,
    );
    if !summary.goals.is_empty() {
        html += "<h2>Goals</h2><ul>";
        for (time_s, by) in &summary.goals {
            _ = write!(html, "<li>{} {}</li>", minutes(*time_s), escaped(by));
        }
        html += "</ul>";
    }
    html += "<h2>Teams</h2>";
    table(&mut html, &["", "blue", "pink"], &team_rows(summary));
    html += "<h2>Where they were</h2><div class=\"maps\">";
    let maps = [
        ("the ball", &summary.ball, "#d2691e"),
        ("blue", &summary.places.blue, "#2458b8"),
        ("pink", &summary.places.pink, "#c02f78"),
    ];
    for (words, map, colour) in maps {
        _ = write!(html, "<figure>{}<figcaption>{words}</figcaption></figure>", svg(&summary.pitch, map, colour));
    }
    html += "</div><h2>Robots</h2>";
    let columns = ["", "kicks", "shots", "goals", "passes completed", "walked", "falls", "penalties"];
    table(&mut html, &columns, &robot_rows(summary));
    let mistakes = summary.mistakes();
    if !mistakes.is_empty() {
        html += "<h2>Mistakes</h2>";
        let count = |team: Team, kind: MistakeKind| {
            let is_it = |mistake: &&super::mistakes::Mistake| mistake.robot.team == team && mistake.kind == kind;
            mistakes.iter().filter(is_it).count().to_string()
        };
        let row = |kind: MistakeKind| vec![kind.to_string(), count(Team::Blue, kind), count(Team::Pink, kind)];
        let rows: Vec<Vec<String>> = MistakeKind::ALL.into_iter().map(row).collect();
        table(&mut html, &["", "blue", "pink"], &rows);
    }
    html + "</body></html>\n"
}

/// What the teams did: a row for each quantity, in words, blue, pink.
pub fn team_rows(summary: &MatchSummary) -> Vec<Vec<String>> {
    let counts = &summary.counts;
    let percent = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), |share| format!("{:.0} %", 100.0 * share));
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

/// What the robots did: a row for each.
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

/// A table; cells are escaped.
fn table(html: &mut String, columns: &[&str], rows: &[Vec<String>]) {
    *html += "<table><tr>";
    for column in columns {
        _ = write!(html, "<th>{}</th>", escaped(column));
    }
    *html += "</tr>";
    for row in rows {
        *html += "<tr>";
        for cell in row {
            _ = write!(html, "<td>{}</td>", escaped(cell));
        }
        *html += "</tr>";
    }
    *html += "</table>";
}

/// A heat map on a plan of the pitch, +y up.
fn svg(pitch: &Pitch, map: &HeatMap, colour: &str) -> String {
    let (half_length, half_width) = (pitch.half_length(), pitch.half_width());
    let line = pitch.line_width_m;
    let most_s = map.most_s().max(1e-6);
    let cell = Vec2::new(2.0 * half_length / CELLS_ALONG as f32, 2.0 * half_width / map.rows as f32);
    let mut svg = format!(
        "<svg width=\"{MAP_WIDTH}\" viewBox=\"{:.2} {:.2} {:.2} {:.2}\"><g fill=\"{colour}\">",
        -half_length - 0.3,
        -half_width - 0.3,
        2.0 * half_length + 0.6,
        2.0 * half_width + 0.6,
    );
    for (index, time_s) in map.time_s.iter().enumerate().filter(|(_, time_s)| **time_s > 0.0) {
        let (column, row) = ((index % CELLS_ALONG) as f32, (index / CELLS_ALONG) as f32);
        let (x, y) = (column * cell.x - half_length, half_width - (row + 1.0) * cell.y);
        // The eye tells shares of the longest time apart better by their roots.
        let cover = (time_s / most_s).sqrt();
        _ = write!(
            svg,
            "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{:.3}\" height=\"{:.3}\" opacity=\"{cover:.3}\"/>",
            cell.x, cell.y
        );
    }
    _ = write!(
        svg,
        "</g><g fill=\"none\" stroke=\"#888\" stroke-width=\"{line}\">\
         <rect x=\"{:.3}\" y=\"{:.3}\" width=\"{:.3}\" height=\"{:.3}\"/>\
         <path d=\"M0 {:.3}V{half_width:.3}\"/><circle r=\"{:.3}\"/>",
        -half_length,
        -half_width,
        2.0 * half_length,
        2.0 * half_width,
        -half_width,
        pitch.centre_circle_diameter_m / 2.0,
    );
    for area in [Some(pitch.penalty_area), pitch.goal_area].into_iter().flatten() {
        for x in [-half_length, half_length - area.depth_m] {
            _ = write!(
                svg,
                "<rect x=\"{x:.3}\" y=\"{:.3}\" width=\"{:.3}\" height=\"{:.3}\"/>",
                -area.width_m / 2.0,
                area.depth_m,
                area.width_m
            );
        }
    }
    svg + "</g></svg>"
}

fn team_name(summary: &MatchSummary, team: Team) -> String {
    escaped(summary.teams.as_ref().map_or(team.name(), |teams| teams[team].as_str()))
}

/// Minutes and seconds.
pub fn minutes(time_s: f64) -> String {
    let seconds = time_s.round() as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// Words as HTML has them.
fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::{Scenario, TeamsSpec};

    #[test]
    fn a_page_says_who_played_and_is_no_ones_to_write_into() {
        let teams = Some(TeamsSpec::new("roles", "<script>alert(1)</script>"));
        let scenario = Scenario { name: "a & b".to_owned(), seed: 7, teams, ..Scenario::default() };
        let page = page(&MatchSummary::new(&scenario));
        assert!(page.contains("<h1>a &amp; b, seed 7</h1>") && page.contains("roles 0"), "{page}");
        assert!(page.contains("realism paper"), "{page}");
        assert!(!page.contains("<script>"));
        // Each map has the pitch, two areas at each end at most, and nothing else without play.
        assert_eq!(page.matches("<svg").count(), 3);
        assert_eq!(page.matches("opacity").count(), 0);
    }
}
