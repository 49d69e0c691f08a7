//! Small plans of the pitch: where the ball and the teams were, passes and shots.

use bevy::math::Vec2;
use bevy_egui::egui::{self, Color32, Sense};

use crate::viewer::theme::team_colour_on;
use naoisis_core::pitch::Pitch;
use naoisis_record::record::match_summary::{CELLS_ALONG, HeatMap};
use naoisis_record::record::summary_rows::KickLine;

/// The ground of maps.
const TURF: Color32 = Color32::from_rgb(24, 84, 44);

/// A plan of the pitch, with a border.
struct Plan {
    area: egui::Rect,
    /// Half of the length and of the width of the pitch, m.
    half_m: Vec2,
    /// Logical pixels per metre.
    scale: f32,
}

impl Plan {
    /// The border, logical pixels.
    const BORDER: f32 = 5.0;

    fn new(ui: &mut egui::Ui, pitch: &Pitch, width: f32) -> Self {
        let half_m = Vec2::new(pitch.half_length(), pitch.half_width());
        let scale = (width / 2.0 - Self::BORDER) / half_m.x;
        let size = egui::vec2(width, 2.0 * (scale * half_m.y + Self::BORDER));
        let (area, _) = ui.allocate_exact_size(size, Sense::hover());
        ui.painter().rect_filled(area, 2.0, TURF);
        Self { area, half_m, scale }
    }

    /// The position in the window of a point on the pitch, m.
    fn place(&self, at: Vec2) -> egui::Pos2 {
        self.area.center() + self.scale * egui::vec2(at.x, -at.y)
    }

    fn draw_lines(&self, painter: &egui::Painter, pitch: &Pitch) {
        let stroke = egui::Stroke::new(1.0, Color32::from_white_alpha(90));
        let frame = |low: Vec2, high: Vec2| {
            let area = egui::Rect::from_two_pos(self.place(low), self.place(high));
            painter.rect_stroke(area, 0.0, stroke, egui::StrokeKind::Middle);
        };
        frame(-self.half_m, self.half_m);
        let side = Vec2::new(pitch.penalty_area.depth_m, pitch.penalty_area.width_m / 2.0);
        for end in [-1.0, 1.0] {
            let goal_line = end * self.half_m.x;
            frame(Vec2::new(goal_line, -side.y), Vec2::new(goal_line - end * side.x, side.y));
        }
        painter.line_segment([-1.0, 1.0].map(|end| self.place(Vec2::new(0.0, end * self.half_m.y))), stroke);
        painter.circle_stroke(self.area.center(), self.scale * pitch.centre_circle_diameter_m / 2.0, stroke);
    }
}

/// Draws a heat map: stronger colours for more time.
pub(super) fn draw_map(ui: &mut egui::Ui, map: &HeatMap, colour: Color32, (pitch, width): (&Pitch, f32)) {
    let plan = Plan::new(ui, pitch, width);
    let cell = 2.0 * plan.half_m / Vec2::new(CELLS_ALONG as f32, map.rows as f32);
    let most_s = map.most_s().max(f32::EPSILON);
    for (index, time_s) in map.time_s.iter().enumerate().filter(|(_, time_s)| **time_s > 0.0) {
        // Rows are counted from -y upwards.
        let least = Vec2::new((index % CELLS_ALONG) as f32, (index / CELLS_ALONG) as f32) * cell - plan.half_m;
        // The square root keeps short times visible beside long ones.
        let strength = 0.25 + 0.75 * (time_s / most_s).sqrt();
        let area = egui::Rect::from_two_pos(plan.place(least), plan.place(least + cell));
        ui.painter().rect_filled(area, 0.0, colour.gamma_multiply(strength));
    }
    plan.draw_lines(ui.painter(), pitch);
}

/// Draws passes or shots on a plan of the pitch: those with success are thicker and end with a dot, the others are dashed.
pub(super) fn draw_kicks(ui: &mut egui::Ui, lines: &[KickLine], pitch: &Pitch, width: f32) {
    let plan = Plan::new(ui, pitch, width);
    let painter = ui.painter().with_clip_rect(plan.area.intersect(ui.clip_rect()));
    plan.draw_lines(&painter, pitch);
    for line in lines {
        // The bright colours of text on dark panels, for lines on dark turf.
        let colour = team_colour_on(true, line.team);
        let (from, to) = (plan.place(line.from_m), plan.place(line.to_m));
        if line.is_success {
            painter.line_segment([from, to], (1.8, colour));
            painter.circle_filled(to, 3.0, colour);
        } else {
            painter.extend(egui::Shape::dashed_line(&[from, to], (1.0, colour), 3.0, 2.0));
        }
    }
}
