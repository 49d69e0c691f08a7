//! Writes the [summary](MatchSummary) of a match as a self-contained HTML page.

use bevy::prelude::*;
use core::fmt::Write as _;

use super::match_summary::{CELLS_ALONG, HeatMap, MatchSummary};
use super::summary_rows::{
    BLUE, KickLine, PINK, ROBOT_COLUMNS, TEAM_COLUMNS, kick_maps, maps, mistake_rows, robot_rows, team_rows,
};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::Team;
use naoisis_sensing::appearance::colours::Colour;

const STYLE: &str = "body{font-family:system-ui,sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color:#202226}\
h1{font-size:1.5em}h2{font-size:1.1em;margin:1.6em 0 .4em}.score{font-size:3em;font-weight:300}\
table{border-collapse:collapse}td,th{padding:.25em .8em;text-align:right;border-bottom:1px solid #ddd;font-weight:400}\
th{color:#666}td:first-child,th:first-child{text-align:left}.maps{display:flex;flex-wrap:wrap;gap:1.5em}\
figure{margin:0}figcaption{color:#666;margin-top:.3em}";
/// Width of the map of a pitch of any size, pixels.
const MAP_WIDTH: f32 = 340.0;

/// Returns the HTML page of a match.
pub fn page(summary: &MatchSummary) -> String {
    let mut html = String::new();
    let title = escaped(&summary.name);
    // Writing to a string cannot fail.
    _ = write!(
        html,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}, seed {seed}</title>\
         <style>{STYLE}.blue{{color:{blue}}}.pink{{color:{pink}}}</style></head><body><h1>{title}, seed {seed}</h1>\
         <div class=\"score\"><span class=\"blue\">{} {}</span> : <span class=\"pink\">{} {}</span></div>\
         <p>{how}{} min played, {} min of them in play, realism {}.</p>",
        team_name(summary, Team::Blue),
        summary.score.blue,
        summary.score.pink,
        team_name(summary, Team::Pink),
        minutes(summary.duration_s),
        minutes(summary.counts.play_s()),
        escaped(&summary.realism),
        how = summary.how.as_ref().map(|how| format!("Decided: {}. ", escaped(how))).unwrap_or_default(),
        seed = summary.seed,
        blue = hex(BLUE),
        pink = hex(PINK),
    );
    if !summary.goals.is_empty() {
        html += "<h2>Goals</h2><ul>";
        for (time_s, by) in &summary.goals {
            _ = write!(html, "<li>{} {}</li>", minutes(*time_s), escaped(by));
        }
        html += "</ul>";
    }
    html += "<h2>Teams</h2>";
    table(&mut html, &TEAM_COLUMNS, &team_rows(summary));
    html += "<h2>Where they were</h2><div class=\"maps\">";
    for (words, map, colour) in maps(summary) {
        let cells = cells(&summary.pitch, map, &hex(colour));
        _ = write!(html, "<figure>{}<figcaption>{words}</figcaption></figure>", svg(&summary.pitch, &cells));
    }
    html += "</div><h2>Passes and shots</h2><div class=\"maps\">";
    for (words, lines) in kick_maps(summary) {
        _ = write!(html, "<figure>{}<figcaption>{words}</figcaption></figure>", svg(&summary.pitch, &arrows(&lines)));
    }
    html += "</div><h2>Robots</h2>";
    table(&mut html, &ROBOT_COLUMNS, &robot_rows(summary));
    let mistakes = summary.mistakes();
    if !mistakes.is_empty() {
        html += "<h2>Mistakes</h2>";
        table(&mut html, &TEAM_COLUMNS, &mistake_rows(&mistakes));
    }
    html + "</body></html>\n"
}

/// Adds a table. Its cells are escaped.
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

/// Returns passes or shots as lines in SVG, with +y up; those with success are thicker and end with a dot.
fn arrows(lines: &[KickLine]) -> String {
    let mut svg = String::new();
    for line in lines {
        let colour = hex(if line.team == Team::Blue { BLUE } else { PINK });
        let (from, to) = (line.from_m * Vec2::new(1.0, -1.0), line.to_m * Vec2::new(1.0, -1.0));
        let (width, opacity) = if line.is_success { (0.045, 1.0) } else { (0.025, 0.5) };
        _ = write!(
            svg,
            "<path d=\"M{:.3} {:.3}L{:.3} {:.3}\" stroke=\"{colour}\" stroke-width=\"{width}\" opacity=\"{opacity}\"/>",
            from.x, from.y, to.x, to.y
        );
        if line.is_success {
            _ = write!(svg, "<circle cx=\"{:.3}\" cy=\"{:.3}\" r=\"0.09\" fill=\"{colour}\"/>", to.x, to.y);
        }
    }
    svg
}

/// Returns a heat map as rectangles in SVG, with +y up.
fn cells(pitch: &Pitch, map: &HeatMap, colour: &str) -> String {
    let (half_length, half_width) = (pitch.half_length(), pitch.half_width());
    let most_s = map.most_s().max(1e-6);
    let cell = Vec2::new(2.0 * half_length / CELLS_ALONG as f32, 2.0 * half_width / map.rows as f32);
    let mut svg = format!("<g fill=\"{colour}\">");
    for (index, time_s) in map.time_s.iter().enumerate().filter(|(_, time_s)| **time_s > 0.0) {
        let (column, row) = ((index % CELLS_ALONG) as f32, (index / CELLS_ALONG) as f32);
        let (x, y) = (column * cell.x - half_length, half_width - (row + 1.0) * cell.y);
        // Square roots of the shares make differences easier to see.
        let cover = (time_s / most_s).sqrt();
        _ = write!(
            svg,
            "<rect x=\"{x:.3}\" y=\"{y:.3}\" width=\"{:.3}\" height=\"{:.3}\" opacity=\"{cover:.3}\"/>",
            cell.x, cell.y
        );
    }
    svg + "</g>"
}

/// Returns a plan of the pitch with `contents`.
fn svg(pitch: &Pitch, contents: &str) -> String {
    let (half_length, half_width) = (pitch.half_length(), pitch.half_width());
    let line = pitch.line_width_m;
    let mut svg = format!(
        "<svg width=\"{MAP_WIDTH}\" viewBox=\"{:.2} {:.2} {:.2} {:.2}\">{contents}",
        -half_length - 0.3,
        -half_width - 0.3,
        2.0 * half_length + 0.6,
        2.0 * half_width + 0.6,
    );
    _ = write!(
        svg,
        "<g fill=\"none\" stroke=\"#888\" stroke-width=\"{line}\">\
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

/// Formats a time as the whole minutes and seconds that have passed, as a clock shows it.
pub fn minutes(time_s: f64) -> String {
    // Times of cycles may be less than the second by rounding.
    let seconds = (time_s + 1e-4).max(0.0) as u64;
    format!("{}:{:02}", seconds / 60, seconds % 60)
}

/// Returns a colour as CSS.
fn hex(Colour([red, green, blue]): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Escapes words for HTML.
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
        // Each map has the pitch and at most two areas at each end, and nothing else without play.
        assert_eq!(page.matches("<svg").count(), 5);
        assert_eq!(page.matches("opacity").count(), 0);
    }
}
