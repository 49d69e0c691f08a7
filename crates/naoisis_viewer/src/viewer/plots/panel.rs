//! The panel of the plots.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::containers::menu::{MenuButton, MenuConfig};
use bevy_egui::egui::{
    self, Align2, Color32, FontId, PopupCloseBehavior, Pos2, Rect as Area, RichText, Sense, Shape, Stroke, WidgetInfo,
    WidgetType,
};
use std::path::Path;

use super::catalogue::FieldList;
use super::chart::{Chart, Line, ink};
use super::export::{self, FileKind, clipped};
use super::field::{KnownField, Subject};
use super::series::Series;
use super::{Pin, PlotCommand, Plots, list};
use crate::viewer::commands::TimelineCommand;
use crate::viewer::dock::{Dock, Edge, PanelSizes};
use crate::viewer::shared::Notice;
use crate::viewer::theme::{bright, dim, minutes, team_colour, text_size};
use crate::viewer::time_axis::{Axis, BEFORE, LEGEND, ShownPart, upright};
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::MarkKind;
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sim::scenario::Scenario;

/// The panel.
const DOCK: Dock = Dock { name: "plots", edge: Edge::Below, size: 190.0, least: 110.0, most_share: 0.6 };
/// The least height of the panel without plots, logical pixels.
const EMPTY: f32 = 70.0;
/// The height of the curves, and of the time below them, logical pixels.
const CURVES: f32 = 92.0;
const TIME: f32 = 15.0;
/// The height of a line of the legend, logical pixels.
const ENTRY: f32 = 14.0;
/// The height of everything but the curves in a panel with one plot, logical pixels.
const AROUND: f32 = 90.0;
/// The height of labels of axes.
const LETTERS: f32 = 10.5;
/// The longest gap in cycles across which a curve is connected; a trace may contain only every few cycles.
const LONGEST_GAP: u64 = 15;

/// The resources that the panel shows and changes.
#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Shown<'w> {
    plots: Res<'w, Plots>,
    list: Res<'w, FieldList>,
    history: Res<'w, History>,
    timeline: Res<'w, Timeline>,
    clock: Res<'w, CycleClock>,
    roster: Res<'w, Roster>,
    scenario: Option<Res<'w, Scenario>>,
}

pub(super) fn show(
    mut contexts: EguiContexts,
    shown: Shown,
    mut part: ResMut<ShownPart>,
    mut sizes: ResMut<PanelSizes>,
    mut notice: ResMut<Notice>,
    mut moments: MessageWriter<TimelineCommand>,
    mut commands: MessageWriter<PlotCommand>,
) -> Result {
    let Some(cycles) = shown.history.cycles() else { return Ok(()) };
    let whole = [*cycles.start() as f64, (*cycles.end()).max(cycles.start() + 1) as f64];
    let now = shown.timeline.cursor().unwrap_or(whole[1]);
    // Without plots, it leaves the space to the match. The plot with the longest legend is shown whole.
    let most = shown.plots.pins.iter().map(|pin| pin.robots.len()).max();
    let dock = match most {
        None => Dock { least: EMPTY, most_share: 0.1, ..DOCK },
        Some(most) => Dock { size: DOCK.size.max(AROUND + curves_height(most)), ..DOCK },
    };
    dock.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        ui.horizontal(|ui| {
            ui.label(bright("Plots"));
            ui.separator();
            list::show(ui, &shown.list, &shown.plots, &mut commands);
            if part.0.is_some() && ui.button("Whole match").on_hover_text("Or a double click").clicked() {
                part.0 = None;
            }
        });
        if shown.plots.pins.is_empty() {
            let words = "Nothing is plotted yet: click on a value of the selected robot (I), or add a field.";
            ui.add(egui::Label::new(dim(words)).wrap());
        }
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for pin in &shown.plots.pins {
                let Some(known) = shown.list.find(&pin.field) else {
                    missing(ui, pin, &mut commands);
                    continue;
                };
                let axis = Axis {
                    part: part.0.unwrap_or(whole),
                    left: ui.cursor().left() + BEFORE,
                    width: (ui.available_width() - BEFORE - LEGEND).max(40.0),
                };
                let plot = Plot { pin, known, shown: &shown, now, axis };
                plot.show_head(ui, &mut commands, &mut notice);
                let response = plot.show_curves(ui);
                if let Some(changed) = axis.changed_part(ui, &response, whole) {
                    *part = changed;
                }
                if response.hovered() {
                    // On curves, the wheel zooms. Beside them, it scrolls the list of plots.
                    ui.input_mut(|input| input.smooth_scroll_delta.y = 0.0);
                }
                if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
                    moments.write(TimelineCommand::GoTo(axis.cycle(at.x).round().max(0.0) as u64));
                }
            }
        });
    });
    Ok(())
}

/// Shows a plotted field that no robot of this match has.
fn missing(ui: &mut egui::Ui, pin: &Pin, commands: &mut MessageWriter<PlotCommand>) {
    let path = pin.field.0.rsplit("::").next().unwrap_or(&pin.field.0);
    let (component, path) = path.split_once('/').unwrap_or((path, ""));
    let names: Vec<String> = path.split('.').map(str::to_owned).collect();
    ui.horizontal(|ui| {
        let what = format!("{}: {}", super::wording::component(component), super::wording::path(&names));
        ui.label(dim(format!("{what}: no robot in this match has it")).size(text_size::ENTRY));
        if ui.small_button("✖").on_hover_text("Remove the plot").clicked() {
            commands.write(PlotCommand::Remove(pin.field.clone()));
        }
    });
}

/// A plot that is being shown.
struct Plot<'a> {
    pin: &'a Pin,
    known: &'a KnownField,
    shown: &'a Shown<'a>,
    now: f64,
    axis: Axis,
}

impl Plot<'_> {
    /// The subjects with curves.
    fn subjects(&self) -> Vec<Subject> {
        if self.known.of_ball {
            return vec![Subject::Ball];
        }
        // Robots that are not in this match have no curve.
        let robots = self.pin.robots.iter().filter(|id| self.shown.roster.get(**id).is_some());
        robots.map(|id| Subject::Robot(*id)).collect()
    }

    fn series(&self, subject: Subject) -> Option<&Series> {
        self.shown.plots.series(&self.pin.field, subject)
    }

    /// The visible part, in `columns` columns.
    fn chart(&self, columns: usize) -> Chart {
        let curve = |subject| self.series(subject).map(|series| series.curve(self.axis.part, columns, LONGEST_GAP));
        let line = |subject: Subject| Line { name: subject.name(), pieces: curve(subject).unwrap_or_default() };
        Chart {
            title: self.known.full_name(),
            unit: self.known.unit.clone(),
            lines: self.subjects().into_iter().map(line).collect(),
            cycles: self.axis.part,
            period_s: self.shown.clock.period_s,
        }
    }

    /// Shows the title, the choice of robots, and the export.
    fn show_head(&self, ui: &mut egui::Ui, commands: &mut MessageWriter<PlotCommand>, notice: &mut Notice) {
        let chart = self.chart(1);
        let is_reading = self.shown.plots.is_reading(&self.pin.field);
        ui.horizontal(|ui| {
            ui.label(bright(chart.heading()).size(text_size::ENTRY));
            if self.subjects().is_empty() {
                ui.label(dim("none of its robots is in this match: choose others under Robots").size(text_size::SMALL));
            }
            if let Some(state) = self.shown.plots.state(&self.pin.field, &self.shown.clock) {
                ui.label(dim(state).size(text_size::SMALL));
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let named = |response: egui::Response, what: &str| {
                    let name = format!("{what} {}", chart.title);
                    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, &name));
                    response
                };
                if named(ui.small_button("✖"), "Remove").on_hover_text("Remove the plot").clicked() {
                    commands.write(PlotCommand::Remove(self.pin.field.clone()));
                }
                for kind in FileKind::ALL.into_iter().rev() {
                    let button = ui.add_enabled(!is_reading, egui::Button::new(kind.name()).small());
                    let button = named(button, kind.name()).on_disabled_hover_text("The match is still being read");
                    if button.on_hover_text("Saves the visible part in the current folder").clicked() {
                        notice.tell(self.save(kind));
                    }
                }
                if !self.known.of_ball {
                    let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
                    let menu = MenuButton::new(RichText::new("Robots").size(text_size::SMALL)).config(stays);
                    let (button, _) = menu.ui(ui, |ui| self.choose_robots(ui, commands));
                    named(button, "Robots of").on_hover_text("Robots with a curve");
                }
            });
        });
    }

    fn choose_robots(&self, ui: &mut egui::Ui, commands: &mut MessageWriter<PlotCommand>) {
        let ids: Vec<RobotId> = self.shown.roster.iter().map(|(id, _)| id).collect();
        for id in &ids {
            let mut is_on = self.pin.robots.contains(id);
            let words = RichText::new(id.to_string()).color(team_colour(ui, id.team));
            if ui.checkbox(&mut is_on, words).clicked() {
                commands.write(PlotCommand::Toggle(self.pin.field.clone(), Some(*id)));
            }
        }
        if ui.button("All of them").clicked() {
            for id in ids.iter().filter(|id| !self.pin.robots.contains(id)) {
                commands.write(PlotCommand::Toggle(self.pin.field.clone(), Some(*id)));
            }
        }
    }

    /// Exports the plot. Returns a notice for the user.
    fn save(&self, kind: FileKind) -> String {
        let empty = Series::default();
        let whole = self.subjects().into_iter();
        let whole: Vec<(String, &Series)> =
            whole.map(|subject| (subject.name(), self.series(subject).unwrap_or(&empty))).collect();
        let name = self.shown.scenario.as_ref().map_or("match", |scenario| scenario.name.as_str());
        let seed = self.shown.scenario.as_ref().map_or(0, |scenario| scenario.seed);
        let name = format!("{}-seed{seed}", if name.is_empty() { "match" } else { name });
        match export::save(Path::new(""), &name, &self.chart(export::columns()), &whole, kind) {
            Ok(path) => format!("Saved as {}", path.display()),
            Err(error) => format!("The plot was not saved: {error}"),
        }
    }

    /// Shows the curves with axes and legend. Returns the input of the mouse.
    fn show_curves(&self, ui: &mut egui::Ui) -> egui::Response {
        let subjects = self.subjects();
        let height = curves_height(subjects.len());
        let size = egui::vec2(BEFORE + self.axis.width + LEGEND, height + TIME + 4.0);
        let (area, _) = ui.allocate_exact_size(size, Sense::hover());
        let corner = Pos2::new(self.axis.left, area.top() + 3.0);
        let curves = Area::from_min_size(corner, egui::vec2(self.axis.width, height));
        let response = ui.interact(curves, ui.id().with(("curves", &self.pin.field)), Sense::click_and_drag());
        if !ui.is_rect_visible(area) {
            return response;
        }
        let chart = self.chart(curves.width() as usize);
        let [low, high] = self.draw_axes(ui, &chart, curves);
        let y = |value: f64| curves.bottom() - ((value - low) / (high - low)) as f32 * curves.height();
        let painter = ui.painter().with_clip_rect(curves.expand(1.0).intersect(ui.clip_rect()));
        let is_dark = ui.visuals().dark_mode;
        for (index, line) in chart.lines.iter().enumerate() {
            let (colour, is_dashed) = ink(index, is_dark);
            let stroke = Stroke::new(1.4, rgb(colour));
            for piece in &line.pieces {
                let points: Vec<Pos2> = clipped(piece, self.axis.part)
                    .map(|[cycle, value]| Pos2::new(self.axis.x(cycle), y(value + chart.shift(index))))
                    .collect();
                match points.as_slice() {
                    [point] => drop(painter.circle_filled(*point, 1.5, stroke.color)),
                    _ if is_dashed => painter.extend(Shape::dashed_line(&points, stroke, 6.0, 4.0)),
                    _ => drop(painter.add(Shape::line(points, stroke))),
                }
            }
        }
        for mark in self.shown.history.marks().iter().filter(|mark| mark.kind == MarkKind::Goal) {
            let colour = mark.team.map_or(Color32::GRAY, |team| team_colour(ui, team));
            upright(ui, self.axis.x(mark.cycle as f64), curves, Stroke::new(1.0, colour.gamma_multiply(0.7)));
        }
        upright(ui, self.axis.x(self.now), curves, Stroke::new(1.5, ui.visuals().strong_text_color()));
        let pointed = response.hover_pos().map(|at| self.axis.cycle(at.x));
        if let Some(cycle) = pointed {
            upright(ui, self.axis.x(cycle), curves, Stroke::new(1.0, ui.visuals().weak_text_color()));
        }
        self.show_legend(ui, &chart, &subjects, curves, pointed.unwrap_or(self.now).round().max(0.0) as u64);
        response
    }

    /// Draws ticks with labels. Returns the range of values.
    fn draw_axes(&self, ui: &egui::Ui, chart: &Chart, curves: Area) -> [f64; 2] {
        /// The space that a tick needs, logical pixels.
        const EACH: [f32; 2] = [80.0, 20.0];
        let values = chart.value_ticks((curves.height() / EACH[1]) as usize);
        let times = chart.time_ticks((curves.width() / EACH[0]) as usize);
        let [low, high] = values.range;
        let (font, weak) = (FontId::proportional(LETTERS), ui.visuals().weak_text_color());
        let grid = Stroke::new(0.5, weak.gamma_multiply(0.5));
        for (value, words) in &values.at {
            let y = curves.bottom() - ((value - low) / (high - low)) as f32 * curves.height();
            ui.painter().hline(curves.x_range(), y, grid);
            // Long texts begin at the edge of the panel.
            let galley = ui.painter().layout_no_wrap(words.clone(), font.clone(), weak);
            let left = (curves.left() - 5.0 - galley.size().x).max(curves.left() - BEFORE);
            ui.painter().galley(Pos2::new(left, y - galley.size().y / 2.0), galley, weak);
        }
        for (time_s, words) in &times.at {
            let x = self.axis.x(time_s / chart.period_s);
            ui.painter().vline(x, curves.y_range(), grid);
            // At the corner, the time would run into the lowest value.
            let galley = ui.painter().layout_no_wrap(words.clone(), font.clone(), weak);
            let left = (x - galley.size().x / 2.0).max(curves.left());
            ui.painter().galley(Pos2::new(left, curves.bottom() + 2.0), galley, weak);
        }
        values.range
    }

    /// Shows the legend, with values at the mouse or at the moment that is shown.
    fn show_legend(&self, ui: &egui::Ui, chart: &Chart, subjects: &[Subject], curves: Area, cycle: u64) {
        let left = curves.right() + 10.0;
        let visuals = ui.visuals();
        let time = minutes((cycle as f64 * chart.period_s) as f32);
        let mut at = Pos2::new(left, curves.top() + ENTRY / 2.0);
        let font = FontId::proportional(text_size::SMALL);
        ui.painter().text(at, Align2::LEFT_CENTER, format!("at {time}"), font.clone(), visuals.weak_text_color());
        for (index, subject) in subjects.iter().enumerate() {
            at.y += ENTRY;
            let (colour, is_dashed) = ink(index, visuals.dark_mode);
            let ends = [at, at + egui::vec2(14.0, 0.0)];
            let stroke = Stroke::new(2.5, rgb(colour));
            if is_dashed {
                ui.painter().extend(Shape::dashed_line(&ends, stroke, 4.0, 2.5));
            } else {
                ui.painter().line_segment(ends, stroke);
            }
            let value = self.series(*subject).and_then(|series| series.value_about(cycle, LONGEST_GAP));
            let value = value.map_or("—".to_owned(), |value| chart.value_words(value));
            let words = format!("{}  {value}", subject.name());
            let beside = at + egui::vec2(19.0, 0.0);
            ui.painter().text(beside, Align2::LEFT_CENTER, words, font.clone(), visuals.text_color());
        }
    }
}

/// The height of a plot with a number of curves, without its time axis, logical pixels: the legend is beside it.
fn curves_height(count: usize) -> f32 {
    CURVES.max(ENTRY * (count + 1) as f32)
}

fn rgb(Colour([red, green, blue]): Colour) -> Color32 {
    Color32::from_rgb(red, green, blue)
}
