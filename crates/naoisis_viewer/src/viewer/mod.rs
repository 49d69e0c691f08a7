//! The window in which a match is watched.
//!
//! The viewer only reads the simulation and sends it commands ([`ViewerCommand`]): the same scenario and seed give
//! the same trace here as headless, at whatever speed they are watched. A program of one's own shows its match with
//!
//! ```no_run
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::viewer::ViewerPlugins;
//!
//! let mut app = App::new();
//! app.add_plugins((ViewerPlugins, NaoisisPlugins));
//! app.start_match(&Scenario::default())?;
//! app.run();
//! # Ok::<(), naoisis::scenario::ScenarioFault>(())
//! ```
//!
//! | file | what it shows or does |
//! |---|---|
//! | [`shared`] | what all parts know, and tell each other |
//! | [`drive`], [`speed`] | runs the cycles: pause, single cycle, speed, restart |
//! | [`timeline`] | the past of the match, and of one that a trace was written of |
//! | `timeline_bar` | the bar below the match: where it is, what happened when, the ways that it went |
//! | [`stage`] | the pitch frame in Bevy's world, light, smooth motion between cycles |
//! | `drawing` | shadows and smooth edges, where they cost little |
//! | `field` | carpet, lines, goals, nets |
//! | `robot_model`, `robot_animation` | robots and how they move |
//! | `ball_and_posts` | ball and posts |
//! | [`camera`] | where the match is watched from |
//! | [`keys`], [`display_settings`] | what the keys do; which panels are shown, and how |
//! | [`hands`] | drags, turns, kicks, whistles; drives a robot |
//! | [`overlays`] | what is drawn on the pitch of what robots see, hear, believe and want |
//! | [`eyes`] | images of the robots' cameras that someone looks at |
//! | [`robot_panel`] | what the selected robot sees, hears, wants, believes and keeps in mind |
//! | [`cycle_samples`] | the latest cycles in numbers |
//! | [`behaviour_state`] | what a behaviour keeps in mind, by reflection |
//! | [`keyframes`], [`rebuild`] | any moment whole: what records leave out is played again in the background |
//! | [`branches`] | the ways that the match went, when a moment was played on in another way |
//! | [`ghosts`] | another of them on the same pitch at the same moment, translucent |
//! | [`many_times`] | this moment, played on many times with other chance |
//! | [`lanes`] | the whole match at a glance, a lane for each robot; events of a kind |
//! | [`plots`] | any number of robots and the ball as a curve, over the whole match |
//! | `time_axis` | where cycles are on lanes and plots, and the part of the match that is looked at |
//! | `pen_marks` | what the pen draws |
//! | `new_file` | files that a button writes, never over another |
//! | [`workspace`] | what the window is used for: to watch, to debug, to teach |
//! | [`watch`] | a large score, goals again in slow motion, a summary at the end |
//! | [`teach`] | a pen, one robot's world alone, moments with captions |
//! | `panels` | score, clock, controls, help |
//! | `events_panel` | penalties, what happened, where and why |
//! | [`selection`] | which robot the user looks at |
//! | [`statistics`] | what a frame costs |
//! | [`memory`] | what is remembered from one time to the next |
//! | [`match_panel`] | scenario, teams, settings; a scenario's file is watched |
//! | [`start_page`] | what there is to open, where nothing was said; files that are dropped |
//! | `scenario_list` | the built-in scenarios to choose from |
//! | [`film`] | a video of the window |
//! | [`first_frame`] | how long the start takes |
//! | [`report_state`] | what is shown, as JSON lines |
//! | [`widgets`] | the buttons and boxes of the panels, by name |
//! | [`theme`], `layout` | dark and light panels, and where they are |
//! | `labels` | names above the robots, words of the overlays |
//! | [`event_log`] | what happened in the match |
//! | [`event_filter`] | which of it is listed |

use bevy::app::PluginGroupBuilder;
use bevy::log::{BoxedFmtLayer, LogPlugin, tracing_subscriber};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::WindowResolution;
use bevy_egui::EguiPlugin;
use std::io::{self, IsTerminal};

mod ball_and_posts;
pub mod behaviour_state;
pub mod branches;
pub mod camera;
#[cfg(test)]
mod colour_vision;
pub mod cycle_samples;
pub mod display_settings;
mod drawing;
pub mod drive;
pub mod event_filter;
pub mod event_log;
mod events_panel;
pub mod eyes;
mod field;
pub mod film;
pub mod first_frame;
pub mod ghosts;
pub mod hands;
pub mod keyframes;
pub mod keys;
mod labels;
pub mod lanes;
mod layout;
pub mod many_times;
pub mod match_panel;
pub mod memory;
mod new_file;
pub mod overlays;
mod palette;
mod panels;
mod part_mesh;
mod pen_marks;
pub mod plots;
pub mod rebuild;
pub mod report_state;
mod robot_animation;
mod robot_model;
pub mod robot_panel;
mod scenario_list;
pub mod selection;
pub mod shared;
pub mod speed;
pub mod stage;
pub mod start_page;
pub mod statistics;
pub mod teach;
pub mod theme;
mod time_axis;
pub mod timeline;
mod timeline_bar;
pub mod watch;
pub mod widgets;
pub mod workspace;

pub use shared::{TimelineCommand, ViewerCommand};
pub use speed::Speed;
pub use timeline::Timeline;

/// Size of the window at first, in logical pixels.
const WINDOW_SIZE: (u32, u32) = (1280, 720);

/// Everything that a program needs to show its match in a window: Bevy's `DefaultPlugins`, set up for it, and the
/// viewer's own. The match itself comes from [`NaoisisPlugins`](naoisis_sim::simulation::NaoisisPlugins).
pub struct ViewerPlugins;

impl PluginGroup for ViewerPlugins {
    fn build(self) -> PluginGroupBuilder {
        DefaultPlugins
            .build()
            .set(WindowPlugin {
                primary_window: Some(Window {
                    title: "naoisis".to_owned(),
                    name: Some("naoisis".to_owned()),
                    resolution: WindowResolution::new(WINDOW_SIZE.0, WINDOW_SIZE.1),
                    ..default()
                }),
                ..default()
            })
            // Otherwise the parts of the scene pop in one by one while their pipelines are compiled.
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(LogPlugin {
                filter: "warn,naoisis=info,winit=error,bevy_egui=error".to_owned(),
                fmt_layer: plain_unless_in_a_terminal,
                ..default()
            })
            .add(EguiPlugin::default())
            .add(first_frame::FirstFramePlugin::default())
            .add(drive::DrivePlugin)
            .add(event_log::EventLogPlugin)
            .add(cycle_samples::CycleSamplesPlugin)
            .add(stage::StagePlugin)
            .add(drawing::DrawingPlugin)
            .add(field::FieldPlugin)
            .add(robot_model::RobotModelPlugin)
            .add(robot_animation::RobotAnimationPlugin)
            .add(ball_and_posts::BallAndPostsPlugin)
            .add(camera::ViewerCameraPlugin)
            .add(keys::KeysPlugin)
            .add(hands::HandsPlugin)
            .add(selection::SelectionPlugin)
            .add(theme::ThemePlugin)
            .add(layout::LayoutPlugin)
            .add(workspace::WorkspacePlugin)
            .add(watch::WatchPlugin)
            .add(teach::TeachPlugin)
            .add(labels::LabelsPlugin)
            .add(overlays::OverlaysPlugin)
            .add(panels::PanelsPlugin)
            .add(timeline_bar::TimelineBarPlugin)
            .add(match_panel::MatchPanelPlugin)
            .add(start_page::StartPagePlugin)
            .add(film::FilmPlugin)
            .add(event_filter::EventFilterPlugin)
            .add(events_panel::EventsPanelPlugin)
            .add(eyes::EyesPlugin)
            .add(rebuild::RebuildPlugin)
            .add(branches::BranchesPlugin)
            .add(ghosts::GhostsPlugin)
            .add(lanes::LanesPlugin)
            .add(plots::PlotsPlugin)
            .add(many_times::ManyTimesPlugin)
            .add(robot_panel::RobotPanelPlugin)
            .add(statistics::StatisticsPlugin)
            .add(memory::MemoryPlugin)
            .add(widgets::WidgetsPlugin)
            .add(report_state::ReportStatePlugin)
    }
}

/// Messages without colours, where standard error is a file or a pipe; Bevy's own otherwise.
fn plain_unless_in_a_terminal(_app: &mut App) -> Option<BoxedFmtLayer> {
    if io::stderr().is_terminal() {
        return None;
    }
    Some(Box::new(tracing_subscriber::fmt::Layer::default().with_ansi(false).with_writer(io::stderr)))
}
