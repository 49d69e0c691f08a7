//! The statistics of a match: of a finished one that is watched, or until now when asked for, as by `naoisis run --summary`, computed
//! from its records by a thread.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use super::goal_replay::GoalReplay;
use super::large_letters;
use super::summary_contents::{show_contents, show_robots, show_table};
use crate::viewer::commands::Action;
use crate::viewer::display_settings::{DisplaySettings, Switch, Workspace};
use crate::viewer::event_log::{EventJump, EventLog, LogEntry, LogKind};
use crate::viewer::keyframes::Keyframes;
use crate::viewer::lanes::Lanes;
use crate::viewer::layout::{self, LayoutSystems};
use crate::viewer::match_panel::trace_reading::TraceReading;
use crate::viewer::new_file::{stem, write_new};
use crate::viewer::shared::{Notice, Playback, is_over};
use crate::viewer::team_labels::TeamNames;
use crate::viewer::theme::{card, text_size};
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Rules};
use naoisis_core::team::PerTeam;
use naoisis_record::record::history::History;
use naoisis_record::record::match_summary::MatchSummary;
use naoisis_record::record::summary_picture::picture;
use naoisis_record::record::summary_recorder::png;
use naoisis_record::record::summary_rows::mistake_rows;
use naoisis_sim::scenario::Scenario;

/// The height of the button, the margins and the distance to the edges of the window, logical pixels.
const BESIDE_CONTENTS: f32 = 80.0;

/// Shows the summary of a match.
pub struct SummaryPlugin;

impl Plugin for SummaryPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FinalSummary>()
            .add_systems(Update, sum_up)
            .add_systems(EguiPrimaryContextPass, show_summary.in_set(LayoutSystems::Floating));
    }
}

/// The summary, once the match has ended.
#[derive(Resource, Default)]
pub struct FinalSummary {
    /// The match, and its last cycle.
    of: Option<(Keyframes, u64)>,
    read: Option<Reading>,
    summary: Option<MatchSummary>,
    /// Whether the trace of the match is still being read.
    waits_for_trace: bool,
    /// Whether the end of the match is shown and the summary was not closed.
    is_shown: bool,
    is_closed: bool,
    /// Whether it was asked for in the last frame.
    was_asked_for: bool,
    /// Whether the end of the match was shown in the last frame, and whether the match was running then.
    was_at_end: bool,
    was_running: bool,
    /// Whether the match was played to the end that is shown. A jump to the last moment of a trace is no end of a match.
    is_played_to_end: bool,
}

/// A thread that reads the match.
struct Reading {
    summary: Mutex<Receiver<MatchSummary>>,
    /// The cycle that was read last, and the last one to read.
    done: Arc<AtomicU64>,
    last: u64,
}

impl FinalSummary {
    /// The share of the match that has been read for it, in words.
    fn progress(&self) -> String {
        let share = |read: &Reading| 100.0 * read.done.load(Ordering::Relaxed) as f64 / read.last.max(1) as f64;
        self.read.as_ref().map_or_else(String::new, |read| format!(" {:.0}\u{a0}%", share(read)))
    }

    /// Returns whether it is on the screen.
    pub fn is_shown(&self) -> bool {
        self.is_wanted() && self.summary.is_some()
    }

    /// Returns whether it is on the screen or being computed.
    pub fn is_wanted(&self) -> bool {
        self.is_shown && !self.is_closed
    }

    /// Returns whether it is being computed.
    pub fn is_reading(&self) -> bool {
        self.read.is_some()
    }
}

/// Returns whether the statistics are on the screen.
pub(super) fn is_shown(shown: Res<FinalSummary>) -> bool {
    shown.is_shown()
}

fn sum_up(
    (game, rules, clock, playback, timeline): (Res<Game>, Res<Rules>, Res<CycleClock>, Res<Playback>, Res<Timeline>),
    history: Res<History>,
    keyframes: Res<Keyframes>,
    (scenario, display): (Option<Res<Scenario>>, Res<DisplaySettings>),
    (replay, trace): (Res<GoalReplay>, Option<Res<TraceReading>>),
    mut shown: ResMut<FinalSummary>,
) {
    let (Some(scenario), Some(last)) = (scenario, history.last_cycle()) else { return };
    // A replay ends at its last cycle, even if the match did not end there.
    let is_at_end = match timeline.cursor() {
        Some(cursor) => timeline.is_replay() && cursor >= last as f64,
        None => is_over(&game, &clock, &playback),
    };
    if is_at_end && !shown.was_at_end {
        shown.is_played_to_end = shown.was_running || game.state == GameState::Finished;
    }
    (shown.was_at_end, shown.was_running) = (is_at_end, !playback.paused);
    let is_watched_end =
        display.workspace == Workspace::Watch && is_at_end && shown.is_played_to_end && !replay.is_busy();
    let is_shown = is_watched_end || display.summary;
    let is_asked_for = display.summary && !shown.was_asked_for;
    if shown.is_shown != is_shown || is_asked_for {
        shown.is_shown = is_shown;
        shown.is_closed &= is_shown && !display.summary;
    }
    if is_asked_for {
        shown.of = None;
    }
    shown.was_asked_for = display.summary;
    // While the match is played, the statistics are those of the moment at which they were asked for.
    let is_late = |until: u64| until != last && (playback.paused || is_at_end);
    let is_known = shown.of.as_ref().is_some_and(|(of, until)| of.is_same(&keyframes) && !is_late(*until));
    // The statistics of a part of a trace would be replaced at once.
    shown.waits_for_trace = trace.is_some_and(|trace| trace.is_on());
    if is_shown && !is_known && shown.read.is_none() && !shown.waits_for_trace {
        shown.of = Some((keyframes.clone(), last));
        shown.summary = None;
        let started_from = timeline.trace_scenario().unwrap_or(&scenario).clone();
        shown.read = read_by_thread(started_from, history.clone(), last).ok();
    }
    let Some(read) = &shown.read else { return };
    let summary = read.summary.lock().unwrap_or_else(PoisonError::into_inner).try_recv();
    match summary {
        Ok(mut summary) => {
            summary.how = game.result(&rules).how().filter(|_| is_at_end);
            (shown.summary, shown.read) = (Some(summary), None);
        }
        Err(TryRecvError::Disconnected) => shown.read = None,
        Err(TryRecvError::Empty) => {}
    }
}

fn read_by_thread(scenario: Scenario, mut history: History, last: u64) -> io::Result<Reading> {
    let (sender, receiver) = mpsc::channel();
    let done = Arc::<AtomicU64>::default();
    let progress = Arc::clone(&done);
    thread::Builder::new().name("summary".to_owned()).spawn(move || {
        let mut summary = MatchSummary::new(&scenario);
        for cycle in history.cycles().into_iter().flatten() {
            if let Ok(Some(record)) = history.record(cycle) {
                summary.look(&record);
            }
            progress.store(cycle, Ordering::Relaxed);
        }
        let _nobody_waits = sender.send(summary);
    })?;
    Ok(Reading { summary: Mutex::new(receiver), done, last })
}

fn show_summary(
    mut contexts: EguiContexts,
    mut shown: ResMut<FinalSummary>,
    mut notice: ResMut<Notice>,
    (mut display, names): (ResMut<DisplaySettings>, TeamNames),
    (log, lanes): (Res<EventLog>, Option<ResMut<Lanes>>),
    (mut actions, mut jumps): (MessageWriter<Action>, MessageWriter<EventJump>),
) -> Result {
    if !shown.is_wanted() {
        return Ok(());
    }
    let context = contexts.ctx_mut()?;
    let Some(summary) = &shown.summary else {
        layout::floating(context, "summary to come", Align2::CENTER_CENTER).show(context, |ui| {
            let words = match shown.waits_for_trace {
                true => "The statistics follow when the whole trace has been read.".to_owned(),
                false => format!("The statistics are being counted…{}", shown.progress()),
            };
            card(ui).fill(ui.visuals().panel_fill.to_opaque()).show(ui, |ui| ui.label(words));
        });
        return Ok(());
    };
    let names = names.both();
    // With the goals of an ordinary match, it fits into a window of 720 logical pixels without scrolling.
    let letters = (0.33 * large_letters(context)).max(text_size::ENTRY);
    let most_height = (layout::free_area(context).height() - BESIDE_CONTENTS).max(BESIDE_CONTENTS);
    let (mut is_closed, mut is_saved, mut goal) = (false, false, None);
    let mistakes = lanes.map(|mut lanes| {
        lanes.want_mistakes();
        mistake_rows(lanes.tracks.mistakes())
    });
    layout::floating(context, "summary", Align2::CENTER_CENTER).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill.to_opaque()).show(ui, |ui| {
            let contents = egui::ScrollArea::vertical().max_height(most_height);
            // The area would keep the height of its first frame.
            let contents = contents.min_scrolled_height(most_height);
            // The bar is drawn over the right edge.
            let beside_bar = egui::Frame::NONE.inner_margin(egui::Margin { right: 14, ..default() });
            contents.show(ui, |ui| {
                beside_bar.show(ui, |ui| {
                    let room = layout::free_area(ui.ctx()).width() - BESIDE_CONTENTS;
                    goal = show_contents(ui, summary, &names, (letters, room));
                    show_robots(ui, summary, letters);
                    show_table(ui, "mistakes", &["mistakes", &names[0], &names[1]], mistakes.as_deref(), letters);
                });
            });
            ui.horizontal(|ui| {
                is_closed = ui.button("Close").clicked();
                let hint = "Saves the statistics as a picture in the current folder";
                is_saved = ui.button("Save as PNG").on_hover_text(hint).clicked();
                let hint = "A: finds the moments that changed the chances to score most, and the mistakes there";
                if ui.button("What decided it").on_hover_text(hint).clicked() {
                    actions.write(Action::Toggle(Switch::Decided));
                }
            });
        });
    });
    if is_saved {
        let name = format!("{}-seed{}-summary", stem(&summary.name), summary.seed);
        let mut summary = summary.clone();
        summary.teams = Some(PerTeam { blue: names[0].clone(), pink: names[1].clone() });
        let written = png(&picture(&summary)).and_then(|bytes| write_new(Path::new(""), &name, "png", &bytes));
        notice.tell(match written {
            Ok(path) => format!("Saved as {}", path.display()),
            Err(error) => format!("The summary was not saved: {error}"),
        });
    }
    if let Some(goal) = goal.and_then(|time_s| goal_at(&log, time_s)) {
        jumps.write(EventJump(Some(goal.clone())));
        (display.events, is_closed) = (true, true);
    }
    if is_closed {
        (shown.is_closed, display.summary) = (true, false);
    }
    Ok(())
}

/// Returns the goal at this time, s.
fn goal_at(log: &EventLog, time_s: f64) -> Option<&LogEntry> {
    let is_it = |entry: &&LogEntry| entry.kind == LogKind::Goal && (entry.time_s - time_s).abs() < 0.01;
    log.until(f64::INFINITY).iter().find(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::watch::summary_contents::rows;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::game::{Evidence, PenaltyReason};
    use naoisis_core::team::{RobotId, Team};
    use naoisis_sim::interface::cycle_record::CycleRecord;

    #[test]
    fn statistics_that_are_asked_for_again_are_those_until_then() {
        let mut app = App::new();
        app.init_resource::<Game>().init_resource::<Rules>().init_resource::<CycleClock>().init_resource::<Playback>();
        app.init_resource::<Timeline>().init_resource::<Keyframes>().init_resource::<Scenario>();
        app.init_resource::<GoalReplay>().init_resource::<FinalSummary>().init_resource::<DisplaySettings>();
        app.init_resource::<History>().add_systems(Update, sum_up);
        let mut cycle = 0;
        for until in [10, 40] {
            while cycle <= until {
                let record = CycleRecord { cycle, time_s: cycle as f64 / 30.0, ..default() };
                app.world_mut().resource_mut::<History>().push(&record).unwrap();
                cycle += 1;
            }
            app.world_mut().resource_mut::<DisplaySettings>().summary = true;
            // The thread may take any time: the test waits for it, but not for ever.
            let counted = (0..200_000).find_map(|_| {
                app.update();
                thread::yield_now();
                app.world().resource::<FinalSummary>().summary.as_ref().map(|summary| summary.duration_s)
            });
            assert!((counted.unwrap() - f64::from(until as u32) / 30.0).abs() < 1e-6, "{counted:?} until {until}");
            app.world_mut().resource_mut::<DisplaySettings>().summary = false;
            app.update();
            assert!(!app.world().resource::<FinalSummary>().is_shown());
        }
    }

    #[test]
    fn a_match_is_summed_up_from_its_records() {
        let mut history = History::default();
        for cycle in 0..3 {
            let mut record = CycleRecord { cycle, time_s: cycle as f64 / 30.0, ..CycleRecord::default() };
            if cycle == 2 {
                let (robot, reason) = (RobotId::new(Team::Pink, 2), PenaltyReason::Pushing);
                record.events.push(MatchEvent::Penalty { robot, reason, until_s: 1.0, evidence: Evidence::default() });
                record.game.score.blue = 1;
            }
            history.push(&record).unwrap();
        }
        let summary =
            read_by_thread(Scenario::default(), history, 1).unwrap().summary.into_inner().unwrap().recv().unwrap();
        let rows = rows(&summary);
        assert_eq!(rows.first().unwrap(), &["goals", "1", "0"]);
        assert!(rows.iter().any(|row| row == &["penalties", "0", "1"]), "{rows:?}");
    }
}
