//! The details of the selected event: the evidence of the referee, and what led to a goal.

use bevy_egui::egui::{self, RichText};

use super::event_filter::{COSTLY_S, FoundMistakes};
use super::event_log::{EventLog, LogEntry, LogKind};
use super::event_reasons;
use super::lanes::Lanes;
use super::theme::{dim, minutes, text_size};
use naoisis_core::game::{Evidence, Measurement, RobotEvidence};
use naoisis_record::record::history::History;

/// What the user wants of the selected event.
pub(super) enum Wish {
    Replay,
    Show(LogEntry),
    Close,
}

/// The events that led to a goal.
pub(super) struct GoalReasons<'a> {
    events: Vec<&'a LogEntry>,
    /// Whether the match is still being read for mistakes.
    is_reading: bool,
}

/// Returns what led to a goal, in the seconds before it. Returns `None` for other events.
pub(super) fn goal_reasons<'a>(
    goal: &LogEntry,
    log: &'a EventLog,
    (lanes, found): (Option<&mut Lanes>, &'a FoundMistakes),
    history: &History,
) -> Option<GoalReasons<'a>> {
    let team = goal.team.filter(|_| goal.kind == LogKind::Goal)?;
    let interval_s = goal.time_s - COSTLY_S..=goal.time_s;
    let lanes = lanes?;
    lanes.want_mistakes();
    let mistakes = lanes.tracks.mistakes().iter().zip(&found.0);
    let (events, _) = event_reasons::reasons(team, &interval_s, mistakes, log.until(goal.time_s));
    let is_reading = history.last_cycle().is_some_and(|last| lanes.is_behind(last));
    Some(GoalReasons { events, is_reading })
}

/// Shows the time and the details of an event, and what led to a goal. They stay while other moments are shown. Returns what was clicked.
pub(super) fn show_circumstances(ui: &mut egui::Ui, entry: &LogEntry, before: Option<&GoalReasons>) -> Option<Wish> {
    ui.separator();
    let title = format!("{}  {}", minutes(entry.time_s as f32), entry.text);
    ui.label(RichText::new(title).size(text_size::ENTRY).strong());
    for line in entry.evidence.iter().flat_map(reasons) {
        ui.add(egui::Label::new(dim(line).size(text_size::SMALL)).wrap());
    }
    let mut clicked = None;
    if let Some(GoalReasons { events, is_reading }) = before {
        ui.label(RichText::new("What led to it").size(text_size::ENTRY).strong());
        clicked = event_reasons::show(ui, events, f64::NEG_INFINITY).cloned().map(Wish::Show);
        if *is_reading {
            ui.label(dim("The match is being read for its mistakes…").size(text_size::SMALL));
        } else if events.is_empty() {
            ui.label(dim("No mistake, kick or fall in the ten seconds before.").size(text_size::SMALL));
        }
    }
    let buttons = ui.horizontal(|ui| {
        let replay = ui.small_button("Replay").on_hover_text("Starts two seconds before the event").clicked();
        let close = ui.small_button("Close").on_hover_text("Hides these details and the mark on the pitch").clicked();
        replay.then_some(Wish::Replay).or(close.then_some(Wish::Close))
    });
    clicked.or(buttons.inner)
}

/// The evidence of the referee, line by line.
fn reasons(evidence: &Evidence) -> Vec<String> {
    let mut lines = vec![evidence.rule.to_string()];
    if let Some(measured) = &evidence.measured {
        lines.push(measured_words(measured));
        // The robots' speeds are a reason only if the measured quantity is a speed.
        if measured.what.starts_with("m/s") {
            let walked = |robot: &RobotEvidence| format!("{} walked at {:.2} m/s.", robot.robot, robot.speed_mps);
            lines.extend(evidence.robots.iter().map(walked));
        }
    }
    lines.push(evidence.otherwise.to_string());
    lines.retain(|line| !line.is_empty());
    lines
}

/// A measurement with as many digits as distinguish it from its limit, and its difference from the limit.
fn measured_words(measured: &Measurement) -> String {
    const MOST_DIGITS: u32 = 5;
    let Measurement { what, value, limit } = measured;
    let margin = (value - limit).abs();
    if margin == 0.0 {
        return format!("{value:.2} {what}; the limit is {limit:.2}.");
    }
    // Enough digits that the margin has two significant ones.
    let is_enough = |digits: &u32| margin * 10_u32.pow(*digits) as f32 >= 10.0;
    let digits = (2..MOST_DIGITS).find(is_enough).unwrap_or(MOST_DIGITS) as usize;
    let relation = if value < limit { "below" } else { "beyond" };
    format!("{value:.digits$} {what}: {margin:.digits$} {relation} the limit of {limit:.digits$}.")
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec2;
    use bevy::utils::default;
    use naoisis_core::team::{RobotId, Team};

    #[test]
    fn the_reasons_are_the_rule_what_was_measured_and_what_would_have_helped() {
        let evidence = Evidence {
            rule: "A rule.".into(),
            measured: Some(Measurement { what: "s in the goal".into(), value: 3.25, limit: 3.0 }),
            otherwise: "It had to come out.".into(),
            ..default()
        };
        let measured = "3.25 s in the goal: 0.25 beyond the limit of 3.00.";
        assert_eq!(reasons(&evidence), ["A rule.", measured, "It had to come out."]);
        assert_eq!(reasons(&Evidence::default()), [""; 0]);
    }

    #[test]
    fn a_small_margin_is_seen_and_speeds_are_said_where_they_count() {
        let measured = |value, limit, what: &'static str| Measurement { what: what.into(), value, limit };
        assert_eq!(
            measured_words(&measured(3.034, 3.03, "m from the centre")),
            "3.0340 m from the centre: 0.0040 beyond the limit of 3.0300."
        );
        assert_eq!(measured_words(&measured(0.2, 0.2, "m/s")), "0.20 m/s; the limit is 0.20.");
        let robot = RobotEvidence { robot: RobotId::new(Team::Blue, 2), position_m: Vec2::ZERO, speed_mps: 0.2 };
        let evidence = |what| Evidence { measured: Some(measured(1.0, 0.5, what)), ..default() }.with_robot(robot);
        assert_eq!(reasons(&evidence("m/s towards the other"))[1], "blue2 walked at 0.20 m/s.");
        assert_eq!(reasons(&evidence("m behind the line")).len(), 1);
    }
}
