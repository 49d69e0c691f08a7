//! The chart of the chances over the match.

use bevy_egui::egui::{self, Align2, FontId, Pos2, Rect, Sense, Stroke, WidgetInfo};

use crate::viewer::theme::{minutes, team_colour, text_size};
use naoisis_core::team::Team;
use naoisis_record::whatif::chances::{Chance, Restart, Swing};

/// The height of the chart, and the width of the labels of its axis, logical pixels.
const HEIGHT: f32 = 120.0;
const LABELS: f32 = 34.0;

/// The contents of the chart.
pub(super) struct Chart<'a> {
    /// The chances in the order of their times.
    pub(super) chances: &'a [Chance],
    pub(super) restarts: &'a [Restart],
    pub(super) swings: &'a [Swing],
    /// The times at which the match begins and ends, s.
    pub(super) whole_s: [f64; 2],
    /// The time that is shown, s.
    pub(super) now_s: f64,
}

impl Chart<'_> {
    /// Shows the chart. Returns the time that was clicked, s.
    pub(super) fn show(&self, ui: &mut egui::Ui) -> Option<f64> {
        let (response, painter) = ui.allocate_painter(egui::vec2(ui.available_width(), HEIGHT), Sense::click());
        response.widget_info(|| WidgetInfo::slider(true, self.now_s, "Chances to score first"));
        let area = response.rect.shrink2(egui::vec2(4.0, 8.0));
        let area = area.with_min_x(area.left() + LABELS);
        let length = (self.whole_s[1] - self.whole_s[0]).max(f64::EPSILON);
        let x = |time_s: f64| area.left() + ((time_s - self.whole_s[0]) / length) as f32 * area.width();
        let y = |share: f64| area.bottom() - share as f32 * area.height();
        for (share, words) in [(0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %")] {
            let weak = ui.visuals().weak_text_color();
            painter.hline(area.x_range(), y(share), (0.5, weak.gamma_multiply(0.5)));
            let font = FontId::proportional(text_size::SMALL - 1.0);
            painter.text(Pos2::new(area.left() - 4.0, y(share)), Align2::RIGHT_CENTER, words, font, weak);
        }
        for swing in self.swings {
            let strip =
                Rect::from_x_y_ranges(x(swing.from_s)..=x(swing.until_s).max(x(swing.from_s) + 2.0), area.y_range());
            // On a light panel, a faint colour looks grey.
            let strength = if ui.visuals().dark_mode { 0.25 } else { 0.45 };
            painter.rect_filled(strip, 0.0, team_colour(ui, swing.team).gamma_multiply(strength));
        }
        for restart in self.restarts {
            let Some(team) = restart.goal else { continue };
            painter.vline(x(restart.time_s), area.y_range(), (1.5, team_colour(ui, team)));
            painter.circle_filled(Pos2::new(x(restart.time_s), area.top()), 4.5, team_colour(ui, team));
        }
        for team in Team::BOTH {
            let colour = team_colour(ui, team);
            let share = |chance: &Chance| chance.share(team).map(|share| Pos2::new(x(chance.time_s), y(share.value)));
            for pair in self.chances.windows(2).filter(|pair| !self.is_apart(&pair[0], &pair[1])) {
                if let [Some(from), Some(to)] = [share(&pair[0]), share(&pair[1])] {
                    painter.line_segment([from, to], Stroke::new(1.5, colour));
                }
            }
            for at in self.chances.iter().filter_map(share) {
                // Square for blue, round for pink, as everywhere.
                match team {
                    Team::Blue => painter.rect_filled(Rect::from_center_size(at, egui::Vec2::splat(4.5)), 0.0, colour),
                    Team::Pink => painter.circle_filled(at, 2.5, colour),
                };
            }
        }
        painter.vline(x(self.now_s), area.y_range(), (1.5, ui.visuals().strong_text_color()));
        let time_at = |at: Pos2| {
            let share = ((at.x - area.left()) / area.width()).clamp(0.0, 1.0);
            self.whole_s[0] + f64::from(share) * length
        };
        let clicked = response.interact_pointer_pos().filter(|_| response.clicked()).map(time_at);
        if let Some(at) = response.hover_pos() {
            let words = self.words(time_at(at));
            response.on_hover_text_at_pointer(words);
        }
        clicked
    }

    /// Whether the match was restarted between two moments.
    fn is_apart(&self, one: &Chance, other: &Chance) -> bool {
        self.restarts.iter().any(|restart| one.time_s < restart.time_s && restart.time_s <= other.time_s)
    }

    /// The tooltip: the chances at the moment nearest to a time.
    fn words(&self, time_s: f64) -> String {
        let away = |chance: &&Chance| (chance.time_s - time_s).abs();
        let Some(chance) = self.chances.iter().min_by(|one, other| away(one).total_cmp(&away(other))) else {
            return minutes(time_s as f32);
        };
        let of = |team: Team| {
            chance.share(team).map_or_else(String::new, |share| {
                let [value, low, high] = [share.value, share.low, share.high].map(|share| 100.0 * share);
                format!("\n{team}: {value:.0} % ({low:.0} to {high:.0})")
            })
        };
        format!("{}{}{}", minutes(chance.time_s as f32), of(Team::Blue), of(Team::Pink))
    }
}
