//! What agents observe, as arrays: one list of entries for each kind of observation.
//!
//! | kind | what an agent knows |
//! |---|---|
//! | [`Perception`](ObservationKind::Perception) | what its sensors say now, and what it is told of the game |
//! | [`Belief`](ObservationKind::Belief) | what the built-in estimator makes of it |
//! | [`Truth`](ObservationKind::Truth) | what is true: for critics, and to see what perfect knowledge is worth |
//! | [`Body`](ObservationKind::Body) | what it knows besides camera images |

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::PI;
use serde::{Deserialize, Serialize};

use super::entry::{Entries, Group, ObservationEntry, Sink, Values};
use naoisis_core::ball::{Ball, BallVelocity};
use naoisis_core::game::{Game, GameState, Penalty};
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::pitch::{GoalColour, Pitch};
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{Belief, RobotBelief, point_team_from_pitch, team_from_pitch};
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::{LandmarkKind, LandmarkPercept, Percepts};

/// What agents observe.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObservationKind {
    /// Sensors, and what the robot is told.
    #[default]
    Perception,
    /// The built-in estimator's belief.
    Belief,
    /// What is true.
    Truth,
    /// What a robot knows besides its camera images.
    Body,
}

/// How many robots there are beside an agent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Others {
    /// Robots of its own team.
    pub team_mates: u8,
    /// Robots of the other team.
    pub opponents: u8,
}

impl Others {
    /// Those beside a robot of this team.
    pub fn of(roster: &Roster, team: Team) -> Self {
        let count = |of: Team| roster.iter().filter(|(id, _)| id.team == of).count().min(usize::from(u8::MAX)) as u8;
        Self { team_mates: count(team).saturating_sub(1), opponents: count(team.opponent()) }
    }
}

/// What of an agent's past is in what it observes.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Memory {
    /// Its odometry when it observed last.
    pub odometry: Pose,
}

/// Farther away nothing is said to be, m.
const FARTHEST_M: f32 = 20.0;
/// Nothing is faster, m/s.
const FASTEST_MPS: f32 = 10.0;
/// What is older is as good as forgotten, s.
const OLDEST_S: f32 = 10.0;
/// Junctions of lines that are told, the nearest.
const JUNCTIONS: u8 = 3;

const PLACE: [f32; 2] = [-FARTHEST_M, FARTHEST_M];
const SPEED: [f32; 2] = [-FASTEST_MPS, FASTEST_MPS];
const UNIT: [f32; 2] = [-1.0, 1.0];
const AGE: [f32; 2] = [0.0, OLDEST_S];

/// The entries of what a robot of the match in the world observes.
pub fn entries(kind: ObservationKind, world: &World, id: RobotId) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    observe_into(&mut entries, kind, world, id, &Memory::default());
    entries.0
}

/// Fills an array with what a robot observes. As many numbers as [`entries`] has names.
pub(super) fn observe(array: &mut [f32], kind: ObservationKind, world: &World, id: RobotId, memory: &Memory) {
    observe_into(&mut Values { array, filled: 0 }, kind, world, id, memory);
}

fn observe_into(sink: &mut impl Sink, kind: ObservationKind, world: &World, id: RobotId, memory: &Memory) {
    let roster = world.resource::<Roster>();
    let Some(robot) = roster.get(id).and_then(|entity| world.get_entity(entity).ok()) else { return };
    let others = Others::of(roster, id.team);
    let status = robot.get::<GameStatus>().copied().unwrap_or_default();
    match kind {
        ObservationKind::Perception => {
            put_body(sink, &robot, memory);
            put_percepts(sink, robot.get::<Percepts>(), &status, world, id, others);
        }
        ObservationKind::Belief => {
            put_body(sink, &robot, memory);
            put_belief(sink, robot.get::<Belief>(), world, others);
        }
        ObservationKind::Truth => put_truth(sink, &robot, world, id, others),
        ObservationKind::Body => put_body(sink, &robot, memory),
    }
    put_game(sink, &status, robot.get::<BodyStatus>().copied().unwrap_or_default(), id.team);
}

/// What the body feels and the sonars hear.
fn put_body(sink: &mut impl Sink, robot: &EntityRef, memory: &Memory) {
    let head = robot.get::<HeadAngles>().copied().unwrap_or_default();
    let limits = robot.get::<HeadLimits>().copied().unwrap_or_default();
    Group::new(sink, "head", 0).put("yaw", limits.yaw, "the head's yaw, rad, counter-clockwise", head.yaw).put(
        "pitch",
        limits.pitch,
        "the head's pitch, rad, downwards",
        head.pitch,
    );
    let odometry = robot.get::<Odometry>().map(|odometry| odometry.0).unwrap_or_default();
    let step = memory.odometry.relative(odometry);
    Group::new(sink, "step", 0)
        .put("x", UNIT, "the way since the last observation by its own steps, forward, m", step.position.x)
        .put("y", UNIT, "the same to the left, m", step.position.y)
        .put("turn", [-PI, PI], "the same counter-clockwise, rad", step.heading);
    let settings = robot.get::<SonarSettings>().copied().unwrap_or_default();
    let reading = robot.get::<SonarReading>().copied().unwrap_or_default();
    let range = [0.0, settings.max_m];
    Group::new(sink, "sonar", 0)
        .put(
            "left",
            range,
            "what the left sonar hears, m; its range where it hears nothing",
            reading.left.unwrap_or(settings.max_m),
        )
        .put("right", range, "what the right sonar hears, m", reading.right.unwrap_or(settings.max_m));
}

/// Something that may be seen, in the robot's frame.
fn put_seen<S: Sink>(sink: &mut S, group: &'static str, number: u8, place: Option<Vec2>) {
    let [x, y] = place.unwrap_or_default().to_array();
    Group::new(sink, group, number)
        .flag("seen", "1 where it is seen, and else 0 like the rest", place.is_some())
        .put("x", PLACE, "how far it is ahead, m", x)
        .put("y", PLACE, "how far it is to the left, m", y);
}

/// What the cameras recognise.
fn put_percepts(
    sink: &mut impl Sink,
    percepts: Option<&Percepts>,
    status: &GameStatus,
    world: &World,
    id: RobotId,
    others: Others,
) {
    let nothing = Percepts::default();
    let percepts = percepts.unwrap_or(&nothing);
    put_seen(sink, "ball", 0, percepts.ball.map(|ball| ball.position_m));
    let pitch = world.resource::<Pitch>();
    let own = pitch.goal_colour(status.own_end);
    for (group, is_own) in [("goal_post", false), ("own_goal_post", true)] {
        let is_of =
            |colour: GoalColour| pitch.goal_colour(status.own_end.opposite()) != own && (colour == own) == is_own;
        let mut posts: Vec<Vec2> =
            percepts.goal_posts.iter().filter(|post| is_of(post.colour)).map(|post| post.position_m).collect();
        // From left to right.
        posts.sort_by(|a, b| angle_of(*b).total_cmp(&angle_of(*a)));
        for number in 1..=2 {
            put_seen(sink, group, number, posts.get(usize::from(number) - 1).copied());
        }
    }
    for (group, team, count) in
        [("team_mate", id.team, others.team_mates), ("opponent", id.team.opponent(), others.opponents)]
    {
        let mut robots: Vec<Vec2> =
            percepts.robots.iter().filter(|robot| robot.team == team).map(|robot| robot.position_m).collect();
        nearest_first(&mut robots);
        for number in 1..=count {
            put_seen(sink, group, number, robots.get(usize::from(number) - 1).copied());
        }
    }
    let nearest = |is_it: fn(&LandmarkKind) -> bool| {
        let places = percepts.landmarks.iter().filter(|mark| is_it(&mark.kind));
        let mut places: Vec<Vec2> = places.map(|mark: &LandmarkPercept| mark.position_m).collect();
        nearest_first(&mut places);
        places
    };
    put_seen(sink, "centre_circle", 0, nearest(|kind| matches!(kind, LandmarkKind::CentreCircle)).first().copied());
    put_seen(sink, "penalty_cross", 0, nearest(|kind| matches!(kind, LandmarkKind::PenaltyCross)).first().copied());
    let junctions = nearest(|kind| matches!(kind, LandmarkKind::Junction { .. }));
    for number in 1..=JUNCTIONS {
        put_seen(sink, "junction", number, junctions.get(usize::from(number) - 1).copied());
    }
}

fn nearest_first(places: &mut [Vec2]) {
    places.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
}

/// What the built-in estimator believes: places of others in the robot's frame, its own in the team's.
fn put_belief(sink: &mut impl Sink, belief: Option<&Belief>, world: &World, others: Others) {
    let nothing = Belief::default();
    let belief = belief.unwrap_or(&nothing);
    let [xx, _, yy, _, _, tt] = belief.pose_covariance;
    put_own_pose(sink, belief.pose);
    Group::new(sink, "own", 0)
        .put("position_sd", AGE, "standard deviation of its place, m", ops::sqrt((xx + yy).max(0.0)))
        .put("heading_sd", [0.0, PI], "standard deviation of its heading, rad", ops::sqrt(tt.max(0.0)))
        .put("age", AGE, "since something seen confirmed its pose, s", belief.pose_age_s);
    put_goals(sink, belief.pose, world.resource::<Pitch>());
    let ball = belief.ball.unwrap_or_default();
    let is_known = belief.ball.is_some();
    let place = if is_known { belief.pose.inverse_transform_point(ball.position_m) } else { Vec2::ZERO };
    let velocity = unrotate(belief.pose.forward(), ball.velocity_mps);
    let [xx, _, yy] = ball.position_covariance;
    Group::new(sink, "ball", 0)
        .flag("known", "1 where the robot knows of it, and else 0 like the rest", is_known)
        .put("x", PLACE, "how far it is ahead, m", place.x)
        .put("y", PLACE, "how far it is to the left, m", place.y)
        .put("vx", SPEED, "how fast it rolls ahead, m/s", velocity.x)
        .put("vy", SPEED, "how fast it rolls to the left, m/s", velocity.y)
        .put("position_sd", AGE, "standard deviation of its place, m", ops::sqrt((xx + yy).max(0.0)))
        .put("age", AGE, "since it was seen, s", ball.age_s);
    put_believed(sink, "team_mate", others.team_mates, belief.pose, &belief.team_mates);
    put_believed(sink, "opponent", others.opponents, belief.pose, &belief.opponents);
}

/// Where other robots are believed to be, the nearest first.
fn put_believed(sink: &mut impl Sink, group: &'static str, count: u8, own: Pose, believed: &[RobotBelief]) {
    let mut robots: Vec<(Vec2, f32)> =
        believed.iter().map(|robot| (own.inverse_transform_point(robot.position_m), robot.age_s)).collect();
    robots.sort_by(|(a, _), (b, _)| a.length_squared().total_cmp(&b.length_squared()));
    for number in 1..=count {
        let robot = robots.get(usize::from(number) - 1).copied();
        let (place, age_s) = robot.unwrap_or_default();
        Group::new(sink, group, number)
            .flag("known", "1 where the robot knows of it, and else 0 like the rest", robot.is_some())
            .put("x", PLACE, "how far it is ahead, m", place.x)
            .put("y", PLACE, "how far it is to the left, m", place.y)
            .put("age", AGE, "since it was seen or heard of, s", age_s);
    }
}

/// A pose in the team's frame: the own goal is at -x.
fn put_own_pose(sink: &mut impl Sink, pose: Pose) {
    let forward = pose.forward();
    Group::new(sink, "own", 0)
        .put("x", PLACE, "where it is, team frame, m: the own goal is at -x", pose.position.x)
        .put("y", PLACE, "where it is, team frame, m", pose.position.y)
        .put("cos", UNIT, "the cosine of its heading, team frame", forward.x)
        .put("sin", UNIT, "the sine of its heading, team frame", forward.y);
}

/// The middle of both goals in the robot's frame.
fn put_goals(sink: &mut impl Sink, own: Pose, pitch: &Pitch) {
    for (group, sign) in [("goal", 1.0), ("own_goal", -1.0)] {
        let place = own.inverse_transform_point(Vec2::new(sign * pitch.half_length(), 0.0));
        Group::new(sink, group, 0).put("x", PLACE, "how far its middle is ahead, m", place.x).put(
            "y",
            PLACE,
            "how far its middle is to the left, m",
            place.y,
        );
    }
}

/// What is true, places of others in the robot's frame.
fn put_truth(sink: &mut impl Sink, robot: &EntityRef, world: &World, id: RobotId, others: Others) {
    let own_end = world.resource::<Game>().own_end(id.team);
    let pose_of = |robot: &EntityRef| robot.get::<Pose>().copied().unwrap_or_default();
    let pose = pose_of(robot);
    let own = team_from_pitch(pose, own_end);
    put_own_pose(sink, own);
    let velocity = robot.get::<Velocity>().copied().unwrap_or_default();
    let [vx, vy] = unrotate(pose.forward(), velocity.linear).to_array();
    let head = robot.get::<HeadAngles>().copied().unwrap_or_default();
    let limits = robot.get::<HeadLimits>().copied().unwrap_or_default();
    Group::new(sink, "own", 0)
        .put("vx", SPEED, "how fast it walks ahead, m/s", vx)
        .put("vy", SPEED, "how fast it walks to the left, m/s", vy)
        .put("turn", SPEED, "how fast it turns, rad/s", velocity.angular);
    Group::new(sink, "head", 0).put("yaw", limits.yaw, "the head's yaw, rad, counter-clockwise", head.yaw).put(
        "pitch",
        limits.pitch,
        "the head's pitch, rad, downwards",
        head.pitch,
    );
    put_goals(sink, own, world.resource::<Pitch>());
    let ball = ball_of(world);
    let (place, velocity) = ball.unwrap_or_default();
    let place = if ball.is_some() { pose.inverse_transform_point(place) } else { Vec2::ZERO };
    let velocity = unrotate(pose.forward(), velocity);
    Group::new(sink, "ball", 0)
        .put("x", PLACE, "how far it is ahead, m", place.x)
        .put("y", PLACE, "how far it is to the left, m", place.y)
        .put("vx", SPEED, "how fast it rolls ahead, m/s", velocity.x)
        .put("vy", SPEED, "how fast it rolls to the left, m/s", velocity.y);
    let roster = world.resource::<Roster>();
    for (group, team, count) in
        [("team_mate", id.team, others.team_mates), ("opponent", id.team.opponent(), others.opponents)]
    {
        let of_team = roster.iter().filter(|(other, _)| other.team == team && *other != id);
        for (number, (_, entity)) in (1..=count).zip(of_team) {
            let Ok(other) = world.get_entity(entity) else { continue };
            let seen = pose.relative(pose_of(&other));
            let forward = seen.forward();
            Group::new(sink, group, number)
                .flag("plays", "1 while it serves no penalty", !other.get::<Penalty>().is_some_and(Penalty::is_active))
                .put("x", PLACE, "how far it is ahead, m", seen.position.x)
                .put("y", PLACE, "how far it is to the left, m", seen.position.y)
                .put("cos", UNIT, "the cosine of its heading, as the robot sees it", forward.x)
                .put("sin", UNIT, "the sine of its heading, as the robot sees it", forward.y);
        }
    }
}

/// Place and velocity of the ball, pitch frame, m and m/s.
pub(super) fn ball_of(world: &World) -> Option<(Vec2, Vec2)> {
    let mut balls = world.try_query_filtered::<(&Pose, &BallVelocity), With<Ball>>()?;
    balls.iter(world).next().map(|(pose, velocity)| (pose.position, velocity.0))
}

/// What the robot is told of the game, and what its body is doing.
fn put_game(sink: &mut impl Sink, status: &GameStatus, body: BodyStatus, team: Team) {
    let mut game = Group::new(sink, "game", 0);
    for (name, state) in [
        ("ready", GameState::Ready),
        ("set", GameState::Set),
        ("playing", GameState::Playing),
        ("finished", GameState::Finished),
    ] {
        game.flag(name, "1 in this state of the game; all 0 before it begins", status.state == state);
    }
    let [own, other] = [team, team.opponent()].map(|team| status.score[team] as f32);
    game.put("lead", [-10.0, 10.0], "own goals less those of the opponents", own - other)
        .put("minutes_left", [0.0, 60.0], "of this half", status.time_left_s.unwrap_or(0.0) / 60.0)
        .flag("own_kick_off", "1 where the last kick-off was the own team's", status.kick_off_team == team);
    let mut own = Group::new(sink, "body", 0);
    own.flag("penalised", "1 while the robot serves a penalty: its actions do nothing", status.penalised);
    for (name, state) in [
        ("walking", BodyStatus::Walking),
        ("kicking", BodyStatus::Kicking),
        ("recovering", BodyStatus::Recovering),
        ("fallen", BodyStatus::Fallen),
        ("getting_up", BodyStatus::GettingUp),
    ] {
        own.flag(name, "1 while the body does this; all 0 where it stands", body == state);
    }
}

/// The entries of the state that a critic may know.
pub fn state_entries(world: &World) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    state_into(&mut entries, world);
    entries.0
}

/// Fills an array with what is true of the whole match, in the frame of blue's team: for critics that may know it.
pub(super) fn state(array: &mut [f32], world: &World) {
    state_into(&mut Values { array, filled: 0 }, world);
}

fn state_into(sink: &mut impl Sink, world: &World) {
    let game = world.resource::<Game>();
    let own_end = game.own_end(Team::Blue);
    let (place, velocity) = ball_of(world).unwrap_or_default();
    let [place, velocity] = [place, velocity].map(|vector| point_team_from_pitch(vector, own_end));
    Group::new(sink, "ball", 0)
        .put("x", PLACE, "where it is, m", place.x)
        .put("y", PLACE, "where it is, m", place.y)
        .put("vx", SPEED, "how fast it rolls, m/s", velocity.x)
        .put("vy", SPEED, "how fast it rolls, m/s", velocity.y);
    for (id, entity) in world.resource::<Roster>().iter() {
        let Ok(robot) = world.get_entity(entity) else { continue };
        let pose = team_from_pitch(robot.get::<Pose>().copied().unwrap_or_default(), own_end);
        let velocity = robot.get::<Velocity>().copied().unwrap_or_default().linear;
        let velocity = point_team_from_pitch(velocity, own_end);
        let forward = pose.forward();
        Group::new(sink, id.team.name(), id.number)
            .flag("plays", "1 while it serves no penalty", !robot.get::<Penalty>().is_some_and(Penalty::is_active))
            .put("x", PLACE, "where it is, m", pose.position.x)
            .put("y", PLACE, "where it is, m", pose.position.y)
            .put("cos", UNIT, "the cosine of its heading", forward.x)
            .put("sin", UNIT, "the sine of its heading", forward.y)
            .put("vx", SPEED, "how fast it walks, m/s", velocity.x)
            .put("vy", SPEED, "how fast it walks, m/s", velocity.y);
    }
    let minutes_left = game.time_left_s(world.resource()).unwrap_or(0.0) / 60.0;
    Group::new(sink, "game", 0)
        .flag("playing", "1 while the ball is in play", game.state == GameState::Playing)
        .put("lead", [-10.0, 10.0], "goals of blue less those of pink", game.score.blue as f32 - game.score.pink as f32)
        .put("minutes_left", [0.0, 60.0], "of this half", minutes_left);
}
