//! Words on the pitch: names above the robots, and those of the overlays.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Color32, FontId, LayerId, Pos2};
use bevy_egui::{EguiContexts, EguiPostUpdateSet, EguiPrimaryContextPass};

use super::camera::ViewerCamera;
use super::display_settings::DisplaySettings;
use super::overlays::OverlayWords;
use super::palette;
use super::theme::text_size;
use crate::cycle::CycleClock;
use crate::game::Penalty;
use crate::team::RobotId;

/// The middle of a robot above its place, and how far above that, as it is seen, its name is, m.
const MIDDLE: Vec3 = Vec3::new(0.0, 0.0, 0.3);
const ABOVE_MIDDLE_M: f32 = 0.36;

/// Writes the robots' names.
pub struct LabelsPlugin;

impl Plugin for LabelsPlugin {
    fn build(&self, app: &mut App) {
        // The camera is where it is in this frame.
        app.configure_sets(PostUpdate, EguiPostUpdateSet::EndPass.after(TransformSystems::Propagate)).add_systems(
            EguiPrimaryContextPass,
            (draw_labels.run_if(|display: Res<DisplaySettings>| display.labels), write_overlay_words).chain(),
        );
    }
}

fn write_overlay_words(
    mut contexts: EguiContexts,
    words: Res<OverlayWords>,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
) -> Result {
    let (camera, camera_transform) = *camera;
    let context = contexts.ctx_mut()?;
    // Panels may be larger than the window has them.
    let zoom = context.zoom_factor();
    let painter = context.layer_painter(LayerId::background());
    for words in &words.0 {
        let Ok(place) = camera.world_to_viewport(camera_transform, words.place) else { continue };
        let font = FontId::proportional(text_size::SMALL);
        let text = painter.layout_no_wrap(words.text.clone(), font, palette::in_panel(words.colour));
        let area = Align2::CENTER_BOTTOM.anchor_size(Pos2::new(place.x / zoom, place.y / zoom - 3.0), text.size());
        painter.rect_filled(area.expand2(egui::vec2(3.0, 0.5)), 4.0, Color32::from_black_alpha(170));
        painter.galley(area.min, text, Color32::WHITE);
    }
    Ok(())
}

fn draw_labels(
    mut contexts: EguiContexts,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    robots: Query<(&RobotId, &GlobalTransform, &Penalty)>,
    clock: Res<CycleClock>,
) -> Result {
    let (camera, camera_transform) = *camera;
    let context = contexts.ctx_mut()?;
    // Panels may be larger than the window has them.
    let zoom = context.zoom_factor();
    let painter = context.layer_painter(LayerId::background());
    for (id, transform, penalty) in &robots {
        let point = transform.transform_point(MIDDLE) + ABOVE_MIDDLE_M * camera_transform.up();
        // A robot behind the camera has no place in the picture.
        let Ok(place) = camera.world_to_viewport(camera_transform, point) else { continue };
        let name = match penalty.0 {
            Some(active) => format!("{id}: {:.0} s", active.left_s(&clock)),
            None => id.to_string(),
        };
        let faded = if penalty.is_active() { 0.45 } else { 0.85 };
        let colour = palette::in_panel(palette::team(id.team));
        let text = painter.layout_no_wrap(name, FontId::proportional(text_size::ENTRY), Color32::WHITE);
        let area = Align2::CENTER_CENTER.anchor_size(Pos2::new(place.x / zoom, place.y / zoom), text.size());
        painter.rect_filled(area.expand2(egui::vec2(5.0, 1.5)), 7.0, colour.gamma_multiply(faded));
        painter.galley(area.min, text, Color32::WHITE);
    }
    Ok(())
}
