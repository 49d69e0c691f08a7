//! The switches of the overlays.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, RichText, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::{Overlay, OverlayCommand, Overlays};
use crate::robot::Roster;
use crate::team::RobotId;
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::layout;
use crate::viewer::shared::Selection;
use crate::viewer::theme::{MARGIN, ThemeSystems, bright, card, dim, panel, team_colour, text_size};

/// What the list leaves of the window's width and height, logical pixels.
const AROUND: (f32, f32) = (50.0, 90.0);

/// Widths of the names and of each column of switches, logical pixels.
const NAMES: f32 = 120.0;
const SWITCH: f32 = 49.0;

/// Shows the switches.
pub struct OverlayPanelPlugin;

impl Plugin for OverlayPanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            show_switches.run_if(|display: Res<DisplaySettings>| display.overlays).after(ThemeSystems),
        );
    }
}

fn show_switches(
    mut contexts: EguiContexts,
    overlays: Res<Overlays>,
    roster: Res<Roster>,
    selection: Res<Selection>,
    mut commands: MessageWriter<OverlayCommand>,
) -> Result {
    let robots: Vec<RobotId> = roster.iter().map(|(id, _)| id).collect();
    let context = contexts.ctx_mut()?;
    let above = layout::above(context, "overlays", &["timeline", "controls", "hands"]);
    let room = context.content_rect().size() - egui::vec2(AROUND.0, AROUND.1 + above);
    panel("overlays", Align2::RIGHT_BOTTOM, [-MARGIN, -above]).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).show(ui, |ui| {
            ui.label(bright("Overlays").size(text_size::IMPORTANT));
            let width = (NAMES + SWITCH * (2 + robots.len()) as f32).min(room.x);
            ui.set_min_width(width);
            egui::ScrollArea::both().max_width(width).max_height(room.y).min_scrolled_height(room.y).show(ui, |ui| {
                egui::Grid::new("overlays").num_columns(3 + robots.len()).spacing([9.0, 3.0]).show(ui, |ui| {
                    show_heads(ui, &robots, &selection);
                    for overlay in Overlay::ALL {
                        show_line(ui, overlay, &overlays, &robots, &mut commands);
                    }
                });
            });
            ui.horizontal(|ui| {
                let mut switch = |ui: &mut egui::Ui, on: bool, text: &str, hint: &str, command: OverlayCommand| {
                    if ui.checkbox(&mut on.clone(), text).on_hover_text(hint).changed() {
                        commands.write(command);
                    }
                };
                let hint = "The lines and circles that the rules go by, and to whom each area belongs";
                switch(ui, overlays.areas, "Areas of the rules", hint, OverlayCommand::ToggleAreas);
                let hint = "Who touched the ball last, and when";
                switch(ui, overlays.last_touch, "Last touch", hint, OverlayCommand::ToggleLastTouch);
                for (text, command) in [("None", OverlayCommand::Clear), ("Reset", OverlayCommand::Reset)] {
                    if ui.button(text).clicked() {
                        commands.write(command);
                    }
                }
            });
        });
    });
    Ok(())
}

fn show_heads(ui: &mut egui::Ui, robots: &[RobotId], selection: &Selection) {
    ui.label("");
    ui.label(dim("all").size(text_size::SMALL)).on_hover_text("all robots");
    ui.label(dim("sel.").size(text_size::SMALL)).on_hover_text("the selected robot");
    for id in robots {
        let initial = id.team.name().chars().next().unwrap_or('?');
        let name = RichText::new(format!("{initial}{}", id.number)).size(text_size::SMALL);
        let name = name.color(team_colour(ui, id.team));
        ui.label(if selection.0 == Some(*id) { name.underline() } else { name }).on_hover_text(id.to_string());
    }
    ui.end_row();
}

fn show_line(
    ui: &mut egui::Ui,
    overlay: Overlay,
    overlays: &Overlays,
    robots: &[RobotId],
    commands: &mut MessageWriter<OverlayCommand>,
) {
    let shows = overlays.of_robots.get(&overlay).cloned().unwrap_or_default();
    ui.label(overlay.name()).on_hover_text(overlay.description());
    let mut switch = |ui: &mut egui::Ui, on: bool, whose: &str, command: OverlayCommand| {
        let response = ui.checkbox(&mut on.clone(), "");
        let name = format!("{}: {whose}", overlay.name());
        response.widget_info(|| WidgetInfo::selected(WidgetType::Checkbox, true, on, &name));
        if response.on_hover_text(name).changed() {
            commands.write(command);
        }
    };
    switch(ui, shows.all, "all robots", OverlayCommand::ToggleAll(overlay));
    switch(ui, shows.selected, "the selected robot", OverlayCommand::ToggleSelected(overlay));
    for id in robots {
        switch(ui, shows.robots.contains(id), &id.to_string(), OverlayCommand::Toggle(overlay, *id));
    }
    ui.end_row();
}
