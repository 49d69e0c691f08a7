//! The panels of score, clock, controls and help.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Margin, RichText, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use core::ops::Range;

use super::commands::{Action, ViewerCommand};
use super::display_settings::{DisplaySettings, Switch};
use super::drive::PlayedFile;
use super::key_bindings::{self, HelpGroup};
use super::layout::{self, LayoutSystems};
use super::scenario_list;
use super::shared::{MatchBefore, Playback, Selection, clock_words, is_over};
use super::speed::Speed;
use super::start_page::StartPage;
use super::team_labels::{TeamNames, width_of};
use super::theme::{MARGIN, band, bright, card, dim, link, panel, problem_colour, tenths, text_size};
use super::timeline::Timeline;
use super::workspace::show_choice;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_core::team::Team;
use naoisis_sim::scenario::Scenario;

/// The height of the score, logical pixels.
const SCORE_HEIGHT: f32 = 30.0;

/// The widths of the lists of speeds and scenarios, logical pixels.
const SPEED: f32 = 58.0;
const SCENARIO: f32 = 150.0;

/// The panels.
pub struct PanelsPlugin;

impl Plugin for PanelsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            (
                show_score.in_set(LayoutSystems::Score),
                show_controls.in_set(LayoutSystems::Controls),
                show_help.run_if(|display: Res<DisplaySettings>| display.help).in_set(LayoutSystems::Floating),
            ),
        );
    }
}

fn show_score(
    mut contexts: EguiContexts,
    game: Res<Game>,
    clock: Res<CycleClock>,
    playback: Res<Playback>,
    (display, selection): (Res<DisplaySettings>, Res<Selection>),
    team_names: TeamNames,
    mut actions: MessageWriter<Action>,
) -> Result {
    /// The hint for new users.
    const HINT: &str = "Click a robot to see what it knows. H: all keys.";
    let hint = if display.robot && selection.0.is_none() { HINT } else { "" };
    /// The width from which on the half and the state of the game are shown, too, and that of bands and gaps, logical pixels.
    const ROOM: f32 = 560.0;
    const GAPS: f32 = 130.0;
    layout::bar_above(contexts.ctx_mut()?, "score", |ui| {
        let text = clock_words(&game, &clock, &playback, ui.available_width() > ROOM);
        let score = format!("{} : {}", game.score.blue, game.score.pink);
        let body = egui::TextStyle::Body.resolve(ui.style()).size;
        let [score_width, text_width] =
            [(&score, text_size::SCORE), (&text, body)].map(|(text, size)| width_of(ui.painter(), text, size));
        let room = ui.available_width() - widths(ui)[1] - score_width - text_width - GAPS;
        let names = team_names.within(room, |name| width_of(ui.painter(), name, text_size::TEAM));
        let mut is_asked = false;
        let teams = |ui: &mut egui::Ui| {
            // As high as the highest of them, so that all are on one line.
            ui.set_min_height(SCORE_HEIGHT);
            band(ui, Team::Blue, egui::vec2(14.0, 22.0));
            ui.label(bright(&names[0]).size(text_size::TEAM));
            ui.add_space(4.0);
            let hint = "The moments that changed the chances to score most, and why (A)";
            is_asked = link(ui, egui::Label::new(bright(&score).size(text_size::SCORE).strong()), &score)
                .on_hover_text(hint)
                .clicked();
            ui.add_space(4.0);
            ui.label(bright(&names[1]).size(text_size::TEAM));
            band(ui, Team::Pink, egui::vec2(14.0, 22.0));
            ui.add_space(12.0);
            ui.add(egui::Label::new(dim(&text)).extend());
        };
        in_the_middle(ui, hint, teams, |ui| show_choice(ui, display.workspace, &mut actions));
        if is_asked {
            actions.write(Action::Toggle(Switch::Decided));
        }
    });
    Ok(())
}

/// Shows contents in the middle of a bar (by their width in the last frame), others at its end, and a text before them
/// if there is room.
fn in_the_middle(
    ui: &mut egui::Ui,
    beside: &str,
    show: impl FnOnce(&mut egui::Ui),
    show_at_end: impl FnOnce(&mut egui::Ui),
) {
    let (id, [before, at_end]) = (widths_id(ui), widths(ui));
    ui.horizontal(|ui| {
        ui.set_min_height(SCORE_HEIGHT);
        let (start, all) = (ui.cursor().left(), ui.available_width());
        // In the middle, as far as the widgets at the end leave room.
        let room = ((all - before) / 2.0).min(all - before - at_end).max(0.0);
        let words = ui.painter().layout_no_wrap(
            beside.to_owned(),
            egui::TextStyle::Body.resolve(ui.style()),
            egui::Color32::WHITE,
        );
        if words.size().x + ui.spacing().item_spacing.x < room {
            ui.add(egui::Label::new(dim(beside)).extend());
        }
        ui.add_space((start + room - ui.cursor().left()).max(0.0));
        let width = ui.horizontal(show).response.rect.width();
        ui.add_space((start + all - at_end - ui.cursor().left()).max(0.0));
        let at_end = ui.horizontal(show_at_end).response.rect.width();
        ui.data_mut(|data| data.insert_temp(id, [width, at_end + ui.spacing().item_spacing.x]));
    });
}

/// The widths of what is in the middle of a bar and at its end in the last frame, logical pixels.
fn widths(ui: &egui::Ui) -> [f32; 2] {
    ui.data(|data| data.get_temp(widths_id(ui))).unwrap_or_default()
}

fn widths_id(ui: &egui::Ui) -> egui::Id {
    ui.id().with("widths")
}

fn show_controls(
    mut contexts: EguiContexts,
    mut actions: MessageWriter<Action>,
    mut playback: ResMut<Playback>,
    (clock, game, timeline): (Res<CycleClock>, Res<Game>, Res<Timeline>),
    (scenario, before, file): (Option<Res<Scenario>>, Res<MatchBefore>, Option<Res<PlayedFile>>),
    start_page: Res<StartPage>,
) -> Result {
    let mut is_read = false;
    let is_over = is_over(&game, &clock, &playback) && !timeline.is_past();
    let mut send = |action: Option<Action>| {
        if let Some(action) = action {
            actions.write(action);
        }
    };
    layout::bar_below(contexts.ctx_mut()?, "controls", |ui| {
        // The start page shows it, too.
        if let Some(problem) = playback.problem.as_ref().filter(|_| !start_page.0) {
            ui.horizontal(|ui| {
                is_read = ui.small_button("✖").on_hover_text("Close this message").clicked();
                ui.add(egui::Label::new(RichText::new(problem).color(problem_colour(ui))).truncate());
            });
        }
        if let Some((robot, waited_s)) = playback.awaited() {
            let paused = if playback.paused { " It is not given up while the match is paused." } else { "" };
            ui.label(format!(
                "The match waits for the program of {robot}, which has not answered for {waited_s:.0} s.{paused}"
            ));
        }
        // In narrow windows, the buttons take several lines.
        ui.horizontal_wrapped(|ui| {
            let button = |ui: &mut egui::Ui, text: &str, hint: &str, action: Action| {
                let button = egui::Button::new(bright(text).size(text_size::BUTTON)).min_size(egui::vec2(34.0, 26.0));
                ui.add(button).on_hover_text(hint).clicked().then_some(action)
            };
            let stands = playback.paused || is_over;
            let (pause, hint) = if stands { ("▶", "Continue (Space)") } else { ("⏸", "Pause (Space)") };
            send(button(ui, pause, hint, Action::Command(ViewerCommand::TogglePause)));
            send(button(ui, "⏭", "One cycle (Right)", Action::Command(ViewerCommand::Step)));
            ui.separator();
            send(button(ui, "⏪", "Slower (Down)", Action::Command(ViewerCommand::Slower)));
            end_row_unless_room(ui, SPEED);
            choose_speed(ui, &playback, |speed| send(Some(Action::Command(ViewerCommand::SetSpeed(speed)))));
            send(button(ui, "⏩", "Faster (Up)", Action::Command(ViewerCommand::Faster)));
            ui.separator();
            let hint = "Restart the same match, with the settings of now (R)";
            send(button(ui, "⟲", hint, Action::Command(ViewerCommand::Restart)));
            let hint = "New match with the next seed (Shift R)";
            send(button(ui, "🎲", hint, Action::Command(ViewerCommand::RestartWithNextSeed)));
            if let Some(name) = &before.0 {
                let hint = format!("{name}, as it was left (Backspace)");
                let is_asked = ui.button(bright("Match before")).on_hover_text(hint).clicked();
                send(is_asked.then_some(Action::Command(ViewerCommand::MatchBefore)));
            }
            ui.separator();
            send(button(ui, "?", "Find a command (? or Ctrl K). All keys: H", Action::Toggle(Switch::Commands)));
            ui.separator();
            end_row_unless_room(ui, SCENARIO);
            let own = file.as_ref().map_or_else(String::new, |file| file.name());
            let load = |name| send(Some(Action::Command(ViewerCommand::Load(name))));
            choose_scenario(ui, (scenario.as_deref(), &own), load);
            ui.add(egui::Label::new(dim(status(&playback, &clock, scenario.as_deref(), is_over))).extend());
        });
    });
    if is_read {
        playback.problem = None;
    }
    Ok(())
}

/// Begins the next line of a wrapped bar if a list of this width has no room on this one: lists do not wrap by themselves.
fn end_row_unless_room(ui: &mut egui::Ui, width: f32) {
    if ui.available_size_before_wrap().x < width + ui.spacing().item_spacing.x {
        ui.end_row();
    }
}

fn choose_speed(ui: &mut egui::Ui, playback: &Playback, mut choose: impl FnMut(Speed)) {
    let text = playback.speed.to_string();
    let list = egui::ComboBox::from_id_salt("speed").width(SPEED).selected_text(bright(&text));
    let shown = list.show_ui(ui, |ui| {
        for speed in Speed::ALL {
            if ui.selectable_label(speed == playback.speed, speed.to_string()).clicked() {
                choose(speed);
            }
        }
    });
    named(shown.response, "Speed", &text).on_hover_text("Simulated seconds per second (Up, Down)");
}

/// Shows the list of scenarios. A scenario without a name has that of its `file`.
fn choose_scenario(ui: &mut egui::Ui, (scenario, file): (Option<&Scenario>, &str), choose: impl FnMut(&'static str)) {
    let current = scenario.map(|scenario| scenario.name.as_str()).unwrap_or_default();
    let shown = if current.is_empty() { file } else { current };
    let list = egui::ComboBox::from_id_salt("scenario").width(SCENARIO).truncate().selected_text(bright(shown));
    let response = scenario_list::show(ui, list, current, choose);
    named(response, "Another scenario", current).on_hover_text("Another scenario, from the start");
}

/// Gives a list a name for screen readers.
fn named(response: egui::Response, name: &str, value: &str) -> egui::Response {
    response.widget_info(|| {
        let mut info = WidgetInfo::labeled(WidgetType::ComboBox, true, name);
        info.current_text_value = Some(value.to_owned());
        info
    });
    response
}

/// The state of the match and its speed, as text.
fn status(playback: &Playback, clock: &CycleClock, scenario: Option<&Scenario>, is_over: bool) -> String {
    let mut parts = Vec::new();
    if let Some(scenario) = scenario {
        parts.push(format!("seed {}", scenario.seed));
    }
    parts.push(tenths(clock.end_time_s()));
    parts.push(match (is_over, playback.paused) {
        (true, _) => "over".to_owned(),
        (false, true) => "paused".to_owned(),
        (false, false) => format!("runs at {:.1}×", playback.achieved),
    });
    parts.join("   ")
}

fn show_help(mut contexts: EguiContexts, mut actions: MessageWriter<Action>) -> Result {
    /// The width of the list, and the height of the title and the button, logical pixels.
    const WIDTH: f32 = 1220.0;
    const AROUND: f32 = 110.0;

    let context = contexts.ctx_mut()?;
    let window = context.content_rect();
    // Between the bars, whose buttons stay in sight, over the other panels.
    let between = layout::between_bars(context).y_range();
    let (width, height) = (WIDTH.min(window.width() - 5.0 * MARGIN).max(100.0), (between.span() - AROUND).max(100.0));
    let lower = between.center() - window.center().y;
    panel("help", Align2::CENTER_CENTER, [0.0, lower]).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).inner_margin(Margin::same(18)).show(ui, |ui| {
            ui.set_width(width);
            ui.label(bright("Keys").size(text_size::TITLE).strong());
            ui.add_space(6.0);
            let keys = egui::ScrollArea::both().max_height(height).min_scrolled_height(height);
            keys.auto_shrink([false, true]).show(ui, show_keys);
            ui.add_space(6.0);
            if ui.button("Close").clicked() {
                actions.write(Action::Toggle(Switch::Help));
            }
        });
    });
    Ok(())
}

/// Shows the groups in as many columns as fit, of about the same length.
fn show_keys(ui: &mut egui::Ui) {
    /// The width of a column, logical pixels.
    const COLUMN: f32 = 285.0;
    const BESIDE: f32 = 20.0;

    let groups = key_bindings::help();
    let columns = (((ui.available_width() + BESIDE) / (COLUMN + BESIDE)) as usize).clamp(1, groups.len());
    let heights: Vec<usize> = groups.iter().map(|group| group.lines.len() + AROUND_GROUP).collect();
    ui.horizontal_top(|ui| {
        for column in in_columns(&heights, columns) {
            ui.vertical(|ui| groups[column].iter().for_each(|group| show_key_group(ui, group)));
            ui.add_space(BESIDE);
        }
    });
}

/// The lines for the name of a group and the gap after it.
const AROUND_GROUP: usize = 2;

/// Divides items of these heights into at most `columns` consecutive columns, so that the highest column is as low as
/// possible.
fn in_columns(heights: &[usize], columns: usize) -> Vec<Range<usize>> {
    let split = |most: usize| {
        let (mut split, mut begin, mut filled) = (Vec::new(), 0, 0);
        for (index, height) in heights.iter().enumerate() {
            if filled + height > most && index > begin {
                split.push(begin..index);
                (begin, filled) = (index, 0);
            }
            filled += height;
        }
        split.push(begin..heights.len());
        split
    };
    let whole: usize = heights.iter().sum();
    (whole / columns.max(1)..=whole).map(split).find(|split| split.len() <= columns.max(1)).unwrap_or_default()
}

fn show_key_group(ui: &mut egui::Ui, group: &HelpGroup) {
    ui.label(bright(group.name).size(text_size::IMPORTANT));
    egui::Grid::new(group.name).num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
        for (key, what) in &group.lines {
            ui.label(bright(*key));
            ui.label(dim(*what));
            ui.end_row();
        }
    });
    ui.add_space(8.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::theme::minutes;

    #[test]
    fn groups_fill_no_more_columns_than_there_are_and_these_evenly() {
        assert_eq!(in_columns(&[14, 10, 8, 12, 22, 8, 6], 3), [0..3, 3..5, 5..7]);
        assert_eq!(in_columns(&[3, 3], 5), [0..1, 1..2]);
        assert_eq!(in_columns(&[3, 9], 1).first(), Some(&(0..2)));
    }

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!([0.0, 59.99, 60.0, 605.2].map(minutes), ["0:00", "0:59", "1:00", "10:05"]);
        // The clock beside them is never a second ahead.
        assert_eq!([15.97, 16.0, 479.0 / 30.0, 480.0 / 30.0].map(tenths), ["15.9 s", "16.0 s", "15.9 s", "16.0 s"]);
        assert_eq!([479.0_f32 / 30.0, 1080.0 * (1.0 / 30.0)].map(minutes), ["0:15", "0:36"]);
    }
}
