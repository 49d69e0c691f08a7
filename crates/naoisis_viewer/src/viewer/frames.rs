//! Draws fewer frames while nothing moves: a paused match waits for keys and the mouse, and a window that cannot be seen
//! plays on without being drawn.

use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;
use bevy::window::{PrimaryWindow, WindowEvent, WindowOccluded};
use bevy::winit::{UpdateMode, WINIT_WINDOWS, WinitSettings};
use core::time::Duration;
use std::thread;

use super::camera::ViewerCamera;
use super::decided::Decided;
use super::film::Filming;
use super::lanes::Lanes;
use super::many_times::ManyTimes;
use super::match_panel::trace_reading::TraceReading;
use super::shared::Playback;
use super::watch::summary::FinalSummary;

/// The time and the number of frames after the last input for which a paused match is drawn on: the camera and panels
/// come to rest.
const AWAKE: (f32, u32) = (1.5, 6);
/// The time between two frames while nothing moves: files and threads are looked after.
const AT_REST: Duration = Duration::from_secs(4);
/// The time between two frames of a window that cannot be seen.
const HIDDEN: Duration = Duration::from_millis(500);

/// The time for which a frame of a hidden window waits: events and panels may ask for more frames than [`HIDDEN`] has.
const HIDDEN_WAIT: Duration = Duration::from_millis(100);

/// Chooses how often frames are drawn.
pub struct FramesPlugin;

impl Plugin for FramesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Hidden>()
            .add_systems(Last, (look_whether_hidden, (choose_frames, draw_unless_hidden)).chain());
    }
}

/// Whether the window cannot be seen: it is minimised, or something covers it.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
struct Hidden {
    is_minimised: bool,
    is_covered: bool,
}

fn look_whether_hidden(
    _main_thread: NonSendMarker,
    windows: Query<(Entity, &Window), With<PrimaryWindow>>,
    mut covers: MessageReader<WindowOccluded>,
    mut hidden: ResMut<Hidden>,
) {
    if let Some(cover) = covers.read().last() {
        hidden.is_covered = cover.occluded;
    }
    // A window that has the focus is not minimised.
    let minimised = windows.iter().next().filter(|(_, window)| !window.focused).and_then(|(entity, _)| {
        WINIT_WINDOWS.with_borrow(|windows| windows.get_window(entity).and_then(|window| window.is_minimized()))
    });
    hidden.is_minimised = minimised.unwrap_or(false);
}

/// Leaves out the picture of a window that cannot be seen, which takes most of a core without a graphics card, and waits a little.
fn draw_unless_hidden(hidden: Res<Hidden>, filming: Res<Filming>, mut cameras: Query<&mut Camera, With<ViewerCamera>>) {
    let is_drawn = filming.is_on() || !(hidden.is_minimised || hidden.is_covered);
    for mut camera in &mut cameras {
        if camera.is_active != is_drawn {
            camera.is_active = is_drawn;
        }
    }
    if !is_drawn {
        thread::sleep(HIDDEN_WAIT);
    }
}

fn choose_frames(
    mut events: MessageReader<WindowEvent>,
    time: Res<Time<Real>>,
    hidden: Res<Hidden>,
    (playback, filming): (Res<Playback>, Res<Filming>),
    (many, decided, summary, lanes): (Res<ManyTimes>, Res<Decided>, Res<FinalSummary>, Res<Lanes>),
    reading: Option<Res<TraceReading>>,
    mut quiet: Local<(f32, u32)>,
    mut settings: ResMut<WinitSettings>,
) {
    let is_busy = !playback.paused
        || many.run.as_ref().is_some_and(|run| run.is_running)
        || decided.is_running()
        || summary.is_reading()
        || lanes.is_reading()
        || reading.is_some_and(|reading| reading.is_on());
    let is_quiet = events.read().count() == 0 && !is_busy;
    *quiet = if is_quiet { (quiet.0 + time.delta_secs(), quiet.1.saturating_add(1)) } else { (0.0, 0) };
    let is_at_rest = quiet.0 > AWAKE.0 && quiet.1 > AWAKE.1;
    let wanted = frames(hidden.is_minimised || hidden.is_covered, filming.is_on(), is_at_rest);
    if settings.focused_mode != wanted.focused_mode || settings.unfocused_mode != wanted.unfocused_mode {
        *settings = wanted;
    }
}

/// How often frames are drawn.
fn frames(is_hidden: bool, is_filmed: bool, is_at_rest: bool) -> WinitSettings {
    let wait = match (is_filmed, is_at_rest, is_hidden) {
        (true, ..) | (false, false, false) => return WinitSettings::game(),
        (false, true, _) => AT_REST,
        (false, false, true) => HIDDEN,
    };
    let mode = UpdateMode::reactive_low_power(wait);
    WinitSettings { focused_mode: mode, unfocused_mode: mode }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::camera::CameraMode;
    use crate::viewer::camera::viewpoint::Viewpoint;
    use bevy::ecs::system::RunSystemOnce;
    use naoisis_core::geometry::Pose;

    #[test]
    fn the_picture_of_a_hidden_window_is_left_out_unless_it_is_filmed() {
        let mut world = World::new();
        world.init_resource::<Filming>();
        let view = Viewpoint::behind(Pose::default());
        let viewer = ViewerCamera { current: view, wanted: view, mode: CameraMode::Orbit };
        let camera = world.spawn((Camera::default(), viewer)).id();
        for is_covered in [true, false] {
            world.insert_resource(Hidden { is_minimised: false, is_covered });
            world.run_system_once(draw_unless_hidden).unwrap();
            assert_eq!(world.get::<Camera>(camera).unwrap().is_active, !is_covered);
        }
    }

    #[test]
    fn a_match_that_rests_or_is_hidden_is_hardly_drawn_unless_it_is_filmed() {
        let wait = |is_hidden, is_filmed, is_at_rest| match frames(is_hidden, is_filmed, is_at_rest).focused_mode {
            UpdateMode::Continuous => None,
            UpdateMode::Reactive { wait, .. } => Some(wait),
        };
        assert_eq!(wait(false, false, false), None);
        assert_eq!(wait(false, false, true), Some(AT_REST));
        assert_eq!(wait(true, false, false), Some(HIDDEN));
        assert_eq!(wait(true, true, true), None);
    }
}
