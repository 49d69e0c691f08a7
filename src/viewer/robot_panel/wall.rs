//! The cameras of all robots side by side.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, Align2, Grid};

use super::pictures::Pictures;
use crate::robot::Roster;
use crate::sensing::camera::CameraSettings;
use crate::sensing::vision::Percepts;
use crate::team::RobotId;
use crate::viewer::layout;
use crate::viewer::shared::{Action, Choice};
use crate::viewer::theme::{MARGIN, band, card, dim, panel, text_size};

/// The images take this share of the window's width at most, so that the pitch is seen beside them.
const SHARE: f32 = 0.45;
/// Robots in a row.
const IN_A_ROW: usize = 3;

pub(super) fn show_wall(
    mut contexts: EguiContexts,
    roster: Res<Roster>,
    robots: Query<(&Percepts, &CameraSettings)>,
    pictures: Res<Pictures>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let context = contexts.ctx_mut()?;
    // As large as the window lets them be beside the panel of the robot.
    let room = context.content_rect().size();
    let rows = roster.len().div_ceil(IN_A_ROW).max(1) as f32;
    let by_width = SHARE * layout::width_beside_robot(context) / (2 * IN_A_ROW) as f32 - 8.0;
    let by_height = ((room.y - 220.0) / rows - 26.0) / 0.75;
    let width = by_width.min(by_height).clamp(60.0, 320.0);
    panel("cameras", Align2::RIGHT_CENTER, [-MARGIN, 0.0]).show(context, |ui| {
        card(ui).show(ui, |ui| {
            Grid::new("cameras").spacing([8.0, 6.0]).show(ui, |ui| {
                let all: Vec<(RobotId, Entity)> = roster.iter().collect();
                for row in all.chunks(IN_A_ROW) {
                    for (id, robot) in row {
                        ui.vertical(|ui| {
                            ui.horizontal(|ui| {
                                band(ui, id.team, egui::vec2(8.0, 12.0));
                                ui.label(dim(id.to_string()).size(text_size::SMALL));
                            });
                            ui.horizontal(|ui| {
                                ui.spacing_mut().item_spacing.x = 2.0;
                                let Ok((percepts, settings)) = robots.get(*robot) else { return };
                                for camera in settings.mounts.names() {
                                    let image = pictures.show(ui, (*id, camera), Some(percepts), width);
                                    if image.on_hover_text("Select").clicked() {
                                        actions.write(Action::Select(Choice::Robot(*id)));
                                    }
                                }
                            });
                        });
                    }
                    ui.end_row();
                }
            });
        });
    });
    Ok(())
}
