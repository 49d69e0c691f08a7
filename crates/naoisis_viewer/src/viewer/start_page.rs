//! The start page of a window without a match: the uses of the window, recent files, and how to start your own program.
//! A file that is dropped into the window is opened at any time.

use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy_egui::egui::{self, Align2, Key, RichText, TextEdit, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::path::Path;

use super::commands::{Action, HandAction};
use super::display_settings::Workspace;
use super::interaction::InteractionSystems;
use super::layout::LayoutSystems;
use super::match_panel::{MatchCommand, WatchedScenarioFile};
use super::memory::ViewerMemory;
use super::shared::{KeysSystems, Notice, Playback};
use super::theme::{bright, card, dim, panel, problem_colour, text_size};
use naoisis_sim::scenario::Scenario;

/// An example of starting a program as a team.
const OWN_PROGRAM: &str = "naoisis play --blue \"exec:python3 my_team.py\"";
/// The greatest width of the page, logical pixels.
const WIDTH: f32 = 560.0;
/// Its least width, also in a smaller window, logical pixels.
const LEAST_WIDTH: f32 = 200.0;

/// Why a key or button does nothing to the match behind the page.
pub(super) const NOT_ON_START_PAGE: &str = "Choose first what to do with a match, or what to open";

/// Shows the page, and opens dropped files.
pub struct StartPagePlugin;

impl Plugin for StartPagePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<StartPage>()
            .init_resource::<DialogIsOpen>()
            .init_resource::<OpensFile>()
            .add_systems(Update, (open_dropped, wait_for_choice, close_when_opened))
            .add_systems(Update, refuse_hands.after(KeysSystems).before(InteractionSystems).run_if(is_open))
            .add_systems(EguiPrimaryContextPass, show.run_if(is_open).in_set(LayoutSystems::Floating));
    }
}

/// Whether a dialog is open, which hides the page meanwhile.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct DialogIsOpen(pub bool);

/// Whether a file was chosen. The page stays until its match begins, because the file may be wrong.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct OpensFile(pub bool);

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

/// Refuses what keys would do to the match behind the page.
fn refuse_hands(mut hands: ResMut<Messages<HandAction>>, mut notice: ResMut<Notice>) {
    if hands.drain().count() > 0 {
        notice.tell(NOT_ON_START_PAGE);
    }
}

/// Closes the page when the match of the chosen file has begun.
fn close_when_opened(
    scenario: Option<Res<Scenario>>,
    mut opens: ResMut<OpensFile>,
    mut page: ResMut<StartPage>,
    mut playback: ResMut<Playback>,
) {
    if opens.0 && playback.problem.is_some() {
        opens.0 = false;
    } else if opens.0 && scenario.is_some_and(|scenario| scenario.is_changed()) {
        (opens.0, page.0, playback.paused) = (false, false, false);
    }
}

fn open_dropped(
    mut drops: MessageReader<FileDragAndDrop>,
    page: Res<StartPage>,
    mut opens: ResMut<OpensFile>,
    mut playback: ResMut<Playback>,
    mut commands: MessageWriter<MatchCommand>,
) {
    for drop in drops.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = drop {
            commands.write(MatchCommand::Open(path_buf.clone()));
            (opens.0, playback.problem) = (page.0, None);
        }
    }
}

fn show(
    mut contexts: EguiContexts,
    memory: Option<Res<ViewerMemory>>,
    mut typed: Local<String>,
    (mut page, mut opens, mut watched): (ResMut<StartPage>, ResMut<OpensFile>, ResMut<WatchedScenarioFile>),
    mut playback: ResMut<Playback>,
    mut actions: MessageWriter<Action>,
    mut commands: MessageWriter<MatchCommand>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let width = WIDTH.min(context.content_rect().width() - 60.0).max(LEAST_WIDTH);
    let (mut is_chosen, mut wanted) = (false, None);
    panel("start page", Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).inner_margin(egui::Margin::same(18)).show(ui, |ui| {
            ui.set_width(width);
            ui.label(bright("naoisis").size(text_size::SCORE));
            ui.add_space(8.0);
            for (workspace, name) in CHOICES {
                ui.horizontal(|ui| {
                    let button = egui::Button::new(bright(name).size(text_size::BUTTON)).min_size([170.0, 30.0].into());
                    if ui.add(button).clicked() {
                        actions.write(Action::Workspace(workspace));
                        is_chosen = true;
                    }
                    ui.add(egui::Label::new(dim(workspace.description())).wrap());
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
                    wanted = Some(Path::new(typed.trim()).to_owned());
                }
                if ui.button("Choose…").clicked() {
                    actions.write(Action::OpenFile);
                }
            });
            // The line of the error is there before, so that the field stays where it is.
            let problem = RichText::new(playback.problem.as_deref().unwrap_or(" ")).color(problem_colour(ui));
            ui.add(egui::Label::new(problem).wrap());
            for path in memory.iter().flat_map(|memory| &memory.remembered.recent) {
                if ui.link(path).clicked() {
                    wanted = Some(Path::new(path).to_owned());
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
            ui.label(dim("plays it as blue; clients in Python, C++ and JavaScript are in the folder clients of the source code; in Rust, a behaviour is a Bevy system."));
        });
    });
    if let Some(path) = wanted {
        commands.write(MatchCommand::Open(path));
        (opens.0, playback.problem) = (true, None);
    }
    if is_chosen {
        page.0 = false;
        playback.paused = false;
        // A file that could not be opened has nothing to do with the match that was chosen.
        if playback.problem.take().is_some() {
            *watched = WatchedScenarioFile::default();
        }
    }
    Ok(())
}

/// The uses of the window with their names on the page.
const CHOICES: [(Workspace, &str); 3] = [
    (Workspace::Watch, "Watch a match"),
    (Workspace::Debug, "Debug a match"),
    (Workspace::Teach, "Teach with a match"),
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
    fn nothing_is_done_by_hand_behind_the_page() {
        let mut app = App::new();
        app.add_message::<HandAction>().init_resource::<Notice>().add_systems(Update, refuse_hands);
        app.world_mut().write_message(HandAction::Whistle);
        app.update();
        assert!(app.world().resource::<Messages<HandAction>>().is_empty());
        assert!(app.world().resource::<Notice>().text.starts_with("Choose first"));
    }

    #[test]
    fn a_file_that_is_dropped_is_opened() {
        let mut app = App::new();
        app.add_message::<FileDragAndDrop>().add_message::<MatchCommand>().insert_resource(StartPage(true));
        app.init_resource::<OpensFile>().insert_resource(Playback { paused: true, ..default() });
        app.add_systems(Update, (open_dropped, close_when_opened).chain());
        let window = Entity::PLACEHOLDER;
        app.world_mut().write_message(FileDragAndDrop::DroppedFile { window, path_buf: "match.jsonl".into() });
        app.update();
        let opened: Vec<_> = app.world_mut().resource_mut::<Messages<MatchCommand>>().drain().collect();
        assert_eq!(opened, [MatchCommand::Open("match.jsonl".into())]);
        // The page stays if the file is wrong, and closes when a match begins.
        app.world_mut().resource_mut::<Playback>().problem = Some("no such file".to_owned());
        app.update();
        app.insert_resource(Scenario::default());
        app.update();
        assert!(app.world().resource::<StartPage>().0);
        app.world_mut().write_message(FileDragAndDrop::DroppedFile { window, path_buf: "match.jsonl".into() });
        app.update();
        app.insert_resource(Scenario::default());
        app.update();
        assert!(!app.world().resource::<StartPage>().0 && !app.world().resource::<Playback>().paused);
    }
}
