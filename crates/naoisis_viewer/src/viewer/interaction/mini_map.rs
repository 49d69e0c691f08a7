//! A small map of the pitch while a robot is driven, because its camera shows only what is ahead.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Color32, Sense, Stroke};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::driving::Driving;
use crate::viewer::layout::{self, LayoutSystems};
use crate::viewer::palette;
use crate::viewer::shared::{RobotsWorld, shows_truth};
use crate::viewer::theme::card;
use naoisis_core::ball::Ball;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::{RobotId, Team};

/// The width of the map as a share of that of the free area, and its range, logical pixels.
const WIDTH_SHARE: f32 = 0.22;
const WIDTHS: [f32; 2] = [120.0, 300.0];
/// The ground.
const TURF: Color32 = Color32::from_rgb(24, 84, 44);
/// The radius of a robot and of the ball, logical pixels.
const ROBOT: f32 = 4.5;
const BALL: f32 = 3.0;

/// Shows the map.
pub(super) struct MiniMapPlugin;

impl Plugin for MiniMapPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(EguiPrimaryContextPass, show_map.in_set(LayoutSystems::Floating));
    }
}

fn show_map(
    mut contexts: EguiContexts,
    driving: Res<Driving>,
    world: Option<Res<RobotsWorld>>,
    pitch: Res<Pitch>,
    robots: Query<(&RobotId, &Pose, &Penalty)>,
    balls: Query<&Pose, With<Ball>>,
) -> Result {
    let Some(driven) = driving.robot.filter(|_| shows_truth(world)) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let width = (WIDTH_SHARE * layout::free_area(context).width()).clamp(WIDTHS[0], WIDTHS[1]);
    layout::floating(context, "mini map", Align2::RIGHT_BOTTOM).interactable(false).show(context, |ui| {
        card(ui).inner_margin(egui::Margin::same(4)).show(ui, |ui| {
            let map = Map::new(ui, &pitch, width);
            map.draw_pitch(&pitch);
            for (id, pose, _) in robots.iter().filter(|(.., penalty)| !penalty.is_off_pitch()) {
                map.draw_robot(*id, *pose, *id == driven);
            }
            for ball in &balls {
                let orange = palette::in_panel(palette::ink(DrawColour::Orange));
                map.painter.circle(map.at(ball.position), BALL, orange, Stroke::new(1.0, Color32::BLACK));
            }
        });
    });
    Ok(())
}

/// A map of the carpet in a panel.
struct Map {
    painter: egui::Painter,
    centre: egui::Pos2,
    points_per_m: f32,
}

impl Map {
    fn new(ui: &mut egui::Ui, pitch: &Pitch, width: f32) -> Self {
        let size_m = 2.0 * pitch.carpet_half_extents();
        let points_per_m = width / size_m.x;
        let (area, _) = ui.allocate_exact_size(egui::vec2(width, size_m.y * points_per_m), Sense::hover());
        let painter = ui.painter().with_clip_rect(area);
        painter.rect_filled(area, 2.0, TURF);
        Self { painter, centre: area.center(), points_per_m }
    }

    /// The place in the panel of a position, m, pitch frame: +x is to the right, +y up.
    fn at(&self, position: Vec2) -> egui::Pos2 {
        self.centre + self.points_per_m * egui::vec2(position.x, -position.y)
    }

    fn draw_pitch(&self, pitch: &Pitch) {
        let line = Stroke::new(1.0, Color32::from_white_alpha(150));
        let rectangle = |half: Vec2, centre: Vec2| {
            let area = egui::Rect::from_two_pos(self.at(centre - half), self.at(centre + half));
            self.painter.rect_stroke(area, 0.0, line, egui::StrokeKind::Middle);
        };
        let half = Vec2::new(pitch.half_length(), pitch.half_width());
        rectangle(half, Vec2::ZERO);
        self.painter.line_segment([half.with_x(0.0), -half.with_x(0.0)].map(|end| self.at(end)), line);
        self.painter.circle_stroke(self.centre, self.points_per_m * pitch.centre_circle_diameter_m / 2.0, line);
        for side in [-1.0, 1.0] {
            let goal = Vec2::new(pitch.goal.depth_m, pitch.goal.width_m) / 2.0;
            rectangle(goal, Vec2::new(side * (half.x + goal.x), 0.0));
        }
    }

    /// Draws a robot with its heading: blue ones square, pink ones round, the driven one with a white edge.
    fn draw_robot(&self, id: RobotId, pose: Pose, is_driven: bool) {
        let (at, colour) = (self.at(pose.position), palette::in_panel(palette::team(id.team)));
        let edge = if is_driven { Stroke::new(2.0, Color32::WHITE) } else { Stroke::new(1.0, Color32::BLACK) };
        let ahead = unit(pose.heading);
        self.painter.line_segment([at, at + 2.2 * ROBOT * egui::vec2(ahead.x, -ahead.y)], (2.0, edge.color));
        match id.team {
            Team::Blue => {
                let area = egui::Rect::from_center_size(at, egui::Vec2::splat(2.0 * ROBOT));
                self.painter.rect(area, 1.0, colour, edge, egui::StrokeKind::Outside);
            }
            Team::Pink => drop(self.painter.circle(at, ROBOT, colour, edge)),
        }
    }
}
