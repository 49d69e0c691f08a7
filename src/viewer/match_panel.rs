//! What is played: scenario, teams, noise, losses and speeds, changed while it runs; a scenario's file is watched, and its
//! match begins again when the file changes.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, ComboBox, Grid, Slider};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::display_settings::{DisplaySettings, Switch};
use super::drive;
use super::shared::{Action, Playback, ViewerCommand};
use super::theme::{MARGIN, ThemeSystems, bright, dim, text_size};
use super::timeline::Timeline;
use crate::ball::Rolling;
use crate::behaviour::BehaviourRegistry;
use crate::scenario::{LIBRARY, Scenario, ScenarioFile, TeamsSpec};
use crate::sensing::fidelity::{Fidelities, Fidelity};
use crate::simulation;

/// How often a scenario's file is looked at, s.
const LOOK_EVERY_S: f32 = 0.5;
/// The scenario in which two teams are lined up, where the present one has none.
const TEAM_MATCH: &str = "match3v3";
/// In place of the name of a team, where robots are none.
const NOBODY: &str = "—";
/// What the panel leaves of the window's height, logical pixels.
const AROUND: f32 = 80.0;

/// Shows and changes what is played.
pub struct MatchPanelPlugin;

impl Plugin for MatchPanelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<WatchedScenarioFile>()
            .add_message::<MatchCommand>()
            .add_systems(First, (forget_file, obey).chain())
            .add_systems(Update, watch_file)
            .add_systems(
                EguiPrimaryContextPass,
                show_panel.run_if(|display: Res<DisplaySettings>| display.game).after(ThemeSystems),
            );
    }
}

/// Another match, or other settings of this one.
#[derive(Message, Clone, PartialEq, Debug)]
pub enum MatchCommand {
    /// A match between two teams, by name.
    Teams(Box<TeamsSpec>),
    /// The scenario of this file, or built-in one, from the start.
    Open(PathBuf),
    /// This match goes on with the settings of this scenario.
    Change(Box<Scenario>),
}

/// The file that the scenario is from, if any. The match begins again when it changes.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
pub struct WatchedScenarioFile {
    file: Option<PathBuf>,
    modified: Option<SystemTime>,
    is_gone: bool,
}

impl WatchedScenarioFile {
    /// From now on this file is watched.
    pub fn of(file: &Path) -> Self {
        Self { file: Some(file.to_owned()), modified: modified(file), is_gone: false }
    }

    /// Where the scenario is from, for people.
    fn words(&self) -> String {
        match &self.file {
            Some(file) if self.is_gone => format!("{} is gone; the match goes on", file.display()),
            Some(file) => format!("{} begins again when the file changes", file.display()),
            None => "built in".to_owned(),
        }
    }
}

fn modified(file: &Path) -> Option<SystemTime> {
    file.metadata().and_then(|metadata| metadata.modified()).ok()
}

/// A built-in scenario has no file.
fn forget_file(mut commands: MessageReader<ViewerCommand>, mut source: ResMut<WatchedScenarioFile>) {
    if commands.read().any(|command| matches!(command, ViewerCommand::Load(_))) {
        *source = WatchedScenarioFile::default();
    }
}

/// Begins the match again when its file has changed. One that cannot be read changes nothing, and is said.
fn watch_file(
    time: Res<Time<Real>>,
    mut since_s: Local<f32>,
    mut source: ResMut<WatchedScenarioFile>,
    mut commands: MessageWriter<MatchCommand>,
) {
    *since_s += time.delta_secs();
    if *since_s < LOOK_EVERY_S {
        return;
    }
    *since_s = 0.0;
    let Some(file) = source.file.clone() else { return };
    let now = modified(&file);
    source.is_gone = now.is_none();
    // While it is being replaced there is no such file.
    if now.is_some() && now != source.modified {
        source.modified = now;
        commands.write(MatchCommand::Open(file));
    }
}

fn obey(world: &mut World) {
    let commands: Vec<MatchCommand> = world.resource_mut::<Messages<MatchCommand>>().drain().collect();
    for command in commands {
        let is_start = !matches!(command, MatchCommand::Change(_));
        let result = match command {
            MatchCommand::Teams(teams) => play_teams(world, *teams),
            MatchCommand::Open(path) => open(world, &path),
            MatchCommand::Change(scenario) => {
                simulation::change_settings(world, &scenario).map_err(|fault| fault.to_string())
            }
        };
        // Other settings do not mend what was wrong before.
        if is_start || result.is_err() {
            world.resource_mut::<Playback>().problem = result.err();
        }
    }
}

fn play_teams(world: &mut World, teams: TeamsSpec) -> Result<(), String> {
    let present = world.get_resource::<Scenario>().filter(|scenario| scenario.teams.is_some()).cloned();
    let scenario = match present {
        Some(scenario) => scenario,
        None => ScenarioFile::named(TEAM_MATCH).map_err(|error| error.to_string())?.scenario,
    };
    drive::start(world, &Scenario { teams: Some(teams), ..scenario }).map_err(|fault| fault.to_string())
}

fn open(world: &mut World, path: &Path) -> Result<(), String> {
    let name = path.to_string_lossy();
    // Whatever is wrong with it, the file is watched: it may be right the next time.
    world.insert_resource(if path.exists() { WatchedScenarioFile::of(path) } else { WatchedScenarioFile::default() });
    let file = ScenarioFile::find(&name).map_err(|error| error.headline())?;
    drive::start(world, &file.scenario).map_err(|fault| file.source.error(&fault).headline())
}

/// What the panel keeps from frame to frame.
#[derive(Default)]
struct Typed {
    path: String,
}

fn show_panel(
    mut contexts: EguiContexts,
    mut typed: Local<Typed>,
    scenario: Option<Res<Scenario>>,
    registry: Res<BehaviourRegistry>,
    source: Res<WatchedScenarioFile>,
    timeline: Res<Timeline>,
    mut actions: MessageWriter<Action>,
    mut viewer_commands: MessageWriter<ViewerCommand>,
    mut commands: MessageWriter<MatchCommand>,
) -> Result {
    let Some(scenario) = scenario else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let room = context.content_rect();
    let mut is_open = true;
    // At the side, where it hides little, and from where it can be moved.
    egui::Window::new(bright("The match").size(text_size::IMPORTANT))
        .id(egui::Id::new("match"))
        .pivot(Align2::RIGHT_CENTER)
        .default_pos(room.right_center() - egui::vec2(MARGIN, 0.0))
        .constrain(true)
        .resizable(false)
        .collapsible(false)
        .vscroll(true)
        .max_height(room.height() - AROUND)
        .open(&mut is_open)
        .show(context, |ui| {
            Grid::new("what is played").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
                let label = ui.label("Scenario").id;
                let name = if scenario.name.is_empty() { "—" } else { &scenario.name };
                let list = ComboBox::from_id_salt("built-in scenario").selected_text(name);
                list.show_ui(ui, |ui| {
                    for entry in LIBRARY {
                        if ui.selectable_label(entry.name == scenario.name, entry.name).clicked() {
                            viewer_commands.write(ViewerCommand::Load(entry.name));
                        }
                    }
                })
                .response
                .labelled_by(label);
                ui.end_row();
                let label = ui.label("File").id;
                ui.horizontal(|ui| {
                    let text = egui::TextEdit::singleline(&mut typed.path);
                    let text = ui.add(text.hint_text("scenario.json").desired_width(220.0)).labelled_by(label);
                    let is_entered = text.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
                    if (ui.button("Open").clicked() || is_entered) && !typed.path.trim().is_empty() {
                        commands.write(MatchCommand::Open(typed.path.trim().into()));
                    }
                });
                ui.end_row();
                ui.label("");
                ui.add(egui::Label::new(dim(source.words())).wrap());
                ui.end_row();
                // A scenario may have robots, but no teams: whoever chooses one lines up two.
                let teams = scenario.teams.clone();
                let nobody = || TeamsSpec::new(NOBODY, NOBODY);
                let mut chosen = teams.clone().unwrap_or_else(nobody);
                for (side, name) in [("Blue", &mut chosen.blue), ("Pink", &mut chosen.pink)] {
                    let label = ui.label(side).id;
                    let list = ComboBox::from_id_salt(side).selected_text(name.as_str());
                    list.show_ui(ui, |ui| {
                        for (team, recipe) in registry.teams() {
                            ui.selectable_value(name, team.to_owned(), team).on_hover_text(&recipe.description);
                        }
                    })
                    .response
                    .labelled_by(label);
                    ui.end_row();
                }
                if chosen != teams.unwrap_or_else(nobody) {
                    commands.write(MatchCommand::Teams(Box::new(lined_up(chosen))));
                }
            });
            if !timeline.is_replay() {
                ui.separator();
                ui.label(bright("While it runs"));
                let mut changed = scenario.clone();
                show_settings(ui, &mut changed);
                if changed != *scenario {
                    commands.write(MatchCommand::Change(Box::new(changed)));
                }
            }
        });
    if !is_open {
        actions.write(Action::Toggle(Switch::Game));
    }
    Ok(())
}

/// Two teams, of which one may not have been chosen yet.
fn lined_up(chosen: TeamsSpec) -> TeamsSpec {
    let usual = TeamsSpec::default();
    let or_usual = |name: String, usual| if name == NOBODY { usual } else { name };
    TeamsSpec {
        blue: or_usual(chosen.blue, usual.blue),
        pink: or_usual(chosen.pink, usual.pink),
        robots: chosen.robots,
    }
}

/// The settings that can change in the middle of a match.
fn show_settings(ui: &mut egui::Ui, scenario: &mut Scenario) {
    Grid::new("settings").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
        let hint = "What robots perceive: perfectly, within their limits, or with noise";
        let label = ui.label("Sensors").on_hover_text(hint).id;
        let now = scenario.fidelity.vision.unwrap_or_default();
        let mut fidelity = now;
        let list = ComboBox::from_id_salt("fidelity").selected_text(fidelity_name(now));
        list.show_ui(ui, |ui| {
            for choice in [Fidelity::Truth, Fidelity::Ideal, Fidelity::Noisy, Fidelity::Image] {
                ui.selectable_value(&mut fidelity, choice, fidelity_name(choice));
            }
        })
        .response
        .labelled_by(label);
        if fidelity != now {
            scenario.fidelity = Fidelities::all(fidelity);
        }
    });
    let mut slider = |name: &str, hint: &str, slider: Slider| {
        ui.add(slider.text(name)).on_hover_text(hint);
    };
    let messages = &mut scenario.messages;
    slider("Messages lost", "The share of messages that do not arrive", Slider::new(&mut messages.loss, 0.0..=1.0));
    let delay = Slider::new(&mut messages.delay_cycles, 1..=90).suffix(" cycles");
    slider("Message delay", "From sending to arrival", delay);
    let motion = &mut scenario.motion;
    let speed = Slider::new(&mut motion.max_linear_mps, 0.05..=1.0).suffix(" m/s");
    slider("Walking speed", "The greatest, of robots without one of their own", speed);
    let mut turn_deg = motion.max_angular.to_degrees();
    slider("Turning speed", "The greatest", Slider::new(&mut turn_deg, 10.0..=360.0).suffix("°/s"));
    if (turn_deg - motion.max_angular.to_degrees()).abs() > 1e-3 {
        motion.max_angular = turn_deg.to_radians();
    }
    let error = &mut motion.error_sd;
    let walk = Slider::new(&mut error.dx_m, 0.0..=0.01).suffix(" m").fixed_decimals(4);
    slider("Walking error", "Spread in each cycle", walk);
    if let Some(ball) = &mut scenario.ball
        && let Rolling::ExponentialPerS(drag) = &mut ball.rolling
    {
        slider("Drag of the ball", "How fast it slows down", Slider::new(drag, 0.05..=2.0).suffix(" /s"));
    }
}

fn fidelity_name(fidelity: Fidelity) -> &'static str {
    match fidelity {
        Fidelity::Truth => "truth",
        Fidelity::Ideal => "ideal",
        Fidelity::Noisy => "noisy",
        Fidelity::Image => "image",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::{MatchApp, NaoisisPlugins};
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use bevy::time::TimeUpdateStrategy;
    use core::time::Duration;
    use std::fs::{self, File};

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
        assert_eq!(app.world().resource::<crate::communication::MessageSettings>().loss, 0.5);
        changed.cycle_s *= 2.0;
        send(&mut app, MatchCommand::Change(Box::new(changed)));
        assert!(problem(&app).unwrap().contains("cycle_s"));
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
    }

    #[test]
    fn where_no_teams_play_the_one_that_is_chosen_meets_the_usual_one() {
        let chosen = TeamsSpec::new(NOBODY, "passers");
        assert_eq!(lined_up(chosen), TeamsSpec::new("roles", "passers"));
    }

    #[test]
    fn a_file_that_changes_begins_again_and_a_wrong_one_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("test.json");
        let mut age = 100;
        let mut write = |text: &str| {
            fs::write(&path, text).unwrap();
            // Files written within a tick of the file system's clock have the same time.
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
        // A built-in scenario is not begun again for it.
        app.world_mut().write_message(ViewerCommand::Load("match3v3"));
        frames(&mut app);
        write(r#"{ "seed": 8 }"#);
        frames(&mut app);
        assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
    }
}
