//! The panel with the switches of the overlays.

use bevy::prelude::*;
use bevy_egui::egui::{self, RichText, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::legend::{PATCH, marks, patch};
use super::{Overlay, OverlayCommand, Overlays, Shows};
use crate::viewer::commands::Action;
use crate::viewer::display_settings::{DisplaySettings, Switch, Workspace};
use crate::viewer::dock::{Dock, Edge, PanelSizes, title};
use crate::viewer::layout::LayoutSystems;
use crate::viewer::shared::{Selection, short_name};
use crate::viewer::theme::{dim, team_colour, text_size};
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// The height of the part below the switches, logical pixels.
const BELOW: f32 = 60.0;

/// The widths of the names and of each column of switches, logical pixels.
const NAMES: f32 = 165.0;
const SWITCH: f32 = 22.0;
/// The distance between two columns, logical pixels.
const BETWEEN: f32 = 9.0;

/// Shows the switches.
pub struct OverlayPanelPlugin;

impl Plugin for OverlayPanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            show_switches.run_if(|display: Res<DisplaySettings>| display.overlays).in_set(LayoutSystems::Right),
        );
    }
}

fn show_switches(
    mut contexts: EguiContexts,
    overlays: Res<Overlays>,
    roster: Res<Roster>,
    (selection, display): (Res<Selection>, Res<DisplaySettings>),
    mut sizes: ResMut<PanelSizes>,
    mut actions: MessageWriter<Action>,
    mut commands: MessageWriter<OverlayCommand>,
) -> Result {
    let robots: Vec<RobotId> = roster.iter().map(|(id, _)| id).collect();
    let size = NAMES + (SWITCH + BETWEEN) * (2 + robots.len()) as f32 + 40.0;
    let dock = Dock { name: "overlays", edge: Edge::Right, size, least: 240.0, most_share: 0.55 };
    dock.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        if title(ui, "Overlays") {
            actions.write(Action::Toggle(Switch::Overlays));
        }
        let room = (ui.available_height() - BELOW).max(60.0);
        egui::ScrollArea::both().auto_shrink([false, true]).max_height(room).min_scrolled_height(room).show(ui, |ui| {
            let grid = egui::Grid::new("overlays").num_columns(3 + robots.len());
            grid.min_col_width(SWITCH).spacing([BETWEEN, 3.0]).show(ui, |ui| {
                show_heads(ui, &robots, &selection);
                for overlay in Overlay::ALL {
                    let shows = overlays.of_robots.get(&overlay).cloned().unwrap_or_default();
                    show_line(ui, overlay, (&shows, display.workspace), &robots, &mut commands);
                }
            });
            // Space for the scroll bar of a narrow panel.
            ui.add_space(12.0);
        });
        ui.horizontal_wrapped(|ui| {
            let mut switch = |ui: &mut egui::Ui, on: bool, text: &str, hint: &str, command: OverlayCommand| {
                if ui.checkbox(&mut on.clone(), text).on_hover_text(hint).changed() {
                    commands.write(command);
                }
            };
            let hint = "Lines and circles of the rules, and the team of each area";
            switch(ui, overlays.areas, "Areas of the rules", hint, OverlayCommand::ToggleAreas);
            let hint = "The last robot that touched the ball, and when";
            switch(ui, overlays.last_touch, "Last touch", hint, OverlayCommand::ToggleLastTouch);
            for (text, command) in [("None", OverlayCommand::Clear), ("Reset", OverlayCommand::Reset)] {
                if ui.button(text).clicked() {
                    commands.write(command);
                }
            }
        });
    });
    Ok(())
}

fn show_heads(ui: &mut egui::Ui, robots: &[RobotId], selection: &Selection) {
    ui.label("");
    ui.label(dim("all").size(text_size::SMALL)).on_hover_text("all robots");
    ui.label(dim("sel.").size(text_size::SMALL)).on_hover_text("the selected robot");
    for id in robots {
        let name = RichText::new(short_name(*id)).size(text_size::SMALL);
        let name = name.color(team_colour(ui, id.team));
        ui.label(if selection.0 == Some(*id) { name.underline() } else { name }).on_hover_text(id.to_string());
    }
    ui.end_row();
}

fn show_line(
    ui: &mut egui::Ui,
    overlay: Overlay,
    (shows, workspace): (&Shows, Workspace),
    robots: &[RobotId],
    commands: &mut MessageWriter<OverlayCommand>,
) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.label(overlay.name()).on_hover_text(overlay.description());
        for (colour, words) in marks(overlay) {
            patch(ui, colour, PATCH).on_hover_text(words);
        }
    });
    let mut switch = |ui: &mut egui::Ui, on: bool, whose: &str, command: OverlayCommand| {
        let response = ui.checkbox(&mut on.clone(), "");
        let name = format!("{}: {whose}", overlay.name());
        response.widget_info(|| WidgetInfo::selected(WidgetType::Checkbox, true, on, &name));
        if response.on_hover_text(name).changed() {
            commands.write(command);
        }
    };
    switch(ui, shows.all, "all robots", OverlayCommand::ToggleAll(overlay));
    switch(ui, shows.of_selected(workspace), "the selected robot", OverlayCommand::ToggleSelected(overlay));
    for id in robots {
        switch(ui, shows.robots.contains(id), &id.to_string(), OverlayCommand::Toggle(overlay, *id));
    }
    ui.end_row();
}
