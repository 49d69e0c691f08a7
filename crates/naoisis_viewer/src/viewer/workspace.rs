//! The three uses of the window: to watch a match, to debug its robots, and to teach.
//!
//! Docked panels belong to debugging; the others use the whole window for the match.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::camera::{CameraMode, ViewerCamera};
use super::commands::{Action, ViewPreset};
use super::display_settings::{DisplaySettings, Workspace, is_debugging};
use super::layout::{self, LayoutSystems};
use super::shared::{CameraSystems, Notice};
use super::theme::card;

/// How long the names of the uses are shown after the mouse has moved, in uses without panels, s.
const SHOWN_S: f32 = 3.0;

/// Switches between the uses of the window.
pub struct WorkspacePlugin;

impl Plugin for WorkspacePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, enter.before(CameraSystems)).add_systems(
            EguiPrimaryContextPass,
            show_floating_choice.run_if(not(is_debugging)).in_set(LayoutSystems::Floating),
        );
    }
}

/// A hint after switching to a use.
fn hint(workspace: Workspace) -> &'static str {
    match workspace {
        Workspace::Watch => "Watch: the camera follows play, goals are replayed. Space: pause; V: debug",
        Workspace::Debug => "Debug: click a robot to see what it knows; V: teach",
        Workspace::Teach => "Teach: U: pen, Y: one robot's world, K: bookmark, J: next one; V: watch",
    }
}

/// Sets the camera for a use, and shows its hint.
fn enter(
    display: Res<DisplaySettings>,
    camera: Single<&ViewerCamera>,
    mut before: Local<Option<Workspace>>,
    mut views: MessageWriter<ViewPreset>,
    mut notice: ResMut<Notice>,
) {
    let now = display.workspace;
    let Some(last) = before.replace(now) else {
        if now == Workspace::Watch {
            views.write(ViewPreset::FollowPlay);
        }
        return;
    };
    if last == now {
        return;
    }
    notice.tell(hint(now));
    if now == Workspace::Watch {
        views.write(ViewPreset::FollowPlay);
    } else if camera.mode == CameraMode::Play {
        views.write(ViewPreset::Broadcast);
    }
}

/// Shows the three names; a click chooses one.
pub fn show_choice(ui: &mut egui::Ui, now: Workspace, actions: &mut MessageWriter<Action>) {
    for workspace in Workspace::ALL {
        let chosen = ui.selectable_label(workspace == now, workspace.name());
        let hint = format!("{} V, Shift V: the next use, the previous one", workspace.description());
        if chosen.on_hover_text(hint).clicked() {
            actions.write(Action::Workspace(workspace));
        }
    }
}

/// Shows the names in uses without panels while the mouse moves.
fn show_floating_choice(
    mut contexts: EguiContexts,
    time: Res<Time<Real>>,
    display: Res<DisplaySettings>,
    windows: Query<&Window>,
    mut last: Local<(Option<Vec2>, f32)>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let cursor = windows.iter().next().and_then(Window::cursor_position);
    if cursor != last.0 {
        *last = (cursor, time.elapsed_secs());
    }
    if cursor.is_none() || time.elapsed_secs() - last.1 > SHOWN_S {
        return Ok(());
    }
    layout::floating(contexts.ctx_mut()?, "workspaces", Align2::RIGHT_TOP).show(contexts.ctx_mut()?, |ui| {
        card(ui).show(ui, |ui| ui.horizontal(|ui| show_choice(ui, display.workspace, &mut actions)));
    });
    Ok(())
}
