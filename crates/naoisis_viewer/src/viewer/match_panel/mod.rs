//! The panel of the match: scenario, teams, noise, losses and speeds, changed while the match runs. The file of the
//! scenario is watched, and its match restarts when the file changes.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use std::path::{Path, PathBuf};

pub mod choice;
mod panel;
pub mod trace_reading;
mod watched_file;

use super::display_settings::DisplaySettings;
use super::drive::{self, PlayedFile};
use super::layout::LayoutSystems;
use super::memory::ViewerMemory;
use super::shared::{Notice, OpenedTrace, Playback};
use super::timeline;
use choice::MatchChoice;
use naoisis_record::record::read_trace::ReadTrace;
use naoisis_sim::scenario::saved_match::EXTENSION;
use naoisis_sim::scenario::{Scenario, ScenarioError, ScenarioFile, TeamsSpec};
use naoisis_sim::simulation;
pub use trace_reading::TraceReading;
use trace_reading::is_reading;
pub use watched_file::WatchedScenarioFile;

/// The files that can be opened.
const KINDS: &str = "a scenario (.json, .ron), a trace (.jsonl, .jsonl.zst, .mcap) or a saved match (.naoisis)";
/// The scenario for two teams if the current one has none.
const TEAM_MATCH: &str = "match3v3";

/// Shows and changes the match.
pub struct MatchPanelPlugin;

impl Plugin for MatchPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<WatchedScenarioFile>()
            .add_message::<MatchCommand>()
            .init_resource::<TraceReading>()
            .add_systems(First, (watched_file::forget, apply, trace_reading::show_when_read.run_if(is_reading)).chain())
            .add_systems(Update, watched_file::watch)
            .add_systems(
                EguiPrimaryContextPass,
                panel::show.run_if(|display: Res<DisplaySettings>| display.game).in_set(LayoutSystems::Right),
            );
    }
}

/// Starts another match, or changes the settings of this one.
#[derive(Message, Clone, PartialEq, Debug)]
pub enum MatchCommand {
    /// A match between two teams, by name.
    Teams(Box<TeamsSpec>),
    /// A scenario file, a built-in scenario or a trace, from the start; or a saved match.
    Open(PathBuf),
    /// The match with another league, realism or robot model, from the start.
    Choose(MatchChoice),
    /// Continues this match with the settings of a scenario.
    Change(Box<Scenario>),
}

fn apply(world: &mut World) {
    let commands: Vec<MatchCommand> = world.resource_mut::<Messages<MatchCommand>>().drain().collect();
    for command in commands {
        let is_start = !matches!(command, MatchCommand::Change(_));
        if is_start {
            world.resource_mut::<TraceReading>().give_up();
        }
        let result = match command {
            MatchCommand::Teams(teams) => play_teams(world, *teams),
            MatchCommand::Open(path) => open(world, &path),
            MatchCommand::Choose(choice) => choose(world, &choice),
            MatchCommand::Change(scenario) => {
                simulation::change_settings(world, &scenario).map_err(|fault| fault.to_string())
            }
        };
        // A change of settings does not solve an earlier problem.
        if is_start || result.is_err() {
            world.resource_mut::<Playback>().problem = result.err();
        }
    }
}

fn play_teams(world: &mut World, teams: TeamsSpec) -> Result<(), String> {
    // Teams line up on the pitch of a scenario without robots, too. One that lists its robots has no place for them.
    let takes_teams = |scenario: &&Scenario| scenario.teams.is_some() || scenario.robots.is_empty();
    let before = world.get_resource::<Scenario>().cloned();
    let present = before.clone().filter(|scenario| takes_teams(&scenario));
    // A trace of that match lists its robots, too.
    let is_same = before.as_ref().is_some_and(|before| before.name == TEAM_MATCH);
    let is_other = present.is_none() && !is_same;
    let scenario = match present {
        Some(scenario) => scenario,
        None => {
            let named = ScenarioFile::named(TEAM_MATCH).map_err(|error| error.to_string())?.scenario;
            let seed = before.filter(|_| is_same).map_or(named.seed, |before| before.seed);
            Scenario { seed, ..named }
        }
    };
    drive::start(world, &Scenario { teams: Some(teams), ..scenario }).map_err(|fault| fault.to_string())?;
    if is_other {
        world.insert_resource(WatchedScenarioFile::default());
        if let Some(mut notice) = world.get_resource_mut::<Notice>() {
            notice.tell(format!("The scenario before lists its robots, so the teams play {TEAM_MATCH} instead"));
        }
    }
    world.resource_mut::<WatchedScenarioFile>().is_changed = !is_other;
    Ok(())
}

/// Returns a path that a user has typed, with the home folder in place of `~`.
fn with_home(path: &Path) -> PathBuf {
    let in_home = path.strip_prefix("~").ok().and_then(|rest| Some(dirs::home_dir()?.join(rest)));
    in_home.unwrap_or_else(|| path.to_owned())
}

fn open(world: &mut World, path: &Path) -> Result<(), String> {
    let path = &with_home(path);
    let name = path.to_string_lossy();
    if [".jsonl", ".jsonl.zst", ".mcap"].iter().any(|ending| name.ends_with(ending)) && path.exists() {
        let begun = world.resource_mut::<TraceReading>().begin(path);
        return begun.map_err(|error| format!("{}: cannot be read: {error}", path.display()));
    }
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(EXTENSION)) && path.exists() {
        drive::go_on(world, path)?;
        world.insert_resource(WatchedScenarioFile::default());
        note_opened(world, path);
        return Ok(());
    }
    // The time of its last change is that of before it was read.
    let watched = if path.exists() { WatchedScenarioFile::of(path) } else { WatchedScenarioFile::default() };
    // Without an ending it may be the name of a built-in scenario.
    if let Some(ending) = path.extension() {
        let is_scenario = ["json", "ron"].iter().any(|known| ending.eq_ignore_ascii_case(known));
        let problem = if path.exists() { "no such kind of file is known" } else { "there is no such file" };
        if !(is_scenario && path.exists()) {
            return Err(format!("{}: {problem}; expected {KINDS}", path.display()));
        }
    }
    let words = |error: ScenarioError| error.to_string();
    let started = ScenarioFile::find(&name).map_err(words).and_then(|file| drive::start_file(world, file));
    match started {
        Ok(()) => world.insert_resource(watched),
        Err(error) => {
            world.resource_mut::<WatchedScenarioFile>().note_failed(path);
            return Err(error);
        }
    }
    note_opened(world, path);
    Ok(())
}

/// Shows a trace.
fn show_trace(world: &mut World, path: &Path, trace: ReadTrace) -> Result<(), String> {
    if trace.last.is_none() {
        return Err(format!("{}: the trace has no cycle after its header; expected at least one", path.display()));
    }
    timeline::start_replay(world, trace).map_err(|fault| format!("{}:1: {fault}", path.display()))?;
    world.insert_resource(WatchedScenarioFile::default());
    world.insert_resource(PlayedFile::default());
    world.insert_resource(OpenedTrace(Some(path.to_owned())));
    note_opened(world, path);
    Ok(())
}

/// Remembers a file that was opened.
fn note_opened(world: &mut World, path: &Path) {
    // The viewer may be started in another folder the next time, so the path is absolute.
    let path = path.canonicalize().ok().and_then(|path| path.to_str().map(str::to_owned));
    if let (Some(path), Some(mut memory)) = (path, world.get_resource_mut::<ViewerMemory>()) {
        memory.note_recent(&path);
    }
}

fn choose(world: &mut World, choice: &MatchChoice) -> Result<(), String> {
    let Some(present) = world.get_resource::<Scenario>().cloned() else { return Ok(()) };
    let file = world.resource::<PlayedFile>().0.clone();
    let chosen = choice.applied(&present, file.as_ref())?;
    if matches!(choice, MatchChoice::League(_)) {
        world.insert_resource(WatchedScenarioFile::default());
    }
    drive::start_file(world, chosen)?;
    world.resource_mut::<WatchedScenarioFile>().is_changed = true;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::commands::ViewerCommand;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use bevy::time::TimeUpdateStrategy;
    use core::time::Duration;
    use naoisis_core::robot::body::Body;
    use naoisis_core::team::{RobotId, Team};
    use naoisis_sim::scenario::{Realism, RealismSettings};
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};
    use std::fs::{self, File};
    use std::time::SystemTime;

    fn app() -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, MatchPanelPlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(100)));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        app.update();
        app
    }

    fn send(app: &mut App, command: MatchCommand) {
        app.world_mut().write_message(command);
        app.update();
    }

    fn problem(app: &App) -> Option<&str> {
        app.world().resource::<Playback>().problem.as_deref()
    }

    #[test]
    fn a_match_goes_on_with_other_settings_and_what_cannot_change_is_said() {
        let mut app = app();
        app.update();
        let cycle = app.cycle();
        let mut changed = app.world().resource::<Scenario>().clone();
        changed.messages.loss = 0.5;
        send(&mut app, MatchCommand::Change(Box::new(changed.clone())));
        assert!(app.cycle() > cycle, "it went on");
        assert_eq!(app.world().resource::<naoisis_core::communication::MessageSettings>().loss, 0.5);
        changed.cycle_s *= 2.0;
        send(&mut app, MatchCommand::Change(Box::new(changed)));
        assert!(problem(&app).unwrap().contains("cycle_s"));
    }

    #[test]
    fn a_tilde_is_the_home_folder() {
        assert_eq!(with_home(Path::new("~/a/b.json")), dirs::home_dir().unwrap().join("a/b.json"));
        assert_eq!(with_home(Path::new("a/~b.json")), Path::new("a/~b.json"));
    }

    #[test]
    fn other_teams_begin_another_match() {
        let mut app = app();
        app.update();
        let teams = TeamsSpec::new("chasers", "chasers");
        send(&mut app, MatchCommand::Teams(Box::new(teams.clone())));
        assert!(app.cycle() <= 3);
        assert_eq!(app.world().resource::<Scenario>().teams, Some(teams));
        send(&mut app, MatchCommand::Teams(Box::new(TeamsSpec::new("nobody", "chasers"))));
        assert!(problem(&app).unwrap().contains("nobody"));
        // They play on the pitch of a scenario without robots.
        let large = Scenario { teams: None, robots: Vec::new(), ..Scenario::named("hsl2026_large").unwrap() };
        app.start_match(&large).unwrap();
        send(&mut app, MatchCommand::Teams(Box::new(TeamsSpec::new("roles", "chasers"))));
        assert_eq!(app.world().resource::<naoisis_core::pitch::Pitch>().length_m, 21.88);
    }

    #[test]
    fn another_league_realism_or_model_begins_another_match() {
        let mut app = app();
        let scenario = |app: &App| app.world().resource::<Scenario>().clone();
        send(&mut app, MatchCommand::Choose(MatchChoice::League("spl2025".to_owned())));
        assert_eq!((problem(&app), scenario(&app).league.as_deref()), (None, Some("spl2025")));
        assert_eq!(scenario(&app).teams.unwrap().blue, "roles");
        send(&mut app, MatchCommand::Choose(MatchChoice::Realism(Realism::Ideal)));
        assert_eq!((problem(&app), scenario(&app).realism), (None, RealismSettings::all(Realism::Ideal)));
        assert_eq!(scenario(&app).league.as_deref(), Some("spl2025"));
        send(&mut app, MatchCommand::Choose(MatchChoice::Model(Team::Pink, Some("booster_k1".to_owned()))));
        assert_eq!(problem(&app), None);
        let [nao, k1] = [Team::Blue, Team::Pink].map(|team| app.robot::<Body>(RobotId::new(team, 1)).unwrap().height_m);
        assert!(k1 > nao + 0.2, "{k1} {nao}");
        assert_eq!(scenario(&app).realism, RealismSettings::all(Realism::Ideal), "what was chosen before stays");
        send(&mut app, MatchCommand::Choose(MatchChoice::Model(Team::Pink, Some("gundam".to_owned()))));
        assert!(problem(&app).unwrap().contains("gundam"));
    }

    #[test]
    fn a_file_that_changes_begins_again_and_a_wrong_one_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("test.json");
        let mut age = 100;
        let mut write = |text: &str| {
            fs::write(&path, text).unwrap();
            // Files that are written within one tick of the file system's clock have the same time.
            age -= 10;
            let time = SystemTime::now() - Duration::from_secs(age);
            File::options().write(true).open(&path).unwrap().set_modified(time).unwrap();
        };
        write(r#"{ "seed": 5, "robots": [{ "number": 1 }] }"#);
        let mut app = app();
        send(&mut app, MatchCommand::Open(path.clone()));
        let seed = |app: &App| app.world().resource::<Scenario>().seed;
        assert_eq!(seed(&app), 5);
        let frames = |app: &mut App| (0..10).for_each(|_| app.update());
        write(r#"{ "seed": 6, "robots": [{ "number": 1 }] }"#);
        frames(&mut app);
        assert_eq!((seed(&app), problem(&app)), (6, None));
        let cycle = app.cycle();
        write(r#"{ "sed": 6 }"#);
        frames(&mut app);
        assert!(problem(&app).unwrap().contains("sed"), "{:?}", problem(&app));
        assert!(app.cycle() > cycle);
        // A missing file changes nothing, either: the previous file is still watched.
        send(&mut app, MatchCommand::Open(folder.path().join("nothing.json")));
        assert!(problem(&app).unwrap().contains("nothing.json"), "{:?}", problem(&app));
        write(r#"{ "seed": 7, "robots": [{ "number": 1 }] }"#);
        frames(&mut app);
        assert_eq!((seed(&app), problem(&app)), (7, None));
        // Another file that is invalid is not that of the match, and is opened when it has been corrected.
        let other = folder.path().join("other.json");
        fs::write(&other, r#"{ "sed": 8 }"#).unwrap();
        File::options().write(true).open(&other).unwrap().set_modified(SystemTime::UNIX_EPOCH).unwrap();
        send(&mut app, MatchCommand::Open(other.clone()));
        let watched = app.world().resource::<WatchedScenarioFile>().clone();
        assert!(watched.words().contains("test.json: the match restarts") && watched.words().contains("other.json is"));
        assert!(!watched.without_failed().words().contains("other.json"));
        fs::write(&other, r#"{ "seed": 9, "robots": [{ "number": 1 }] }"#).unwrap();
        frames(&mut app);
        assert_eq!((seed(&app), problem(&app)), (9, None));
        send(&mut app, MatchCommand::Open(path.clone()));
        assert_eq!(seed(&app), 7);
        // When the file changes, a built-in scenario is not restarted.
        app.world_mut().write_message(ViewerCommand::Load("match3v3"));
        frames(&mut app);
        write(r#"{ "seed": 8 }"#);
        frames(&mut app);
        assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
    }
}
