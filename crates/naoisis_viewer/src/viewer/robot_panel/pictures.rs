//! Images of the robots' cameras in panels, with their detections.

use bevy::asset::RenderAssetUsages;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};
use bevy_egui::egui::{self, Align2, Color32, FontId, Pos2, Rect as Area, Stroke, TextureId};
use bevy_egui::{EguiContexts, EguiTextureHandle, EguiUserTextures};
use std::collections::BTreeMap;

use crate::viewer::camera::robot_view::image_in;
use crate::viewer::camera::{ViewerCamera, mount_of};
use crate::viewer::camera_images::{ShownImages, Watched, age_cycles};
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::layout::{self, FreeArea};
use crate::viewer::overlays::{Overlay, Overlays, junction_letter};
use crate::viewer::palette;
use crate::viewer::shared::Selection;
use crate::viewer::theme::{card, text_size};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};

/// The images as textures of the panels.
#[derive(Resource, Default)]
pub struct Pictures(BTreeMap<(RobotId, CameraName), Picture>);

struct Picture {
    texture: Handle<bevy::image::Image>,
    id: TextureId,
    /// The number of its match, and its cycle.
    taken: (u64, u64),
    size: egui::Vec2,
}

/// Updates the textures before the frame is drawn, so that none is missing in it.
pub(super) fn update_pictures(
    images: Res<ShownImages>,
    watched: Res<Watched>,
    mut pictures: ResMut<Pictures>,
    mut textures: ResMut<Assets<bevy::image::Image>>,
    mut user_textures: ResMut<EguiUserTextures>,
) {
    let pictures = &mut pictures.0;
    pictures.retain(|camera, picture| {
        let is_shown = images.image(camera.0, camera.1).is_some_and(|(_, image)| !image.is_empty());
        if !is_shown {
            user_textures.remove_image(&picture.texture);
        }
        is_shown
    });
    for &(id, side) in &watched.cameras {
        let Some((cycle, image)) = images.image(id, side).filter(|(_, image)| !image.is_empty()) else { continue };
        let (size, taken) = (egui::vec2(image.width as f32, image.height as f32), (images.matches, cycle));
        match pictures.get_mut(&(id, side)) {
            Some(picture) if picture.taken == taken => {}
            Some(picture) if picture.size == size => {
                if let Some(mut texture) = textures.get_mut(&picture.texture) {
                    texture.data = Some(colours(image));
                }
                picture.taken = taken;
            }
            _ => {
                let texture = textures.add(texture(image));
                let texture_id = user_textures.add_image(EguiTextureHandle::Strong(texture.clone()));
                pictures.insert((id, side), Picture { texture, id: texture_id, taken, size });
            }
        }
    }
}

/// Draws the detections over the window when the match is seen through a robot's camera.
pub(super) fn draw_in_window(
    mut contexts: EguiContexts,
    camera: Single<&ViewerCamera>,
    selection: Res<Selection>,
    overlays: Res<Overlays>,
    roster: Res<Roster>,
    robots: Query<(&Percepts, &CameraSettings, &Penalty)>,
    (window, free, display): (Single<&Window>, Res<FreeArea>, Res<DisplaySettings>),
    clock: Res<CycleClock>,
) -> Result {
    let Some((id, side)) = camera.robot_camera(&selection) else { return Ok(()) };
    let Some((percepts, settings, penalty)) = roster.get(id).and_then(|robot| robots.get(robot).ok()) else {
        return Ok(());
    };
    let context = contexts.ctx_mut()?;
    if penalty.is_off_pitch() {
        // The view is that from where it stood before.
        layout::floating(context, "off the pitch", Align2::CENTER_CENTER).show(context, |ui| {
            card(ui).show(ui, |ui| ui.label(format!("{id} is off the pitch: its cameras see nothing")));
        });
        return Ok(());
    }
    if !overlays.shows(Overlay::Percepts, id, &selection, display.workspace) {
        return Ok(());
    }
    let mount = mount_of(settings, side);
    let Some(mount) = mount else { return Ok(()) };
    let (side, intrinsics) = (mount.name, settings.intrinsics(mount));
    // The panels may be scaled relative to the window.
    let area = free.in_sight(window.size());
    let zoom = context.zoom_factor();
    let area = Rect { min: area.min / zoom, max: area.max / zoom };
    let frame = image_in(intrinsics, area);
    let scale = frame.size() / intrinsics.drawn().size;
    let painter = context.layer_painter(egui::LayerId::background());
    let corners = Area::from_min_max(Pos2::new(frame.min.x, frame.min.y), Pos2::new(frame.max.x, frame.max.y));
    painter.rect_stroke(corners, 0.0, Stroke::new(1.0, Color32::from_white_alpha(120)), egui::StrokeKind::Middle);
    draw_percepts(&painter, percepts, side, words_size(corners.width()), |pixel| {
        let at = frame.min + scale * intrinsics.in_drawn(pixel);
        Pos2::new(at.x, at.y)
    });
    // The view is of the cycle that is shown, whatever the delay of the robot's vision.
    let age_s = age_cycles(percepts, &clock) as f64 * clock.period_s;
    if age_s > 0.0 {
        let words = format!("{id}'s vision is late: detections of {age_s:.2} s before");
        let font = FontId::proportional(text_size::ENTRY);
        let at = corners.left_top() + egui::vec2(8.0, 6.0);
        painter.text(at + egui::vec2(1.0, 1.0), Align2::LEFT_TOP, &words, font.clone(), Color32::BLACK);
        painter.text(at, Align2::LEFT_TOP, words, font, Color32::WHITE);
    }
    Ok(())
}

fn texture(image: &Image) -> bevy::image::Image {
    let extent = Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 };
    let format = TextureFormat::Rgba8UnormSrgb;
    bevy::image::Image::new(extent, TextureDimension::D2, colours(image), format, RenderAssetUsages::all())
}

/// The red, green, blue and alpha of each pixel.
fn colours(image: &Image) -> Vec<u8> {
    image.rgb.chunks_exact(3).flat_map(|colour| [colour[0], colour[1], colour[2], 255]).collect()
}

impl Pictures {
    /// Shows the image of a camera with this width, with its detections. Without `percepts`, the robot sees nothing.
    pub fn show(
        &self,
        ui: &mut egui::Ui,
        (id, side): (RobotId, CameraName),
        percepts: Option<&Percepts>,
        width: f32,
    ) -> egui::Response {
        let (Some(picture), Some(percepts)) = (self.0.get(&(id, side)), percepts) else {
            let (area, response) = ui.allocate_exact_size(egui::vec2(width, 0.75 * width), egui::Sense::click());
            ui.painter().rect_filled(area, 2.0, Color32::from_gray(40));
            let font = FontId::proportional(text_size::SMALL);
            let words = if percepts.is_some() { "no image" } else { "off the pitch" };
            ui.painter().text(area.center(), Align2::CENTER_CENTER, words, font, Color32::GRAY);
            return response;
        };
        let scale = width / picture.size.x.max(1.0);
        let (area, response) = ui.allocate_exact_size(scale * picture.size, egui::Sense::click());
        let whole = Area::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        ui.painter().image(picture.id, area, whole, Color32::WHITE);
        let painter = ui.painter().with_clip_rect(area);
        draw_percepts(&painter, percepts, side, words_size(area.width()), |pixel| {
            area.min + scale * egui::vec2(pixel.x, pixel.y)
        });
        response
    }
}

/// Returns the size of the words of detections in an image of this width, logical pixels.
fn words_size(width: f32) -> f32 {
    (width / 40.0).clamp(text_size::SMALL, text_size::TITLE)
}

/// Draws the detections of one camera with words of this size; `place` maps pixels of its image.
fn draw_percepts(
    painter: &egui::Painter,
    percepts: &Percepts,
    side: CameraName,
    words_size: f32,
    place: impl Fn(Vec2) -> Pos2,
) {
    let stroke = |colour: Color| Stroke::new(1.5, palette::in_panel(colour));
    let write = |at: Pos2, text: &str, colour: Color| {
        let font = FontId::proportional(words_size);
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
        let colour = palette::ink(DrawColour::Sky);
        match landmark.kind {
            LandmarkKind::Line { end_pixel, .. } => {
                painter.line_segment([at, place(end_pixel)], stroke(colour));
            }
            LandmarkKind::Junction { shape } => {
                cross(at, 3.0, stroke(palette::ink(DrawColour::Vermilion)));
                write(at - egui::vec2(0.0, 3.0), junction_letter(shape), palette::ink(DrawColour::White));
            }
            LandmarkKind::PenaltyCross => cross(at, 4.0, stroke(palette::ink(DrawColour::Vermilion))),
            LandmarkKind::CentreCircle | LandmarkKind::CornerArc => {
                painter.circle_stroke(at, 5.0, stroke(palette::ink(DrawColour::Vermilion)));
            }
        }
    }
    for post in percepts.goal_posts.iter().filter(|post| post.camera == side) {
        let at = place(post.pixel);
        painter.line_segment(
            [at, at - egui::vec2(0.0, 22.0)],
            Stroke::new(2.5, palette::in_panel(palette::goal(post.colour))),
        );
        cross(at, 4.0, stroke(palette::ink(DrawColour::White)));
    }
    for robot in percepts.robots.iter().filter(|robot| robot.camera == side) {
        // A pin at its feet: detections have no size. For people who cannot tell the colours apart, its head is square or round.
        let at = place(robot.pixel);
        let head = at - egui::vec2(0.0, 18.0);
        let outline = Stroke::new(1.0, Color32::WHITE);
        painter.line_segment([at, head], Stroke::new(2.0, Color32::WHITE));
        let area = Area::from_center_size(head, egui::Vec2::splat(9.0));
        let rounding = if robot.team == Team::Blue { 0.0 } else { 4.5 };
        let colour = palette::in_panel(palette::team(robot.team));
        painter.rect(area, rounding, colour, outline, egui::StrokeKind::Middle);
        // In small images, the names of robots that stand close would cover each other.
        if words_size > text_size::SMALL {
            write(at + egui::vec2(0.0, 12.0), robot.team.name(), palette::ink(DrawColour::White));
        }
    }
    for ball in percepts.all_balls().filter(|ball| ball.camera == side) {
        let at = place(ball.pixel);
        painter.circle_stroke(at, 4.0, stroke(palette::ink(DrawColour::Yellow)));
        for side in [egui::vec2(7.0, 0.0), egui::vec2(0.0, 7.0)] {
            painter.line_segment([at - side, at - 0.4 * side], stroke(palette::ink(DrawColour::Yellow)));
            painter.line_segment([at + 0.4 * side, at + side], stroke(palette::ink(DrawColour::Yellow)));
        }
        write(at - egui::vec2(0.0, 7.0), "ball", palette::ink(DrawColour::Yellow));
    }
}
