//! The panel of the lanes.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{
    self, Align2, Color32, FontId, Pos2, Rect as Area, RichText, Sense, Stroke, WidgetInfo, WidgetType,
};

use super::looks::{WordLook, ball_colour, ball_words, condition_look, ink, show_legend, word_looks};
use super::mistake_list::{cycle_of, mistake_words};
use super::tracks::{Condition, LaneTrack, Span};
use super::{EventKind, Lanes};
use crate::viewer::commands::{Action, FindEvent, SelectionCommand, TimelineCommand};
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::dock::{Dock, Edge, PanelSizes};
use crate::viewer::event_filter::EventFilter;
use crate::viewer::event_log::LogKind;
use crate::viewer::shared::{Notice, Selection};
use crate::viewer::theme::{bright, count, dim, problem_colour, team_colour, text_size};
use crate::viewer::time_axis::{Axis, BEFORE, LEGEND, ShownPart, time_ticks, upright};
use crate::viewer::timeline::Timeline;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::MarkKind;
use naoisis_record::record::mistake_recorder::table;
use naoisis_record::record::mistakes::Mistake;

/// Heights of a lane, of the ball's bar in it, and of all lanes at least, logical pixels.
const LANE: f32 = 17.0;
const BALL: f32 = 4.0;
const LEAST: f32 = 2.0 * LANE;
/// The initial height of the other parts of the panel, logical pixels.
const AROUND: f32 = 100.0;
/// The height of the times below the lanes, and the least distance between two of them, logical pixels.
const TIMES: f32 = 14.0;
const BETWEEN_TIMES: f32 = 70.0;
/// The tolerance of a click on the triangle of a mistake, logical pixels.
const MISTAKE: f32 = 5.0;
/// The least width of a span with a word in it, logical pixels.
const WIDE_ENOUGH: f32 = 46.0;

pub(super) fn show(
    mut contexts: EguiContexts,
    mut lanes: ResMut<Lanes>,
    history: Res<History>,
    timeline: Res<Timeline>,
    clock: Res<CycleClock>,
    selection: Res<Selection>,
    mut moments: MessageWriter<TimelineCommand>,
    mut events: MessageWriter<FindEvent>,
    (mut actions, mut sizes, mut part): (MessageWriter<Action>, ResMut<PanelSizes>, ResMut<ShownPart>),
    mut notice: ResMut<Notice>,
    (mut filter, mut display): (ResMut<EventFilter>, ResMut<DisplaySettings>),
) -> Result {
    let Some(cycles) = history.cycles() else { return Ok(()) };
    let whole = [*cycles.start() as f64, (*cycles.end()).max(cycles.start() + 1) as f64];
    let now = timeline.cursor().unwrap_or(whole[1]);
    let size = LANE * lanes.tracks.robots().count() as f32 + AROUND;
    // In a low window, plots above the lanes need space, too.
    let most_share = if display.plots { 0.22 } else { 0.55 };
    let dock = Dock { name: "lanes", edge: Edge::Below, size, least: 110.0, most_share };
    let rest = |ui: &egui::Ui| ui.data(|data| data.get_temp::<f32>(egui::Id::new("rest of lanes"))).unwrap_or(AROUND);
    dock.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        let (width, top) = (ui.available_width(), ui.cursor().top());
        let height = (ui.available_height() - rest(ui)).max(LEAST);
        let in_view = (height / LANE) as usize;
        if show_head(ui, &mut lanes, in_view, &mut part, &mut events) {
            lanes.kind = EventKind::Listed;
            list_mistakes(&mut filter, &mut display);
        }
        if lanes.is_reading() {
            ui.label(dim("The match is being read…").size(text_size::SMALL));
        }
        let behind = if display.plots { LEGEND } else { 0.0 };
        let axis = Axis { part: part.0.unwrap_or(whole), left: BEFORE, width: (width - BEFORE - behind).max(40.0) };
        let rows = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            let looks = word_looks(lanes.tracks.words());
            let words = (lanes.tracks.words(), &looks[..]);
            for (id, track) in lanes.tracks.robots() {
                let mistakes = cycles_of_mistakes(&lanes, id, clock.period_s);
                let lane = show_lane(ui, (id, track, &mistakes), words, &axis, selection.0, &mut actions);
                mark_mistakes(ui, lane, mistakes.into_iter(), &axis);
            }
        });
        // Below the lanes is the legend, even if there is room for more of them.
        let bottom = rows.inner_rect.top() + LANE * lanes.tracks.robots().count() as f32;
        let area = rows.inner_rect.with_max_y(bottom.min(rows.inner_rect.bottom()));
        // From here on, positions are those of the whole window.
        let axis = Axis { left: area.left() + BEFORE, ..axis };
        let time_area = area.with_min_x(axis.left).with_max_x(axis.left + axis.width);
        mark_goals(ui, &history, &axis, time_area);
        upright(ui, axis.x(now), time_area, Stroke::new(1.5, ui.visuals().strong_text_color()));
        show_times(ui, &axis, clock.period_s, time_area);
        let response = ui.interact(time_area, ui.id().with("time"), Sense::click_and_drag());
        if let Some(changed) = axis.changed_part(ui, &response, whole) {
            *part = changed;
        }
        // The lane at a position, and the number of cycles that the triangle of a mistake covers on each side.
        let row = |at: Pos2| (at.y - rows.inner_rect.top()) / LANE + rows.state.offset.y / LANE;
        let reach = (axis.cycle(axis.left + MISTAKE) - axis.cycle(axis.left)).abs().ceil() as u64;
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            let cycle = axis.cycle(at.x).round().max(0.0) as u64;
            let mistake = mistake_at(&lanes, clock.period_s, cycle, row(at), reach);
            moments.write(TimelineCommand::GoTo(mistake.map_or(cycle, |mistake| cycle_of(mistake, clock.period_s))));
            if let Some(mistake) = mistake {
                actions.write(Action::Select(SelectionCommand::Robot(mistake.robot)));
                notice.tell(mistake_words(mistake));
            }
        }
        if let Some(at) = response.hover_pos() {
            let words = hint(&lanes, clock.period_s, axis.cycle(at.x).max(0.0) as u64, row(at), reach);
            response.on_hover_text_at_pointer(format!("{}{words}", axis.time_at(at.x, clock.period_s)));
        }
        show_legend(ui, lanes.tracks.words());
        let others = ui.min_rect().bottom() - top - rows.inner_rect.height();
        ui.data_mut(|data| data.insert_temp(egui::Id::new("rest of lanes"), others));
    });
    Ok(())
}

/// Opens the list of events with mistakes only.
fn list_mistakes(filter: &mut EventFilter, display: &mut DisplaySettings) {
    filter.list_only(LogKind::Mistake);
    display.events = true;
    // Another panel at the right may have taken its space.
    display.close_opened();
}

/// Shows how many lanes are in view, if not all are, and the choice of events to jump to. Returns whether a list of the mistakes is wanted.
fn show_head(
    ui: &mut egui::Ui,
    lanes: &mut Lanes,
    in_view: usize,
    part: &mut ShownPart,
    events: &mut MessageWriter<FindEvent>,
) -> bool {
    let mut wants_list = false;
    ui.horizontal(|ui| {
        ui.label(bright("Lanes"));
        let robots = lanes.tracks.robots().count();
        if in_view < robots {
            ui.label(dim(format!("{in_view} of {robots}, scroll for more")).size(text_size::SMALL));
        }
        ui.separator();
        let mut step = |ui: &mut egui::Ui, text: &str, name: &str, hint: &str, event: FindEvent| {
            let button = ui.button(text);
            button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
            if button.on_hover_text(hint).clicked() {
                events.write(event);
            }
        };
        step(ui, "<", "Previous event", "Previous event (,)", FindEvent::Previous);
        let mut kind = lanes.kind;
        let list = egui::ComboBox::from_id_salt("kind of event").selected_text(kind.name());
        let shown = list.show_ui(ui, |ui| {
            for (other, name) in EventKind::ALL {
                ui.selectable_value(&mut kind, other, name);
            }
        });
        shown.response.widget_info(|| WidgetInfo::labeled(WidgetType::ComboBox, true, "Kind of event"));
        shown.response.on_hover_text("Of the selected robot, if one is selected");
        step(ui, ">", "Next event", "Next event (.)", FindEvent::Next);
        lanes.kind = kind;
        let mistakes = lanes.tracks.mistakes();
        if !mistakes.is_empty() {
            ui.separator();
            let count = count(mistakes.len(), "mistake");
            let button = ui.button(RichText::new(count).color(problem_colour(ui)));
            button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "List mistakes"));
            let button = button.on_hover_ui(|ui| {
                ui.label("Click: the list of events with mistakes only; those before a goal stand out");
                let table = RichText::new(table(mistakes)).monospace().size(text_size::SMALL);
                ui.add(egui::Label::new(table).extend());
            });
            wants_list = button.clicked();
        }
        if part.0.is_some() && ui.button("Whole match").on_hover_text("Or a double click").clicked() {
            part.0 = None;
        }
    });
    wants_list
}

fn show_lane(
    ui: &mut egui::Ui,
    (id, track, mistakes): (RobotId, &LaneTrack, &[u64]),
    (words, looks): (&[String], &[WordLook]),
    axis: &Axis,
    selected: Option<RobotId>,
    actions: &mut MessageWriter<Action>,
) -> Area {
    ui.spacing_mut().item_spacing.y = 0.0;
    let (area, _) = ui.allocate_exact_size(egui::vec2(axis.left + axis.width, LANE), Sense::hover());
    let name_area = Area::from_min_size(area.min, egui::vec2(BEFORE, LANE));
    let name = ui.interact(name_area, ui.id().with(("lane", id.to_string())), Sense::click());
    name.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Lane of {id}")));
    let font = FontId::proportional(if selected == Some(id) { text_size::IMPORTANT } else { text_size::ENTRY });
    ui.painter().text(name_area.left_center(), Align2::LEFT_CENTER, id.to_string(), font, team_colour(ui, id.team));
    if name.clicked() {
        actions.write(Action::Select(SelectionCommand::Robot(id)));
    }
    let lane = Area::from_min_max(Pos2::new(area.left() + BEFORE, area.top() + 1.0), area.max - egui::vec2(0.0, 1.0));
    let painter = ui.painter().with_clip_rect(lane.intersect(ui.clip_rect()));
    let axis = Axis { left: lane.left(), ..*axis };
    let block = |first: u64, last: u64, top: f32, bottom: f32| {
        let right = axis.x(last as f64).max(axis.x(first as f64) + 1.0);
        Area::from_min_max(Pos2::new(axis.x(first as f64), top), Pos2::new(right, bottom))
    };
    let mut marks: Vec<f32> =
        track.kicks.iter().map(|(cycle, _)| cycle).chain(mistakes).map(|cycle| axis.x(*cycle as f64)).collect();
    marks.sort_by(f32::total_cmp);
    for span in shown(&track.intentions, &axis).filter(|span| !words[span.what].is_empty()) {
        let block = block(span.first, span.last, lane.top(), lane.bottom() - BALL);
        let look = looks[span.what];
        look.fill(&painter, block);
        let left = left_of_word(block.left() + 3.0, &marks);
        if block.right() - left > WIDE_ENOUGH - 3.0 {
            let font = FontId::proportional(10.0);
            painter.with_clip_rect(block.intersect(painter.clip_rect())).text(
                Pos2::new(left, block.center().y),
                Align2::LEFT_CENTER,
                &words[span.what],
                font,
                look.text(ui.visuals().panel_fill),
            );
        }
    }
    for span in shown(&track.ball, &axis) {
        let block = block(span.first, span.last, lane.bottom() - BALL, lane.bottom());
        painter.rect_filled(block, 0.0, ball_colour(span.what));
    }
    for span in shown(&track.conditions, &axis).filter(|span| span.what != Condition::Up) {
        let block = block(span.first, span.last, lane.top(), lane.bottom());
        condition_look(span.what).fill(&painter, block);
    }
    for (cycle, struck) in &track.kicks {
        let at = Pos2::new(axis.x(*cycle as f64), lane.center().y - 2.0);
        let stroke = Stroke::new(1.2, ui.visuals().strong_text_color());
        if *struck {
            // The edge separates it from a bright lane.
            painter.circle(at, 3.0, stroke.color, Stroke::new(0.8, Color32::BLACK));
        } else {
            painter.circle_stroke(at, 3.0, stroke);
        }
    }
    lane
}

/// The cycles in which the mistakes of a robot began.
fn cycles_of_mistakes(lanes: &Lanes, robot: RobotId, period_s: f64) -> Vec<u64> {
    let mistakes = lanes.tracks.mistakes().iter().filter(|mistake| mistake.robot == robot);
    mistakes.map(|mistake| cycle_of(mistake, period_s)).collect()
}

/// The left end of a word that begins at `left` unless there are marks: behind those that would cover its first letter. `marks` are in order.
fn left_of_word(left: f32, marks: &[f32]) -> f32 {
    /// The half width of a mark with a gap, and the width of a letter, logical pixels.
    const MARK: f32 = 4.5;
    const LETTER: f32 = 6.0;
    marks
        .iter()
        .fold(left, |left, mark| if (left - MARK..left + LETTER + MARK).contains(mark) { mark + MARK } else { left })
}

/// Draws a triangle at the upper edge of a lane for each mistake.
fn mark_mistakes(ui: &egui::Ui, lane: Area, cycles: impl Iterator<Item = u64>, axis: &Axis) {
    let painter = ui.painter().with_clip_rect(lane.intersect(ui.clip_rect()));
    let axis = Axis { left: lane.left(), ..*axis };
    for cycle in cycles {
        let tip = Pos2::new(axis.x(cycle as f64), lane.top() + 6.0);
        let corners = vec![tip, tip + egui::vec2(-3.5, -6.0), tip + egui::vec2(3.5, -6.0)];
        let edge = Stroke::new(0.8, Color32::BLACK);
        painter.add(egui::Shape::convex_polygon(corners, ink(DrawColour::Vermilion), edge));
    }
}

/// Draws a line over all lanes for each goal, in the colour of the team.
fn mark_goals(ui: &egui::Ui, history: &History, axis: &Axis, lanes: Area) {
    for mark in history.marks().iter().filter(|mark| mark.kind == MarkKind::Goal) {
        let colour = mark.team.map_or(Color32::GRAY, |team| team_colour(ui, team));
        upright(ui, axis.x(mark.cycle as f64), lanes, Stroke::new(1.5, colour));
    }
}

/// The spans in the visible part.
fn shown<'a, T>(spans: &'a [Span<T>], axis: &Axis) -> impl Iterator<Item = &'a Span<T>> {
    let [first, last] = axis.part;
    let from = spans.partition_point(|span| (span.last as f64) < first);
    spans[from..].iter().take_while(move |span| span.first as f64 <= last)
}

/// Shows ticks of time, and the times below the lanes.
fn show_times(ui: &mut egui::Ui, axis: &Axis, period_s: f64, lanes: Area) {
    let (below, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), TIMES), Sense::hover());
    let colour = ui.visuals().weak_text_color();
    let most = (lanes.width() / BETWEEN_TIMES) as usize;
    for (time_s, words) in time_ticks(axis.part.map(|cycle| cycle * period_s), most) {
        let x = axis.x(time_s / period_s);
        ui.painter().vline(x, lanes.y_range(), Stroke::new(0.5, colour.gamma_multiply(0.5)));
        ui.painter().vline(x, lanes.bottom()..=lanes.bottom() + 3.0, Stroke::new(1.0, colour));
        let words = ui.painter().layout_no_wrap(words, FontId::proportional(text_size::SMALL), colour);
        // The times at both ends stay on the panel.
        let left = (x - words.size().x / 2.0).min(below.right() - words.size().x);
        ui.painter().galley(Pos2::new(left, lanes.bottom() + 2.0), words, colour);
    }
}

/// The robot of a row, and its lane.
fn lane_at(lanes: &Lanes, row: f32) -> Option<(RobotId, &LaneTrack)> {
    (row >= 0.0).then(|| lanes.tracks.robots().nth(row as usize)).flatten()
}

/// Whether a mistake lasts in a cycle, or its triangle is near.
fn is_near(mistake: &Mistake, period_s: f64, cycle: u64, reach: u64) -> bool {
    let from = cycle_of(mistake, period_s);
    let until = from + ((mistake.until_s - mistake.from_s) / period_s) as u64;
    (from.saturating_sub(reach)..=until.max(from + reach)).contains(&cycle)
}

/// The mistake whose triangle is nearest to a position in a lane, if it is near.
fn mistake_at(lanes: &Lanes, period_s: f64, cycle: u64, row: f32, reach: u64) -> Option<&Mistake> {
    let (id, _) = lane_at(lanes, row)?;
    let distance = |mistake: &&Mistake| cycle_of(mistake, period_s).abs_diff(cycle);
    let of_robot = lanes.tracks.mistakes().iter().filter(|mistake| mistake.robot == id);
    of_robot.filter(|mistake| distance(mistake) <= reach).min_by_key(distance)
}

/// The tooltip at a position in a lane.
fn hint(lanes: &Lanes, period_s: f64, cycle: u64, row: f32, reach: u64) -> String {
    let Some((id, track)) = lane_at(lanes, row) else { return String::new() };
    fn at<T>(spans: &[Span<T>], cycle: u64) -> Option<&T> {
        spans.get(spans.partition_point(|span| span.last < cycle)).map(|span| &span.what)
    }
    let intention = at(&track.intentions, cycle).map(|word| lanes.tracks.words()[*word].as_str());
    let intention = intention.filter(|words| !words.is_empty()).unwrap_or("no intention");
    let ball = at(&track.ball, cycle).map(|source| ball_words(*source));
    let condition = match at(&track.conditions, cycle) {
        Some(Condition::Down) => "   down",
        Some(Condition::Penalised) => "   penalised",
        Some(Condition::Up) | None => "",
    };
    let mut words = format!("   {id}: {intention}{condition}   ball {}", ball.unwrap_or_default());
    let of_robot = lanes.tracks.mistakes().iter().filter(|mistake| mistake.robot == id);
    for mistake in of_robot.filter(|mistake| is_near(mistake, period_s, cycle, reach)) {
        words.push('\n');
        words.push_str(&mistake_words(mistake));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_begins_behind_the_marks_that_would_cover_its_first_letter() {
        assert_eq!(left_of_word(100.0, &[]), 100.0);
        assert_eq!(left_of_word(100.0, &[50.0, 120.0]), 100.0);
        // A kick at the beginning, and a mistake right behind it.
        assert_eq!(left_of_word(100.0, &[97.0, 108.0]), 112.5);
    }
}
