//! The match as on television: a large score, replays of goals, a summary at the end. The camera that follows play is
//! among the [others](super::camera).

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, FontId, RichText};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

pub mod goal_replay;
pub mod summary;
mod summary_contents;
mod summary_maps;

use super::display_settings::is_watching;
use super::layout::{self, LARGE_SCORE, LayoutSystems};
use super::shared::{Playback, clock_words};
use super::team_labels::{TeamNames, width_of};
use super::theme::{band, bright, card, dim};
use goal_replay::GoalReplay;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_core::team::Team;

/// The height of the score as a fraction of the window's, and its limits, logical pixels.
const SCORE_SHARE: f32 = 0.06;
const SCORE_HEIGHTS: [f32; 2] = [26.0, 72.0];

/// Shows the score, goal replays and the final summary.
pub struct WatchPlugin;

impl Plugin for WatchPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((goal_replay::GoalReplayPlugin, summary::SummaryPlugin)).add_systems(
            EguiPrimaryContextPass,
            (show_score.run_if(not(summary::is_shown)), show_replay)
                .run_if(is_watching)
                .in_set(LayoutSystems::Floating),
        );
    }
}

/// The height of large letters in this window, logical pixels of the panels.
pub(super) fn large_letters(context: &egui::Context) -> f32 {
    (SCORE_SHARE * context.content_rect().height()).clamp(SCORE_HEIGHTS[0], SCORE_HEIGHTS[1])
}

fn show_score(
    mut contexts: EguiContexts,
    (game, clock, playback): (Res<Game>, Res<CycleClock>, Res<Playback>),
    names: TeamNames,
) -> Result {
    /// The width of the choice of the window's use on both sides, logical pixels.
    const BESIDE: f32 = 360.0;
    /// The width of bands and gaps, as a multiple of the height of the letters, and that of margins, logical pixels.
    const GAPS: f32 = 1.5;
    const MARGINS: f32 = 90.0;
    /// The width of everything with short names, as a multiple of the height of the letters.
    const LEAST: f32 = 12.5;
    /// The width of the free area from which on the half is shown, too, logical pixels.
    const ROOM: f32 = 900.0;
    let context = contexts.ctx_mut()?;
    let size = large_letters(context);
    let width = layout::free_area(context).width();
    let clock = clock_words(&game, &clock, &playback, width > ROOM);
    let clock = if playback.paused && width > ROOM { format!("{clock}   paused") } else { clock };
    // Beside a panel there may be no room in the middle.
    let (align, beside) = match width < BESIDE + LEAST * size {
        true => (Align2::LEFT_TOP, BESIDE / 2.0),
        false => (Align2::CENTER_TOP, BESIDE),
    };
    let painter = context.layer_painter(egui::LayerId::background());
    let score = format!("{} : {}", game.score.blue, game.score.pink);
    let others = width_of(&painter, &score, size) + width_of(&painter, &clock, 0.5 * size) + GAPS * size + MARGINS;
    let names = names.within(width - beside - others, |name| width_of(&painter, name, 0.6 * size));
    let large = |words: String, share: f32| bright(words).font(FontId::proportional(share * size));
    layout::floating(context, LARGE_SCORE, align).interactable(false).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.set_min_height(1.2 * size);
                band(ui, Team::Blue, egui::vec2(0.4 * size, 0.8 * size));
                ui.label(large(names[0].clone(), 0.6));
                ui.add_space(0.2 * size);
                ui.label(large(score.clone(), 1.0));
                ui.add_space(0.2 * size);
                ui.label(large(names[1].clone(), 0.6));
                band(ui, Team::Pink, egui::vec2(0.4 * size, 0.8 * size));
                ui.add_space(0.3 * size);
                ui.label(dim(clock).font(FontId::proportional(0.5 * size)));
            });
        });
    });
    Ok(())
}

/// Shows the text of a replay.
fn show_replay(mut contexts: EguiContexts, replay: Res<GoalReplay>) -> Result {
    let Some(words) = replay.words() else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let size = large_letters(context);
    layout::floating(context, "goal replay", Align2::LEFT_BOTTOM).interactable(false).show(context, |ui| {
        card(ui).show(ui, |ui| {
            ui.label(RichText::new("REPLAY").font(FontId::proportional(0.5 * size)).weak());
            ui.label(bright(words).font(FontId::proportional(0.8 * size)));
        });
    });
    Ok(())
}
