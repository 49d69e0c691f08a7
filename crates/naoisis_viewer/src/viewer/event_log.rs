//! The log of the match: events that are worth a line.

use bevy::prelude::*;

use super::shared::state_name;
use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems};
use naoisis_core::events::{BoundaryLine, CollisionPartner, CycleEvents, KickMiss, KickResult, MatchEvent};
use naoisis_core::game::{Evidence, Intervention, PenaltyReason};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::referee::report::headline;
use naoisis_core::team::{RobotId, Team};

/// The greatest number of entries. The oldest are dropped.
const LONGEST: usize = 20_000;

/// Keeps the [`EventLog`].
pub struct EventLogPlugin;

impl Plugin for EventLogPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EventLog>()
            .add_message::<EventJump>()
            .add_systems(Cycle, log_events.in_set(CycleSystems::Record));
    }
}

/// The kind of an entry.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum LogKind {
    /// A goal, or a shot of a shoot-out.
    Goal,
    /// A kick.
    Kick,
    /// A robot fell, or got up.
    Fall,
    /// A penalty, its end, or a caution.
    Penalty,
    /// Another decision of the referee.
    Referee,
    /// An intervention by hand or by the scenario.
    Hand,
    /// A mistake of a robot.
    Mistake,
    /// Anything else.
    #[default]
    Other,
}

impl LogKind {
    /// All kinds with their names.
    pub const ALL: [(LogKind, &str); 8] = [
        (LogKind::Goal, "goals"),
        (LogKind::Kick, "kicks"),
        (LogKind::Fall, "falls, failures"),
        (LogKind::Penalty, "penalties"),
        (LogKind::Referee, "referee"),
        (LogKind::Hand, "by hand"),
        (LogKind::Mistake, "mistakes"),
        (LogKind::Other, "others"),
    ];

    fn of(event: &MatchEvent) -> Self {
        match event {
            MatchEvent::Goal { .. } | MatchEvent::Shot { .. } | MatchEvent::ShootOutWon { .. } => LogKind::Goal,
            MatchEvent::Kick { .. } => LogKind::Kick,
            MatchEvent::Fall { .. }
            | MatchEvent::GotUp { .. }
            | MatchEvent::ProgramRestarts { .. }
            | MatchEvent::AgentLost { .. }
            | MatchEvent::Dive { .. } => LogKind::Fall,
            MatchEvent::Penalty { .. } | MatchEvent::PenaltyOver { .. } | MatchEvent::Caution { .. } => {
                LogKind::Penalty
            }
            MatchEvent::Intervention { intervention: Intervention::PickUp { .. } } => LogKind::Penalty,
            MatchEvent::Intervention { .. } | MatchEvent::InterventionRefused { .. } => LogKind::Hand,
            MatchEvent::InvariantBroken { .. } | MatchEvent::Collision { .. } | MatchEvent::CommandRefused { .. } => {
                LogKind::Other
            }
            _ => LogKind::Referee,
        }
    }
}

/// An entry of the log.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LogEntry {
    /// The time, s since the start.
    pub time_s: f64,
    /// The team that scored or that is responsible, if any.
    pub team: Option<Team>,
    /// The text.
    pub text: String,
    /// Whether it is important: a goal, or the start or end of a half.
    pub important: bool,
    /// The robot that it is about.
    pub robot: Option<RobotId>,
    /// The position, m, pitch frame, if the event has one.
    pub place: Option<Vec2>,
    /// The evidence of the referee.
    pub evidence: Option<Evidence>,
    /// The kind.
    pub kind: LogKind,
    /// Whether it is the end of a fall or of a penalty.
    pub is_recovery: bool,
}

impl LogEntry {
    /// Returns the cycle to show for the entry. In the cycle of a goal, ball and robots already stand at their places for the
    /// kick-off, so it is the one before.
    pub fn shown_cycle(&self, period_s: f64) -> u64 {
        let cycle = (self.time_s / period_s).round() as u64;
        cycle.saturating_sub(u64::from(self.kind == LogKind::Goal))
    }
}

impl LogEntry {
    /// The team whose colour the event has: the team that scored or is responsible, or else that of its robot.
    pub fn side(&self) -> Option<Team> {
        self.team.or(self.robot.map(|robot| robot.team))
    }
}

/// A jump to an event that no click has chosen. It is shown like a chosen one; without an entry, the chosen one is deselected.
#[derive(Message, Clone, PartialEq, Debug)]
pub struct EventJump(pub Option<LogEntry>);

/// A touch of the ball by a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BallTouch {
    /// The time, s since the start.
    pub time_s: f64,
    /// The robot that touched it.
    pub robot: RobotId,
    /// Whether it was a kick.
    pub kick: bool,
}

/// The entries, oldest first.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct EventLog {
    entries: Vec<LogEntry>,
    touches: Vec<BallTouch>,
    /// The times at which robots lost their programs, s.
    lost_programs: Vec<(f64, RobotId)>,
}

impl EventLog {
    /// Adds the events of a time that are worth a line.
    pub fn note<'a>(&mut self, time_s: f64, events: impl IntoIterator<Item = &'a MatchEvent>) {
        for event in events {
            let touch = touch(event).map(|(robot, kick)| BallTouch { time_s, robot, kick });
            self.touches.extend(touch);
            if let MatchEvent::AgentLost { robot, .. } = event {
                self.lost_programs.push((time_s, *robot));
            }
            let Some((team, important, text)) = describe(event) else { continue };
            let (robot, place, evidence) = circumstances(event);
            self.entries.push(LogEntry {
                time_s,
                team,
                text,
                important,
                robot,
                place: place.or(evidence.map(|evidence| evidence.position_m)),
                evidence: evidence.cloned(),
                kind: LogKind::of(event),
                is_recovery: matches!(event, MatchEvent::GotUp { .. } | MatchEvent::PenaltyOver { .. }),
            });
        }
        let surplus = self.entries.len().saturating_sub(LONGEST);
        self.entries.drain(..surplus);
        let surplus = self.touches.len().saturating_sub(LONGEST);
        self.touches.drain(..surplus);
    }

    /// Removes all entries.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Returns the entries until a time, s, oldest first.
    pub fn until(&self, time_s: f64) -> &[LogEntry] {
        &self.entries[..self.entries.partition_point(|entry| entry.time_s <= time_s)]
    }

    /// Returns the log until a time, s, for a branch of the match.
    pub fn cut(&self, time_s: f64) -> EventLog {
        let touches = self.touches.iter().filter(|touch| touch.time_s <= time_s).copied().collect();
        let lost = self.lost_programs.iter().filter(|(lost_s, _)| *lost_s <= time_s);
        EventLog { entries: self.until(time_s).to_vec(), touches, lost_programs: lost.copied().collect() }
    }

    /// Returns the time at which a robot lost its program, if it did until a time, s.
    pub fn lost_program(&self, robot: RobotId, time_s: f64) -> Option<f64> {
        self.lost_programs.iter().find(|(lost_s, id)| *id == robot && *lost_s <= time_s).map(|(lost_s, _)| *lost_s)
    }

    /// Returns whether the log has this entry.
    pub fn has(&self, entry: &LogEntry) -> bool {
        let from = self.entries.partition_point(|other| other.time_s < entry.time_s);
        self.entries[from..].iter().take_while(|other| other.time_s <= entry.time_s).any(|other| other == entry)
    }

    /// Returns the last touch of the ball until a time, s.
    pub fn last_touch(&self, time_s: f64) -> Option<BallTouch> {
        self.touches[..self.touches.partition_point(|touch| touch.time_s <= time_s)].last().copied()
    }
}

/// The robot that touched the ball in an event, and whether by a kick.
fn touch(event: &MatchEvent) -> Option<(RobotId, bool)> {
    match event {
        MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. } => Some((*robot, true)),
        MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => Some((*robot, false)),
        _ => None,
    }
}

/// The robot of an event, its position (m, pitch frame), and the evidence of the referee.
fn circumstances(event: &MatchEvent) -> (Option<RobotId>, Option<Vec2>, Option<&Evidence>) {
    match event {
        MatchEvent::Kick { robot, .. }
        | MatchEvent::Fall { robot, .. }
        | MatchEvent::GotUp { robot }
        | MatchEvent::ProgramRestarts { robot, .. }
        | MatchEvent::Dive { robot, .. } => (Some(*robot), None, None),
        MatchEvent::PenaltyOver { robot, position_m } => (Some(*robot), Some(*position_m), None),
        MatchEvent::Penalty { robot, evidence, .. } | MatchEvent::Caution { robot, evidence, .. } => {
            (Some(*robot), None, Some(evidence))
        }
        MatchEvent::DoubleTouch { robot, evidence } => (Some(*robot), Some(evidence.position_m), Some(evidence)),
        MatchEvent::Substitution { robot, .. } => (Some(*robot), None, None),
        MatchEvent::MovedAside { robot, position_m } => (Some(*robot), Some(*position_m), None),
        MatchEvent::PlacedByHand { robot, position_m, evidence } => (Some(*robot), Some(*position_m), Some(evidence)),
        MatchEvent::Goal { scorer, evidence, .. } => (*scorer, None, Some(evidence)),
        MatchEvent::GameStuck { robot, evidence } => (*robot, None, Some(evidence)),
        MatchEvent::BallOut { position_m, evidence, .. } => (None, Some(*position_m), Some(evidence)),
        MatchEvent::GoalDisallowed { evidence, .. }
        | MatchEvent::Shot { evidence, .. }
        | MatchEvent::TooManyMessages { evidence, .. } => (None, None, Some(evidence)),
        MatchEvent::ThrowIn { position_m, .. }
        | MatchEvent::DropBall { position_m }
        | MatchEvent::FreeKick { position_m, .. } => (None, Some(*position_m), None),
        MatchEvent::Collision { robot, position_m, .. } => (*robot, Some(*position_m), None),
        _ => (None, None, None),
    }
}

fn log_events(events: Res<CycleEvents>, clock: Res<CycleClock>, mut log: ResMut<EventLog>) {
    log.note(clock.end_time_s(), events.iter());
}

/// The team, the importance and the text of an event; `None` for events that happen all the time.
fn describe(event: &MatchEvent) -> Option<(Option<Team>, bool, String)> {
    let (team, important, text) = match event {
        MatchEvent::Kick { reason: Some(KickMiss::Busy | KickMiss::Penalised | KickMiss::PlayStopped), .. } => {
            return None;
        }
        MatchEvent::Kick { robot, kick_type, result, .. } => {
            let kick = match kick_type {
                KickType::LeftStraight => "kicks with the left foot".to_owned(),
                KickType::RightStraight => "kicks with the right foot".to_owned(),
                KickType::LeftSide => "side-kicks to the right".to_owned(),
                KickType::RightSide => "side-kicks to the left".to_owned(),
                KickType::Custom(_) => match kick_type.words() {
                    words if words.ends_with("kick") => format!("kicks ({words})"),
                    words => format!("kicks ({words} kick)"),
                },
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
        MatchEvent::Penalty { robot, reason: PenaltyReason::SentOff, .. } => {
            (Some(robot.team), true, format!("{robot} is sent off"))
        }
        MatchEvent::Penalty { robot, reason, .. } => {
            (Some(robot.team), false, format!("{robot} penalised for {}", reason.words()))
        }
        MatchEvent::TooManyMessages { team, .. } => {
            (Some(*team), true, format!("{team} sent too many messages: its goals do not count"))
        }
        MatchEvent::PenaltyOver { robot, .. } => (Some(robot.team), false, format!("{robot} is back")),
        MatchEvent::HalfBegins { half } => (None, true, format!("Half {half} begins")),
        MatchEvent::AgentLost { robot, .. } => {
            (Some(robot.team), true, headline(event)?.trim_end_matches('.').to_owned())
        }
        MatchEvent::Intervention { intervention: request @ Intervention::PickUp { robot } } => {
            (Some(robot.team), false, request.to_string())
        }
        MatchEvent::StateChanged { state } => (None, false, format!("The game is in state {}", state_name(*state))),
        MatchEvent::FinalWhistle => (None, true, "Final whistle".to_owned()),
        MatchEvent::InvariantBroken { message } => (None, true, format!("Error in the simulation: {message}")),
        MatchEvent::Collision { .. } | MatchEvent::CommandRefused { .. } => return None,
        // The referee's other decisions, in its own words.
        decision => (None, false, headline(decision)?.trim_end_matches('.').to_owned()),
    };
    Some((team, important, text))
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_kick_by_hand_has_other_words_than_a_ball_that_is_put_somewhere() {
        let words = |velocity_mps| {
            let intervention = Intervention::PlaceBall { position_m: Vec2::new(1.0, 0.5), velocity_mps };
            describe(&MatchEvent::Intervention { intervention }).map(|(.., text)| text).unwrap_or_default()
        };
        assert_eq!(words(Vec2::ZERO), "By hand: the ball is put at (1.00, 0.50)");
        assert_eq!(words(Vec2::new(0.0, 2.0)), "By hand: the ball is kicked from (1.00, 0.50) with 2.00 m/s");
    }

    #[test]
    fn entries_say_where_and_why_and_who_touched_the_ball() {
        let robot = RobotId::new(Team::Blue, 3);
        let evidence = Evidence { position_m: Vec2::new(1.0, 0.5), ..default() };
        let out = MatchEvent::BallOut {
            line: BoundaryLine::Side,
            position_m: Vec2::new(2.0, 2.1),
            last_touch: Some(Team::Blue),
            evidence: evidence.clone(),
        };
        let goal = MatchEvent::Goal { team: Team::Blue, scorer: Some(robot), own_goal: false, evidence };
        let touch = MatchEvent::Collision {
            robot: Some(robot),
            with: CollisionPartner::Ball,
            collision_type: naoisis_core::events::CollisionType::MovingRobotAndMovingBall,
            speed_mps: 0.1,
            position_m: Vec2::ZERO,
        };
        let mut log = EventLog::default();
        log.note(1.0, [&touch]);
        log.note(2.0, [&out, &goal]);
        let [first, second] = log.until(3.0) else { panic!("two entries") };
        assert_eq!(first.place, Some(Vec2::new(2.0, 2.1)));
        assert_eq!((second.place, second.robot), (Some(Vec2::new(1.0, 0.5)), Some(robot)));
        assert!(second.evidence.is_some() && log.until(1.5).is_empty());
        assert!(log.has(second) && !log.has(&LogEntry { time_s: 2.5, ..second.clone() }));
        assert_eq!(log.last_touch(2.0), Some(BallTouch { time_s: 1.0, robot, kick: false }));
        assert_eq!(log.last_touch(0.5), None);
    }

    #[test]
    fn a_robot_has_lost_its_program_from_then_on() {
        let robot = RobotId::new(Team::Blue, 2);
        let (reason, message) = (naoisis_core::events::AgentLoss::Malformed, String::new());
        let mut log = EventLog::default();
        log.note(17.0, [&MatchEvent::AgentLost { robot, reason, message }]);
        assert_eq!([16.9, 17.0, 90.0].map(|time_s| log.lost_program(robot, time_s)), [None, Some(17.0), Some(17.0)]);
        assert_eq!(log.lost_program(RobotId::new(Team::Blue, 3), 90.0), None);
        assert_eq!([log.cut(20.0), log.cut(10.0)].map(|log| log.lost_program(robot, 90.0)), [Some(17.0), None]);
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
