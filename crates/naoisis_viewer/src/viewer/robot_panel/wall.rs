//! The panel with the cameras of all robots side by side.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, Grid, ScrollArea};

use super::pictures::Pictures;
use crate::viewer::commands::{Action, SelectionCommand};
use crate::viewer::display_settings::Switch;
use crate::viewer::dock::{Dock, Edge, PanelSizes, title};
use crate::viewer::theme::{band, dim, text_size};
use naoisis_core::game::Penalty;
use naoisis_core::robot::Roster;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::vision::Percepts;

/// The panel.
const DOCK: Dock = Dock { name: "cameras", edge: Edge::Right, size: 560.0, least: 180.0, most_share: 0.5 };
/// The least width of an image, the gap between robots, and the height of a name, logical pixels.
const LEAST_WIDTH: f32 = 60.0;
const GAPS: [f32; 2] = [8.0, 6.0];
const NAME: f32 = 24.0;
/// The height of an image divided by its width.
const SHAPE: f32 = 0.75;

pub(super) fn show_wall(
    mut contexts: EguiContexts,
    roster: Res<Roster>,
    robots: Query<(&Percepts, &CameraSettings, &Penalty)>,
    pictures: Res<Pictures>,
    mut sizes: ResMut<PanelSizes>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let robots: Vec<_> = roster.iter().filter_map(|(id, robot)| Some((id, robots.get(robot).ok()?))).collect();
    DOCK.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        if title(ui, "Cameras") {
            actions.write(Action::Toggle(Switch::Cameras));
        }
        let cameras = robots.iter().map(|(_, (_, settings, _))| settings.mounts.names().count()).max().unwrap_or(1);
        let (in_a_row, width) = arranged(robots.len(), cameras, ui.available_size());
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            Grid::new("cameras").spacing(GAPS).show(ui, |ui| {
                for row in robots.chunks(in_a_row) {
                    for (id, (percepts, settings, penalty)) in row {
                        let percepts = (!penalty.is_off_pitch()).then_some(*percepts);
                        ui.vertical(|ui| {
                            ui.horizontal(|ui| {
                                band(ui, id.team, egui::vec2(8.0, 12.0));
                                ui.label(dim(id.to_string()).size(text_size::SMALL));
                            });
                            ui.horizontal(|ui| {
                                ui.spacing_mut().item_spacing.x = 2.0;
                                for camera in settings.mounts.names() {
                                    let image = pictures.show(ui, (*id, camera), percepts, width);
                                    if image.on_hover_text("Select").clicked() {
                                        actions.write(Action::Select(SelectionCommand::Robot(*id)));
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

/// The number of robots in a row, and the width of an image, for the largest images in a panel of `size`. If images of the least width do not fit, as
/// many robots are in a row as fit beside each other, over the whole width, and the rows are scrolled.
fn arranged(robots: usize, cameras: usize, size: egui::Vec2) -> (usize, f32) {
    let by_width = |in_a_row: usize| ((size.x - 12.0) / in_a_row as f32 - GAPS[0]) / cameras.max(1) as f32 - 2.0;
    let by_height = |in_a_row: usize| (size.y / robots.div_ceil(in_a_row) as f32 - GAPS[1] - NAME) / SHAPE;
    let rows = (1..=robots.max(1)).map(|in_a_row| (in_a_row, by_width(in_a_row).min(by_height(in_a_row))));
    let largest = rows.max_by(|(_, one), (_, other)| one.total_cmp(other)).filter(|(_, width)| *width >= LEAST_WIDTH);
    largest.unwrap_or_else(|| {
        let most = (1..=robots).rev().find(|in_a_row| by_width(*in_a_row) >= LEAST_WIDTH).unwrap_or(1);
        (most, by_width(most).max(LEAST_WIDTH))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_as_large_as_the_panel_lets_them_be() {
        // Six robots with two cameras each: one below the other in a high panel, several per row in a wide one.
        let (in_a_row, width) = arranged(6, 2, egui::vec2(300.0, 900.0));
        assert!(in_a_row == 1 && width > 130.0, "{in_a_row} of {width}");
        let (in_a_row, width) = arranged(6, 2, egui::vec2(900.0, 400.0));
        assert!(in_a_row == 3 && width > 130.0, "{in_a_row} of {width}");
        assert_eq!(arranged(22, 1, egui::vec2(60.0, 100.0)), (1, LEAST_WIDTH));
        // Where they are not high enough for all, rows are as wide as the panel and no wider.
        assert_eq!(arranged(6, 2, egui::vec2(290.0, 150.0)), (2, 63.5));
        assert_eq!(arranged(14, 2, egui::vec2(240.0, 900.0)), (1, 108.0));
        assert_eq!(arranged(0, 0, egui::vec2(100.0, 100.0)).0, 1);
    }
}
