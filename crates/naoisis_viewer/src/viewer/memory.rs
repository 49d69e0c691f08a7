//! The state of the viewer that persists between runs: the size of the window, panels, the last scenario.
//!
//! It is stored in a file of the user, `naoisis/viewer.json` in the configuration folder (`~/.config` on Linux) or in
//! the folder that the environment variable `NAOISIS_CONFIG_DIR` names; an empty variable disables it. An invalid file
//! is ignored with a warning and replaced. The command `naoisis` uses this; your own program does when it inserts
//! [`ViewerMemory`].

use bevy::prelude::*;
use bevy::window::{Monitor, PrimaryWindow};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::display_settings::DisplaySettings;
use super::dock::PanelSizes;
use super::overlays::Overlays;
use super::plots::{Pin, Plots};
use naoisis_core::read_file::read_file;
use naoisis_core::replace_file::replace_file;

/// The environment variable with the folder.
pub const FOLDER_VARIABLE: &str = "NAOISIS_CONFIG_DIR";
/// The name of the file.
const FILE: &str = "viewer.json";
/// The time between two writes, s.
const INTERVAL_S: f32 = 1.0;

/// Keeps [`ViewerMemory`] up to date, if it was inserted.
pub struct MemoryPlugin;

impl Plugin for MemoryPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, recall.run_if(resource_exists::<ViewerMemory>))
            .add_systems(Update, fit_to_screen)
            .add_systems(Last, remember.run_if(resource_exists::<ViewerMemory>).run_if(is_time));
    }
}

/// The persistent state.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Remembered {
    /// The width and height of the window, logical pixels.
    pub window: Option<[f32; 2]>,
    /// Which panels are shown, and how.
    #[serde(rename = "shown")]
    pub display: Option<DisplaySettings>,
    /// The sizes of panels whose edges were dragged.
    pub panels: Option<PanelSizes>,
    /// The overlays.
    pub overlays: Option<Overlays>,
    /// The plotted fields.
    pub plots: Option<Vec<Pin>>,
    /// The last scenario: the name of a built-in one, or a file.
    pub scenario: Option<String>,
    /// The scenarios and traces that were opened last, most recent first.
    pub recent: Vec<String>,
}

/// The persistent state with its file.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct ViewerMemory {
    /// The state.
    pub remembered: Remembered,
    /// The file; `None` if nothing is written.
    path: Option<PathBuf>,
}

impl ViewerMemory {
    /// The state of the current user.
    pub fn of_user() -> Self {
        let folder = match std::env::var_os(FOLDER_VARIABLE) {
            Some(folder) => (!folder.is_empty()).then(|| PathBuf::from(folder)),
            None => dirs::config_dir().map(|folder| folder.join("naoisis")),
        };
        folder.map_or_else(Self::default, |folder| Self::in_file(folder.join(FILE)))
    }

    /// The state in a file, which may be missing.
    pub fn in_file(path: PathBuf) -> Self {
        let remembered = match read_file(&path) {
            Ok(text) => serde_json::from_slice(&text).unwrap_or_else(|error| {
                warn!("{}: invalid and ignored: {error}", path.display());
                Remembered::default()
            }),
            Err(error) => {
                if error.kind() != io::ErrorKind::NotFound {
                    warn!("{}: {error}", path.display());
                }
                Remembered::default()
            }
        };
        Self { remembered, path: Some(path) }
    }

    /// Writes the state if it has changed.
    fn update(&mut self, remembered: Remembered) {
        if remembered == self.remembered {
            return;
        }
        self.remembered = remembered;
        if let Some(path) = &self.path
            && let Err(error) = write(path, &self.remembered)
        {
            warn!("{}: {error}; the state of the window is not saved", path.display());
            self.path = None;
        }
    }
}

fn write(path: &Path, remembered: &Remembered) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let text = serde_json::to_string_pretty(remembered)?;
    // Another window may read the file meanwhile, so it is replaced as a whole.
    replace_file(path, |mut file| file.write_all(text.as_bytes()))
}

fn recall(
    memory: Res<ViewerMemory>,
    mut windows: Query<&mut Window, With<PrimaryWindow>>,
    display: Option<ResMut<DisplaySettings>>,
    sizes: Option<ResMut<PanelSizes>>,
    overlays: Option<ResMut<Overlays>>,
    plots: Option<ResMut<Plots>>,
) {
    let Remembered { window, display: display_last, panels, overlays: overlays_last, plots: pins, .. } =
        &memory.remembered;
    if let (Some(pins), Some(mut plots)) = (pins, plots) {
        plots.pins.clone_from(pins);
    }
    if let (Some(last), Some(mut sizes)) = (panels, sizes) {
        sizes.clone_from(last);
    }
    if let (Some([width, height]), Ok(mut present)) = (*window, windows.single_mut()) {
        present.resolution.set(width.clamp(320.0, 8192.0), height.clamp(240.0, 8192.0));
    }
    if let (Some(last), Some(mut display)) = (display_last, display) {
        // Lists that cover the view are closed at the start.
        *display = DisplaySettings { help: false, many_times: false, decided: false, summary: false, ..*last };
    }
    if let (Some(last), Some(mut overlays)) = (overlays_last, overlays) {
        overlays.clone_from(last);
    }
}

/// Makes the window no larger than the largest screen, when a screen becomes known: the size may be that on another one.
fn fit_to_screen(
    added: Query<(), Added<Monitor>>,
    screens: Query<&Monitor>,
    mut windows: Query<&mut Window, With<PrimaryWindow>>,
) {
    if added.is_empty() {
        return;
    }
    let area = |screen: &&Monitor| u64::from(screen.physical_width) * u64::from(screen.physical_height);
    let largest =
        screens.iter().max_by_key(area).map(|screen| UVec2::new(screen.physical_width, screen.physical_height));
    let (Some(largest), Ok(mut window)) = (largest, windows.single_mut()) else { return };
    let size = window.resolution.physical_size();
    let fitting = size.min(largest);
    if fitting != size && largest.min_element() > 0 {
        window.resolution.set_physical_resolution(fitting.x, fitting.y);
    }
}

/// Whether to write: at intervals, and when the program ends.
fn is_time(time: Res<Time<Real>>, exits: MessageReader<AppExit>, mut last_s: Local<f32>) -> bool {
    let is_time = !exits.is_empty() || time.elapsed_secs() - *last_s > INTERVAL_S;
    if is_time {
        *last_s = time.elapsed_secs();
    }
    is_time
}

fn remember(
    mut memory: ResMut<ViewerMemory>,
    windows: Query<&Window, With<PrimaryWindow>>,
    display: Option<Res<DisplaySettings>>,
    sizes: Option<Res<PanelSizes>>,
    overlays: Option<Res<Overlays>>,
    plots: Option<Res<Plots>>,
) {
    let remembered = Remembered {
        window: windows.single().ok().map(|window| [window.width(), window.height()]).or(memory.remembered.window),
        display: display.map(|display| *display).or(memory.remembered.display),
        panels: sizes.map(|sizes| sizes.clone()).or_else(|| memory.remembered.panels.clone()),
        overlays: overlays.map(|overlays| overlays.clone()).or_else(|| memory.remembered.overlays.clone()),
        plots: plots.map(|plots| plots.pins.clone()).or_else(|| memory.remembered.plots.clone()),
        scenario: memory.remembered.scenario.clone(),
        recent: memory.remembered.recent.clone(),
    };
    memory.update(remembered);
}

impl ViewerMemory {
    /// Remembers the current scenario: the name of a built-in one, or a file.
    pub fn note_scenario(&mut self, scenario: &str) {
        let scenario = Some(scenario.to_owned());
        self.update(Remembered { scenario, ..self.remembered.clone() });
    }

    /// Remembers a file that was opened.
    pub fn note_recent(&mut self, path: &str) {
        /// The most files that are remembered.
        const MOST: usize = 6;
        let others = self.remembered.recent.iter().filter(|other| *other != path).cloned();
        let recent = core::iter::once(path.to_owned()).chain(others).take(MOST).collect();
        self.update(Remembered { recent, ..self.remembered.clone() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn app(path: &Path) -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, MemoryPlugin));
        app.init_resource::<DisplaySettings>().init_resource::<Overlays>();
        app.insert_resource(ViewerMemory::in_file(path.to_owned()));
        app.world_mut().spawn((Window::default(), PrimaryWindow));
        app
    }

    #[test]
    fn what_was_shown_is_shown_the_next_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/viewer.json");
        let mut first = app(&path);
        first.update();
        first.world_mut().resource_mut::<DisplaySettings>().light = true;
        first.world_mut().resource_mut::<Overlays>().areas = true;
        first.world_mut().resource_mut::<ViewerMemory>().note_scenario("match7v7");
        let mut windows = first.world_mut().query::<&mut Window>();
        windows.single_mut(first.world_mut()).unwrap().resolution.set(900.0, 500.0);
        first.world_mut().write_message(AppExit::Success);
        first.update();
        let mut second = app(&path);
        second.update();
        assert!(second.world().resource::<DisplaySettings>().light && second.world().resource::<Overlays>().areas);
        assert_eq!(second.world().resource::<ViewerMemory>().remembered.scenario.as_deref(), Some("match7v7"));
        let mut windows = second.world_mut().query::<&Window>();
        assert_eq!(windows.single(second.world()).unwrap().width(), 900.0);
    }

    #[test]
    fn a_window_larger_than_the_largest_screen_is_made_to_fit() {
        let screen = |physical_width, physical_height| Monitor {
            name: None,
            physical_height,
            physical_width,
            physical_position: IVec2::ZERO,
            refresh_rate_millihertz: None,
            scale_factor: 1.0,
            video_modes: Vec::new(),
        };
        let mut app = App::new();
        app.add_systems(Update, fit_to_screen);
        let window = app.world_mut().spawn((Window::default(), PrimaryWindow)).id();
        let size_after = |app: &mut App, wanted: [u32; 2]| {
            let mut shown = app.world_mut().get_mut::<Window>(window).unwrap();
            shown.resolution.set_physical_resolution(wanted[0], wanted[1]);
            app.update();
            app.world().get::<Window>(window).unwrap().resolution.physical_size().to_array()
        };
        assert_eq!(size_after(&mut app, [9000, 700]), [9000, 700], "no screen is known yet");
        app.world_mut().spawn(screen(800, 600));
        app.world_mut().spawn(screen(1920, 1080));
        assert_eq!(size_after(&mut app, [2560, 700]), [1920, 700]);
        app.world_mut().spawn(screen(640, 480));
        assert_eq!(size_after(&mut app, [1280, 720]), [1280, 720]);
    }

    #[test]
    fn the_files_that_were_opened_last_are_each_remembered_once() {
        let mut memory = ViewerMemory::default();
        for path in ["a", "b", "c", "a", "d", "e", "f", "g"] {
            memory.note_recent(path);
        }
        assert_eq!(memory.remembered.recent, ["g", "f", "e", "d", "a", "c"]);
    }

    #[test]
    fn a_file_that_is_not_understood_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("viewer.json");
        for text in ["", "{ \"shown\": 7 }", "not JSON at all"] {
            fs::write(&path, text).unwrap();
            assert_eq!(ViewerMemory::in_file(path.clone()).remembered, Remembered::default());
        }
        // Fields that a later version has added are ignored.
        fs::write(&path, "{ \"scenario\": \"kicks\", \"hologram\": true }").unwrap();
        assert_eq!(ViewerMemory::in_file(path).remembered.scenario.as_deref(), Some("kicks"));
    }
}
