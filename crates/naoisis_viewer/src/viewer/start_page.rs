//! The start page of a window without a match: the uses of the window, recent files, and how to start your own program.
//! A file that is dropped into the window is opened at any time.

use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy_egui::egui::{self, Align2, Key, RichText, TextEdit, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::path::Path;

use super::display_settings::Workspace;
use super::layout::LayoutSystems;
use super::match_panel::MatchCommand;
use super::memory::ViewerMemory;
use super::shared::{Action, Playback};
use super::theme::{bright, card, dim, panel, text_size};

/// An example of starting a program as a team.
const OWN_PROGRAM: &str = "naoisis play --blue \"exec:python3 my_team.py\"";
/// The greatest width of the page, logical pixels.
const WIDTH: f32 = 560.0;
/// Its least width, also in a smaller window, logical pixels.
const LEAST_WIDTH: f32 = 200.0;

/// Shows the page, and opens dropped files.
pub struct StartPagePlugin;

impl Plugin for StartPagePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<StartPage>()
            .init_resource::<DialogIsOpen>()
            .add_systems(Update, (open_dropped, wait_for_choice))
            .add_systems(EguiPrimaryContextPass, show.run_if(is_open).in_set(LayoutSystems::Floating));
    }
}

/// Whether a dialog is open, which hides the page meanwhile.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct DialogIsOpen(pub bool);

/// Whether the page is shown; the match behind it is paused.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct StartPage(pub bool);

fn is_open(page: Res<StartPage>, dialog: Res<DialogIsOpen>) -> bool {
    page.0 && !dialog.0
}

/// Pauses the match until a use is chosen. Continuing it by a key closes the page.
fn wait_for_choice(mut page: ResMut<StartPage>, mut playback: ResMut<Playback>, mut has_begun: Local<bool>) {
    if !page.0 {
        return;
    }
    if !*has_begun {
        *has_begun = true;
        playback.paused = true;
    } else if !playback.paused {
        page.0 = false;
    }
}

fn open_dropped(
    mut drops: MessageReader<FileDragAndDrop>,
    mut page: ResMut<StartPage>,
    mut commands: MessageWriter<MatchCommand>,
) {
    for drop in drops.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = drop {
            commands.write(MatchCommand::Open(path_buf.clone()));
            page.0 = false;
        }
    }
}

fn show(
    mut contexts: EguiContexts,
    memory: Option<Res<ViewerMemory>>,
    mut typed: Local<String>,
    mut page: ResMut<StartPage>,
    mut playback: ResMut<Playback>,
    mut actions: MessageWriter<Action>,
    mut commands: MessageWriter<MatchCommand>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let width = WIDTH.min(context.content_rect().width() - 60.0).max(LEAST_WIDTH);
    let mut is_chosen = false;
    panel("start page", Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).inner_margin(egui::Margin::same(18)).show(ui, |ui| {
            ui.set_width(width);
            ui.label(bright("naoisis").size(text_size::SCORE));
            ui.add_space(8.0);
            for (workspace, name, what) in CHOICES {
                ui.horizontal(|ui| {
                    let button = egui::Button::new(bright(name).size(text_size::BUTTON)).min_size([170.0, 30.0].into());
                    if ui.add(button).clicked() {
                        actions.write(Action::Workspace(workspace));
                        is_chosen = true;
                    }
                    ui.add(egui::Label::new(dim(what)).wrap());
                });
            }
            ui.add_space(10.0);
            ui.label(bright("Open a scenario or a trace").size(text_size::IMPORTANT));
            ui.label(dim("Drop its file into the window, choose it (Ctrl O), or type its path."));
            ui.horizontal(|ui| {
                let text = TextEdit::singleline(&mut *typed).hint_text("match.jsonl.zst").desired_width((width - 160.0).max(40.0));
                let text = ui.add(text);
                text.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "File to open"));
                let is_entered = text.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                let is_typed = !typed.trim().is_empty();
                let is_clicked = ui.add_enabled(is_typed, egui::Button::new("Open")).clicked();
                if is_clicked || (is_entered && is_typed) {
                    commands.write(MatchCommand::Open(typed.trim().into()));
                    is_chosen = true;
                }
                if ui.button("Choose…").clicked() {
                    actions.write(Action::OpenFile);
                }
            });
            for path in memory.iter().flat_map(|memory| &memory.remembered.recent) {
                if ui.link(path).clicked() {
                    commands.write(MatchCommand::Open(Path::new(path).to_owned()));
                    is_chosen = true;
                }
            }
            ui.add_space(10.0);
            ui.label(bright("A behaviour of your own").size(text_size::IMPORTANT));
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(OWN_PROGRAM).monospace());
                if ui.small_button("Copy").clicked() {
                    ui.ctx().copy_text(OWN_PROGRAM.to_owned());
                }
            });
            ui.label(dim("plays it as blue; clients in Python, C++ and JavaScript are in the folder clients, and in Rust it is a system."));
        });
    });
    if is_chosen {
        page.0 = false;
        playback.paused = false;
    }
    Ok(())
}

/// The uses of the window with descriptions.
const CHOICES: [(Workspace, &str, &str); 3] = [
    (Workspace::Watch, "Watch a match", "A camera that follows play, replays of goals, statistics."),
    (Workspace::Debug, "Debug a match", "Perceptions, beliefs and decisions of robots, and repetitions of moments."),
    (Workspace::Teach, "Teach with a match", "Only the pitch, with a pen and bookmarks with captions."),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_match_waits_for_a_choice_and_a_key_is_one() {
        let mut app = App::new();
        app.init_resource::<Playback>().insert_resource(StartPage(true)).add_systems(Update, wait_for_choice);
        app.update();
        assert!(app.world().resource::<Playback>().paused && app.world().resource::<StartPage>().0);
        app.world_mut().resource_mut::<Playback>().paused = false;
        app.update();
        assert!(!app.world().resource::<StartPage>().0);
    }

    #[test]
    fn a_file_that_is_dropped_is_opened() {
        let mut app = App::new();
        app.add_message::<FileDragAndDrop>().add_message::<MatchCommand>().insert_resource(StartPage(true));
        app.add_systems(Update, open_dropped);
        let window = Entity::PLACEHOLDER;
        app.world_mut().write_message(FileDragAndDrop::DroppedFile { window, path_buf: "match.jsonl".into() });
        app.update();
        let opened: Vec<_> = app.world_mut().resource_mut::<Messages<MatchCommand>>().drain().collect();
        assert_eq!(opened, [MatchCommand::Open("match.jsonl".into())]);
        assert!(!app.world().resource::<StartPage>().0);
    }
}
