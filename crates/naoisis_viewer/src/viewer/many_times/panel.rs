//! The panel of repetitions: their number, the progress, the outcomes.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, DragValue, Grid, ProgressBar};

use super::{ManyTimes, ManyTimesCommand, Outcome, Run, heat_map, saved_test};
use crate::viewer::commands::Action;
use crate::viewer::display_settings::Switch;
use crate::viewer::dock::{Dock, Edge, PanelSizes, title};
use crate::viewer::keyframes::Keyframes;
use crate::viewer::theme::{dim, minutes, team_colour, text_size};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Interventions;
use naoisis_core::statistics::{Estimate, rounded};
use naoisis_core::team::Team;
use naoisis_record::whatif::Outcomes;

/// The panel.
const DOCK: Dock = Dock { name: "many times", edge: Edge::Right, size: 330.0, least: 200.0, most_share: 0.45 };

/// The state of the panel: the expectation of a test.
#[derive(Default)]
pub(super) struct Expected {
    pink: bool,
    percent: Option<f64>,
}

pub(super) fn show(
    mut contexts: EguiContexts,
    mut expected: Local<Expected>,
    mut many: ResMut<ManyTimes>,
    (clock, interventions, keyframes): (Res<CycleClock>, Res<Interventions>, Res<Keyframes>),
    mut commands: MessageWriter<ManyTimesCommand>,
    mut sizes: ResMut<PanelSizes>,
    mut actions: MessageWriter<Action>,
) -> Result {
    DOCK.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        if title(ui, "This moment, many times") {
            actions.write(Action::Toggle(Switch::ManyTimes));
        }
        let width = ui.available_width();
        egui::ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            // Texts wrap at the edge of the panel.
            ui.set_max_width(width);
            let many = &mut *many;
            ui.horizontal(|ui| {
                ui.add(DragValue::new(&mut many.times).range(10..=10_000).suffix(" times"));
                ui.label("for");
                ui.add(DragValue::new(&mut many.for_s).range(1.0..=600.0).suffix(" s"));
                if many.run.as_ref().is_some_and(|run| run.is_running) {
                    if ui.button("Stop").clicked() {
                        commands.write(ManyTimesCommand::Stop);
                    }
                } else if many.awaited.is_some() {
                    ui.spinner();
                } else if ui
                    .button("Begin")
                    .on_hover_text("Plays on from the moment that is shown, with other random numbers")
                    .clicked()
                {
                    commands.write(ManyTimesCommand::Begin);
                }
            });
            if let Some(run) = &many.run {
                ui.separator();
                if !run.keyframes.is_same(&keyframes) {
                    ui.label(egui::RichText::new("Of another match or branch:").strong());
                }
                show_run(ui, run, &clock, &mut commands);
                let is_changed = run.is_changed_since(&clock, &interventions, &keyframes);
                show_test(ui, run, is_changed, &mut expected, &mut commands);
            }
        });
    });
    Ok(())
}

fn show_run(ui: &mut egui::Ui, run: &Run, clock: &CycleClock, commands: &mut MessageWriter<ManyTimesCommand>) {
    let at = minutes((run.cycle as f64 * clock.period_s) as f32);
    ui.label(format!("From {at} on, for {:.0} s", run.for_s));
    let (played, times) = (run.rows.len(), run.times);
    ui.add(ProgressBar::new(played as f32 / times as f32).text(format!("{played} of {times}")));
    if !run.is_running && played < times {
        ui.label(format!("Stopped after {played} of {times}"));
    }
    if run.rows.is_empty() {
        return;
    }
    let outcomes = Outcomes::of(&run.rows);
    Grid::new("outcomes").num_columns(3).spacing([12.0, 4.0]).show(ui, |ui| {
        for outcome in Outcome::ALL {
            let (colour, share) = match outcome {
                Outcome::ScoresFirst(team) => (team_colour(ui, team), outcomes.scores_first[team]),
                Outcome::NobodyScores => (ui.visuals().text_color(), outcomes.nobody_scores),
            };
            let name = outcome.words();
            ui.label(egui::RichText::new(name).color(colour));
            ui.label(share.map_or_else(String::new, in_percent));
            let there_is_one = run.rows.iter().any(|row| outcome.is_of(row));
            let button = ui.add_enabled(there_is_one, egui::Button::new("Watch").small());
            let label = format!("Watch: {name}");
            button.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, there_is_one, &label));
            if button.on_hover_text("Shows the first of them as a branch").clicked() {
                commands.write(ManyTimesCommand::Watch(outcome));
            }
            ui.end_row();
        }
    });
    let difference = outcomes
        .goal_difference
        .filter(|goals| goals.margin().is_finite())
        .map(|goals| format!("goals, blue - pink: {:+.2} ± {:.2}", rounded(goals.value, 2), goals.margin()));
    let first =
        outcomes.first_goal_s.map(|time_s| format!("first goal after {time_s:.1} s (median, of those with a goal)"));
    for line in difference.into_iter().chain(first) {
        ui.label(dim(line).size(text_size::ENTRY));
    }
    for words in ["(… to …) and ±: 95 % confidence".to_owned(), heat_map::legend(&run.rows)] {
        ui.add(egui::Label::new(dim(words).size(text_size::SMALL)).wrap());
    }
}

/// Shows the expectation for a test of this moment.
fn show_test(
    ui: &mut egui::Ui,
    run: &Run,
    is_changed: bool,
    expected: &mut Expected,
    commands: &mut MessageWriter<ManyTimesCommand>,
) {
    let team = if expected.pink { Team::Pink } else { Team::Blue };
    let Some((at_least, share)) = saved_test::measured_percent(run, team).filter(|_| !run.is_running) else {
        expected.percent = None;
        return;
    };
    ui.separator();
    let before = expected.pink;
    ui.horizontal_wrapped(|ui| {
        ui.label("A test:");
        for (is_pink, side) in [(false, Team::Blue), (true, Team::Pink)] {
            ui.selectable_value(&mut expected.pink, is_pink, side.name());
        }
        ui.label("scores, first or not, in at least");
        let percent = expected.percent.get_or_insert(at_least);
        let field = ui.add(DragValue::new(percent).range(0.0..=100.0).speed(0.2).max_decimals(1).suffix(" %"));
        field.on_hover_text(
            "By default the lower end of the interval: the measured share passes, a clearly lower one fails",
        );
        ui.label(format!("of {}", run.rows.len()));
    });
    if expected.pink != before {
        // The share of one team says nothing about the other.
        expected.percent = None;
        return;
    }
    let percent = expected.percent.unwrap_or(at_least);
    let can_fail = percent > 0.0;
    let verdict = match (can_fail, share >= percent) {
        (false, _) => "every match passes: a test needs more than 0 %, or the other team",
        (true, true) => "it passes",
        (true, false) => "it fails",
    };
    ui.label(dim(format!("measured: {share:.1} %; with these figures, {verdict}")).size(text_size::ENTRY));
    if is_changed {
        ui.label("You have changed this moment since: begin again, so that the test contains the change");
    }
    let button = ui.add_enabled(can_fail && !is_changed, egui::Button::new("Save as a test"));
    let hint = "Saves this moment, and a scenario that continues from it, for naoisis check --play";
    if button.on_hover_text(hint).clicked() {
        commands.write(ManyTimesCommand::Save { team, percent });
    }
}

/// A share in percent, with its interval.
fn in_percent(Estimate { value, low, high }: Estimate) -> String {
    format!("{:.0} % ({:.0} to {:.0})", 100.0 * value, 100.0 * low, 100.0 * high)
}
