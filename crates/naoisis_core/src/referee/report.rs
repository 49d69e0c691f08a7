//! The match report: the decisions of the referee and their reasons, in lines for people.

use bevy::math::Vec2;
use core::fmt::Write;

use crate::events::{BoundaryLine, DisallowedGoal, FallCause, MatchEvent};
use crate::game::{Evidence, PenaltyReason};

/// The header line of the report.
pub const HEADER: &str = "     time    to play  decision";

/// The lines of the report for an event at `time_s` since the start, with `to_play_s` left in the half: the decision, then the evidence,
/// indented. `None` for an event that is not a decision of the referee.
pub fn report(time_s: f64, to_play_s: Option<f32>, event: &MatchEvent) -> Option<String> {
    let (headline, evidence) = sentence(event)?;
    let to_play = to_play_s.map_or_else(|| "-".to_owned(), |seconds| minutes(f64::from(seconds)));
    let mut text = format!("{:>9}  {to_play:>9}  {headline}", minutes(time_s));
    if let Some(evidence) = evidence {
        explain(&mut text, evidence);
    }
    Some(text)
}

/// Minutes and seconds, to the hundredth.
fn minutes(seconds: f64) -> String {
    let hundredths = (seconds * 100.0).round() as u64;
    format!("{}:{:02}.{:02}", hundredths / 6000, hundredths / 100 % 60, hundredths % 100)
}

/// The decision in a sentence; `None` for an event that is not a decision of the referee.
pub fn headline(event: &MatchEvent) -> Option<String> {
    sentence(event).map(|(sentence, _)| sentence)
}

/// The decision in a sentence, and its evidence.
fn sentence(event: &MatchEvent) -> Option<(String, Option<&Evidence>)> {
    let (sentence, evidence) = match event {
        MatchEvent::Goal { team, scorer, own_goal, evidence } => {
            let by = match scorer {
                Some(scorer) if *own_goal => format!(", an own goal by {scorer}"),
                Some(scorer) => format!(", by {scorer}"),
                None => String::new(),
            };
            (format!("Goal for {team}{by}."), evidence)
        }
        MatchEvent::GoalDisallowed { team, reason, evidence } => {
            let why = match reason {
                DisallowedGoal::KickOffShot => "it was shot straight from the kick-off",
                DisallowedGoal::NotIndirect => "only one robot of the team had played the ball",
                DisallowedGoal::OwnSetPlay => "it came straight from a set play of the other team",
                DisallowedGoal::TooManyMessages => "the team has sent more messages than it may",
            };
            (format!("No goal for {team}: {why}."), evidence)
        }
        MatchEvent::BallOut { line, last_touch, evidence, .. } => {
            let line = match line {
                BoundaryLine::Side => "side line",
                BoundaryLine::Goal => "goal line",
            };
            let by = last_touch.map(|team| format!(", last touched by {team}")).unwrap_or_default();
            (format!("Ball out over the {line}{by}."), evidence)
        }
        MatchEvent::GameStuck { robot, evidence } => {
            let remedy = robot.map_or("play is stopped".to_owned(), |robot| format!("{robot} is taken from the ball"));
            (format!("Game stuck: {remedy}."), evidence)
        }
        MatchEvent::PlacedByHand { robot, position_m, evidence } => {
            (format!("{robot} is placed by hand at {}.", place(position_m)), evidence)
        }
        MatchEvent::Penalty { robot, reason: PenaltyReason::SentOff, evidence, .. } => {
            (format!("{robot} is sent off."), evidence)
        }
        MatchEvent::Penalty { robot, reason, until_s, evidence } => {
            let until = minutes(f64::from(*until_s));
            (format!("{robot} is penalised for {} until {until}.", reason.words()), evidence)
        }
        MatchEvent::Caution { robot, cautions, evidence } => {
            (format!("{robot} is cautioned, for the {} time.", ordinal(*cautions)), evidence)
        }
        MatchEvent::DoubleTouch { robot, evidence } => (format!("{robot} touches the ball twice."), evidence),
        MatchEvent::TooManyMessages { team, evidence } => {
            (format!("{team} has sent more messages than it may: its goals do not count."), evidence)
        }
        MatchEvent::Shot { team, scored, goals, evidence } => {
            let result = if *scored { "scores" } else { "does not score" };
            (format!("{team} {result}; blue {} : pink {}.", goals.blue, goals.pink), evidence)
        }
        _ => return announcement(event).map(|sentence| (sentence, None)),
    };
    Some((sentence, Some(evidence)))
}

/// A sentence for an event that is reported without evidence.
fn announcement(event: &MatchEvent) -> Option<String> {
    Some(match event {
        MatchEvent::ThrowIn { team, position_m } => format!("Throw-in for {team} at {}.", place(position_m)),
        MatchEvent::KickOff { team } => format!("Kick-off for {team}."),
        MatchEvent::DropBall { position_m } => format!("Drop ball at {}.", place(position_m)),
        MatchEvent::FreeKick { set_play, team, position_m } => {
            format!("{} for {team} at {}.", set_play.words(), place(position_m))
        }
        MatchEvent::FreeKickOver { team, taken } => {
            let how = if *taken { "has played the ball" } else { "did not play the ball in time" };
            format!("Ball free: {team} {how}.")
        }
        MatchEvent::MovedAside { robot, position_m } => {
            format!("{robot} is moved aside for the ball, to {}.", place(position_m))
        }
        MatchEvent::PenaltyOver { robot, position_m } => format!("{robot} is back at {}.", place(position_m)),
        MatchEvent::Intervention { intervention } => format!("By hand: {intervention}."),
        MatchEvent::InterventionRefused { intervention, message } => {
            format!("Not done by hand: {intervention}: {message}.")
        }
        MatchEvent::StateChanged { state } => format!("The game is in state {}.", state.name()),
        MatchEvent::Timeout { team, duration_s } => {
            let who = team.map_or("the referee", |team| team.name());
            format!("Time-out of {who}: {duration_s:.0} s at most.")
        }
        MatchEvent::Substitution { robot, replaced } => format!("{robot} replaces {replaced}."),
        MatchEvent::HalfBegins { half } => format!("Half {half} begins."),
        MatchEvent::FinalWhistle => "Final whistle.".to_owned(),
        MatchEvent::ShootOutBegins => "The match is drawn: penalty shoot-out.".to_owned(),
        MatchEvent::ShootOutWon { team } => format!("{team} wins the shoot-out."),
        MatchEvent::Fall { robot, cause, speed_mps, probability } => {
            let why = match cause {
                FallCause::Collision => format!("a collision at {speed_mps:.2} m/s"),
                FallCause::Walking => format!("walking at {speed_mps:.2} m/s"),
                FallCause::Contact => "contact with another robot".to_owned(),
                FallCause::Tripping => format!("tripping over a robot at {speed_mps:.2} m/s"),
                FallCause::Kick => "a kick".to_owned(),
                FallCause::GettingUp => "getting up".to_owned(),
            };
            // In walking and in contact it is the probability of a single cycle, which says nothing to people.
            match cause {
                FallCause::Walking | FallCause::Contact => format!("{robot} falls: {why}."),
                _ => format!("{robot} falls: {why}, probability {probability:.2}."),
            }
        }
        MatchEvent::GotUp { robot } => format!("{robot} stands again."),
        MatchEvent::ProgramRestarts { robot, duration_s } => {
            format!("The program of {robot} stopped; it starts again in {duration_s} s.")
        }
        MatchEvent::Dive { robot, side } => format!("{robot} dives to its {}.", side.name()),
        MatchEvent::GameController { message } => format!("GameController: {message}."),
        MatchEvent::AgentLost { robot, message, .. } => format!("{robot} has lost its program: {message}."),
        _ => return None,
    })
}

/// A position, m, in parentheses.
fn place(position_m: &Vec2) -> String {
    format!("({:.2}, {:.2})", position_m.x, position_m.y)
}

/// An ordinal number in words.
fn ordinal(number: u32) -> String {
    match number {
        1 => "first".to_owned(),
        2 => "second".to_owned(),
        3 => "third".to_owned(),
        _ => format!("{number}th"),
    }
}

fn explain(text: &mut String, evidence: &Evidence) {
    const INDENT: &str = "\n                      ";
    // Writing to a string cannot fail.
    let mut line = |what: core::fmt::Arguments| _ = write!(text, "{INDENT}{what}");
    line(format_args!("Rule: {}", evidence.rule));
    let mut where_and_who = format!("At {}", place(&evidence.position_m));
    if let Some(ball_m) = &evidence.ball_m {
        _ = write!(where_and_who, "; ball at {}", place(ball_m));
    }
    for robot in &evidence.robots {
        _ = write!(where_and_who, "; {} at {}, {:.2} m/s", robot.robot, place(&robot.position_m), robot.speed_mps);
    }
    line(format_args!("{where_and_who}."));
    if let Some(measured) = &evidence.measured {
        line(format_args!("Measured: {:.3} {}; limit {:.3}.", measured.value, measured.what, measured.limit));
    }
    if !evidence.otherwise.is_empty() {
        line(format_args!("Otherwise: {}", evidence.otherwise));
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};

    #[test]
    fn a_verdict_reads_as_what_why_and_what_else() {
        let (blue2, pink2) = (RobotId::new(Team::Blue, 2), RobotId::new(Team::Pink, 2));
        let situation = MatchFixture::three_a_side()
            .robot_at(blue2, Pose::new(1.0, 0.5, 0.0))
            .robot_at(pink2, Pose::new(1.1, 0.5, 0.0))
            .walking(blue2, [0.2, 0.0])
            .contact(blue2, pink2);
        let events = situation.decide().events;
        let report = report(63.5, Some(536.5), &events[0]).unwrap();
        let lines: Vec<&str> = report.lines().collect();
        assert_eq!(lines[0], "  1:03.50    8:56.50  blue2 is penalised for pushing until 0:33.33.");
        let why = [
            "Rule: Of two robots that collide, the one that walks faster towards the other is responsible, unless they \
             face each other with the ball between them.",
            "At (1.05, 0.50); ball at (0.00, 0.00); blue2 at (1.00, 0.50), 0.20 m/s; pink2 at (1.10, 0.50), 0.00 m/s.",
            "Measured: 0.200 m/s towards the other; limit 0.050.",
            "Otherwise: It had to walk towards pink2 at no more than 0.05 m/s.",
        ];
        assert_eq!(lines[1..], why.map(|line| format!("{:22}{line}", "")));
    }

    #[test]
    fn what_is_no_decision_is_not_reported() {
        assert_eq!(report(0.0, None, &MatchEvent::InvariantBroken { message: String::new() }), None);
        let whistle = report(600.0, Some(0.0), &MatchEvent::FinalWhistle).unwrap();
        assert_eq!(whistle, " 10:00.00    0:00.00  Final whistle.");
    }

    #[test]
    fn without_a_clock_nothing_is_left_to_play_and_seconds_are_rounded_before_they_are_split() {
        let whistle = report(59.999, None, &MatchEvent::FinalWhistle).unwrap();
        assert_eq!(whistle, "  1:00.00          -  Final whistle.");
    }
}
