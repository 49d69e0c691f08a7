//! A dialog in which to choose the file of a scenario, a saved match or a trace.

use bevy::prelude::*;
use bevy_egui::egui::{Align2, Color32};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use egui_file_dialog::{DialogState, FileDialog, FileDialogConfig, OpeningMode};

use super::commands::Action;
use super::layout::LayoutSystems;
use super::match_panel::MatchCommand;
use super::shared::Playback;
use super::start_page::{DialogIsOpen, OpensFile, StartPage};

/// The endings of files that can be opened.
const OPENED: [&str; 5] = ["json", "ron", "naoisis", "jsonl", "zst"];
/// The name of the choice of these files in the dialog.
const MATCHES: &str = "Scenarios, matches, traces";

/// Shows the dialog.
pub struct OpenDialogPlugin;

impl Plugin for OpenDialogPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OpenDialog>().add_systems(
            EguiPrimaryContextPass,
            (open.run_if(is_wanted), show).chain().in_set(LayoutSystems::Floating),
        );
    }
}

/// The dialog.
#[derive(Resource)]
struct OpenDialog(FileDialog);

impl Default for OpenDialog {
    fn default() -> Self {
        let config = FileDialogConfig { opening_mode: OpeningMode::LastPickedDir, ..default() };
        let dialog = FileDialog::with_config(config)
            .title("Open a scenario, a match or a trace")
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .add_file_filter_extensions(MATCHES, OPENED.to_vec())
            .default_file_filter(MATCHES);
        Self(dialog)
    }
}

fn is_wanted(mut actions: MessageReader<Action>) -> bool {
    actions.read().any(|action| *action == Action::OpenFile)
}

fn open(mut dialog: ResMut<OpenDialog>) {
    dialog.0.pick_file();
}

fn show(
    mut contexts: EguiContexts,
    mut dialog: ResMut<OpenDialog>,
    (page, mut is_open, mut opens): (Res<StartPage>, ResMut<DialogIsOpen>, ResMut<OpensFile>),
    mut playback: ResMut<Playback>,
    mut commands: MessageWriter<MatchCommand>,
) -> Result {
    let context = contexts.ctx_mut()?;
    // The dialog writes with the colour of selected rows, too.
    let style = context.global_style();
    context.global_style_mut(|style| {
        let selection = &mut style.visuals.selection;
        (selection.bg_fill, selection.stroke.color) = match style.visuals.dark_mode {
            true => (Color32::from_rgb(90, 165, 225), Color32::BLACK),
            false => (Color32::from_rgb(0, 100, 160), Color32::WHITE),
        };
    });
    dialog.0.update(context);
    context.set_global_style(style);
    is_open.set_if_neq(DialogIsOpen(*dialog.0.state() == DialogState::Open));
    if let Some(path) = dialog.0.take_picked() {
        commands.write(MatchCommand::Open(path));
        // The page stays until the match of the file begins.
        (opens.0, playback.problem) = (page.0, None);
    }
    Ok(())
}
