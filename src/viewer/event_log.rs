//! What happened in the match so far, as far as it is worth a line.

use bevy::prelude::*;

use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::{BoundaryLine, CycleEvents, KickMiss, KickResult, MatchEvent};
use crate::referee::report::headline;
use crate::robot::Team;
use crate::robot::kick::KickType;

/// The log forgets the oldest entries beyond this many.
const LONGEST: usize = 20_000;

/// Keeps the [`EventLog`].
pub struct EventLogPlugin;

impl Plugin for EventLogPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EventLog>().add_systems(Cycle, log_events.in_set(CycleSystems::Record));
    }
}

/// Something that happened.
#[derive(Clone, PartialEq, Debug)]
pub struct LogEntry {
    /// When, s since the start.
    pub time_s: f64,
    /// The team that it is to be credited to or blamed on, if any.
    pub team: Option<Team>,
    /// What, in a few words.
    pub text: String,
    /// Whether it is one of the big moments: a goal, a half.
    pub important: bool,
}

/// What happened, oldest first.
#[derive(Resource, Clone, PartialEq, Debug, Default, Deref, DerefMut)]
pub struct EventLog(pub Vec<LogEntry>);

impl EventLog {
    /// Adds what happened at a time, as far as it is worth a line.
    pub fn note<'a>(&mut self, time_s: f64, events: impl IntoIterator<Item = &'a MatchEvent>) {
        let entries = events.into_iter().filter_map(describe);
        self.extend(entries.map(|(team, important, text)| LogEntry { time_s, team, text, important }));
        if self.len() > LONGEST {
            let surplus = self.len() - LONGEST;
            self.drain(..surplus);
        }
    }

    /// The entries until a time, s, oldest first.
    pub fn until(&self, time_s: f64) -> &[LogEntry] {
        &self[..self.partition_point(|entry| entry.time_s <= time_s)]
    }
}

fn log_events(events: Res<CycleEvents>, clock: Res<CycleClock>, mut log: ResMut<EventLog>) {
    log.note(clock.end_time_s(), events.iter());
}

/// The team that an event is about, whether it is important, and what it is; nothing for what happens all the time.
fn describe(event: &MatchEvent) -> Option<(Option<Team>, bool, String)> {
    let (team, important, text) = match event {
        MatchEvent::Kick { reason: Some(KickMiss::Busy | KickMiss::Penalised | KickMiss::PlayStopped), .. } => {
            return None;
        }
        MatchEvent::Kick { robot, kick_type, result, .. } => {
            let kick = match kick_type {
                KickType::LeftStraight => "kicks with the left foot",
                KickType::RightStraight => "kicks with the right foot",
                KickType::LeftSide => "side-kicks to the right",
                KickType::RightSide => "side-kicks to the left",
            };
            let result = match result {
                KickResult::Kicked => "",
                KickResult::Reduced => ", from the wrong side",
                KickResult::Missed => " and misses",
            };
            (Some(robot.team), false, format!("{robot} {kick}{result}"))
        }
        MatchEvent::Goal { team, scorer, own_goal, .. } => {
            let by = match scorer {
                Some(robot) if *own_goal => format!(", own goal by {robot}"),
                Some(robot) => format!(" by {robot}"),
                None => String::new(),
            };
            (Some(*team), true, format!("Goal for {team}{by}"))
        }
        MatchEvent::BallOut { line, last_touch, .. } => {
            let line = match line {
                BoundaryLine::Side => "side line",
                BoundaryLine::Goal => "goal line",
            };
            let by = last_touch.map(|team| format!(", off {team}")).unwrap_or_default();
            (*last_touch, false, format!("Out over the {line}{by}"))
        }
        MatchEvent::KickOff { team } => (Some(*team), false, format!("Kick-off for {team}")),
        MatchEvent::ThrowIn { team, .. } => (Some(*team), false, format!("Throw-in for {team}")),
        MatchEvent::Penalty { robot, reason, .. } => {
            (Some(robot.team), false, format!("{robot} penalised for {}", reason.words()))
        }
        MatchEvent::PenaltyOver { robot, .. } => (Some(robot.team), false, format!("{robot} is back")),
        MatchEvent::HalfBegins { half } => (None, true, format!("Half {half} begins")),
        MatchEvent::FinalWhistle => (None, true, "Final whistle".to_owned()),
        MatchEvent::InvariantBroken { message } => (None, true, format!("Error in the simulation: {message}")),
        MatchEvent::Collision { .. } | MatchEvent::CommandRefused { .. } => return None,
        // What else the referee decides, in its own words.
        decision => (None, false, headline(decision)?.trim_end_matches('.').to_owned()),
    };
    Some((team, important, text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::referee::Evidence;
    use crate::robot::RobotId;

    #[test]
    fn goals_are_named_after_their_scorers() {
        let scorer = Some(RobotId::new(Team::Pink, 2));
        let text = |team, own_goal| {
            describe(&MatchEvent::Goal { team, scorer, own_goal, evidence: Evidence::default() })
                .map(|(team, _, text)| (team, text))
        };
        assert_eq!(text(Team::Pink, false), Some((Some(Team::Pink), "Goal for pink by pink2".to_owned())));
        assert_eq!(text(Team::Blue, true), Some((Some(Team::Blue), "Goal for blue, own goal by pink2".to_owned())));
    }

    #[test]
    fn kicks_while_recovering_are_not_worth_a_line() {
        let kick = |reason| MatchEvent::Kick {
            robot: RobotId::new(Team::Blue, 1),
            kick_type: KickType::LeftSide,
            speed: Some(1.0),
            result: KickResult::Missed,
            reason: Some(reason),
            direction: None,
            launch_speed_mps: None,
        };
        assert_eq!(describe(&kick(KickMiss::Busy)), None);
        let missed = describe(&kick(KickMiss::OutOfReach)).map(|(.., text)| text);
        assert_eq!(missed.as_deref(), Some("blue1 side-kicks to the right and misses"));
    }
}
