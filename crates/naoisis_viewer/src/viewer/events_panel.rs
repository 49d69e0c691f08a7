//! The panel of penalties and events. A click on an event shows its moment, marks its position and explains the
//! decision of the referee.

use bevy::prelude::*;
use bevy_egui::egui::{self, RichText};
use bevy_egui::{EguiContexts, EguiPostUpdateSet, EguiPrimaryContextPass};

use super::camera::LookAt;
use super::commands::{FindEvent, TimelineCommand};
use super::display_settings::DisplaySettings;
use super::dock::{Dock, Edge, PanelSizes};
use super::event_details::{Wish, goal_reasons, show_circumstances};
use super::event_filter::{self, EventFilter, FoundMistakes, ListedEvents};
use super::event_log::{EventJump, EventLog, LogEntry, LogKind};
use super::lanes::{EventKind, Lanes};
use super::layout::LayoutSystems;
use super::overlays::{Brush, OverlaySystems};
use super::palette;
use super::shared::{Playback, shows_truth};
use super::theme::{dim, minutes, team_colour, text_size};
use super::timeline::Timeline;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sensing::belief::point_pitch_from_team;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// The height of a line of the list, and the least height of the list, logical pixels.
const LINE: f32 = 19.0;
const LEAST_HEIGHT: f32 = 48.0;
/// The width of the bar that is drawn over the right edge of the list, logical pixels.
const BESIDE_LIST: f32 = 10.0;
/// The panel.
const DOCK: Dock = Dock { name: "events", edge: Edge::Right, size: 260.0, least: 150.0, most_share: 0.35 };
/// How long before an event its replay starts, s.
const RUN_UP_S: f64 = 2.0;
/// How long before and after an event its place is marked, s.
const MARKED_S: f64 = 3.0;

/// Shows penalties and events.
pub struct EventsPanelPlugin;

impl Plugin for EventsPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ShownEvent>()
            .add_message::<EventChoice>()
            .add_systems(PreUpdate, forget_event.run_if(resource_exists_and_changed::<Scenario>))
            .add_systems(Update, choose_event)
            .add_systems(
                PostUpdate,
                mark_place.run_if(shows_truth).after(OverlaySystems).before(EguiPostUpdateSet::EndPass),
            )
            .add_systems(
                EguiPrimaryContextPass,
                show_events.run_if(|display: Res<DisplaySettings>| display.events).in_set(LayoutSystems::Events),
            );
    }
}

/// The selected event with its position, m, pitch frame.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct ShownEvent(pub Option<(LogEntry, Option<Vec2>)>);

/// Selects an event of the list, or deselects it.
#[derive(Message, Clone, PartialEq, Debug)]
pub struct EventChoice(pub LogEntry);

/// Deselects the event of another match.
fn forget_event(log: Res<EventLog>, mut shown: ResMut<ShownEvent>) {
    if shown.0.as_ref().is_some_and(|(entry, _)| !log.has(entry)) {
        shown.0 = None;
    }
}

fn choose_event(
    (mut choices, mut jumps): (MessageReader<EventChoice>, MessageReader<EventJump>),
    clock: Res<CycleClock>,
    mut playback: ResMut<Playback>,
    mut history: ResMut<History>,
    mut shown: ResMut<ShownEvent>,
    mut looks: MessageWriter<LookAt>,
    mut moments: MessageWriter<TimelineCommand>,
) {
    let chosen = choices.read().map(|EventChoice(entry)| (Some(entry), true));
    for (entry, is_chosen) in chosen.chain(jumps.read().map(|EventJump(entry)| (entry.as_ref(), false))) {
        let is_shown = is_chosen && shown.0.as_ref().is_some_and(|(other, _)| Some(other) == entry);
        let Some(entry) = entry.filter(|_| !is_shown) else {
            shown.0 = None;
            continue;
        };
        let place = entry.place.or_else(|| place_in_record(entry, &clock, &mut history));
        if let Some(place) = place {
            let record = history.record(entry.shown_cycle(clock.period_s)).ok().flatten();
            looks.write(view_of(place, entry, record.as_ref()));
        }
        shown.0 = Some((entry.clone(), place));
        moments.write(TimelineCommand::GoTo(entry.shown_cycle(clock.period_s)));
        playback.paused = true;
    }
}

/// The part of the pitch to look at for an event at a position, m. A mistake needs the ball in view, and where the robot believed it.
fn view_of(place: Vec2, entry: &LogEntry, record: Option<&CycleRecord>) -> LookAt {
    let Some(record) = record.filter(|_| entry.kind == LogKind::Mistake) else {
        return LookAt { place, reach_m: 0.0 };
    };
    let believed = entry.robot.and_then(|id| {
        let ball = record.robot(id)?.belief.as_ref()?.ball.as_ref()?;
        Some(point_pitch_from_team(ball.position_m, record.game.own_end(id.team)))
    });
    let ball = record.ball.map(|ball| ball.position_m.truncate());
    // Programs may believe anything.
    let points = || [Some(place), ball, believed].into_iter().flatten().filter(|point| point.is_finite());
    let [least, most] = [points().reduce(Vec2::min), points().reduce(Vec2::max)].map(|corner| corner.unwrap_or(place));
    let centre = (least + most) / 2.0;
    LookAt { place: centre, reach_m: centre.distance(most) }
}

/// The position of an event without one: that of its robot, or of the ball.
fn place_in_record(entry: &LogEntry, clock: &CycleClock, history: &mut History) -> Option<Vec2> {
    let record = history.record(entry.shown_cycle(clock.period_s)).ok()??;
    let robot = record.robots.iter().find(|robot| Some(robot.id) == entry.robot).map(|robot| robot.pose.position);
    robot.or(record.ball.map(|ball| ball.position_m.truncate()))
}

/// Marks the position of the event, and the robots and areas of the evidence, while a moment near it is shown.
fn mark_place(shown: Res<ShownEvent>, clock: Res<CycleClock>, time: Res<Time<Real>>, mut brush: Brush) {
    let Some((entry, place)) = &shown.0 else { return };
    if (clock.end_time_s() - entry.time_s).abs() > MARKED_S {
        return;
    }
    let colour = palette::ink(DrawColour::Yellow);
    if let Some(place) = *place {
        let breath = time.elapsed_secs().fract();
        for radius in [0.12, 0.15, 0.15 + 0.25 * breath] {
            brush.circle(place, radius, colour.with_alpha(1.0 - (radius - 0.12)));
        }
        brush.words(place + Vec2::Y * 0.2, entry.text.clone(), colour);
    }
    let Some(evidence) = &entry.evidence else { return };
    if let Some(ball) = evidence.ball_m {
        brush.circle(ball, 0.06, palette::ink(DrawColour::Orange));
    }
    for robot in &evidence.robots {
        brush.circle(robot.position_m, 0.2, palette::team(robot.robot.team));
        brush.words(robot.position_m, format!("{} then", robot.robot), palette::ink(DrawColour::White));
    }
}

fn show_events(
    mut contexts: EguiContexts,
    (log, found, listed): (Res<EventLog>, Res<FoundMistakes>, Res<ListedEvents>),
    mut filter: ResMut<EventFilter>,
    (mut lanes, mut events): (Option<ResMut<Lanes>>, MessageWriter<FindEvent>),
    shown: Res<ShownEvent>,
    clock: Res<CycleClock>,
    (timeline, roster, history): (Res<Timeline>, Res<Roster>, Res<History>),
    robots: Query<(&RobotId, &Penalty)>,
    mut choices: MessageWriter<EventChoice>,
    mut playback: ResMut<Playback>,
    mut sizes: ResMut<PanelSizes>,
    mut moments: MessageWriter<TimelineCommand>,
) -> Result {
    let mut penalties: Vec<_> = robots.iter().filter_map(|(id, penalty)| Some((*id, penalty.0?))).collect();
    penalties.sort_by_key(|(id, _)| *id);
    // In the past, later events are listed, too, so that the user can go to them.
    let now_s = clock.end_time_s();
    let entries = &listed.entries[..];
    let until_now = || entries.partition_point(|entry| entry.time_s <= now_s);
    let entries = if timeline.is_past() { entries } else { &entries[..until_now()] };
    let context = contexts.ctx_mut()?;
    // The panel is left out if the panels beside it need the space.
    if !DOCK.has_room(context, &sizes) {
        return Ok(());
    }
    let rest = |ui: &egui::Ui| ui.data(|data| data.get_temp::<f32>(egui::Id::new("rest of events"))).unwrap_or(0.0);
    DOCK.show(context, &mut sizes, |ui| {
        let height = (ui.available_height() - rest(ui)).max(LEAST_HEIGHT);
        let top = ui.cursor().top();
        let mut wanted = filter.clone();
        let is_used = event_filter::show(ui, &mut wanted, &listed, &roster, &mut events);
        if let Some(lanes) = lanes.as_mut().filter(|_| is_used) {
            lanes.kind = EventKind::Listed;
        }
        filter.set_if_neq(wanted);
        if entries.is_empty() {
            let is_reading = filter.has_mistakes() && lanes.as_ref().is_some_and(|lanes| lanes.is_reading());
            let nothing = match listed.hidden {
                _ if is_reading => "The match is being read…",
                0 => "No events yet.",
                _ if filter.only_costly => "No mistake in the ten seconds before a goal of the others.",
                _ => "No listed events: see Filter.",
            };
            ui.label(dim(nothing));
        }
        // A saved match goes on without its past, but with its score.
        if let Some(first) = history.cycles().map(|cycles| *cycles.start()).filter(|first| *first > 1) {
            let begin = minutes((first as f64 * clock.period_s) as f32);
            ui.add(egui::Label::new(dim(format!("The match is known from {begin} on."))).wrap());
        }
        for (id, penalty) in &penalties {
            let left_s = penalty.left_s(&clock);
            let text = format!("⛔ {id}: {}, {left_s:.0} s", penalty.reason.words());
            ui.label(RichText::new(text).color(team_colour(ui, id.team)));
        }
        let list = show_list(ui, entries, height, (now_s, clock.period_s), |ui, entry| {
            let chosen = shown.0.as_ref().is_some_and(|(other, _)| other == entry);
            if show_entry(ui, entry, chosen, is_to_come(entry, now_s, clock.period_s)) {
                choices.write(EventChoice(entry.clone()));
            }
        });
        if let Some((entry, _)) = &shown.0 {
            let before = goal_reasons(entry, &log, (lanes.as_deref_mut(), &found), &history);
            match show_circumstances(ui, entry, before.as_ref()) {
                Some(Wish::Replay) => {
                    let cycle = ((entry.time_s - RUN_UP_S).max(0.0) / clock.period_s) as u64;
                    moments.write(TimelineCommand::GoTo(cycle));
                    playback.paused = false;
                }
                Some(Wish::Show(other)) => _ = choices.write(EventChoice(other)),
                Some(Wish::Close) => _ = choices.write(EventChoice(entry.clone())),
                None => {}
            }
        }
        let others = ui.min_rect().bottom() - top - list;
        ui.data_mut(|data| data.insert_temp(egui::Id::new("rest of events"), others));
    });
    Ok(())
}

/// Shows all entries, the latest first, with a line between those until now and those to come. When an event passes,
/// the list scrolls to it, and when its height changes. Lines in sight stay where they are while events to come are added. Returns the height
/// of the list.
fn show_list(
    ui: &mut egui::Ui,
    log: &[LogEntry],
    height: f32,
    (now_s, period_s): (f64, f64),
    mut show: impl FnMut(&mut egui::Ui, &LogEntry),
) -> f32 {
    let id = ui.id().with("first and latest shown event");
    let (top, before, length, height_before): (f32, usize, usize, f32) =
        ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let line = LINE + ui.spacing().item_spacing.y;
    let to_come = log.len() - log.partition_point(|entry| !is_to_come(entry, now_s, period_s));
    let mut list = egui::ScrollArea::vertical()
        .max_height(height)
        .min_scrolled_height(height)
        .auto_shrink(false)
        .id_salt("events");
    let added = log.len().saturating_sub(length);
    let is_resized = (height - height_before).abs() > 1.0;
    if added > 0 && length > 0 && to_come == before + added && !is_resized {
        list = list.vertical_scroll_offset(top + added as f32 * line);
    } else if (to_come != before || is_resized)
        && let Some(top) = scrolled(to_come as f32 * line, line, top, height)
    {
        list = list.vertical_scroll_offset(top);
    }
    let output = list.show_rows(ui, LINE, log.len(), |ui, lines| {
        for index in lines {
            if index == to_come && index > 0 {
                let y = ui.cursor().top() - ui.spacing().item_spacing.y / 2.0;
                ui.painter().hline(ui.max_rect().x_range(), y, (1.0, ui.visuals().strong_text_color()));
            }
            show(ui, &log[log.len() - 1 - index]);
        }
    });
    ui.data_mut(|data| data.insert_temp(id, (output.state.offset.y, to_come, log.len(), height)));
    output.inner_rect.height()
}

/// Whether an entry is later than the moment at which it would be shown.
fn is_to_come(entry: &LogEntry, now_s: f64, period_s: f64) -> bool {
    entry.shown_cycle(period_s) as f64 * period_s > now_s + period_s / 2.0
}

/// Returns the new top of a list of this height that shows a line at `at` in its middle; `None` if the line is visible already.
fn scrolled(at: f32, line: f32, top: f32, height: f32) -> Option<f32> {
    let is_visible = at >= top && at + line <= top + height;
    (!is_visible).then(|| (at - height / 2.0).max(0.0))
}

/// Shows a line of the list. Returns whether it was clicked.
fn show_entry(ui: &mut egui::Ui, entry: &LogEntry, chosen: bool, is_to_come: bool) -> bool {
    ui.horizontal(|ui| {
        ui.set_height(LINE);
        ui.set_max_width(ui.available_width() - BESIDE_LIST);
        ui.label(dim(minutes(entry.time_s as f32)).monospace().size(text_size::SMALL));
        let colour = entry.side().map_or(ui.visuals().text_color(), |team| team_colour(ui, team));
        let text = RichText::new(&entry.text).color(colour);
        let text = if is_to_come { text.italics() } else { text };
        let text = match entry.important {
            true => text.strong().size(text_size::IMPORTANT),
            false => text.size(text_size::ENTRY),
        };
        let text = if chosen { text.underline() } else { text };
        let label = egui::Label::new(text).truncate().show_tooltip_when_elided(false).sense(egui::Sense::click());
        let response = ui.add(label).on_hover_cursor(egui::CursorIcon::PointingHand);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &entry.text));
        response.on_hover_text(format!("{}\nClick: show the moment, the place and the reason", entry.text)).clicked()
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::pitch::End;
    use naoisis_core::team::Team;
    use naoisis_sensing::belief::{BallBelief, Belief};
    use naoisis_sim::interface::cycle_record::{BallRecord, RobotRecord};

    #[test]
    fn all_events_are_listed_and_the_list_follows_the_moment() {
        let entry = |second: u32| LogEntry { time_s: f64::from(second), ..LogEntry::default() };
        let log: Vec<LogEntry> = (0..100).map(entry).collect();
        let context = egui::Context::default();
        let lines = |now_s, height| {
            let mut lines = Vec::new();
            // The heights of letters are known from the second frame on.
            for _ in 0..2 {
                lines.clear();
                let mut output = context.run_ui(egui::RawInput::default(), |ui| {
                    show_list(ui, &log, height, (now_s, 0.1), |ui, entry| {
                        show_entry(ui, entry, false, is_to_come(entry, now_s, 0.1));
                        lines.push(entry.time_s);
                    });
                });
                output.textures_delta.clear();
            }
            lines
        };
        // In a high list everything is visible, also what is to come at the start of a trace.
        assert_eq!(lines(0.0, 1e4).len(), 100);
        for now_s in [80.0, 3.0, 99.0, 0.0] {
            let shown = lines(now_s, 200.0);
            assert!(shown.len() < 15 && shown.contains(&now_s), "{now_s}: {shown:?}");
        }
    }

    #[test]
    fn lines_stay_in_place_while_later_events_are_added() {
        let entry = |second: u32| LogEntry { time_s: f64::from(second), ..LogEntry::default() };
        let log: Vec<LogEntry> = (0..100).map(entry).collect();
        let context = egui::Context::default();
        let first = |count: usize| {
            let mut first = None;
            for _ in 0..2 {
                first = None;
                let mut output = context.run_ui(egui::RawInput::default(), |ui| {
                    show_list(ui, &log[..count], 200.0, (40.0, 0.1), |ui, entry| {
                        show_entry(ui, entry, false, is_to_come(entry, 40.0, 0.1));
                        first.get_or_insert(entry.time_s);
                    });
                });
                output.textures_delta.clear();
            }
            first
        };
        let before = first(60);
        assert!(before.is_some_and(|second| second > 40.0), "{before:?}");
        assert_eq!([first(61), first(75), first(100)], [before; 3]);
    }

    #[test]
    fn a_mistake_is_shown_with_the_ball_and_where_the_robot_believed_it() {
        let robot = RobotId::new(Team::Blue, 2);
        let belief = Belief { ball: Some(BallBelief { position_m: Vec2::new(3.0, 0.0), ..default() }), ..default() };
        let mut record = CycleRecord {
            robots: vec![RobotRecord { belief: Some(belief), ..RobotRecord::new(robot) }],
            ball: Some(BallRecord { position_m: Vec3::new(-1.0, 2.0, 0.0), velocity_mps: Vec3::ZERO }),
            ..default()
        };
        record.game.blue_end = End::NegativeX;
        let entry = |kind| LogEntry { kind, robot: Some(robot), ..default() };
        let mistake = view_of(Vec2::ZERO, &entry(LogKind::Mistake), Some(&record));
        assert_eq!((mistake.place, mistake.reach_m), (Vec2::new(1.0, 1.0), 5.0_f32.sqrt()));
        let strange = BallBelief { position_m: Vec2::new(f32::NAN, 1e30), ..default() };
        let mut nowhere = record.clone();
        nowhere.robots[0].belief.as_mut().unwrap().ball = Some(strange);
        assert_eq!(view_of(Vec2::ZERO, &entry(LogKind::Mistake), Some(&nowhere)).place, Vec2::new(-0.5, 1.0));
        let kick = view_of(Vec2::X, &entry(LogKind::Kick), Some(&record));
        assert_eq!((kick.place, kick.reach_m), (Vec2::X, 0.0));
    }
}
