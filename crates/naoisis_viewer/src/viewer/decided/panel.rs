//! The panel: the progress, the chart of the chances, and the largest swings with their reasons.

use bevy::prelude::*;
use bevy_egui::EguiContexts;
use bevy_egui::egui::{self, DragValue, ProgressBar, RichText};

use super::chart::Chart;
use super::{Decided, DecidedCommand, Progress, awaited, refusal, restarts};
use crate::viewer::camera::LookAt;
use crate::viewer::commands::{Action, TimelineCommand};
use crate::viewer::display_settings::Switch;
use crate::viewer::dock::{Dock, Edge, PanelSizes, title};
use crate::viewer::event_filter::FoundMistakes;
use crate::viewer::event_log::{EventLog, LogEntry};
use crate::viewer::event_reasons::{self, reasons};
use crate::viewer::events_panel::{EventChoice, ShownEvent};
use crate::viewer::keyframes::{Keyframes, Simulator};
use crate::viewer::lanes::Lanes;
use crate::viewer::rebuild::{RebuildProgress, Rebuilt};
use crate::viewer::shared::Playback;
use crate::viewer::theme::{band, bright, count, dim, link, minutes, problem_colour, team_colour, text_size};
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::Team;
use naoisis_record::record::history::History;
use naoisis_record::whatif::chances::{Chance, Swing};

/// The panel.
const DOCK: Dock = Dock { name: "decided", edge: Edge::Right, size: 400.0, least: 260.0, most_share: 0.5 };
/// The number of swings that are listed.
const LISTED: usize = 8;

/// The distance around the ball that is shown of the moment of a swing, m.
const AROUND_BALL_M: f32 = 2.5;
/// The width that the score of a swing has at the right of its headline, logical pixels.
const SCORE_WIDTH: f32 = 64.0;

/// What was clicked.
enum Clicked {
    /// A time, s.
    Time(f64),
    /// A mistake or a kick.
    Event(LogEntry),
}

pub(super) fn show(
    mut contexts: EguiContexts,
    mut decided: ResMut<Decided>,
    (clock, mut history, timeline): (Res<CycleClock>, ResMut<History>, Res<Timeline>),
    (keyframes, rebuilt, simulator): (Res<Keyframes>, Res<Rebuilt>, Option<Res<Simulator>>),
    (log, lanes, found): (Res<EventLog>, Res<Lanes>, Res<FoundMistakes>),
    mut commands: MessageWriter<DecidedCommand>,
    (mut moments, mut choices, mut looks): (
        MessageWriter<TimelineCommand>,
        MessageWriter<EventChoice>,
        MessageWriter<LookAt>,
    ),
    (mut playback, mut sizes, mut shown): (ResMut<Playback>, ResMut<PanelSizes>, ResMut<ShownEvent>),
    mut actions: MessageWriter<Action>,
) -> Result {
    let mut clicked = None;
    DOCK.show(contexts.ctx_mut()?, &mut sizes, |ui| {
        if title(ui, "What decided it") {
            actions.write(Action::Toggle(Switch::Decided));
        }
        if let Some(reason) = refusal(&keyframes, &rebuilt, simulator.is_some()) {
            ui.label(format!("It cannot be found for this match: {reason}."));
            return;
        }
        let progress = decided.progress(awaited(&timeline, &rebuilt, &history, clock.period_s));
        let is_complete = progress.played >= progress.all;
        show_head(ui, &mut decided, progress, &mut commands);
        if let RebuildProgress::Differs(from) = &rebuilt.progress {
            let at = minutes((*from as f64 * clock.period_s) as f32);
            let words = format!("Replayed, the match is another one from {at} on: it is played from moments before.");
            ui.label(RichText::new(words).color(problem_colour(ui)).size(text_size::ENTRY));
        }
        let chances: Vec<Chance> = decided.chances().map(|(_, chance)| *chance).collect();
        if chances.is_empty() {
            return;
        }
        let restarts = restarts(&history, &keyframes, clock.period_s);
        let is_read = history.last_cycle().is_some_and(|last| lanes.is_behind(last));
        let listed = &decided.swings()[..decided.swings().len().min(LISTED)];
        show_legend(ui, decided.shown.played_s);
        let whole_s = history
            .cycles()
            .map_or([0.0, 1.0], |cycles| [*cycles.start(), *cycles.end()].map(|cycle| cycle as f64 * clock.period_s));
        let now_s = clock.end_time_s();
        let chart = Chart { chances: &chances, restarts: &restarts, swings: listed, whole_s, now_s };
        clicked = chart.show(ui).map(Clicked::Time);
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            if let Some(words) = limits(listed.len(), is_complete, is_read) {
                ui.label(dim(words));
            }
            let mistakes = || lanes.tracks.mistakes().iter().zip(&found.0);
            for swing in listed {
                let (reasons, earlier) =
                    reasons(swing.team, &(swing.from_s..=swing.until_s), mistakes(), log.until(f64::INFINITY));
                if let Some(there) = show_swing(ui, swing, (&reasons, earlier), is_read) {
                    clicked = Some(there);
                }
            }
        });
    });
    match clicked {
        Some(Clicked::Time(time_s)) => {
            let cycle = (time_s / clock.period_s).round() as u64;
            moments.write(TimelineCommand::GoTo(cycle));
            let record = history.bypass_change_detection().record(cycle).ok().flatten();
            if let Some(ball) = record.and_then(|record| record.ball) {
                looks.write(LookAt { place: ball.position_m.truncate(), reach_m: AROUND_BALL_M });
            }
            playback.paused = true;
            // The mark of an event that was clicked before does not belong to this moment.
            shown.0 = None;
        }
        Some(Clicked::Event(entry)) => drop(choices.write(EventChoice(entry))),
        None => {}
    }
    Ok(())
}

fn show_head(
    ui: &mut egui::Ui,
    decided: &mut Decided,
    progress: Progress,
    commands: &mut MessageWriter<DecidedCommand>,
) {
    let is_wanted = decided.shown.wanted.is_some() && progress.played < progress.all;
    ui.horizontal(|ui| {
        ui.add_enabled(!is_wanted, DragValue::new(&mut decided.times).range(4..=1000).suffix(" times"))
            .on_hover_text("Repetitions of each moment: four times as many are twice as precise");
        ui.label("for");
        ui.add_enabled(!is_wanted, DragValue::new(&mut decided.for_s).range(2.0..=120.0).suffix(" s"));
        let is_complete = progress.played >= progress.all && decided.for_s == decided.shown.played_s;
        if is_wanted {
            if ui.button("Stop").clicked() {
                commands.write(DecidedCommand::Stop);
            }
        } else if is_complete && progress.played > 0 {
            let hint = "Plays every moment as many times again: smaller swings become certain";
            if ui.button("More precisely").on_hover_text(hint).clicked() {
                commands.write(DecidedCommand::Again);
            }
        } else if ui.button("Begin").on_hover_text("Plays on from every 5 s, with other random numbers").clicked() {
            commands.write(DecidedCommand::Begin);
        }
    });
    let share = progress.played as f32 / progress.all.max(1) as f32;
    let words = progress.words(is_wanted);
    ui.add(ProgressBar::new(share).desired_height(16.0).text(RichText::new(words).size(text_size::SMALL)));
}

fn show_legend(ui: &mut egui::Ui, for_s: f64) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for team in Team::BOTH {
            band(ui, team, egui::Vec2::splat(8.0));
            ui.label(RichText::new(team.name()).color(team_colour(ui, team)).size(text_size::SMALL));
        }
        ui.label(dim(format!("chance to score first, within {for_s:.0} s")).size(text_size::SMALL));
    });
}

/// Shows a swing with its reasons, and the number of `earlier` ones. While the match `is_read`, mistakes may be missing. Returns what was
/// clicked.
fn show_swing(
    ui: &mut egui::Ui,
    swing: &Swing,
    (reasons, earlier): (&[&LogEntry], usize),
    is_read: bool,
) -> Option<Clicked> {
    let mut clicked = None;
    ui.separator();
    ui.horizontal(|ui| {
        let times = [swing.from_s, swing.until_s].map(|time_s| minutes(time_s as f32));
        ui.label(dim(format!("{} to {}", times[0], times[1])).monospace().size(text_size::SMALL));
        let words = headline(swing);
        let text = RichText::new(&words).color(team_colour(ui, swing.team)).strong().size(text_size::IMPORTANT);
        // The score is beside the words, not over them.
        let headline = ui.scope(|ui| {
            ui.set_max_width((ui.available_width() - SCORE_WIDTH).max(0.0));
            link(ui, egui::Label::new(text).wrap(), &words)
                .on_hover_text("Click: show the moment at which it began")
                .clicked()
        });
        if headline.inner {
            clicked = Some(Clicked::Time(swing.from_s));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            // The bar of the list is drawn over its right edge.
            ui.add_space(10.0);
            ui.label(bright(format!("{} : {}", swing.score.blue, swing.score.pink)).size(text_size::ENTRY))
                .on_hover_text("The score then, blue : pink");
        });
    });
    ui.label(dim(other_words(swing)).size(text_size::SMALL));
    if earlier > 0 {
        let earlier = count(earlier, "earlier event");
        ui.label(dim(format!("   {earlier}: see the list of events (E)")).size(text_size::SMALL));
    }
    if let Some(entry) = event_reasons::show(ui, reasons, swing.from_s) {
        clicked = Some(Clicked::Event(entry.clone()));
    }
    if reasons.is_empty() && !is_read {
        ui.label(dim("   no mistake, kick, fall, penalty or intervention").size(text_size::SMALL));
    }
    clicked
}

/// What is said of this number of swings before all is known: while moments are played, and while the match is read for its mistakes.
fn limits(swings: usize, is_complete: bool, is_read: bool) -> Option<&'static str> {
    match (swings, is_complete, is_read) {
        (0, ..) => Some("No change of the chances is larger than their statistical noise so far."),
        (_, false, false) => Some("Provisional until all moments are played."),
        (_, false, true) => Some("Provisional: moments are played, and the match is read for its mistakes."),
        (_, true, true) => Some("The match is being read for its mistakes."),
        (_, true, false) => None,
    }
}

/// The team that scored, or whose chance changed most.
fn named_first(swing: &Swing) -> Team {
    let change = |team: Team| (swing.after[team] - swing.before[team]).abs();
    let other = swing.team.opponent();
    if !swing.is_goal && change(other) > change(swing.team) { other } else { swing.team }
}

/// The chance of the team that is named first, before and after. The colour of the line is that of the team that gained.
fn headline(swing: &Swing) -> String {
    let team = named_first(swing);
    let before = 100.0 * swing.before[team];
    if swing.is_goal {
        format!("{team}: {before:.0} %, then the goal")
    } else {
        let gained = if team == swing.team { String::new() } else { format!("good for {}, ", swing.team) };
        format!("{gained}{team}: {before:.0} to {:.0} %", 100.0 * swing.after[team])
    }
}

/// The chance of the other team, and the change of the difference of both with its interval.
fn other_words(swing: &Swing) -> String {
    let other = named_first(swing).opponent();
    let [before, after] = [swing.before, swing.after].map(|share| 100.0 * share[other]);
    let gain = swing.gain;
    format!(
        "{other}: {before:.0} to {after:.0} %; the difference changes by {:.0} ± {:.0} points",
        100.0 * gain.value,
        100.0 * gain.margin()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::PerTeam;
    use naoisis_record::whatif::chances::{Restart, swings};

    #[test]
    fn mistakes_that_are_still_to_be_read_are_said_to_be() {
        assert!(limits(3, true, true).is_some_and(|words| words.contains("mistakes")));
        assert_eq!((limits(3, true, false), limits(0, true, true)), (None, limits(0, false, false)));
    }

    #[test]
    fn the_team_whose_chance_changed_most_is_named_first() {
        let chance = |time_s, blue, pink, scored| Chance {
            time_s,
            score: PerTeam { blue: scored, pink: 0 },
            times: 100,
            first: PerTeam { blue, pink },
        };
        let words = |later, restarts: &[Restart]| {
            let swing = swings(&[chance(10.0, 0, 60, 0), later], restarts)[0];
            (headline(&swing), other_words(&swing).split(';').next().unwrap().to_owned())
        };
        let lost = words(chance(15.0, 0, 5, 0), &[]);
        assert_eq!(lost, ("good for blue, pink: 60 to 5 %".to_owned(), "blue: 0 to 0 %".to_owned()));
        let gained = words(chance(15.0, 90, 5, 0), &[]);
        assert_eq!(gained, ("blue: 0 to 90 %".to_owned(), "pink: 60 to 5 %".to_owned()));
        let scored = words(chance(15.0, 20, 30, 1), &[Restart { time_s: 14.0, goal: Some(Team::Blue) }]);
        assert!(scored.0.starts_with("blue: 0 %, then the goal"), "{scored:?}");
    }
}
