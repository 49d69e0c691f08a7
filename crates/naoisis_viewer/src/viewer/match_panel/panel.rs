//! The contents of the match panel.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, ComboBox, Grid, Slider, SliderClamping};
use std::path::PathBuf;

use super::choice::{MatchChoice, REALISMS, leagues, models};
use super::{MatchCommand, WatchedScenarioFile};
use crate::viewer::commands::{Action, HandAction, ViewerCommand};
use crate::viewer::display_settings::Switch;
use crate::viewer::dock::{Dock, Edge, PanelSizes, title};
use crate::viewer::scenario_list;
use crate::viewer::shared::OpenedTrace;
use crate::viewer::theme::{bright, dim};
use crate::viewer::timeline::Timeline;
use naoisis_core::ball::Rolling;
use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::team_names::team_names;
use naoisis_sensing::sensing::fidelity::Fidelity;
use naoisis_sim::scenario::{Realism, Scenario, TeamsSpec};

/// Shown instead of the name of a team, league or scenario that has none.
const NONE: &str = "none";
/// The panel.
const DOCK: Dock = Dock { name: "match", edge: Edge::Right, size: 430.0, least: 240.0, most_share: 0.5 };
/// The width of the buttons beside the path of a file, logical pixels.
const BESIDE_PATH: f32 = 150.0;
/// The greatest height of lists, logical pixels.
const LIST_HEIGHT: f32 = 460.0;

/// The state of the panel.
#[derive(Default)]
pub(super) struct Typed {
    path: String,
    /// The name of the file or trace that was shown when it was typed.
    beside: String,
}

/// Shows the panel.
pub(super) fn show(
    mut contexts: EguiContexts,
    mut typed: Local<Typed>,
    scenario: Option<Res<Scenario>>,
    registry: Res<BehaviourRegistry>,
    (source, trace): (Res<WatchedScenarioFile>, Option<Res<OpenedTrace>>),
    timeline: Res<Timeline>,
    mut sizes: ResMut<PanelSizes>,
    mut actions: MessageWriter<Action>,
    mut viewer_commands: MessageWriter<ViewerCommand>,
    mut commands: MessageWriter<MatchCommand>,
) -> Result {
    let Some(scenario) = scenario else { return Ok(()) };
    DOCK.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        if title(ui, "The match") {
            actions.write(Action::Toggle(Switch::Game));
        }
        let width = ui.available_width();
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            // Texts wrap at the edge of the panel.
            ui.set_max_width(width);
            Grid::new("what is played").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
                let label = ui.label("Scenario").id;
                let of_file = source.name().unwrap_or_else(|| NONE.to_owned());
                let name = if scenario.name.is_empty() { &of_file } else { &scenario.name };
                let list = ComboBox::from_id_salt("built-in scenario").truncate().selected_text(name);
                scenario_list::show(ui, list, &scenario.name, |name| {
                    viewer_commands.write(ViewerCommand::Load(name));
                })
                .labelled_by(label);
                ui.end_row();
                if let Some(path) = show_path(ui, &mut typed.path, &mut actions) {
                    commands.write(MatchCommand::Open(path));
                }
                ui.label("");
                let trace = trace.as_ref().and_then(|trace| trace.0.as_ref()).filter(|_| timeline.is_replay());
                let shown = trace.map_or_else(|| source.words(), |trace| format!("the trace {}", trace.display()));
                if typed.beside != shown {
                    // The file has been opened, or another one.
                    *typed = Typed { beside: shown.clone(), ..default() };
                }
                ui.add(egui::Label::new(dim(shown)).wrap());
                ui.end_row();
                ui.label("");
                let save = egui::Button::new("Save the match");
                let hint = "Its state, to continue it later, and its trace, as new files (Ctrl S)";
                let save = ui.add_enabled(!timeline.is_replay(), save).on_hover_text(hint);
                if save.on_disabled_hover_text("A trace is saved already; a branch of it (F) can be").clicked() {
                    actions.write(Action::Hand(HandAction::KeepMatch));
                }
                ui.end_row();
                let teams = teams_of(&scenario, &registry);
                let mut chosen = teams.clone();
                show_team(ui, "Blue", &mut chosen.blue, &registry);
                show_team(ui, "Pink", &mut chosen.pink, &registry);
                if chosen != teams {
                    commands.write(MatchCommand::Teams(Box::new(lined_up(chosen))));
                }
                if let Some(choice) = show_choices(ui, &scenario) {
                    commands.write(MatchCommand::Choose(choice));
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
    });
    Ok(())
}

/// Shows the field for the path of a file. Returns the path of a file to open.
fn show_path(ui: &mut egui::Ui, path: &mut String, actions: &mut MessageWriter<Action>) -> Option<PathBuf> {
    let label = ui.label("File").id;
    let row = ui.horizontal(|ui| {
        let width = (ui.available_width() - BESIDE_PATH).clamp(40.0, 180.0);
        let text = egui::TextEdit::singleline(path);
        let text = ui.add(text.hint_text("scenario.json").desired_width(width)).labelled_by(label);
        let is_entered = text.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let is_typed = !path.trim().is_empty();
        let open = ui.add_enabled(is_typed, egui::Button::new("Open"));
        let open = open.on_disabled_hover_text("Type the path of a file first").clicked();
        if ui.button("Choose…").on_hover_text("Ctrl O").clicked() {
            actions.write(Action::OpenFile);
        }
        (open || (is_entered && is_typed)).then(|| path.trim().into())
    });
    ui.end_row();
    row.inner
}

/// Shows the team of a side, and the list to choose another one.
fn show_team(ui: &mut egui::Ui, side: &str, name: &mut String, registry: &BehaviourRegistry) {
    let label = ui.label(side).id;
    let list = ComboBox::from_id_salt(side).width(220.0).truncate().selected_text(name.as_str());
    list.show_ui(ui, |ui| {
        for (team, recipe) in registry.teams() {
            ui.selectable_value(name, team.to_owned(), team).on_hover_text(&recipe.description);
        }
    })
    .response
    .labelled_by(label);
    ui.end_row();
}

/// Shows league, realism and models. Returns a new choice.
fn show_choices(ui: &mut egui::Ui, scenario: &Scenario) -> Option<MatchChoice> {
    let mut chosen = None;
    let mut line = |ui: &mut egui::Ui,
                    name: &str,
                    hint: &str,
                    now: &str,
                    entries: &[(String, String)],
                    choice: &dyn Fn(&str) -> MatchChoice| {
        let label = ui.label(name).on_hover_text(hint).id;
        let list = ComboBox::from_id_salt(name).selected_text(now).height(LIST_HEIGHT);
        let shown = list.show_ui(ui, |ui| {
            for (entry, description) in entries {
                let row = ui.selectable_label(entry == now, entry).on_hover_text(description);
                if row.clicked() && entry != now {
                    chosen = Some(choice(entry));
                }
            }
        });
        shown.response.labelled_by(label);
        ui.end_row();
    };
    let hint = "A new match of these teams with the pitch, ball, rules, robots and realism of a league";
    let league = scenario.league.as_deref().unwrap_or(NONE);
    line(ui, "League", hint, league, leagues(), &|name| MatchChoice::League(name.to_owned()));
    let hint = "The level of realism of all settings that the scenario leaves out";
    let realism = scenario.realism_in_words();
    let words = REALISMS.map(|(word, about)| (word.name().to_owned(), about.to_owned()));
    let realism_of = |name: &str| {
        REALISMS.iter().find(|(word, _)| word.name() == name).map_or(Realism::default(), |(word, _)| *word)
    };
    line(ui, "Realism", hint, &realism, &words, &|name| MatchChoice::Realism(realism_of(name)));
    let Some(teams) = &scenario.teams else {
        ui.label("Robots");
        ui.label(dim("as the scenario lists them"));
        ui.end_row();
        return chosen;
    };
    for team in Team::BOTH {
        let own = teams.robots[team].model.as_deref();
        let (title, now) = (format!("Robots of {team}"), own.unwrap_or(&scenario.model));
        let hint = "The robot model of this team";
        line(ui, &title, hint, now, models(), &|name| MatchChoice::Model(team, Some(name.to_owned())));
    }
    chosen
}

/// The teams of a scenario. A scenario that lists robots, as that of a trace does, has the registered teams with their
/// behaviours.
fn teams_of(scenario: &Scenario, registry: &BehaviourRegistry) -> TeamsSpec {
    let named = |team: Team, name: String| if name == team.name() { NONE.to_owned() } else { name };
    scenario.teams.clone().unwrap_or_else(|| {
        let PerTeam { blue, pink } = team_names(scenario, registry);
        TeamsSpec::new(named(Team::Blue, blue), named(Team::Pink, pink))
    })
}

/// The teams after a choice in which one team may be missing.
fn lined_up(chosen: TeamsSpec) -> TeamsSpec {
    let usual = TeamsSpec::default();
    let or_usual = |name: String, usual| if name == NONE { usual } else { name };
    TeamsSpec {
        blue: or_usual(chosen.blue, usual.blue),
        pink: or_usual(chosen.pink, usual.pink),
        robots: chosen.robots,
    }
}

/// Shows the settings that can change during a match.
fn show_settings(ui: &mut egui::Ui, scenario: &mut Scenario) {
    Grid::new("settings").num_columns(2).spacing([16.0, 6.0]).show(ui, |ui| {
        let hint = "What robots perceive: perfectly, within their limits, or with noise";
        let label = ui.label("Sensors").on_hover_text(hint).id;
        let now = scenario.settings.vision.fidelity();
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
            scenario.set_fidelity(fidelity);
        }
    });
    // A value beyond the slider stays until it is edited.
    let mut slider = |name: &str, hint: &str, slider: Slider| {
        ui.add(slider.clamping(SliderClamping::Edits).text(name)).on_hover_text(hint);
    };
    let messages = &mut scenario.messages;
    slider("Messages lost", "The share of messages that do not arrive", Slider::new(&mut messages.loss, 0.0..=1.0));
    let cycles = if messages.delay_cycles == 1 { " cycle" } else { " cycles" };
    let delay = Slider::new(&mut messages.delay_cycles, 1..=90).suffix(cycles);
    slider("Message delay", "From sending to arrival", delay);
    let motion = &mut scenario.settings.motion;
    let speed = Slider::new(&mut motion.max_linear_mps, 0.05..=1.0).suffix(" m/s");
    slider("Walking speed", "The greatest walking speed, m/s, of robots without one of their own", speed);
    let mut turn_deg = motion.max_angular.to_degrees();
    slider("Turning speed", "The greatest turning speed", Slider::new(&mut turn_deg, 10.0..=360.0).suffix("°/s"));
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
    use naoisis_sim::simulation::{self, NaoisisPlugins};

    #[test]
    fn looking_at_the_settings_changes_none() {
        for league in naoisis_sim::scenario::LEAGUES {
            let mut scenario = Scenario::from_json(&format!(r#"{{ "league": "{}" }}"#, league.name)).unwrap();
            let before = scenario.clone();
            let context = egui::Context::default();
            for _ in 0..2 {
                let mut output = context.run_ui(egui::RawInput::default(), |ui| show_settings(ui, &mut scenario));
                output.textures_delta.clear();
            }
            assert!(scenario == before, "{}", league.name);
        }
    }

    #[test]
    fn where_no_teams_play_the_one_that_is_chosen_meets_the_usual_one() {
        let chosen = TeamsSpec::new(NONE, "passers");
        assert_eq!(lined_up(chosen), TeamsSpec::new("roles", "passers"));
    }

    #[test]
    fn the_teams_of_a_trace_are_those_with_the_behaviours_of_its_robots() {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        let registry = app.world().resource::<BehaviourRegistry>();
        let scenario = Scenario::from_json(r#"{ "teams": { "blue": "roles", "pink": "chasers" } }"#).unwrap();
        let listed = simulation::resolved(app.world(), &scenario);
        assert_eq!(listed.teams, None);
        assert_eq!(teams_of(&listed, registry), TeamsSpec::new("roles", "chasers"));
        let scripted = Scenario::from_json(r#"{ "robots": [{ "team": "pink", "number": 1 }] }"#).unwrap();
        assert_eq!(teams_of(&scripted, registry), TeamsSpec::new(NONE, NONE));
    }
}
