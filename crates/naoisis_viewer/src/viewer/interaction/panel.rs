//! The buttons for interventions.

use bevy::prelude::*;
use bevy_egui::egui::text::LayoutJob;
use bevy_egui::egui::{self, Align2, RichText, TextFormat, TextStyle};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::driving::{self, Driving};
use super::referee_menu::RefereeMenu;
use super::undo::Undo;
use crate::viewer::commands::{Action, HandAction, ToggleFilm};
use crate::viewer::display_settings::Workspace;
use crate::viewer::display_settings::{DisplaySettings, Switch};
use crate::viewer::film::Filming;
use crate::viewer::floating::{moved_clear, place_beside};
use crate::viewer::layout::{self, LARGE_SCORE, LayoutSystems, shown_at};
use crate::viewer::shared::{Notice, OVER, Playback, Selection, is_over};
use crate::viewer::theme::{MARGIN, bright, card, problem_colour, text_size};
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Penalty};
use naoisis_core::robot::Roster;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::posture::Posture;

/// The greatest width of the help for driving, logical pixels.
const WIDEST_HELP: f32 = 250.0;
/// The least width of texts above the match, also where panels leave less, logical pixels.
const LEAST_WIDTH: f32 = 100.0;

/// Shows the buttons, and notices.
pub(super) struct InteractionPanelPlugin;

impl Plugin for InteractionPanelPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            (
                show_buttons.in_set(LayoutSystems::Interventions),
                (show_notice, show_driver).chain().in_set(LayoutSystems::Floating),
            ),
        );
    }
}

fn show_buttons(
    mut contexts: EguiContexts,
    selection: Res<Selection>,
    roster: Res<Roster>,
    penalties: Query<&Penalty>,
    (driving, undo, referee): (Res<Driving>, Res<Undo>, RefereeMenu),
    timeline: Res<Timeline>,
    filming: Res<Filming>,
    mut display: ResMut<DisplaySettings>,
    mut films: MessageWriter<ToggleFilm>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let serves = selection.0.and_then(|id| penalties.get(roster.get(id)?).ok()).is_some_and(Penalty::is_active);
    layout::bar_below(contexts.ctx_mut()?, "hands", |ui| {
        ui.horizontal_wrapped(|ui| {
            let record = if filming.is_on() { "⏹ Stop" } else { "⏺ Record" };
            let hint = "F8: a video of the window; with Shift, a folder of PNG files";
            if ui.button(record).on_hover_text(hint).clicked() {
                let is_shift = ui.input(|input| input.modifiers.shift);
                films.write(if is_shift { ToggleFilm::Frames } else { ToggleFilm::Video });
            }
            if ui.button("Match").on_hover_text("M: scenario, teams, settings").clicked() {
                display.toggle(Switch::Game);
            }
            if timeline.is_replay() {
                return;
            }
            let mut clicked = None;
            let mut button = |ui: &mut egui::Ui, enabled: bool, text: &str, hint: &str, action: HandAction| {
                let button = ui.add_enabled(enabled, egui::Button::new(text)).on_hover_text(hint);
                let why_not = match action {
                    HandAction::PenaliseOrReturn => "Select a robot first (P)",
                    HandAction::Undo => "Nothing to undo (Ctrl Z)",
                    _ => "Nothing to redo (Ctrl Shift Z)",
                };
                if button.on_disabled_hover_text(why_not).clicked() {
                    clicked = Some(action);
                }
            };
            button(ui, true, "Whistle", "W: the referee whistles", HandAction::Whistle);
            button(ui, true, "Drop ball", "B: puts the ball on the centre, in play", HandAction::DropBall);
            let whom = selection.0.map_or_else(|| "robot".to_owned(), |id| id.to_string());
            let what = if serves { "Return" } else { "Penalise" };
            button(
                ui,
                selection.0.is_some(),
                &format!("{what} {whom}"),
                "P: takes it off the pitch, or puts it back",
                HandAction::PenaliseOrReturn,
            );
            let call = referee.show(ui, selection.0).map(HandAction::Intervene);
            let text = match (driving.robot, selection.0) {
                (Some(id), _) => format!("Leave {id}"),
                (None, Some(id)) => format!("Drive {id}"),
                (None, None) => "Drive a robot".to_owned(),
            };
            button(ui, true, &text, "D: by the keyboard, through its camera", HandAction::Drive);
            let [undo, redo] = undo.counts().map(|count| count > 0);
            button(ui, undo, "Undo", "Ctrl Z: undoes the last action", HandAction::Undo);
            button(ui, redo, "Redo", "Ctrl Shift Z: redoes it", HandAction::Redo);
            button(ui, true, "Save situation", "F9: saves a scenario file", HandAction::KeepSituation);
            actions.write_batch(clicked.or(call).map(Action::Hand));
        });
    });
    Ok(())
}

/// The margin beside a notice, its greatest width, and about the width of a letter in it, logical pixels.
const NOTICE_MARGIN: f32 = 60.0;
const WIDEST_NOTICE: f32 = 520.0;
const NOTICE_LETTER: f32 = 7.5;
/// The distance of a notice at the top from the edge: the choice of the window's use is above it, logical pixels.
const BELOW_CHOICE: f32 = 56.0;
/// The floating areas that a notice does not cover.
const NOTICE_BESIDE: [&str; 3] = ["legend", LARGE_SCORE, "goal replay"];

/// Shows the last notice for some seconds.
fn show_notice(
    mut contexts: EguiContexts,
    time: Res<Time<Real>>,
    (display, driving): (Res<DisplaySettings>, Res<Driving>),
    mut notice: ResMut<Notice>,
) -> Result {
    if notice.left_s <= 0.0 {
        return Ok(());
    }
    notice.left_s -= time.delta_secs();
    let context = contexts.ctx_mut()?;
    // In the teaching workspace the captions are below, and while a robot is driven its keys and the map, so the notice is above.
    let is_above = display.workspace == Workspace::Teach || driving.robot.is_some();
    let align = if is_above { Align2::CENTER_TOP } else { Align2::CENTER_BOTTOM };
    let free = layout::free_area(context);
    let widest = (free.width() - NOTICE_MARGIN).clamp(LEAST_WIDTH, WIDEST_NOTICE);
    let mut place = place_beside(context, "notice", align, &NOTICE_BESIDE);
    if display.workspace == Workspace::Teach {
        let top = free.center_top() + egui::vec2(0.0, BELOW_CHOICE);
        let legend: Vec<egui::Rect> = shown_at(context, "legend").into_iter().collect();
        place = moved_clear(align.anchor_size(top, place.size()), &legend, true);
    }
    let area = layout::floating(context, "notice", align).fixed_pos(align.pos_in_rect(&place));
    let shown = area.show(context, |ui| {
        let text = bright(&notice.text).size(text_size::IMPORTANT);
        card(ui).fill(ui.visuals().panel_fill).show(ui, |ui| {
            // The notice is on one line if it fits.
            let long = notice.text.chars().count() as f32 * NOTICE_LETTER > widest;
            if long {
                ui.set_width(widest);
            }
            let words = egui::Label::new(text);
            ui.add(if long { words.wrap() } else { words.extend() });
        });
    });
    // While the pointer is on the notice, the user is still reading it.
    if shown.response.contains_pointer() {
        notice.left_s = notice.left_s.max(1.0);
    }
    Ok(())
}

/// Shows the keys while a robot is driven.
fn show_driver(
    mut contexts: EguiContexts,
    driving: Res<Driving>,
    roster: Res<Roster>,
    robots: Query<(&Penalty, &Posture, &KickSettings)>,
    (clock, game, playback): (Res<CycleClock>, Res<Game>, Res<Playback>),
) -> Result {
    let Some(robot) = driving.robot else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let width = layout::free_area(context).width();
    let driven = roster.get(robot).and_then(|robot| robots.get(robot).ok());
    let (penalty, posture) = (driven.and_then(|(penalty, ..)| penalty.0), driven.map(|(_, posture, _)| posture));
    let own_kicks = driven.map_or(0, |(.., kicks)| kicks.own.len());
    // At the side, where it covers least of what is ahead of the robot.
    layout::floating(context, "driver", Align2::LEFT_BOTTOM).interactable(false).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill.to_opaque()).show(ui, |ui| {
            ui.set_max_width((width - 2.0 * MARGIN).clamp(LEAST_WIDTH, WIDEST_HELP));
            ui.label(bright(format!("You drive {robot}")));
            let problem = |ui: &mut egui::Ui, words: &str| {
                ui.label(RichText::new(words).color(problem_colour(ui)));
            };
            if is_over(&game, &clock, &playback) {
                problem(ui, OVER);
            } else if playback.paused {
                problem(ui, "The match is paused: Space continues");
            } else if game.stop.is_some() || game.state == GameState::Timeout {
                problem(ui, "Play is stopped: no robot may move");
            } else if let Some(false) = posture.map(|posture| posture.is_upright()) {
                problem(ui, "It is not on its feet");
            }
            if let Some(penalty) = penalty {
                let left_s = penalty.left_s(&clock);
                let text = format!("Penalised for {}: {left_s:.0} s", penalty.reason.words());
                ui.label(RichText::new(text).color(problem_colour(ui)));
            }
            ui.horizontal_wrapped(|ui| {
                for (keys, what) in driving::keys(own_kicks) {
                    // Each key stays on one line with its meaning.
                    ui.add(egui::Label::new(key_and_meaning(ui, keys, what)).extend());
                }
            });
        });
    });
    Ok(())
}

/// The name of a key in bold, and its meaning.
fn key_and_meaning(ui: &egui::Ui, key: &str, meaning: &str) -> LayoutJob {
    let font = TextStyle::Body.resolve(ui.style());
    let mut job = LayoutJob::default();
    for (text, colour) in [(key, ui.visuals().strong_text_color()), (meaning, ui.visuals().weak_text_color())] {
        let gap = if job.is_empty() { 0.0 } else { 6.0 };
        job.append(text, gap, TextFormat::simple(font.clone(), colour));
    }
    job
}
