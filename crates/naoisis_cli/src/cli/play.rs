//! `naoisis play`: a match in a window.

use clap::Args;
use std::path::{Path, PathBuf};

use super::agents::AgentArguments;
use super::begin::is_snapshot;
use super::game_controller::GameControllerArguments;
use super::pictures::PictureArguments;
use super::recordings::Recordings;
use super::report::{CommandResult, OrReport};
use super::run::{length_s, run, run_scenario};
use super::run_arguments::RunArguments;
use super::teams::TeamArguments;
use super::window::WindowArguments;
use super::{Program, report};
use naoisis_sim::scenario::{ScenarioError, ScenarioFile};

/// The default scenario.
const DEFAULT_SCENARIO: &str = "match3v3";

/// Arguments of `naoisis play`.
#[derive(Args, Debug, Clone, Default)]
pub struct PlayArguments {
    /// A scenario file (.ron or .json), the name of a built-in scenario (see `naoisis list scenarios`), or a match saved
    /// by `run --save` or in the window (.naoisis), which continues; without any
    /// argument about the match, the window asks, and suggests the last one or match3v3
    pub scenario: Option<String>,
    #[command(flatten)]
    pub teams: TeamArguments,
    #[command(flatten)]
    pub agents: AgentArguments,
    #[command(flatten)]
    pub game_controller: GameControllerArguments,
    /// Seed of all random numbers, instead of the scenario's
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Record the window from the start, as PNG files in this new or empty folder; without a display, the field
    #[arg(long, value_name = "DIR")]
    pub record: Option<PathBuf>,
    /// Replace existing frames
    #[arg(long)]
    pub force: bool,
    /// The window.
    #[command(flatten)]
    pub window: WindowArguments,
}

impl PlayArguments {
    /// Returns whether no argument says which match to play. Then the window asks.
    #[cfg(feature = "viewer")]
    fn names_nothing_to_play(&self) -> bool {
        let Self { scenario, teams, game_controller, seed, record, .. } = self;
        scenario.is_none()
            && teams.blue.is_none()
            && teams.pink.is_none()
            && seed.is_none()
            && record.is_none()
            && *game_controller == GameControllerArguments::default()
    }
}

/// Runs the command. Without a display the match is played headless, with a note, so that scripts do not wait.
pub fn play(program: Program<'static>, arguments: &PlayArguments) -> CommandResult {
    let display = display();
    if let Some(name) = arguments.scenario.as_ref().filter(|name| is_snapshot(Path::new(name))) {
        return go_on(program, name, display, arguments);
    }
    let (name, mut file) = find(arguments, display.is_ok()).map_err(|errors| report::scenario_errors(&errors))?;
    if let Some(seed) = arguments.seed {
        file.scenario.seed = seed;
    }
    arguments.teams.choose(program.simulator().world(), &mut file).or_usage_error()?;
    play_file(program, name, &file, display, arguments)
}

/// Plays a scenario that has been read, from the file or built-in scenario `name`.
pub(super) fn play_file(
    program: Program<'static>,
    name: String,
    file: &ScenarioFile,
    display: Result<(), &'static str>,
    arguments: &PlayArguments,
) -> CommandResult {
    match display {
        #[cfg(feature = "viewer")]
        Ok(()) => watch(program, &name, Some(file), arguments),
        #[cfg(not(feature = "viewer"))]
        Ok(()) => Ok(std::process::ExitCode::SUCCESS),
        Err(reason) => {
            let length_s = length_s(&file.scenario);
            report::note(&format!(
                "{reason}: running the match headless, {length_s:.0} s of it, as fast as it goes; Ctrl-C ends it"
            ));
            run_scenario(program, file, &headless(name, arguments))
        }
    }
}

/// Continues a saved match.
fn go_on(
    program: Program<'static>,
    name: &str,
    display: Result<(), &'static str>,
    arguments: &PlayArguments,
) -> CommandResult {
    match display {
        #[cfg(feature = "viewer")]
        Ok(()) => watch(program, name, None, arguments),
        #[cfg(not(feature = "viewer"))]
        Ok(()) => Ok(std::process::ExitCode::SUCCESS),
        Err(reason) => {
            report::note(&format!("{reason}: continuing the match headless, as fast as it goes; Ctrl-C ends it"));
            run(program, &RunArguments { seed: arguments.seed, ..headless(name.to_owned(), arguments) })
        }
    }
}

/// The arguments of `naoisis run` for the same match.
fn headless(scenario: String, arguments: &PlayArguments) -> RunArguments {
    let pictures = PictureArguments { frames: arguments.record.clone(), ..PictureArguments::default() };
    RunArguments {
        scenario,
        recordings: Recordings { pictures, ..Recordings::default() },
        teams: arguments.teams.clone(),
        agents: arguments.agents.clone(),
        game_controller: arguments.game_controller.clone(),
        force: arguments.force,
        ..RunArguments::default()
    }
}

/// Returns the scenario of the command line. Without one, it is the last one that was watched, if it still exists.
fn find(arguments: &PlayArguments, has_window: bool) -> Result<(String, ScenarioFile), Vec<ScenarioError>> {
    let check = |name: &str| ScenarioFile::check(name, |_| Vec::new());
    if let Some(name) = &arguments.scenario {
        return Ok((name.clone(), check(name)?));
    }
    match last_watched().filter(|_| has_window) {
        Some(last) => Ok(last),
        None => Ok((DEFAULT_SCENARIO.to_owned(), check(DEFAULT_SCENARIO)?)),
    }
}

/// Returns the scenario that was watched last, if it still exists.
#[cfg(feature = "viewer")]
fn last_watched() -> Option<(String, ScenarioFile)> {
    let name = naoisis_viewer::viewer::memory::ViewerMemory::of_user().remembered.scenario?;
    let file = ScenarioFile::find(&name).ok()?;
    Some((name, file))
}

#[cfg(not(feature = "viewer"))]
fn last_watched() -> Option<(String, ScenarioFile)> {
    None
}

/// Checks whether a window can be opened. The error says why not.
#[cfg(not(feature = "viewer"))]
pub(super) fn display() -> Result<(), &'static str> {
    Err("this program was built without the viewer")
}

/// Checks whether a window can be opened. The error says why not.
#[cfg(all(feature = "viewer", unix, not(target_os = "macos")))]
pub(super) fn display() -> Result<(), &'static str> {
    if std::env::var_os("DISPLAY").is_none_or(|display| display.is_empty()) {
        return Err("there is no display");
    }
    match x11rb::connect(None) {
        Ok((connection, _)) => {
            // The connection stays open: a server restarts when its last client leaves, and refuses clients meanwhile.
            core::mem::forget(connection);
            adapter()
        }
        Err(_) => Err("the display does not answer"),
    }
}

/// Checks whether a window can be opened. The error says why not.
#[cfg(all(feature = "viewer", not(all(unix, not(target_os = "macos")))))]
pub(super) fn display() -> Result<(), &'static str> {
    adapter()
}

/// Checks whether there is something to draw with. The error says what to install.
#[cfg(feature = "viewer")]
fn adapter() -> Result<(), &'static str> {
    naoisis_gpu::renderer::check_adapter().map_err(|_| {
        "there is no graphics driver with Vulkan, Metal or DirectX 12; install that of the graphics card, or one that draws without a \
         graphics card (`mesa-vulkan-drivers` on Debian, Ubuntu and Fedora, `vulkan-swrast` on Arch)"
    })
}

#[cfg(feature = "viewer")]
fn watch(
    program: Program<'static>,
    name: &str,
    file: Option<&ScenarioFile>,
    arguments: &PlayArguments,
) -> CommandResult {
    use super::begin;
    use super::pictures::or_force;
    use super::window;
    use naoisis_record::record::film::Film;
    use naoisis_record::record::frames::remove_frames;
    use naoisis_sim::simulation::MatchApp;
    use naoisis_viewer::viewer::drive::PlayedFile;
    use naoisis_viewer::viewer::film::Filming;
    use naoisis_viewer::viewer::match_panel::WatchedScenarioFile;
    use naoisis_viewer::viewer::memory::ViewerMemory;
    use naoisis_viewer::viewer::start_page::StartPage;

    let mut app = window::open(program, &arguments.window).or_usage_error()?;
    match file {
        Some(file) => {
            app.insert_resource(arguments.agents.settings(name, &arguments.teams));
            app.start_match(&file.scenario).map_err(|fault| report::scenario_error(&file.source.error(&fault)))?;
            app.insert_resource(PlayedFile(Some(file.clone())));
        }
        None => {
            begin::restore(&mut app, name, &arguments.teams, &arguments.agents, arguments.seed).or_usage_error()?;
        }
    }
    arguments.game_controller.start(app.world_mut()).or_usage_error()?;
    // The program may be started in another folder the next time, so the path is absolute.
    let path = Path::new(name).canonicalize();
    if let Ok(path) = &path
        && file.is_some()
    {
        app.insert_resource(WatchedScenarioFile::of(path));
    }
    let path = path.ok().and_then(|path| path.to_str().map(str::to_owned));
    let mut memory = app.world_mut().resource_mut::<ViewerMemory>();
    if let Some(path) = &path {
        memory.note_recent(path);
    }
    if file.is_some() {
        memory.note_scenario(path.as_deref().unwrap_or(name));
    }
    if arguments.names_nothing_to_play() {
        app.insert_resource(StartPage(true));
    }
    if let Some(folder) = &arguments.record {
        let cleared = if arguments.force { remove_frames(folder) } else { Ok(()) };
        match cleared.and_then(|()| Film::create_frames(folder)) {
            Ok(film) => app.world_mut().resource_mut::<Filming>().begin(film, 0.0),
            Err(error) => return Err(report::usage_error(&format!("--record: {error}{}", or_force(&error)))),
        }
    }
    window::show(app, &arguments.window)
}

#[cfg(all(test, feature = "viewer"))]
mod tests {
    use super::*;

    #[test]
    fn only_who_says_nothing_of_the_match_is_asked() {
        let of = |change: fn(&mut PlayArguments)| {
            let mut arguments = PlayArguments::default();
            change(&mut arguments);
            arguments.names_nothing_to_play()
        };
        assert!(of(|_| ()) && of(|arguments| arguments.force = true));
        assert!(!of(|arguments| arguments.scenario = Some("match1v1".to_owned())));
        assert!(!of(|arguments| arguments.teams.blue = Some("exec:python3 my_team.py".to_owned())));
        assert!(!of(|arguments| arguments.seed = Some(3)));
        assert!(!of(|arguments| arguments.game_controller.team_messages = true));
    }
}
