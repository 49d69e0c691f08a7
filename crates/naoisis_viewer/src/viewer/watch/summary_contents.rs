//! The tables, goals and maps of the statistics of a match.

use bevy_egui::egui::{self, FontId, Grid};

use super::summary_maps::{draw_kicks, draw_map};
use crate::viewer::palette;
use crate::viewer::theme::{dim, link, minutes, team_colour, team_colour_on};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::match_summary::MatchSummary;
use naoisis_record::record::summary_rows::{ROBOT_COLUMNS, kick_maps, robot_rows, team_rows};

/// The greatest number of goals in a line, and the widths of their name and of each of them, heights of letters.
const GOALS_BESIDE: usize = 4;
const GOALS_NAME: f32 = 5.0;
const GOAL: f32 = 13.0;

/// Shows the table of robots.
pub(super) fn show_robots(ui: &mut egui::Ui, summary: &MatchSummary, letters: f32) {
    let mut columns = ROBOT_COLUMNS;
    columns[0] = "robots";
    show_table(ui, "robots", &columns, Some(&robot_rows(summary)), letters);
}

/// Shows a table with the names of its columns, the first of which is its title. `None` are rows of which nothing is known.
pub(super) fn show_table(ui: &mut egui::Ui, id: &str, columns: &[&str], rows: Option<&[Vec<String>]>, letters: f32) {
    let Some(rows) = rows else { return };
    ui.add_space(letters / 2.0);
    Grid::new(id).num_columns(columns.len()).spacing([1.4 * letters, 0.2 * letters]).show(ui, |ui| {
        for name in columns {
            ui.label(dim(*name).size(letters));
        }
        ui.end_row();
        for row in rows {
            for (column, words) in row.iter().enumerate() {
                let text = egui::RichText::new(words).size(letters);
                ui.label(if column == 0 { text.weak() } else { text });
            }
            ui.end_row();
        }
    });
}

/// Shows the statistics of the teams, the goals and the maps. `letters` is the height of the letters and `width` the
/// room for a line of goals, logical pixels. Returns the time of a goal that was clicked, s.
pub(super) fn show_contents(
    ui: &mut egui::Ui,
    summary: &MatchSummary,
    names: &[String; 2],
    (letters, width): (f32, f32),
) -> Option<f64> {
    let text = |words: String| egui::RichText::new(words).font(FontId::proportional(letters));
    Grid::new("summary").num_columns(3).spacing([2.0 * letters, 0.3 * letters]).show(ui, |ui| {
        ui.label(dim(format!("{} played", minutes(summary.duration_s as f32))).size(letters));
        for (team, name) in Team::BOTH.into_iter().zip(names) {
            ui.label(text(name.clone()).color(team_colour(ui, team)).strong());
        }
        ui.end_row();
        for row in rows(summary) {
            for (column, words) in row.into_iter().enumerate() {
                ui.label(if column == 0 { text(words).weak() } else { text(words).strong() });
            }
            ui.end_row();
        }
    });
    if let Some(how) = &summary.how {
        ui.label(text(how.clone()).strong());
    }
    let beside = (((width / letters - GOALS_NAME) / GOAL) as usize).clamp(1, GOALS_BESIDE);
    let mut clicked = None;
    Grid::new("goals").num_columns(beside + 1).spacing([2.0 * letters, 0.2 * letters]).show(ui, |ui| {
        for (line, goals) in summary.goals.chunks(beside).enumerate() {
            ui.label(dim(if line == 0 { "goals" } else { "" }).size(letters));
            for (time_s, by) in goals {
                let words = format!("{}   {by}", minutes(*time_s as f32));
                let goal = link(ui, egui::Label::new(egui::RichText::new(&words).size(letters)), &words);
                if goal.on_hover_text("Click: show the goal and what led to it").clicked() {
                    clicked = Some(*time_s);
                }
            }
            ui.end_row();
        }
    });
    ui.add_space(letters / 2.0);
    ui.horizontal(|ui| {
        let PerTeam { blue, pink } = &summary.places;
        // The bright colours of text on dark panels, for dark turf.
        let team = |team| team_colour_on(true, team);
        let ball = palette::in_panel(palette::ink(DrawColour::Orange));
        let maps = [
            ("the ball", &summary.ball, ball),
            (&names[0], blue, team(Team::Blue)),
            (&names[1], pink, team(Team::Pink)),
        ];
        for (words, map, colour) in maps {
            ui.vertical(|ui| {
                draw_map(ui, map, colour, (&summary.pitch, 9.0 * letters));
                ui.label(dim(words).size(letters));
            });
        }
    });
    ui.horizontal(|ui| {
        for (words, lines) in kick_maps(summary) {
            ui.vertical(|ui| {
                draw_kicks(ui, &lines, &summary.pitch, 9.0 * letters);
                ui.label(dim(words).size(letters));
            });
        }
    });
    clicked
}

/// The statistics of the teams, line by line.
pub(super) fn rows(summary: &MatchSummary) -> Vec<Vec<String>> {
    let goals = vec!["goals".to_owned(), summary.score.blue.to_string(), summary.score.pink.to_string()];
    [vec![goals], team_rows(summary)].concat()
}
