//! The texts of the robot panel, as plain functions.

use bevy::prelude::*;

use super::false_ones::Objects;
use crate::viewer::shared::state_name;
use crate::viewer::theme::count;
use naoisis_core::communication::TeamMessage;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::{Pose, angle_of, to_degrees};
use naoisis_core::pitch::End;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::Velocity;
use naoisis_core::robot::kick::KickRequest;
use naoisis_core::robot::posture::{Posture, PostureRequest};
use naoisis_core::robot::request::TeamRequest;
use naoisis_sensing::belief::covariance::half_axes_95;
use naoisis_sensing::belief::error::BeliefError;
use naoisis_sensing::belief::{Belief, PlaceCovariance, point_pitch_from_team};
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::vocabulary::RobotCommand;

/// A name and a value.
type Entry = (String, String);

fn entry(name: &str, value: String) -> Entry {
    (name.to_owned(), value)
}

/// A number with two decimals, without a minus sign before zero.
fn decimal(number: f32) -> String {
    format!("{:.2}", (100.0 * number).round() / 100.0 + 0.0)
}

/// An angle in whole degrees, without a minus sign before zero.
fn degrees(angle: f32) -> String {
    format!("{:.0}°", to_degrees(angle).round() + 0.0)
}

/// Returns the text of a position, m.
pub fn place(place: Vec2) -> String {
    format!("{}, {} m", decimal(place.x), decimal(place.y))
}

/// Returns the text of a pose in metres and degrees.
pub fn pose(pose: Pose) -> String {
    format!("{}, {}", place(pose.position), degrees(pose.heading))
}

/// Returns the text of the angles of a head.
pub fn head(yaw: f32, pitch: f32) -> String {
    let aside = if yaw >= 0.0 { "left" } else { "right" };
    let below = if pitch >= 0.0 { "down" } else { "up" };
    format!("{:.0}° {aside}, {:.0}° {below}", to_degrees(yaw.abs()), to_degrees(pitch.abs()))
}

/// Returns the text of a velocity.
pub fn velocity(velocity: Velocity) -> String {
    format!("{:.2} m/s, {}/s", velocity.linear.length(), degrees(velocity.angular))
}

/// Returns the text of the readings of the sonars; "none" for a robot without sonars.
pub fn sonar(reading: SonarReading, is_fitted: bool) -> String {
    if !is_fitted {
        return "none".to_owned();
    }
    let side = |distance: Option<f32>| distance.map_or("—".to_owned(), |distance| format!("{distance:.2} m"));
    format!("left {}, right {}", side(reading.left), side(reading.right))
}

/// Returns the text of a robot's condition.
pub fn condition(posture: &Posture, penalty: &Penalty, clock: &CycleClock) -> String {
    if let Some(active) = penalty.0 {
        let left_s = active.left_s(clock);
        return format!("penalised for {}, {left_s:.0} s left", active.reason.words());
    }
    match posture {
        Posture::Upright => "on its feet",
        Posture::Fallen { .. } => "fallen",
        Posture::GettingUp { .. } => "gets up",
        Posture::Diving { .. } => "dives",
    }
    .to_owned()
}

/// Returns the text with the numbers of detections, of which some are known to be of nothing.
pub fn percepts(percepts: &Percepts, false_ones: Objects) -> String {
    let of_nothing = |number: usize, all: usize| match number {
        0 => String::new(),
        _ if number == all => " (false: not there)".to_owned(),
        _ => format!(" ({number} false)"),
    };
    let ball = percepts.ball.map(|ball| {
        let at = format!("ball at {:.2} m, {}", ball.position_m.length(), degrees(angle_of(ball.position_m)));
        at + &of_nothing(false_ones.balls, percepts.all_balls().count())
    });
    let some = |number: usize, name: &str, of_them: usize| {
        (number > 0).then(|| count(number, name) + &of_nothing(of_them, number))
    };
    let parts = [
        ball,
        some(percepts.goal_posts.len(), "post", false_ones.posts),
        some(percepts.robots.len(), "robot", false_ones.robots),
        some(percepts.landmarks.len(), "landmark", 0),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { "no detections".to_owned() } else { parts.join(", ") }
}

/// Returns the entries of a behaviour's commands in a cycle of this duration, s.
pub fn commands(command: &RobotCommand, period: f32) -> Vec<Entry> {
    let walk = command.walk.map_or("stands".to_owned(), |walk| {
        let way = walk.translation() / period;
        let sideways = format!("{} {}", decimal(way.y.abs()), if way.y < 0.0 { "right" } else { "left" });
        format!("{} ahead, {sideways} m/s, {}/s", decimal(way.x), degrees(walk.dtheta / period))
    });
    let look = command.head.map_or("as before".to_owned(), |to| head(to.yaw, to.pitch));
    let mut entries = vec![entry("Walk", walk), entry("Head to", look)];
    entries.push(entry("Kick", command.kick.map_or("none".to_owned(), kick)));
    if let Some(posture) = command.posture {
        let text = match posture {
            PostureRequest::GetUp => "gets up".to_owned(),
            PostureRequest::Dive(side) => format!("dives to the {}", side.name()),
        };
        entries.push(entry("Body", text));
    }
    if let Some(request) = command.request {
        let text = match request {
            TeamRequest::Timeout => "a time-out".to_owned(),
            TeamRequest::PickUp => "to be picked up".to_owned(),
            TeamRequest::Substitute(number) => format!("substitute {number}"),
        };
        entries.push(entry("Asks for", text));
    }
    if let Some(intention) = command.say.as_ref().and_then(|say| say.intention.as_deref()) {
        entries.push(entry("Says", intention.to_owned()));
    }
    entries
}

fn kick(request: KickRequest) -> String {
    format!("{}, {:.0} %", request.kick_type.words(), 100.0 * request.speed)
}

/// Returns the text of the state of the game that a robot received.
pub fn told(told: &GameStatus) -> String {
    let mut parts = vec![state_name(told.state).to_owned()];
    parts.extend(told.set_play.map(|set_play| {
        let whose = set_play.team.map_or("one team".to_owned(), |team| team.to_string());
        format!("{} for {whose}", set_play.kind.words().to_lowercase())
    }));
    parts.extend(told.penalty.map(|reason| format!("penalised for {}", reason.words())));
    parts.push(format!("{} : {}", told.score.blue, told.score.pink));
    parts.join(", ")
}

/// Returns the text of the state of a robot's body.
pub fn body(body: BodyStatus) -> String {
    match body {
        BodyStatus::Standing => "stands",
        BodyStatus::Walking => "walks",
        BodyStatus::Kicking => "kicks",
        BodyStatus::Recovering => "regains balance",
        BodyStatus::Fallen => "lies",
        BodyStatus::GettingUp => "gets up",
        BodyStatus::Diving => "dives",
        BodyStatus::Penalised => "is penalised",
    }
    .to_owned()
}

/// The length of the major semi-axis of the 95 % ellipse of a position.
fn spread(covariance: PlaceCovariance) -> String {
    half_axes_95(covariance).map(|[long, _]| format!(" ± {:.2} m", long.length())).unwrap_or_default()
}

/// Returns the entries of a robot's belief in the pitch frame, with its errors.
pub fn belief(belief: &Belief, error: Option<&BeliefError>, own_end: End) -> Vec<Entry> {
    let [xx, xy, yy, ..] = belief.pose_covariance;
    let own = format!("{}{}", pose(belief.pose_in_pitch(own_end)), spread([xx, xy, yy]));
    let ball = match &belief.ball {
        None => "unknown".to_owned(),
        Some(ball) => {
            let heard = ball.heard_from.map(|from| format!(", from {from}")).unwrap_or_default();
            let at = place(point_pitch_from_team(ball.position_m, own_end));
            format!("{at}{}, {:.1} s old{heard}", spread(ball.position_covariance), ball.age_s)
        }
    };
    let mut entries = vec![entry("Itself", own)];
    if let Some(error) = error {
        let text = format!("{:.2} m, {}", error.position_m, degrees(error.heading));
        entries.push(entry("  error", text));
    }
    entries.push(entry("Ball", ball));
    if let Some(ball) = error.and_then(|error| error.ball) {
        entries.push(entry("  error", format!("{:.2} m", ball.position_m)));
    }
    let believed = belief.opponents.len();
    let opponents = match error {
        Some(error) if error.opponents_known as usize == believed => format!("{believed} of {}", error.opponents),
        Some(error) => format!("{believed} believed; {} of {} right", error.opponents_known, error.opponents),
        None => believed.to_string(),
    };
    entries.push(entry("Opponents", opponents));
    // Their list has a place for each robot that was seen: the same one may be in it more than once.
    let known = belief.team_mates.iter().filter(|mate| mate.id.is_some()).count();
    let seen = belief.team_mates.len() - known;
    let only_seen = if seen > 0 { format!(", {} without a number", count(seen, "place")) } else { String::new() };
    entries.push(entry("Team-mates", format!("{known} by messages{only_seen}")));
    entries
}

/// Returns the text of a team message on one line.
pub fn message(message: &TeamMessage) -> String {
    let TeamMessage { pose: own, ball_m, robots_m, intention, payload, datagram } = message;
    let robots = (!robots_m.is_empty()).then(|| count(robots_m.len(), "robot"));
    let parts = [
        own.map(|own| format!("at {}", pose(own))),
        ball_m.map(|ball| format!("ball {}", place(ball))),
        robots,
        intention.as_ref().map(|intention| format!("“{intention}”")),
        payload.as_ref().map(|payload| format!("“{payload}”")),
        datagram.as_ref().map(|_| "a datagram".to_owned()),
    ];
    let text = parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
    format!("{text} ({})", count(message.size_bytes(), "byte"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::kick_geometry::KickType;
    use naoisis_core::pitch::GoalColour;
    use naoisis_core::robot::motion::WalkCommand;
    use naoisis_sensing::belief::BallBelief;
    use naoisis_sensing::sensing::vision::GoalPostPercept;

    #[test]
    fn commands_are_told_in_speeds() {
        let command = RobotCommand {
            walk: Some(WalkCommand::new(0.005, -0.002, 0.0349)),
            kick: Some(KickRequest::new(KickType::LeftSide, 0.5)),
            ..default()
        };
        let told = commands(&command, 1.0 / 30.0);
        assert_eq!(told[0].1, "0.15 ahead, 0.06 right m/s, 60°/s");
        assert_eq!(told[2].1, "left foot, to the right, 50 %");
    }

    #[test]
    fn a_belief_is_told_in_the_pitch_frame_with_its_doubt() {
        let belief = Belief {
            ball: Some(BallBelief {
                position_m: Vec2::new(1.0, 0.5),
                position_covariance: [0.01, 0.0, 0.0001],
                ..default()
            }),
            ..Belief::at(Pose::new(-2.0, 1.0, 0.0))
        };
        let told = super::belief(&belief, None, End::PositiveX);
        assert!(told[0].1.starts_with("2.00, -1.00 m, ") && told[0].1.contains("180°"), "{told:?}");
        // 2.4477 x 0.1 m.
        assert_eq!(told[1].1, "-1.00, -0.50 m ± 0.24 m, 0.0 s old");
    }

    #[test]
    fn heads_and_percepts_are_told_in_words() {
        assert_eq!(head(-0.349_07, 0.174_53), "20° right, 10° down");
        assert_eq!(pose(Pose::new(-0.001, 0.0, -0.001)), "0.00, 0.00 m, 0°");
        assert_eq!(percepts(&Percepts::default(), Objects::default()), "no detections");
        let post = GoalPostPercept::new(CameraName::TOP, GoalColour::White, Vec2::ZERO, Vec2::X);
        let mut seen = Percepts::default();
        seen.goal_posts = vec![post; 2];
        let words = |posts| percepts(&seen, Objects { posts, ..default() });
        assert_eq!([words(0), words(1), words(2)], ["2 posts", "2 posts (1 false)", "2 posts (false: not there)"]);
        let reading = SonarReading { left: None, right: Some(0.3), time_s: None };
        assert_eq!([sonar(reading, true), sonar(reading, false)], ["left —, right 0.30 m", "none"]);
    }
}
