//! The searchable list of fields.

use bevy::prelude::*;
use bevy_egui::egui::containers::menu::{MenuButton, MenuConfig};
use bevy_egui::egui::{self, Id, Key, PopupCloseBehavior, Response, WidgetInfo, WidgetType};

use super::catalogue::FieldList;
use super::field::KnownField;
use super::{PlotCommand, Plots};
use crate::viewer::theme::{bright, dim, text_size};
use naoisis_core::team::RobotId;

/// The size of the list, logical pixels.
const WIDTH: f32 = 330.0;
const HEIGHT: f32 = 320.0;

/// Shows the button that opens the list.
pub(super) fn show(ui: &mut egui::Ui, list: &FieldList, plots: &Plots, commands: &mut MessageWriter<PlotCommand>) {
    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let (button, _) = MenuButton::new("Add a field…").config(stays).ui(ui, |ui| {
        let id = Id::new("wanted field");
        let mut wanted: String = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        ui.set_width(WIDTH);
        let text = egui::TextEdit::singleline(&mut wanted)
            .hint_text("a part of its name; Enter plots the first")
            .desired_width(WIDTH);
        let text = ui.add(text);
        text.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Part of a field's name"));
        let is_entered = text.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if !text.has_focus() && ui.memory(|memory| memory.focused().is_none()) {
            text.request_focus();
        }
        let found: Vec<&KnownField> = list.all().iter().filter(|field| is_meant(field, &wanted)).collect();
        ui.data_mut(|data| data.insert_temp(id, wanted));
        if let Some(first) = found.iter().find(|field| is_entered && !plots.is_pinned(&field.field)) {
            commands.write(PlotCommand::Toggle(first.field.clone(), None));
        }
        if found.is_empty() {
            ui.label(dim("No field has a name with these words."));
        }
        // egui would keep the height of the shortest list so far.
        let list = egui::ScrollArea::vertical().max_height(HEIGHT).min_scrolled_height(HEIGHT);
        list.auto_shrink([false, true]).show(ui, |ui| {
            let mut group = "";
            for field in found {
                if field.group != group {
                    group = &field.group;
                    ui.label(bright(group).size(text_size::ENTRY));
                }
                entry(ui, field, plots.is_pinned(&field.field), None, commands);
            }
        });
    });
    button.on_hover_text("Every number of the robots and the ball, by its name");
}

/// Shows a field; a click plots it, or removes its plot.
pub fn entry(
    ui: &mut egui::Ui,
    field: &KnownField,
    is_pinned: bool,
    robot: Option<RobotId>,
    commands: &mut MessageWriter<PlotCommand>,
) {
    let name = if field.name.is_empty() { &field.group } else { &field.name };
    let words = match field.unit.symbol() {
        "" => name.clone(),
        symbol => format!("{name}, {symbol}"),
    };
    let response = ui.selectable_label(is_pinned, egui::RichText::new(words).size(text_size::ENTRY));
    if response.clicked() {
        commands.write(PlotCommand::Toggle(field.field.clone(), robot));
    }
}

/// Makes a value plottable by a click: at once if it is one number, by a menu if it has parts.
pub fn pinnable(
    response: Response,
    fields: &[&KnownField],
    plots: &Plots,
    robot: RobotId,
    commands: &mut MessageWriter<PlotCommand>,
) {
    let response = response.interact(egui::Sense::click()).on_hover_cursor(egui::CursorIcon::PointingHand);
    match fields {
        [] => {}
        [field] => {
            if response.on_hover_text("A click plots it over the match").clicked() {
                commands.write(PlotCommand::Toggle(field.field.clone(), Some(robot)));
            }
        }
        several => {
            let stays = PopupCloseBehavior::CloseOnClickOutside;
            egui::Popup::menu(&response).close_behavior(stays).show(|ui| {
                ui.label(dim("Plot over the match").size(text_size::SMALL));
                egui::ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
                    for field in several {
                        entry(ui, field, plots.is_pinned(&field.field), Some(robot), commands);
                    }
                });
            });
            response.on_hover_text("A click plots it over the match");
        }
    }
}

/// Whether all typed words are in the name of a field or of its group.
fn is_meant(field: &KnownField, wanted: &str) -> bool {
    let name = format!("{} {}", field.group, field.name).to_lowercase();
    wanted.to_lowercase().split_whitespace().all(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::measured_fields;
    use super::*;

    #[test]
    fn fields_are_found_by_parts_of_their_names_in_any_order() {
        let found = |wanted: &str| -> Vec<String> {
            measured_fields().filter(|field| is_meant(field, wanted)).map(|field| field.name).collect()
        };
        assert_eq!(found("BALL err"), ["error of the ball"]);
        assert_eq!(found("sonar left measured"), ["left sonar"]);
        assert!(found("hologram").is_empty() && found("").len() == 19);
    }
}
