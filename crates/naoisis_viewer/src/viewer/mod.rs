//! The window in which a match is watched.
//!
//! The viewer only reads the simulation and sends it commands ([`ViewerCommand`]): the same scenario and seed give the
//! same trace here as without a window, at any speed. A program shows its match with
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
//! | module | contents |
//! |---|---|
//! | `commands` | commands of keys and buttons: messages between the parts of the viewer |
//! | [`shared`] | state that all parts of the viewer use |
//! | [`drive`], [`speed`] | running the cycles: pause, single cycle, speed, restart |
//! | [`timeline`] | the past of the match, and replays of traces |
//! | `timeline_bar` | the bar below the match: position, events, branches |
//! | `pitch_frame` | the pitch frame in Bevy's world, light, smooth motion between cycles |
//! | `drawing` | shadows and anti-aliasing |
//! | `field` | models of carpet, lines, goals, nets and the hall |
//! | `robot_model`, `robot_animation` | models of robots and their motion |
//! | `ball_and_posts` | models of ball and posts |
//! | `contact_shadows` | soft shadows below robots and balls |
//! | `camera` | the camera of the window |
//! | `keys`, `key_bindings`, `key_presses`, `display_settings` | keys; which panels are shown, and how |
//! | `interaction` | dragging, turning, kicking, whistling; driving a robot |
//! | `overlays` | drawings on the pitch: perceptions, beliefs and commands of robots |
//! | [`camera_images`] | images of the robots' cameras |
//! | `robot_panel` | perceptions, commands, beliefs and behaviour of the selected robot |
//! | [`cycle_samples`] | numbers of the latest cycles |
//! | `behaviour_state` | the state of a behaviour, by reflection |
//! | [`keyframes`], `rebuild` | the whole state at any moment: what records leave out is replayed in the background |
//! | `branches` | branches of the match from any moment |
//! | `match_before` | the match before another took its place, to go back to |
//! | `frames` | fewer frames while nothing moves |
//! | `ghost_models` | models of robots and balls that are no part of the match |
//! | `ghosts` | another branch on the same pitch, translucent |
//! | `many_times` | repetitions of a moment with other random numbers |
//! | `decided` | what decided the match: the largest swings of the chance to score, with their mistakes |
//! | `lanes` | the whole match, one lane per robot; jumps to events |
//! | `plots` | numbers of robots and the ball over the whole match |
//! | `time_axis` | the time axis of lanes and plots |
//! | `pen_marks` | strokes of the pen |
//! | `new_file` | new files that never replace others |
//! | `workspace` | the three uses of the window: watch, debug, teach |
//! | `watch` | a large score, replays of goals, a summary at the end |
//! | `teach` | a pen, the world of one robot, bookmarks with captions |
//! | `panels` | score, clock, controls, help |
//! | `team_labels` | the names of the teams |
//! | `events_panel`, `event_details` | penalties and events; the reasons of the selected one |
//! | `selection` | the selected robot |
//! | `frame_cost` | the cost of a frame |
//! | [`memory`] | state that persists between runs |
//! | [`match_panel`] | scenario, teams, settings; watching of scenario files |
//! | [`start_at`] | the time at which the match is shown first |
//! | [`start_page`] | the first page; files that are dropped |
//! | `scenario_list` | the list of built-in scenarios |
//! | `open_dialog` | a dialog to choose a file |
//! | `picture`, [`film`] | pictures and recordings of the window |
//! | [`first_frame`] | the time until the first frame |
//! | [`report_state`] | the state of the window as JSON lines |
//! | `window_icon` | the icon of the window |
//! | `window_title` | the title of the window |
//! | `widgets` | the buttons and boxes of the panels, by name |
//! | `theme`, `layout`, `dock`, `floating` | dark and light panels, and their layout |
//! | `labels` | names of robots, words of overlays |
//! | [`event_log`] | the log of events |
//! | `event_filter` | the filter of the list of events |

use bevy::app::PluginGroupBuilder;
use bevy::log::{BoxedFmtLayer, LogPlugin, tracing_subscriber};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::WindowResolution;
use bevy_egui::EguiPlugin;
use std::io::{self, IsTerminal};

mod ball_and_posts;
/// The crate that the panels are drawn with, for panels of a program's own.
pub use bevy_egui;

mod behaviour_state;
mod branches;
mod camera;
pub mod camera_images;
#[cfg(test)]
mod colour_vision;
mod command_list;
mod commands;
mod contact_shadows;
pub mod cycle_samples;
mod decided;
mod display_settings;
mod dock;
mod drawing;
pub mod drive;
mod event_details;
mod event_filter;
pub mod event_log;
mod event_reasons;
mod events_panel;
mod field;
pub mod film;
pub mod first_frame;
mod floating;
mod frame_cost;
mod frames;
mod ghost_models;
mod ghosts;
mod interaction;
mod key_bindings;
mod key_presses;
pub mod keyframes;
mod keys;
mod labels;
mod lanes;
mod layout;
mod many_times;
mod match_before;
pub mod match_panel;
pub mod memory;
mod new_file;
mod open_dialog;
mod overlays;
mod palette;
#[cfg(test)]
mod panel_tests;
mod panels;
mod part_mesh;
mod pen_marks;
mod picture;
mod pitch_frame;
mod plots;
mod rebuild;
pub mod report_state;
mod robot_animation;
mod robot_model;
mod robot_panel;
mod scenario_list;
mod selection;
pub mod shared;
mod sharing;
pub mod speed;
pub mod start_at;
pub mod start_page;
mod teach;
mod team_labels;
#[cfg(test)]
mod test_window;
mod theme;
mod time_axis;
pub mod timeline;
mod timeline_bar;
mod unrecognised;
mod watch;
mod widgets;
mod window_icon;
mod window_title;
mod workspace;

pub use commands::{TimelineCommand, ViewerCommand};
pub use speed::Speed;
pub use timeline::Timeline;

/// The initial size of the window, logical pixels.
const WINDOW_SIZE: (u32, u32) = (1280, 720);

/// Everything that a program needs to show its match in a window: Bevy's `DefaultPlugins`, configured for it, and the
/// plugins of the viewer. The match itself comes from [`NaoisisPlugins`](naoisis_sim::simulation::NaoisisPlugins).
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
            // Without this, parts of the scene would appear one by one as their pipelines are compiled.
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(LogPlugin {
                filter: "warn,naoisis=info,winit=error,bevy_egui=error".to_owned(),
                fmt_layer: plain_unless_in_a_terminal,
                ..default()
            })
            .add(EguiPlugin::default())
            .add(first_frame::FirstFramePlugin::default())
            .add(frames::FramesPlugin)
            .add(drive::DrivePlugin)
            .add(event_log::EventLogPlugin)
            .add(cycle_samples::CycleSamplesPlugin)
            .add(pitch_frame::PitchFramePlugin)
            .add(drawing::DrawingPlugin)
            .add(field::FieldPlugin)
            .add(robot_model::RobotModelPlugin)
            .add(robot_animation::RobotAnimationPlugin)
            .add(ball_and_posts::BallAndPostsPlugin)
            .add(contact_shadows::ContactShadowsPlugin)
            .add(camera::ViewerCameraPlugin)
            .add(keys::KeysPlugin)
            .add(interaction::InteractionPlugin)
            .add(selection::SelectionPlugin)
            .add(theme::ThemePlugin)
            .add(layout::LayoutPlugin)
            .add(dock::DockPlugin)
            .add(workspace::WorkspacePlugin)
            .add(watch::WatchPlugin)
            .add(teach::TeachPlugin)
            .add(labels::LabelsPlugin)
            .add(overlays::OverlaysPlugin)
            .add(panels::PanelsPlugin)
            .add(command_list::CommandListPlugin)
            .add(sharing::SharingPlugin)
            .add(timeline_bar::TimelineBarPlugin)
            .add(match_panel::MatchPanelPlugin)
            .add(start_at::StartAtPlugin)
            .add(start_page::StartPagePlugin)
            .add(open_dialog::OpenDialogPlugin)
            .add(picture::PicturePlugin)
            .add(film::FilmPlugin)
            .add(event_filter::EventFilterPlugin)
            .add(events_panel::EventsPanelPlugin)
            .add(camera_images::CameraImagesPlugin)
            .add(rebuild::RebuildPlugin)
            .add(unrecognised::UnrecognisedPlugin)
            .add(branches::BranchesPlugin)
            .add(match_before::MatchBeforePlugin)
            .add(ghosts::GhostsPlugin)
            .add(lanes::LanesPlugin)
            .add(plots::PlotsPlugin)
            .add(many_times::ManyTimesPlugin)
            .add(decided::DecidedPlugin)
            .add(robot_panel::RobotPanelPlugin)
            .add(frame_cost::FrameCostPlugin)
            .add(memory::MemoryPlugin)
            .add(widgets::WidgetsPlugin)
            .add(window_icon::WindowIconPlugin)
            .add(window_title::WindowTitlePlugin)
            .add(report_state::ReportStatePlugin)
    }
}

/// A log layer without colours if standard error is a file or a pipe; else Bevy's own.
fn plain_unless_in_a_terminal(_app: &mut App) -> Option<BoxedFmtLayer> {
    if io::stderr().is_terminal() {
        return None;
    }
    Some(Box::new(tracing_subscriber::fmt::Layer::default().with_ansi(false).with_writer(io::stderr)))
}
