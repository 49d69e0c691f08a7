//! The panel of the selected robot: what it sees, hears, wants and believes.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{self, CollapsingHeader, Grid, RichText};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

mod false_ones;
mod last_kick;
mod pictures;
mod pins;
mod unrecognised;
mod wall;
mod why;
mod wording;

use super::camera_images::{CameraImagesSystems, Watched};
use super::commands::{Action, SelectionCommand, TimelineCommand, ViewPreset};
use super::cycle_samples::CycleSamples;
use super::display_settings::{DisplaySettings, Switch};
use super::dock::{Dock, Edge, PanelSizes};
use super::event_log::EventLog;
use super::keyframes::Keyframes;
use super::layout::LayoutSystems;
use super::plots::catalogue::FieldList;
use super::plots::wording::component as component_words;
use super::plots::{PlotCommand, Plots};
use super::rebuild::ShownState;
use super::shared::{DRIVEN, Playback, Selection};
use super::theme::{band, bright, count, dim, minutes, problem_colour, text_size};
use super::timeline::Timeline;
use super::unrecognised::ShownUnrecognised;
use false_ones::Objects;
use naoisis_core::ball::Ball;
use naoisis_core::camera_model::CameraName;
use naoisis_core::communication::{Inbox, TeamMessage};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::belief::error::BeliefError;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::cycle_record::RobotRecord;
use naoisis_sim::interface::gather::CurrentRecord;
use naoisis_sim::scenario::{BehaviourSpec, Scenario};
use pictures::Pictures;
use pins::Pins;
use why::{show_kick, show_reasons};

/// The panel.
const DOCK: Dock = Dock { name: "robot", edge: Edge::Left, size: 350.0, least: 220.0, most_share: 0.4 };

/// Shows the panel of the selected robot.
pub struct RobotPanelPlugin;

impl Plugin for RobotPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Pictures>()
            .init_resource::<Opened>()
            .add_systems(
                Update,
                (watch_cameras.before(CameraImagesSystems), pictures::update_pictures.after(CameraImagesSystems)),
            )
            .add_systems(
                EguiPrimaryContextPass,
                (
                    pictures::draw_in_window.in_set(LayoutSystems::Behind),
                    show_robot.run_if(|display: Res<DisplaySettings>| display.robot).in_set(LayoutSystems::Robot),
                    wall::show_wall
                        .run_if(|display: Res<DisplaySettings>| display.cameras)
                        .in_set(LayoutSystems::Right),
                ),
            );
    }
}

/// The width of a window from which on it has room for this panel and one at the right, logical pixels.
const ROOM_FOR_TWO: f32 = 900.0;

/// Which sections with images are open.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug)]
struct Opened {
    cameras: bool,
}

impl Default for Opened {
    fn default() -> Self {
        Self { cameras: true }
    }
}

/// Watches the cameras whose images are shown.
fn watch_cameras(
    display: Res<DisplaySettings>,
    opened: Res<Opened>,
    selection: Res<Selection>,
    roster: Res<Roster>,
    robots: Query<&CameraSettings>,
    mut watched: ResMut<Watched>,
) {
    let selected = selection.0.filter(|_| display.robot && opened.cameras);
    let all = roster.iter().map(|(id, _)| id).filter(|_| display.cameras);
    let cameras_of = |id: RobotId| {
        let settings = roster.get(id).and_then(|robot| robots.get(robot).ok());
        settings.into_iter().flat_map(move |settings| settings.mounts.names().map(move |camera| (id, camera)))
    };
    let cameras = all.chain(selected).flat_map(cameras_of).collect();
    if watched.cameras != cameras {
        watched.cameras = cameras;
    }
}

/// The values of a robot that are shown.
#[derive(QueryData)]
struct ShownRobot {
    pose: &'static Pose,
    velocity: &'static Velocity,
    posture: &'static Posture,
    penalty: &'static Penalty,
    head: &'static HeadAngles,
    odometry: &'static Odometry,
    sonar: &'static SonarReading,
    sonar_settings: &'static SonarSettings,
    cameras: &'static CameraSettings,
    percepts: &'static Percepts,
    inbox: &'static Inbox,
    belief: Option<&'static Belief>,
}

/// What the sections show besides the components of the robot, and what clicks in them change.
#[derive(SystemParam)]
struct Shown<'w, 's> {
    clock: Res<'w, CycleClock>,
    game: Res<'w, Game>,
    log: Res<'w, EventLog>,
    roster: Res<'w, Roster>,
    scenario: Option<Res<'w, Scenario>>,
    pitch: Res<'w, Pitch>,
    balls: Query<'w, 's, (), With<Ball>>,
    current: Res<'w, CurrentRecord>,
    samples: Res<'w, CycleSamples>,
    state: Res<'w, ShownState>,
    pictures: Res<'w, Pictures>,
    missed: Res<'w, ShownUnrecognised>,
    history: ResMut<'w, History>,
    keyframes: Res<'w, Keyframes>,
    timeline: Res<'w, Timeline>,
    last_kick: Local<'s, last_kick::Found>,
    playback: ResMut<'w, Playback>,
    moments: MessageWriter<'w, TimelineCommand>,
    actions: MessageWriter<'w, Action>,
}

fn show_robot(
    mut contexts: EguiContexts,
    selection: Res<Selection>,
    robots: Query<ShownRobot>,
    display: Res<DisplaySettings>,
    (mut opened, mut shown_cycle): (ResMut<Opened>, Local<u64>),
    mut sizes: ResMut<PanelSizes>,
    (plots, fields, mut commands): (Res<Plots>, Res<FieldList>, MessageWriter<PlotCommand>),
    mut shown: Shown,
) -> Result {
    let Some(id) = selection.0 else { return Ok(()) };
    let Some(robot) = shown.roster.get(id).and_then(|robot| robots.get(robot).ok()) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let cycle = shown.clock.cycle;
    // Tables have the heights of their last rows: those of another moment would lie over each other, until the next frame.
    if shown.playback.paused && (*shown_cycle != cycle || shown.state.is_changed() || shown.missed.is_changed()) {
        context.request_discard("values of another moment");
    }
    *shown_cycle = cycle;
    // A narrow window has no room for both.
    if display.has_panel_at_right() && context.content_rect().width() < ROOM_FOR_TWO {
        return Ok(());
    }
    DOCK.show(context, &mut sizes, |ui| {
        /// The width of the scroll bar, logical pixels.
        const BAR: f32 = 8.0;
        let width = (ui.available_width() - BAR).max(BAR);
        shown.show_head(ui, id, &robot);
        let mut pins = Pins { robot: id, plots: &plots, fields: &fields, commands: &mut commands };
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.set_max_width(width);
            let cameras = section(ui, "Cameras", true, |ui| shown.show_cameras(ui, id, &robot));
            opened.set_if_neq(Opened { cameras });
            let record = shown.current.record.robot(id);
            section(ui, "Senses", true, |ui| show_senses(ui, &robot, record, &mut pins));
            section(ui, "Commands", true, |ui| match record.and_then(|record| record.command.as_ref()) {
                Some(command) => lines(ui, "commands", wording::commands(command, shown.clock.period()), &mut pins),
                None => drop(ui.label(dim("Not known for this cycle."))),
            });
            let error = shown.samples.robot(cycle, id).and_then(|sample| sample.error.as_ref());
            let own_end = shown.game.own_end(id.team);
            section(ui, "Belief", true, |ui| show_belief(ui, robot.belief, error, own_end, &mut pins));
            section(ui, "Why", true, |ui| shown.show_why(ui, id, &robot));
            let command = shown.current.record.robot(id).and_then(|record| record.command.as_ref());
            let said = command.and_then(|command| command.say.as_ref());
            section(ui, "Messages", false, |ui| show_messages(ui, said, &robot.inbox.0, cycle));
            section(ui, "Behaviour", false, |ui| show_state(ui, &shown.state, &mut pins));
            let hint = "Plots: a click on a value plots it over the match, Q shows them";
            ui.add(egui::Label::new(dim(hint).size(text_size::SMALL)).wrap());
        });
    });
    Ok(())
}

impl Shown<'_, '_> {
    /// What the robot does, in the words of its behaviour; `None` if it says nothing.
    fn intention(&self, id: RobotId) -> Option<&str> {
        self.current.record.robot(id)?.intention().filter(|intention| !intention.is_empty())
    }

    fn show_head(&mut self, ui: &mut egui::Ui, id: RobotId, robot: &ShownRobotItem) {
        let behaviour = match &self.state.0 {
            Ok(state) => state.name.as_deref(),
            Err(_) => self.scenario.as_deref().and_then(|scenario| behaviour_in(scenario, id)),
        };
        // The current intention may differ from what the name of the behaviour says.
        let behaviour = behaviour.unwrap_or("no behaviour");
        let words = match self.intention(id) {
            Some(intention) => format!("{behaviour}: {intention}"),
            None => behaviour.to_owned(),
        };
        ui.horizontal(|ui| {
            band(ui, id.team, egui::vec2(12.0, 18.0));
            ui.label(bright(id.to_string()).size(text_size::TITLE));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.small_button("✖").on_hover_text("No robot (Esc)").clicked() {
                    self.actions.write(Action::Select(SelectionCommand::Nobody));
                }
                if ui.small_button("Overlays").on_hover_text("Drawings on the pitch (O)").clicked() {
                    self.actions.write(Action::Toggle(Switch::Overlays));
                }
                // In a narrow panel, the words end before the buttons.
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(egui::Label::new(dim(words).size(text_size::IMPORTANT)).truncate());
                });
            });
        });
        let condition = wording::condition(robot.posture, robot.penalty, &self.clock);
        ui.label(dim(format!("{}   {}", wording::pose(*robot.pose), condition)).size(text_size::ENTRY));
        if let Some(lost_s) = self.log.lost_program(id, self.clock.end_time_s()) {
            let words = format!("its program ended at {}: R starts it again", minutes(lost_s as f32));
            ui.label(RichText::new(words).color(problem_colour(ui)).size(text_size::ENTRY));
        }
    }

    /// Shows the images of the robot's cameras, what was recognised in them, and what was not.
    fn show_cameras(&mut self, ui: &mut egui::Ui, id: RobotId, robot: &ShownRobotItem) {
        let there = Objects::there(self.balls.iter().count(), &self.pitch, &self.roster);
        if let Some(camera) = show_images(ui, id, robot, &self.pictures, &self.missed, there) {
            self.actions.write(Action::View(ViewPreset::RobotCamera(camera)));
        }
        if self.clock.cycle > 0 && !robot.penalty.is_off_pitch() {
            unrecognised::show(ui, &self.missed.0, self.game.own_end(id.team), self.playback.paused);
        }
    }

    /// Shows the reasons of the robot's decision, and its last kick.
    fn show_why(&mut self, ui: &mut egui::Ui, id: RobotId, robot: &ShownRobotItem) {
        let cycle = self.clock.cycle;
        if self.intention(id) == Some(DRIVEN) {
            ui.label(dim("Driven by hand: not as its behaviour decides.").size(text_size::ENTRY));
        }
        show_reasons(ui, &self.state, (cycle, self.timeline.is_past(), robot.penalty.is_active()));
        if let Some(words) = last_kick::refused_now(&self.current.record, id) {
            ui.add(egui::Label::new(RichText::new(words).size(text_size::ENTRY)).wrap());
        }
        let history = self.history.bypass_change_detection();
        let kick = self.last_kick.last_kick((id, cycle), history, &self.keyframes, &self.game);
        if let Some(wanted) = kick.and_then(|kick| show_kick(ui, kick, &self.clock)) {
            self.moments.write(TimelineCommand::GoTo(wanted));
            self.playback.paused = true;
        }
    }
}

/// Shows the belief of a robot, with its errors.
fn show_belief(ui: &mut egui::Ui, belief: Option<&Belief>, error: Option<&BeliefError>, own_end: End, pins: &mut Pins) {
    let Some(belief) = belief else {
        ui.label(dim("This robot has no belief."));
        return;
    };
    lines(ui, "belief", wording::belief(belief, error, own_end), pins);
    if error.is_some() {
        let hint = "Errors are those at the time of its images, before it moved in this cycle.";
        ui.add(egui::Label::new(dim(hint).size(text_size::SMALL)).wrap());
    }
}

/// Shows a section that can be closed. Returns whether it is open.
fn section(ui: &mut egui::Ui, name: &str, open: bool, show: impl FnOnce(&mut egui::Ui)) -> bool {
    let id = ui.id().with((name, "was open"));
    let header = CollapsingHeader::new(bright(name).size(text_size::IMPORTANT)).default_open(open);
    let is_open = header.show(ui, show).openness > 0.0;
    let was_open = ui.data_mut(|data| data.get_temp(id).unwrap_or(false));
    if is_open != was_open {
        ui.data_mut(|data| data.insert_temp(id, is_open));
        // Its tables have the heights of the rows that they had when it was closed.
        ui.ctx().request_discard("a section was opened or closed");
    }
    is_open
}

/// Shows lines with a name and a value.
fn lines(ui: &mut egui::Ui, name: &str, lines: Vec<(String, String)>, pins: &mut Pins) {
    Grid::new(name).num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
        let mut before: Option<String> = None;
        for (line, value) in lines {
            ui.label(dim(&line).size(text_size::ENTRY));
            let shown = ui.add(egui::Label::new(RichText::new(value).size(text_size::ENTRY)).wrap());
            pins.offer(shown, name, &line, before.as_deref());
            ui.end_row();
            before = Some(line);
        }
    });
}

/// Shows the images of the robot's cameras and what was recognised in them. Returns the camera that was clicked.
fn show_images(
    ui: &mut egui::Ui,
    id: RobotId,
    robot: &ShownRobotItem,
    pictures: &Pictures,
    missed: &ShownUnrecognised,
    there: Objects,
) -> Option<CameraName> {
    // The percepts and images are those from before its penalty.
    let percepts = (!robot.penalty.is_off_pitch()).then_some(robot.percepts);
    let mut clicked = None;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let names: Vec<CameraName> = robot.cameras.mounts.names().collect();
        // The section is narrower than the panel.
        let width = ui.available_width();
        let each = if names.len() == 1 { width } else { (width - 4.0) / names.len().max(2) as f32 };
        for name in names {
            let image = pictures.show(ui, (id, name), percepts, each);
            if image.on_hover_text(format!("{name}: click to look through it")).clicked() {
                clicked = Some(name);
            }
        }
    });
    let seen = percepts.map_or("off the pitch: it sees nothing".to_owned(), |percepts| {
        let missed = missed.0.as_deref().unwrap_or_default();
        wording::percepts(percepts, Objects::false_ones(percepts, missed, there))
    });
    ui.label(dim(seen).size(text_size::SMALL));
    clicked
}

fn show_senses(ui: &mut egui::Ui, robot: &ShownRobotItem, record: Option<&RobotRecord>, pins: &mut Pins) {
    let mut senses = vec![
        ("Sonar", wording::sonar(*robot.sonar, robot.sonar_settings.fitted)),
        ("Head", wording::head(robot.head.yaw, robot.head.pitch)),
        ("Odometry", wording::pose(robot.odometry.0)),
        ("True motion", wording::velocity(*robot.velocity)),
    ];
    senses.extend(record.and_then(|record| record.body).map(|body| ("Body", wording::body(body))));
    senses.extend(record.and_then(|record| record.game.as_ref()).map(|told| ("Game status", wording::told(told))));
    lines(ui, "senses", senses.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(), pins);
}

fn show_messages(
    ui: &mut egui::Ui,
    said: Option<&TeamMessage>,
    inbox: &[naoisis_core::communication::ReceivedMessage],
    cycle: u64,
) {
    ui.label(dim("says").size(text_size::SMALL));
    ui.label(said.map_or_else(|| "nothing".to_owned(), wording::message));
    ui.label(dim("hears").size(text_size::SMALL));
    if inbox.is_empty() {
        ui.label("nothing");
    }
    for message in inbox {
        let age = count(cycle.saturating_sub(message.sent_cycle) as usize, "cycle");
        let text = format!("{}, {age} ago: {}", message.from, wording::message(&message.say));
        ui.add(egui::Label::new(RichText::new(text).size(text_size::ENTRY)).wrap());
    }
}

fn show_state(ui: &mut egui::Ui, state: &ShownState, pins: &mut Pins) {
    let state = match &state.0 {
        Ok(state) => state,
        Err(why) => {
            ui.add(egui::Label::new(dim(why).size(text_size::ENTRY)).wrap());
            return;
        }
    };
    if state.components.is_empty() {
        ui.label(dim("Its behaviour has no state."));
    }
    for component in &state.components {
        ui.label(bright(component_words(&component.name)).size(text_size::ENTRY));
        Grid::new(&component.name).num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            for (name, value) in &component.fields {
                ui.label(dim(name).size(text_size::ENTRY));
                let shown = ui.add(egui::Label::new(RichText::new(value).size(text_size::ENTRY)).wrap());
                if let Some(type_id) = component.type_id {
                    pins.offer_field(shown, type_id, name);
                }
                ui.end_row();
            }
        });
    }
}

/// The name of a robot's behaviour in a scenario.
fn behaviour_in(scenario: &Scenario, id: RobotId) -> Option<&str> {
    match &scenario.robots.iter().find(|robot| robot.id() == id)?.behaviour {
        BehaviourSpec::Named(name) => Some(name),
        _ => None,
    }
}
