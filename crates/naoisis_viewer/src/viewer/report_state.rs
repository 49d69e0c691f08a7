//! The state of the window as JSON lines, for programs that drive the window from outside. Tests of the panels read the same state
//! without a file.
//!
//! A line is written at the end of every frame in which something has changed, and flushed. Its fields:
//!
//! | field | contents |
//! |---|---|
//! | `frame` | frames since the start of the program |
//! | `window`, `pointer` | width and height of the window, and the position of the mouse, logical pixels |
//! | `shift`, `control`, `typing` | whether Shift or Ctrl is held down; whether keys go to a field of a panel |
//! | `held` | whether the mouse drags a robot or the ball, or draws |
//! | `scenario`, `seed`, `teams` | the match |
//! | `cycle`, `shown_cycle` | the current cycle of the match; the cycle that is shown, if it is in the past |
//! | `paused`, `speed`, `replay`, `over` | how the match is shown |
//! | `state`, `score` | the state of the game |
//! | `ball`, `robots` | for each the `pose` (m, m, degrees) and the position in the window (`pixel`, if visible); whether it is drawn (`drawn`); for robots `penalised`, and `head` (yaw, pitch, degrees) |
//! | `selected`, `driven` | robots |
//! | `filming` | whether the window is being recorded |
//! | `shown` | the switches of the panels |
//! | `overlays` | the number of overlay switches that are on |
//! | `problem`, `notice` | messages to the user |
//! | `costs` | of a frame, while shown: frames/s, processor time for match and panels and for drawing (ms), draw calls, robots' images/s |
//! | `event` | the selected event |
//! | `branches` | the number of branches, and the index of the one that is shown |
//! | `many_times` | the number of finished repetitions, and whether they are running |
//! | `decided` | of the search for what decided the match: the number of moments with chances, whether it is running, and the beginning and end of the swings, s, the largest first |
//! | `behaviour` | the number of state components of the selected robot's behaviour at the moment that is shown; null if unknown |
//! | `free` | the free area for the match: its upper left and its lower right corner, logical pixels |
//! | `goal_replay` | the text of the goal that is replayed; null otherwise |
//! | `summary` | whether the summary of the match is shown |
//! | `pen` | the number of strokes, while the mouse draws; null otherwise |
//! | `truth` | whether the truth is shown, not the world of one robot |
//! | `believed` | the number of bodies that are drawn in the world of one robot, the ball included |
//! | `bookmarks` | the number of bookmarks, and the one that is shown |
//! | `plots` | the numbers of plotted fields and of curves |
//! | `events` | the numbers of listed and of hidden events |
//! | `ghosts` | the branch whose ghosts are shown (null for the match before), the number of ghosts, and whether they have a pitch of their own; null without ghosts |
//! | `undo` | the numbers of steps to undo and to redo |
//! | `widgets` | the widgets of the panels: `role`, `name`, `value`, `edges` (left, upper, right, lower, logical pixels) |

use bevy::diagnostic::FrameCount;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use super::branches::Branches;
use super::camera::ViewerCamera;
use super::decided::Decided;
use super::display_settings::{DisplaySettings, Workspace};
use super::event_filter::ListedEvents;
use super::events_panel::ShownEvent;
use super::film::Filming;
use super::frame_cost::FrameCost;
use super::ghosts::{Ghosts, GhostsOf};
use super::interaction::MouseDrag;
use super::interaction::driving::Driving;
use super::interaction::undo::Undo;
use super::layout::FreeArea;
use super::many_times::ManyTimes;
use super::overlays::{Overlays, Shows};
use super::pitch_frame::{pose_of, world_from_pitch};
use super::plots::Plots;
use super::rebuild::ShownState;
use super::shared::{Notice, Playback, RobotsWorld, Selection, is_over};
use super::teach::believed_bodies::BelievedBodies;
use super::teach::bookmarks::Bookmarks;
use super::teach::pen::Pen;
use super::timeline::Timeline;
use super::watch::goal_replay::GoalReplay;
use super::watch::summary::FinalSummary;
use super::widgets::{Widgets, WidgetsSystems};
use naoisis_core::ball::Ball;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::to_degrees;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::Scenario;

/// Writes the state of the window.
pub struct ReportStatePlugin;

impl Plugin for ReportStatePlugin {
    fn build(&self, app: &mut App) {
        app.configure_sets(Update, WidgetsSystems.run_if(resource_exists::<StateReport>))
            .configure_sets(Last, WidgetsSystems.run_if(resource_exists::<StateReport>))
            .add_systems(Last, report.after(WidgetsSystems).run_if(resource_exists::<StateReport>));
    }
}

/// The output of the state.
#[derive(Resource)]
pub struct StateReport {
    output: Box<dyn Write + Send + Sync>,
    last: Value,
}

impl StateReport {
    /// Creates a new file.
    ///
    /// # Errors
    /// When it cannot be created.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self::to(File::create(path)?))
    }

    /// Writes to any output.
    pub fn to(output: impl Write + Send + Sync + 'static) -> Self {
        Self { output: Box::new(output), last: Value::Null }
    }

    /// Writes a line if anything but the number of the frame has changed.
    fn write(&mut self, frame: u32, state: Value) -> io::Result<()> {
        if state == self.last {
            return Ok(());
        }
        let mut line = state.clone();
        line["frame"] = frame.into();
        self.last = state;
        writeln!(self.output, "{line}")?;
        self.output.flush()
    }
}

/// All resources that are reported.
#[derive(SystemParam)]
struct Reported<'w, 's> {
    scenario: Option<Res<'w, Scenario>>,
    clock: Res<'w, CycleClock>,
    game: Res<'w, Game>,
    playback: Res<'w, Playback>,
    timeline: Res<'w, Timeline>,
    selection: Res<'w, Selection>,
    drag: Res<'w, MouseDrag>,
    filming: Res<'w, Filming>,
    driving: Res<'w, Driving>,
    display: Res<'w, DisplaySettings>,
    overlays: Res<'w, Overlays>,
    notice: Res<'w, Notice>,
    roster: Res<'w, Roster>,
    robots: Query<'w, 's, (&'static RobotId, Thing, &'static Penalty, &'static HeadAngles, &'static Body)>,
    balls: Query<'w, 's, Thing, With<Ball>>,
    meshes: Query<'w, 's, &'static ViewVisibility, With<Mesh3d>>,
    cameras: Query<'w, 's, (&'static Camera, &'static GlobalTransform), With<ViewerCamera>>,
    windows: Query<'w, 's, &'static Window>,
    keys: Res<'w, ButtonInput<KeyCode>>,
    event: Res<'w, ShownEvent>,
    widgets: Res<'w, Widgets>,
    panels: Res<'w, EguiWantsInput>,
    cost: Res<'w, FrameCost>,
    branches: Res<'w, Branches>,
    many_times: Res<'w, ManyTimes>,
    decided: Res<'w, Decided>,
    behaviour: Res<'w, ShownState>,
    free: Res<'w, FreeArea>,
    watched: (Res<'w, GoalReplay>, Res<'w, FinalSummary>),
    taught: (Res<'w, Pen>, Res<'w, RobotsWorld>, Res<'w, Bookmarks>, Res<'w, BelievedBodies>),
    looked: (Res<'w, Plots>, Res<'w, ListedEvents>, Res<'w, Ghosts>, Res<'w, Undo>),
}

/// The place of something on the pitch, and the parts of its model.
type Thing = (&'static Transform, Option<&'static Children>);

/// Returns the fields of the state, without the number of the frame.
#[cfg(test)]
pub(super) fn state_of(world: &mut World) -> Value {
    world.run_system_cached(|reported: Reported| reported.state()).unwrap()
}

fn report(reported: Reported, frame: Res<FrameCount>, mut report: ResMut<StateReport>, mut commands: Commands) {
    if let Err(error) = report.write(frame.0, reported.state()) {
        warn!("the state of the window can no longer be written: {error}");
        commands.remove_resource::<StateReport>();
    }
}

impl Reported<'_, '_> {
    fn state(&self) -> Value {
        let window = self.windows.iter().next().map(|window| [window.width(), window.height()]);
        let pointer = self.windows.iter().next().and_then(Window::cursor_position);
        let robots: serde_json::Map<String, Value> = self
            .roster
            .iter()
            .filter_map(|(_, entity)| self.robots.get(entity).ok())
            .map(|(id, place, penalty, head, body)| {
                // Where it is best clicked at.
                let mut robot = self.thing(place, body.height_m / 2.0);
                robot["penalised"] = penalty.is_active().into();
                robot["head"] = json!([to_degrees(head.yaw), to_degrees(head.pitch)]);
                (id.to_string(), robot)
            })
            .collect();
        let mut state = json!({
            "window": window,
            "pointer": pointer.map(|pointer| [pointer.x, pointer.y]),
            "shift": self.keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]),
            "typing": self.panels.wants_any_keyboard_input(),
            "held": self.drag.is_dragging() || self.taught.0.is_drawing(),
            "scenario": self.scenario.as_ref().map(|scenario| &scenario.name),
            "seed": self.scenario.as_ref().map(|scenario| scenario.seed),
            "teams": self.scenario.as_ref().and_then(|scenario| scenario.teams.as_ref()),
            "cycle": self.clock.cycle,
            "shown_cycle": self.timeline.cursor(),
            "paused": self.playback.paused,
            "speed": self.playback.speed.to_string(),
            "replay": self.timeline.is_replay(),
            "over": is_over(&self.game, &self.clock, &self.playback),
            "state": self.game.state,
            "score": self.game.score,
            "ball": self.balls.iter().next().map(|ball| self.thing(ball, 0.0)),
            "robots": robots,
            "selected": self.selection.0,
            "driven": self.driving.robot,
            "shown": *self.display,
            "filming": self.filming.is_on(),
            "overlays": self.overlays.of_robots.values().map(|shows| switches_of(shows, self.display.workspace)).sum::<usize>(),
            "problem": self.playback.problem,
            "awaited": self.playback.awaited().map(|(robot, _)| robot),
            "notice": (self.notice.left_s > 0.0).then_some(&self.notice.text),
            "costs": self.display.frame_cost.then(|| costs(&self.cost)),
            "event": self.event.0.as_ref().map(|(entry, _)| &entry.text),
            "branches": [self.branches.list().len(), self.branches.shown()],
            "many_times": self.many_times.run.as_ref().map(|run| json!([run.rows.len(), run.is_running])),
            "behaviour": self.behaviour.0.as_ref().ok().map(|state| state.components.len()),
            "free": window.map(|window| self.free.within(window.into())).map(|free| [free.min, free.max].map(|corner| corner.to_array())),
            "goal_replay": self.watched.0.words(),
            "summary": self.watched.1.is_shown(),
            "pen": self.taught.0.is_on.then_some(self.taught.0.marks.len()),
            "truth": !self.taught.1.0,
            "bookmarks": [Some(self.taught.2.list().len()), self.taught.2.shown()],
            "widgets": self.widgets.0,
        });
        let (plots, listed, ghosts, undo) = &self.looked;
        let swings: Vec<[f64; 2]> = self.decided.swings().iter().map(|swing| [swing.from_s, swing.until_s]).collect();
        state["decided"] = json!([self.decided.chances().count(), self.decided.is_running(), swings]);
        state["plots"] = json!(plots.counts());
        state["events"] = json!([listed.entries.len(), listed.hidden]);
        state["ghosts"] = match ghosts.of {
            Some(GhostsOf::Branch(index)) => json!([index, ghosts.seen, ghosts.beside]),
            Some(GhostsOf::MatchBefore) => json!([null, ghosts.seen, ghosts.beside]),
            None => json!(null),
        };
        state["believed"] = self.taught.3.0.into();
        state["undo"] = json!(undo.counts());
        state["control"] = self.keys.any_pressed([KeyCode::ControlLeft, KeyCode::ControlRight]).into();
        state
    }

    fn thing(&self, (place, parts): (&Transform, Option<&Children>), height: f32) -> Value {
        let pose = pose_of(place);
        let point = world_from_pitch() * place.translation.truncate().extend(height);
        let camera = self.cameras.iter().next();
        let pixel = camera.and_then(|(camera, from)| camera.world_to_viewport(from, point).ok());
        json!({
            "pose": [pose.position.x, pose.position.y, to_degrees(pose.heading)],
            "pixel": pixel.map(|pixel| [pixel.x, pixel.y]),
            "drawn": parts.is_some_and(|parts| self.meshes.iter_many(parts).any(|visible| visible.get())),
        })
    }
}

fn costs(cost: &FrameCost) -> Value {
    json!({
        "frames_per_s": cost.frames_per_s,
        "main_ms": 1000.0 * cost.main_s,
        "drawing_ms": 1000.0 * cost.rendering_s,
        "draw_calls": cost.draw_calls,
        "eye_images_per_s": cost.eye_images_per_s,
    })
}

/// The number of switches of an overlay that are on.
fn switches_of(shows: &Shows, workspace: Workspace) -> usize {
    usize::from(shows.all) + usize::from(shows.of_selected(workspace)) + shows.robots.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_line_is_written_when_something_is_different() {
        let written = Shared::default();
        let mut report = StateReport::to(written.clone());
        for (frame, cycle) in [(1, 0), (2, 0), (3, 1)] {
            report.write(frame, json!({ "cycle": cycle })).unwrap();
        }
        let bytes = written.0.lock().unwrap().clone();
        assert_eq!(String::from_utf8(bytes).unwrap(), "{\"cycle\":0,\"frame\":1}\n{\"cycle\":1,\"frame\":3}\n");
    }
}
