//! Images of robots' cameras in panels, with what was recognised in them drawn in.

use bevy::prelude::*;
use bevy_egui::egui::{
    self, Align2, Color32, ColorImage, FontId, Pos2, Rect as Area, Stroke, TextureHandle, TextureOptions,
};
use std::collections::BTreeMap;

use crate::behaviour::drawings::Ink;
use crate::robot::{RobotId, Team};
use crate::sensing::camera::CameraSide;
use crate::sensing::camera::image::Image;
use crate::sensing::vision::{LandmarkKind, Percepts};
use crate::viewer::eyes::EyeImages;
use crate::viewer::overlays::junction_letter;
use crate::viewer::palette;
use crate::viewer::theme::text_size;

/// The images as the panels have them.
#[derive(Resource, Default)]
pub struct Pictures(BTreeMap<(RobotId, CameraSide), Picture>);

struct Picture {
    texture: TextureHandle,
    cycle: u64,
}

impl Pictures {
    /// Forgets images of cameras that nobody looks at.
    pub fn keep(&mut self, is_watched: impl Fn(RobotId, CameraSide) -> bool) {
        self.0.retain(|(id, side), _| is_watched(*id, *side));
    }

    /// Shows the image of a camera, this wide, with what was recognised in it.
    pub fn show(
        &mut self,
        ui: &mut egui::Ui,
        eyes: &EyeImages,
        (id, side): (RobotId, CameraSide),
        percepts: Option<&Percepts>,
        width: f32,
    ) -> egui::Response {
        let image = eyes.image(id, side).filter(|(_, image)| !image.is_empty());
        let Some((cycle, image)) = image else {
            let (area, response) = ui.allocate_exact_size(egui::vec2(width, 0.75 * width), egui::Sense::click());
            ui.painter().rect_filled(area, 2.0, Color32::from_gray(40));
            let font = FontId::proportional(text_size::SMALL);
            ui.painter().text(area.center(), Align2::CENTER_CENTER, "no image", font, Color32::GRAY);
            return response;
        };
        let picture = self.0.entry((id, side)).or_insert_with(|| {
            let texture = ui.ctx().load_texture(format!("{id} {side:?}"), colours(image), TextureOptions::LINEAR);
            Picture { texture, cycle }
        });
        if picture.cycle != cycle {
            picture.texture.set(colours(image), TextureOptions::LINEAR);
            picture.cycle = cycle;
        }
        let size = egui::vec2(width, width * image.height as f32 / image.width.max(1) as f32);
        let (area, response) = ui.allocate_exact_size(size, egui::Sense::click());
        let whole = Area::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        ui.painter().image(picture.texture.id(), area, whole, Color32::WHITE);
        if let Some(percepts) = percepts {
            let scale = width / image.width.max(1) as f32;
            draw_percepts(&ui.painter().with_clip_rect(area), percepts, side, |pixel| {
                area.min + scale * egui::vec2(pixel.x, pixel.y)
            });
        }
        response
    }
}

fn colours(image: &Image) -> ColorImage {
    ColorImage::from_rgb([image.width as usize, image.height as usize], &image.rgb)
}

/// Draws what was recognised by one camera; `place` is where a pixel of its image is.
fn draw_percepts(painter: &egui::Painter, percepts: &Percepts, side: CameraSide, place: impl Fn(Vec2) -> Pos2) {
    let stroke = |colour: Color| Stroke::new(1.5, palette::in_panel(colour));
    let write = |at: Pos2, text: &str, colour: Color| {
        let font = FontId::proportional(10.0);
        painter.text(at + egui::vec2(1.0, 1.0), Align2::CENTER_BOTTOM, text, font.clone(), Color32::BLACK);
        painter.text(at, Align2::CENTER_BOTTOM, text, font, palette::in_panel(colour));
    };
    let cross = |at: Pos2, half: f32, stroke: Stroke| {
        for slope in [1.0, -1.0] {
            let arm = egui::vec2(half, slope * half);
            painter.line_segment([at - arm, at + arm], stroke);
        }
    };
    for landmark in percepts.landmarks.iter().filter(|landmark| landmark.camera == side) {
        let at = place(landmark.pixel);
        let colour = palette::ink(Ink::Sky);
        match landmark.kind {
            LandmarkKind::Line { end_pixel, .. } => {
                painter.line_segment([at, place(end_pixel)], stroke(colour));
            }
            LandmarkKind::Junction { shape } => {
                cross(at, 3.0, stroke(palette::ink(Ink::Vermilion)));
                write(at - egui::vec2(0.0, 3.0), junction_letter(shape), palette::ink(Ink::White));
            }
            LandmarkKind::PenaltyCross => cross(at, 4.0, stroke(palette::ink(Ink::Vermilion))),
            LandmarkKind::CentreCircle => {
                painter.circle_stroke(at, 5.0, stroke(palette::ink(Ink::Vermilion)));
            }
        }
    }
    for post in percepts.goal_posts.iter().filter(|post| post.camera == side) {
        let at = place(post.pixel);
        painter.line_segment(
            [at, at - egui::vec2(0.0, 22.0)],
            Stroke::new(2.5, palette::in_panel(palette::goal(post.colour))),
        );
        cross(at, 4.0, stroke(palette::ink(Ink::White)));
    }
    for robot in percepts.robots.iter().filter(|robot| robot.camera == side) {
        let at = place(robot.pixel);
        let colour = palette::team(robot.team);
        let top = Area::from_min_max(at + egui::vec2(-9.0, -34.0), at + egui::vec2(9.0, 0.0));
        let rounding = if robot.team == Team::Blue { 0.0 } else { 8.0 };
        painter.rect_stroke(top, rounding, stroke(colour), egui::StrokeKind::Middle);
        write(at + egui::vec2(0.0, 12.0), robot.team.name(), palette::ink(Ink::White));
    }
    if let Some(ball) = percepts.ball.filter(|ball| ball.camera == side) {
        let at = place(ball.pixel);
        painter.circle_stroke(at, 7.0, stroke(palette::ink(Ink::Yellow)));
        write(at - egui::vec2(0.0, 7.0), "ball", palette::ink(Ink::Yellow));
    }
}
