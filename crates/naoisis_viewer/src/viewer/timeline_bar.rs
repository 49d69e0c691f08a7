//! The timeline bar below the match: the current moment, marks of events, and branches.

use bevy::prelude::*;
use bevy_egui::egui::{self, Color32, Pos2, Rangef, Sense, Stroke, WidgetInfo};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::branches::{BranchCommand, Branches};
use super::commands::{Action, TimelineCommand};
use super::display_settings::Switch;
use super::ghosts::{Ghosts, GhostsOf};
use super::layout::{self, LayoutSystems};
use super::match_panel::TraceReading;
use super::shared::Playback;
use super::theme::{bright, dim, minutes, problem_colour, team_colour, text_size};
use super::time_axis::BEFORE;
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::{Mark, MarkKind};

/// The least width of the bar, and the width of the parts beside it, logical pixels.
const LEAST_WIDTH: f32 = 120.0;
const BESIDE_BAR: f32 = 510.0;
/// The height of the bar, and the margins at its ends, logical pixels.
const HEIGHT: f32 = 18.0;
const END: f32 = 6.0;

/// The height of the line of a branch, logical pixels.
const BRANCH_HEIGHT: f32 = 14.0;

/// Shows the bar.
pub struct TimelineBarPlugin;

impl Plugin for TimelineBarPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(EguiPrimaryContextPass, show_bar.in_set(LayoutSystems::TimelineBar));
    }
}

fn show_bar(
    mut contexts: EguiContexts,
    timeline: Res<Timeline>,
    history: Res<History>,
    clock: Res<CycleClock>,
    (branches, playback): (Res<Branches>, Res<Playback>),
    mut commands: MessageWriter<TimelineCommand>,
    (mut ways, mut ghosts): (MessageWriter<BranchCommand>, ResMut<Ghosts>),
    (mut actions, reading): (MessageWriter<Action>, Option<Res<TraceReading>>),
) -> Result {
    let Some(cycles) = history.cycles() else { return Ok(()) };
    let (first, end) = (*cycles.start(), *cycles.end());
    let now = timeline.cursor().unwrap_or(end as f64);
    // The bar is long enough for all branches, including those that went further.
    let last = branches.list().iter().map(|branch| branch.last_cycle).fold(end, u64::max);
    layout::bar_below(contexts.ctx_mut()?, "timeline", |ui| {
        let width = (ui.available_width() - BESIDE_BAR).max(LEAST_WIDTH);
        let bar = ui.horizontal(|ui| {
            let time = |cycle: f64| minutes((cycle * clock.period_s) as f32);
            let label = if timeline.is_past() { bright(time(now)) } else { dim(time(now)) };
            show_before_axis(ui, label);
            let (response, painter) = ui.allocate_painter(egui::vec2(width, HEIGHT), Sense::click_and_drag());
            response.widget_info(|| WidgetInfo::slider(true, now, "Timeline"));
            // The bar leaves room at both ends for the mark of the current moment.
            let rect = response.rect.shrink2(egui::vec2(END, 0.0));
            let x = |cycle: f64| rect.left() + share(cycle, first, last) * rect.width();
            let line = |from: f32, to: f32, stroke: Stroke| {
                painter.line_segment([Pos2::new(from, rect.center().y), Pos2::new(to, rect.center().y)], stroke);
            };
            line(rect.left(), x(end as f64), Stroke::new(3.0, ui.visuals().weak_text_color()));
            line(rect.left(), x(now), Stroke::new(3.0, ui.visuals().strong_text_color()));
            for mark in history.marks() {
                draw_mark(ui, &painter, mark, Pos2::new(x(mark.cycle as f64), rect.center().y));
            }
            painter.circle_filled(Pos2::new(x(now), rect.center().y), 6.0, ui.visuals().strong_text_color());
            let pointed = response.hover_pos().map(|at| cycle_at((at.x - rect.left()) / rect.width(), first, last));
            let wanted = response.interact_pointer_pos();
            if let Some(at) = wanted.filter(|_| response.dragged() || response.clicked()) {
                commands.write(TimelineCommand::GoTo(cycle_at((at.x - rect.left()) / rect.width(), first, last)));
            }
            if let Some(cycle) = pointed {
                response.on_hover_text_at_pointer(hint(cycle, history.marks(), last - first, &time(cycle as f64)));
            }
            // While a trace is being read, it goes on behind the end of the bar.
            let is_read = timeline.is_replay() && reading.is_some_and(|reading| reading.is_on());
            ui.label(dim(time(end as f64) + if is_read { "…" } else { "" }));
            if let Some(action) = show_buttons(ui, timeline.is_past(), playback.paused) {
                actions.write(action);
            }
            if !timeline.is_replay() {
                // The button is always there, so that the bar does not move under the mouse.
                let button = ui.add_enabled(timeline.is_past(), egui::Button::new("Present"));
                let button = button.on_hover_text("Back to the match as it is now (End)");
                if button.on_disabled_hover_text("This is the present (End)").clicked() {
                    commands.write(TimelineCommand::Present);
                }
            }
            rect.x_range()
        });
        if branches.list().len() > 1
            && let Some(command) =
                show_branches(ui, (&branches, *ghosts), end, bar.inner, |cycle| share(cycle as f64, first, last))
        {
            match command {
                Clicked::Branch(index) => drop(ways.write(BranchCommand::Show(index))),
                Clicked::Ghosts(index) => {
                    let of = Some(GhostsOf::Branch(index));
                    *ghosts = Ghosts { of: of.filter(|_| ghosts.of != of), ..default() };
                }
            }
        }
    });
    Ok(())
}

/// Shows the buttons behind the bar. Returns what was clicked.
fn show_buttons(ui: &mut egui::Ui, is_past: bool, is_paused: bool) -> Option<Action> {
    let hint = if is_paused {
        "F: starts a branch at this moment, paused until Space; the original match stays"
    } else {
        "F: starts a branch at this moment; the original match stays"
    };
    let branch = ui.add_enabled(is_past, egui::Button::new("Branch from here")).on_hover_text(hint);
    let branch = branch.on_disabled_hover_text("F: first go to a moment of the past; the present continues anyway");
    let hint = "T: plays on from this moment many times and counts the outcomes";
    let many_times = ui.button("Many times").on_hover_text(hint);
    let hint = "A: finds the moments that changed the chances to score most, and the mistakes there";
    let decided = ui.button("What decided it").on_hover_text(hint);
    let actions = [
        (branch, Action::PlayFromHere),
        (many_times, Action::Toggle(Switch::ManyTimes)),
        (decided, Action::Toggle(Switch::Decided)),
    ];
    actions.into_iter().find(|(button, _)| button.clicked()).map(|(_, action)| action)
}

/// Shows the time, as wide as the names of the lanes.
fn show_before_axis(ui: &mut egui::Ui, label: egui::RichText) {
    let width = BEFORE - END - ui.spacing().item_spacing.x;
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(egui::vec2(width, HEIGHT), layout, |ui| {
        ui.set_min_width(width);
        ui.add(egui::Label::new(label).extend());
    });
}

/// What was clicked in the tree.
enum Clicked {
    /// A branch, to show it.
    Branch(usize),
    /// A branch, to show or hide its ghosts.
    Ghosts(usize),
}

/// Shows the tree of branches, one line for each below the bar. Returns what was clicked.
fn show_branches(
    ui: &mut egui::Ui,
    (branches, ghosts): (&Branches, Ghosts),
    end: u64,
    bar: Rangef,
    share: impl Fn(u64) -> f32,
) -> Option<Clicked> {
    /// The width of the label, logical pixels.
    const WORD: f32 = 50.0;

    let mut clicked = None;
    let height = BRANCH_HEIGHT * branches.list().len() as f32;
    let (area, _) = ui.allocate_exact_size(egui::vec2(bar.max - ui.cursor().left(), height), Sense::hover());
    // The branches are below the bar, with its width.
    let area = egui::Rect::from_x_y_ranges(bar, area.y_range());
    let at = |index: usize, cycle: u64| {
        let y = area.top() + BRANCH_HEIGHT * (index as f32 + 0.5);
        Pos2::new(area.left() + share(cycle) * area.width(), y)
    };
    for (index, branch) in branches.list().iter().enumerate() {
        let is_shown = index == branches.shown();
        let last = if is_shown { end } else { branch.last_cycle };
        let begin = branch.from.map_or(0, |(_, cycle)| cycle);
        let colour = if is_shown { ui.visuals().strong_text_color() } else { ui.visuals().weak_text_color() };
        let stroke = Stroke::new(if is_shown { 3.0 } else { 2.0 }, colour);
        if let Some((from, cycle)) = branch.from {
            ui.painter().line_segment([at(from, cycle), at(index, cycle)], Stroke::new(1.0, colour));
        }
        ui.painter().line_segment([at(index, begin), at(index, last)], stroke);
        ui.painter().circle_filled(at(index, last), 3.0, colour);
        let row = egui::Rect::from_center_size(area.center(), egui::vec2(area.width(), BRANCH_HEIGHT))
            .translate(egui::vec2(0.0, at(index, 0).y - area.center().y));
        let response = ui.interact(row, ui.id().with(("branch", index)), Sense::click());
        let name = branch.name.clone();
        response.widget_info(|| WidgetInfo::selected(egui::WidgetType::RadioButton, true, is_shown, &name));
        // The name of the branch, to the right of the label of its ghosts.
        let font = egui::FontId::proportional(text_size::SMALL);
        let beside = row.right_center() + egui::vec2(END + WORD + 8.0, 0.0);
        let text = if is_shown { format!("{name} (shown)") } else { name.clone() };
        let written = ui.painter().text(beside, egui::Align2::LEFT_CENTER, &text, font, colour);
        let words = ui.interact(written, ui.id().with(("name of branch", index)), Sense::click());
        if response.on_hover_text(&name).clicked() || words.on_hover_text("Show it").clicked() {
            clicked = Some(Clicked::Branch(index));
        }
        if is_shown {
            continue;
        }
        let place = egui::Rect::from_min_size(row.right_top() + egui::vec2(END, 0.0), egui::vec2(WORD, BRANCH_HEIGHT));
        let response = ui.interact(place, ui.id().with(("ghosts", index)), Sense::click());
        let is_on = ghosts.of == Some(GhostsOf::Branch(index));
        let named = || WidgetInfo::selected(egui::WidgetType::Checkbox, true, is_on, format!("Ghosts of {name}"));
        response.widget_info(named);
        let strong = ui.visuals().strong_text_color();
        let colour = if is_on || response.hovered() { strong } else { ui.visuals().weak_text_color() };
        let disc = place.left_center() + egui::vec2(4.0, 0.0);
        if is_on {
            ui.painter().circle_filled(disc, 3.0, colour);
        } else {
            ui.painter().circle_stroke(disc, 3.0, Stroke::new(1.0, colour));
        }
        let font = egui::FontId::proportional(text_size::SMALL);
        let beside = disc + egui::vec2(7.0, 0.0);
        ui.painter().text(beside, egui::Align2::LEFT_CENTER, "ghosts", font, colour);
        if response
            .on_hover_text("Shows its robots and ball, translucent, at the same moment; Z: on a pitch of its own")
            .clicked()
        {
            clicked = Some(Clicked::Ghosts(index));
        }
    }
    clicked
}

/// Draws a mark: a disc for a goal, a triangle for a penalty, a short line for a ball that is out, a long one for the
/// start or end of a half.
fn draw_mark(ui: &egui::Ui, painter: &egui::Painter, mark: &Mark, at: Pos2) {
    let colour = mark.team.map_or(ui.visuals().text_color(), |team| team_colour(ui, team));
    let up = |height: f32| Pos2::new(at.x, at.y - height);
    match mark.kind {
        MarkKind::Goal => {
            painter.circle(at, 4.5, colour, Stroke::new(1.0, Color32::BLACK));
        }
        MarkKind::Whistle => {
            painter.line_segment([up(7.0), up(-7.0)], Stroke::new(1.0, ui.visuals().weak_text_color()));
        }
        MarkKind::Out => {
            painter.line_segment([up(4.0), up(-4.0)], Stroke::new(1.5, colour));
        }
        MarkKind::Penalty => {
            let points = vec![up(8.0) + egui::vec2(-4.0, 0.0), up(8.0) + egui::vec2(4.0, 0.0), up(2.0)];
            let edge = Stroke::new(1.0, problem_colour(ui));
            painter.add(egui::Shape::convex_polygon(points, colour, edge));
        }
    }
}

/// The position of a cycle in the bar, 0 to 1.
fn share(cycle: f64, first: u64, last: u64) -> f32 {
    let length = last.saturating_sub(first).max(1) as f64;
    ((cycle - first as f64) / length).clamp(0.0, 1.0) as f32
}

/// The cycle at a position of the bar.
fn cycle_at(share: f32, first: u64, last: u64) -> u64 {
    let length = last.saturating_sub(first) as f64;
    first + (f64::from(share.clamp(0.0, 1.0)) * length).round() as u64
}

/// The tooltip: the time under the mouse, and the events there.
fn hint(cycle: u64, marks: &[Mark], length: u64, time: &str) -> String {
    // About four pixels of the bar.
    let reach = length / 100;
    let near = marks.iter().filter(|mark| mark.cycle.abs_diff(cycle) <= reach);
    let near = near.min_by_key(|mark| (mark.cycle.abs_diff(cycle), mark.cycle));
    let Some(mark) = near else { return time.to_owned() };
    let what = match mark.kind {
        MarkKind::Goal => "goal",
        MarkKind::Out => "ball out",
        MarkKind::Penalty => "penalty",
        MarkKind::Whistle => "whistle",
    };
    let whose = mark.team.map_or(String::new(), |team| format!(", {team}"));
    format!("{time}   {what}{whose}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn a_place_in_the_bar_is_a_cycle_and_back() {
        assert_eq!([0.0, 0.5, 1.0, 2.0].map(|share| cycle_at(share, 10, 110)), [10, 60, 110, 110]);
        assert_eq!(share(60.0, 10, 110), 0.5);
        assert_eq!(share(0.0, 10, 110), 0.0);
        assert_eq!(share(0.0, 0, 0), 0.0, "a match that has just begun");
    }

    #[test]
    fn the_mark_next_to_the_mouse_is_named() {
        let mark = |cycle, kind, team| Mark { cycle, kind, team };
        let marks = [mark(100, MarkKind::Goal, Some(Team::Blue)), mark(108, MarkKind::Out, None)];
        assert_eq!(hint(102, &marks, 1000, "0:03"), "0:03   goal, blue");
        assert_eq!(hint(107, &marks, 1000, "0:03"), "0:03   ball out");
        assert_eq!(hint(300, &marks, 1000, "0:10"), "0:10");
    }
}
