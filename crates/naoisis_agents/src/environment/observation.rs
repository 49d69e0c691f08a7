//! Observations of agents as arrays: one list of entries for each kind of observation.
//!
//! | kind | contents |
//! |---|---|
//! | [`Perception`](ObservationKind::Perception) | current sensor readings, and the state of the game that the robot received |
//! | [`Belief`](ObservationKind::Belief) | the belief of the built-in estimator |
//! | [`Truth`](ObservationKind::Truth) | the true state: for critics, and to measure the value of perfect knowledge |
//! | [`Body`](ObservationKind::Body) | everything except vision, for agents that observe camera images |

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::PI;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::entry::{AGE, Entries, Group, ObservationEntry, PLACE, SPEED, Sink, UNIT, Values};
use super::extras::Extras;
use super::heard::{Heard, keep_newest, put_messages};
use super::tracks::{Track, follow};
use naoisis_core::ball::{Ball, BallVelocity};
use naoisis_core::game::{Game, GameState, Penalty, SetPlayKind};
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

/// The kinds of observations.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ObservationKind {
    /// Sensor readings, and the state of the game that the robot received.
    #[default]
    Perception,
    /// The belief of the built-in estimator.
    Belief,
    /// The true state.
    Truth,
    /// Everything except vision, for agents that observe camera images.
    Body,
}

/// What an agent observes: the kind of observation, with its extras.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ObservationForm {
    /// The kind.
    pub kind: ObservationKind,
    /// The extras.
    pub extras: Extras,
}

impl From<ObservationKind> for ObservationForm {
    fn from(kind: ObservationKind) -> Self {
        Self { kind, extras: Extras::default() }
    }
}

/// The number of other robots in a match with an agent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Others {
    /// Other robots of its team.
    pub team_mates: u8,
    /// Robots of the other team.
    pub opponents: u8,
}

impl Others {
    /// The other robots in a match with a robot of `team`.
    pub fn of(roster: &Roster, team: Team) -> Self {
        let count = |of: Team| roster.iter().filter(|(id, _)| id.team == of).count().min(usize::from(u8::MAX)) as u8;
        Self { team_mates: count(team).saturating_sub(1), opponents: count(team.opponent()) }
    }
}

/// The past values of an agent that its observations use.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Memory {
    /// Its odometry at its last observation.
    pub odometry: Pose,
    /// The last message of each team-mate, if messages are observed.
    #[reflect(default)]
    heard: Vec<Heard>,
    /// The team-mates that are followed, if the order of robots is stable.
    #[reflect(default)]
    team_mates: Vec<Track>,
    /// The opponents that are followed, like `team_mates`.
    #[reflect(default)]
    opponents: Vec<Track>,
}

impl Memory {
    /// Creates the memory of a robot at the start of an episode.
    pub fn at(odometry: Pose) -> Self {
        Self { odometry, ..default() }
    }

    /// Keeps the messages that arrived in this cycle.
    pub fn listen(&mut self, world: &World, robot: Entity) {
        keep_newest(&mut self.heard, world, robot);
    }

    /// Follows the other robots that the robot `id` knows of now.
    pub fn follow(&mut self, kind: ObservationKind, world: &World, id: RobotId, others: Others) {
        let Some(robot) = world.resource::<Roster>().get(id).and_then(|entity| world.get_entity(entity).ok()) else {
            return;
        };
        let [team_mates, opponents] = places_of_others(kind, &robot, id);
        follow(&mut self.team_mates, &team_mates, others.team_mates);
        follow(&mut self.opponents, &opponents, others.opponents);
    }
}

/// The places of other robots that `robot` knows of, in the order of its lists, team-mates and opponents: in the team frame for beliefs, in the
/// frame of its odometry for detections, m. The truth has a stable order of its own.
fn places_of_others(kind: ObservationKind, robot: &EntityRef, id: RobotId) -> [Vec<Vec2>; 2] {
    match (kind, robot.get::<Belief>(), robot.get::<Percepts>()) {
        (ObservationKind::Belief, Some(belief), _) => [&belief.team_mates, &belief.opponents]
            .map(|robots| robots.iter().map(|robot: &RobotBelief| robot.position_m).collect()),
        (ObservationKind::Perception, _, Some(percepts)) => {
            let odometry = robot.get::<Odometry>().map(|odometry| odometry.0).unwrap_or_default();
            [id.team, id.team.opponent()].map(|team| {
                let places = of_team(percepts, team).into_iter();
                places.map(|place| odometry.transform_point(place)).collect()
            })
        }
        _ => [Vec::new(), Vec::new()],
    }
}

/// The places of the robots of `team` that are detected, m, robot frame.
fn of_team(percepts: &Percepts, team: Team) -> Vec<Vec2> {
    percepts.robots.iter().filter(|robot| robot.team == team).map(|robot| robot.position_m).collect()
}

/// The index in `places` of each of `count` robots: as they are followed in `tracks`, or else the nearest first.
fn order_of(places: &[Vec2], count: u8, tracks: Option<&[Track]>) -> Vec<Option<usize>> {
    let mut order: Vec<Option<usize>> = match tracks {
        Some(tracks) => tracks.iter().map(|track| track.index).collect(),
        None => {
            let mut indices: Vec<usize> = (0..places.len()).collect();
            indices.sort_by(|a, b| places[*a].length_squared().total_cmp(&places[*b].length_squared()));
            indices.into_iter().map(Some).collect()
        }
    };
    order.resize(usize::from(count), None);
    order
}

/// The number of line junctions in an observation: the nearest ones.
const JUNCTIONS: u8 = 3;

/// The entries of the observation of robot `id` in the match of `world`.
pub fn entries(form: ObservationForm, world: &World, id: RobotId) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    observe_into(&mut entries, form, world, id, Others::of(world.resource(), id.team), &Memory::default());
    entries.0
}

/// Fills `array` with the observation of robot `id`. It has as many numbers as [`entries`] has entries.
pub(crate) fn observe(array: &mut [f32], form: ObservationForm, world: &World, id: RobotId, memory: &Memory) {
    let others = Others::of(world.resource(), id.team);
    observe_into(&mut Values { array, filled: 0 }, form, world, id, others, memory);
}

/// The observation of robot `id` with entries for `others`: the nearest ones if the match has more of them; those that it lacks are unknown.
pub(crate) fn observed(
    form: ObservationForm,
    world: &World,
    id: RobotId,
    others: Others,
    memory: &Memory,
) -> Vec<(ObservationEntry, f32)> {
    let mut observed = Vec::new();
    observe_into(&mut observed, form, world, id, others, memory);
    observed
}

fn observe_into(
    sink: &mut impl Sink,
    form: ObservationForm,
    world: &World,
    id: RobotId,
    others: Others,
    memory: &Memory,
) {
    let roster = world.resource::<Roster>();
    let Some(robot) = roster.get(id).and_then(|entity| world.get_entity(entity).ok()) else { return };
    let status = robot.get::<GameStatus>().copied().unwrap_or_default();
    let extras = form.extras;
    let tracks = extras.tracked.then_some([memory.team_mates.as_slice(), memory.opponents.as_slice()]);
    match form.kind {
        ObservationKind::Perception => {
            put_body(sink, &robot, memory);
            put_percepts(sink, robot.get::<Percepts>(), &status, world, id, others, tracks);
        }
        ObservationKind::Belief => {
            put_body(sink, &robot, memory);
            put_belief(sink, robot.get::<Belief>(), world, others, tracks);
        }
        ObservationKind::Truth => put_truth(sink, &robot, world, id, others),
        ObservationKind::Body => put_body(sink, &robot, memory),
    }
    put_game(sink, &status, robot.get::<BodyStatus>().copied().unwrap_or_default(), id.team);
    if extras.set_plays {
        put_set_play(sink, &status, id.team);
    }
    if extras.messages {
        put_messages(sink, &memory.heard, world, id, others.team_mates, extras.words);
    }
}

/// Puts the state of the body, and the sonars.
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
        .put("x", UNIT, "displacement since the last observation by odometry, forward, m", step.position.x)
        .put("y", UNIT, "displacement since the last observation by odometry, to the left, m", step.position.y)
        .put("turn", [-PI, PI], "turn since the last observation by odometry, counter-clockwise, rad", step.heading);
    let settings = robot.get::<SonarSettings>().copied().unwrap_or_default();
    let reading = robot.get::<SonarReading>().copied().unwrap_or_default();
    let range = [0.0, settings.max_m];
    Group::new(sink, "sonar", 0)
        .put(
            "left",
            range,
            "echo of the left sonar, m; its range without an echo",
            reading.left.unwrap_or(settings.max_m),
        )
        .put(
            "right",
            range,
            "echo of the right sonar, m; its range without an echo",
            reading.right.unwrap_or(settings.max_m),
        );
}

/// Puts a detection, in the robot frame; if there is none, its numbers are 0.
fn put_seen<S: Sink>(sink: &mut S, group: &'static str, number: u8, place: Option<Vec2>) {
    let [x, y] = place.unwrap_or_default().to_array();
    Group::new(sink, group, number)
        .flag("seen", "1 if it is seen; else it and the rest of its group are 0", place.is_some())
        .put("x", PLACE, "distance forwards, m", x)
        .put("y", PLACE, "distance to the left, m", y);
}

/// Puts the detections of the cameras.
fn put_percepts(
    sink: &mut impl Sink,
    percepts: Option<&Percepts>,
    status: &GameStatus,
    world: &World,
    id: RobotId,
    others: Others,
    tracks: Option<[&[Track]; 2]>,
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
        // Sorted from left to right.
        posts.sort_by(|a, b| angle_of(*b).total_cmp(&angle_of(*a)));
        for number in 1..=2 {
            put_seen(sink, group, number, posts.get(usize::from(number) - 1).copied());
        }
    }
    for (side, group, team, count) in
        [(0, "team_mate", id.team, others.team_mates), (1, "opponent", id.team.opponent(), others.opponents)]
    {
        let robots = of_team(percepts, team);
        let order = order_of(&robots, count, tracks.map(|tracks| tracks[side]));
        for (number, index) in (1..=count).zip(order) {
            put_seen(sink, group, number, index.and_then(|index| robots.get(index)).copied());
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

/// Puts the belief of the built-in estimator: other objects in the robot frame, the own pose in the team frame.
fn put_belief(
    sink: &mut impl Sink,
    belief: Option<&Belief>,
    world: &World,
    others: Others,
    tracks: Option<[&[Track]; 2]>,
) {
    let nothing = Belief::default();
    let belief = belief.unwrap_or(&nothing);
    let [xx, _, yy, _, _, tt] = belief.pose_covariance;
    put_own_pose(sink, belief.pose);
    Group::new(sink, "own", 0)
        .put("position_sd", AGE, "standard deviation of its position, m", ops::sqrt((xx + yy).max(0.0)))
        .put("heading_sd", [0.0, PI], "standard deviation of its heading, rad", ops::sqrt(tt.max(0.0)))
        .put("age", AGE, "time since landmarks confirmed the pose, s", belief.pose_age_s);
    put_goals(sink, belief.pose, world.resource::<Pitch>());
    let ball = belief.ball.unwrap_or_default();
    let is_known = belief.ball.is_some();
    let place = if is_known { belief.pose.inverse_transform_point(ball.position_m) } else { Vec2::ZERO };
    let velocity = unrotate(belief.pose.forward(), ball.velocity_mps);
    let [xx, _, yy] = ball.position_covariance;
    Group::new(sink, "ball", 0)
        .flag("known", "1 if the robot knows of it; else it and the rest of its group are 0", is_known)
        .put("x", PLACE, "distance forwards, m", place.x)
        .put("y", PLACE, "distance to the left, m", place.y)
        .put("vx", SPEED, "forward velocity, m/s", velocity.x)
        .put("vy", SPEED, "velocity to the left, m/s", velocity.y)
        .put("position_sd", AGE, "standard deviation of its position, m", ops::sqrt((xx + yy).max(0.0)))
        .put("age", AGE, "time since it was seen, s", ball.age_s);
    for (side, group, count, robots) in
        [(0, "team_mate", others.team_mates, &belief.team_mates), (1, "opponent", others.opponents, &belief.opponents)]
    {
        put_believed(sink, group, count, belief.pose, robots, tracks.map(|tracks| tracks[side]));
    }
}

/// Puts the believed positions of other robots: as they are followed, or else the nearest first.
fn put_believed(
    sink: &mut impl Sink,
    group: &'static str,
    count: u8,
    own: Pose,
    believed: &[RobotBelief],
    tracks: Option<&[Track]>,
) {
    let robots: Vec<Vec2> = believed.iter().map(|robot| own.inverse_transform_point(robot.position_m)).collect();
    for (number, index) in (1..=count).zip(order_of(&robots, count, tracks)) {
        let robot = index.and_then(|index| Some((*robots.get(index)?, believed.get(index)?.age_s)));
        let (place, age_s) = robot.unwrap_or_default();
        Group::new(sink, group, number)
            .flag("known", "1 if the robot knows of it; else it and the rest of its group are 0", robot.is_some())
            .put("x", PLACE, "distance forwards, m", place.x)
            .put("y", PLACE, "distance to the left, m", place.y)
            .put("age", AGE, "time since it was seen or reported, s", age_s);
    }
}

/// Puts a pose in the team frame: the own goal is at -x.
fn put_own_pose(sink: &mut impl Sink, pose: Pose) {
    let forward = pose.forward();
    Group::new(sink, "own", 0)
        .put("x", PLACE, "position, team frame, m: the own goal is at -x", pose.position.x)
        .put("y", PLACE, "position, team frame, m", pose.position.y)
        .put("cos", UNIT, "cosine of its heading, team frame", forward.x)
        .put("sin", UNIT, "sine of its heading, team frame", forward.y);
}

/// Puts the centres of both goals in the robot frame.
fn put_goals(sink: &mut impl Sink, own: Pose, pitch: &Pitch) {
    for (group, sign) in [("goal", 1.0), ("own_goal", -1.0)] {
        let place = own.inverse_transform_point(Vec2::new(sign * pitch.half_length(), 0.0));
        Group::new(sink, group, 0).put("x", PLACE, "distance of its centre forwards, m", place.x).put(
            "y",
            PLACE,
            "distance of its centre to the left, m",
            place.y,
        );
    }
}

/// Puts the true state, other objects in the robot frame.
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
        .put("vx", SPEED, "forward velocity, m/s", vx)
        .put("vy", SPEED, "velocity to the left, m/s", vy)
        .put("turn", SPEED, "turning velocity, counter-clockwise, rad/s", velocity.angular);
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
        .put("x", PLACE, "distance forwards, m", place.x)
        .put("y", PLACE, "distance to the left, m", place.y)
        .put("vx", SPEED, "forward velocity, m/s", velocity.x)
        .put("vy", SPEED, "velocity to the left, m/s", velocity.y);
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
                .flag("plays", "1 while it is not penalised", !other.get::<Penalty>().is_some_and(Penalty::is_active))
                .put("x", PLACE, "distance forwards, m", seen.position.x)
                .put("y", PLACE, "distance to the left, m", seen.position.y)
                .put("cos", UNIT, "cosine of its heading, robot frame", forward.x)
                .put("sin", UNIT, "sine of its heading, robot frame", forward.y);
        }
    }
}

/// The position and velocity of the ball, pitch frame, m and m/s.
pub(super) fn ball_of(world: &World) -> Option<(Vec2, Vec2)> {
    let mut balls = world.try_query_filtered::<(&Pose, &BallVelocity), With<Ball>>()?;
    balls.iter(world).next().map(|(pose, velocity)| (pose.position, velocity.0))
}

/// Puts the state of the game that the robot received, and the state of its body.
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
    game.put("lead", [-10.0, 10.0], "own goals minus goals of the opponents", own - other)
        .put("minutes_left", [0.0, 60.0], "minutes left in this half", status.time_left_s.unwrap_or(0.0) / 60.0)
        .flag("own_kick_off", "1 if the last kick-off was the own team's", status.kick_off_team == team);
    let mut own = Group::new(sink, "body", 0);
    own.flag("penalised", "1 while the robot is penalised; its actions then have no effect", status.penalised);
    for (name, state) in [
        ("walking", BodyStatus::Walking),
        ("kicking", BodyStatus::Kicking),
        ("recovering", BodyStatus::Recovering),
        ("fallen", BodyStatus::Fallen),
        ("getting_up", BodyStatus::GettingUp),
    ] {
        own.flag(name, "1 while the body does this; all 0 while it stands", body == state);
    }
}

/// Puts the set play that the robot was told of, and other stops of the game.
fn put_set_play(sink: &mut impl Sink, status: &GameStatus, team: Team) {
    let (kind, of) = status.set_play.map_or((None, None), |set_play| (Some(set_play.kind), set_play.team));
    let mut group = Group::new(sink, "set_play", 0);
    for (name, kinds) in [
        ("kick_off", &[SetPlayKind::KickOff][..]),
        ("kick_in", &[SetPlayKind::KickIn]),
        ("goal_kick", &[SetPlayKind::GoalKick]),
        ("corner_kick", &[SetPlayKind::CornerKick]),
        ("free_kick", &[SetPlayKind::PushingFreeKick, SetPlayKind::IndirectFreeKick]),
        ("penalty_kick", &[SetPlayKind::PenaltyKick]),
    ] {
        group.flag(name, "1 during this set play; all 0 without one", kind.is_some_and(|kind| kinds.contains(&kind)));
    }
    group
        .flag("own", "1 if the ball belongs to the own team in the set play", of == Some(team))
        .flag("opponents", "1 if the ball belongs to the opponents in the set play", of == Some(team.opponent()))
        .put(
            "seconds_left",
            [0.0, 60.0],
            "seconds left of `ready`, of a free kick or of a time-out; else 0",
            status.secondary_time_left_s.unwrap_or(0.0),
        )
        .flag("drop_ball", "1 if play was last restarted by a drop ball", status.drop_ball)
        .flag("stopped", "1 while no robot may move", status.stopped);
}

/// The entries of the true state, for critics.
pub fn state_entries(world: &World) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    state_into(&mut entries, world);
    entries.0
}

/// Fills `array` with the true state of the whole match in the frame of team blue, for critics.
pub(super) fn state(array: &mut [f32], world: &World) {
    state_into(&mut Values { array, filled: 0 }, world);
}

fn state_into(sink: &mut impl Sink, world: &World) {
    let game = world.resource::<Game>();
    let own_end = game.own_end(Team::Blue);
    let (place, velocity) = ball_of(world).unwrap_or_default();
    let [place, velocity] = [place, velocity].map(|vector| point_team_from_pitch(vector, own_end));
    Group::new(sink, "ball", 0)
        .put("x", PLACE, "position, m", place.x)
        .put("y", PLACE, "position, m", place.y)
        .put("vx", SPEED, "velocity, m/s", velocity.x)
        .put("vy", SPEED, "velocity, m/s", velocity.y);
    for (id, entity) in world.resource::<Roster>().iter() {
        let Ok(robot) = world.get_entity(entity) else { continue };
        let pose = team_from_pitch(robot.get::<Pose>().copied().unwrap_or_default(), own_end);
        let velocity = robot.get::<Velocity>().copied().unwrap_or_default().linear;
        let velocity = point_team_from_pitch(velocity, own_end);
        let forward = pose.forward();
        Group::new(sink, id.team.name(), id.number)
            .flag("plays", "1 while it is not penalised", !robot.get::<Penalty>().is_some_and(Penalty::is_active))
            .put("x", PLACE, "position, m", pose.position.x)
            .put("y", PLACE, "position, m", pose.position.y)
            .put("cos", UNIT, "cosine of its heading", forward.x)
            .put("sin", UNIT, "sine of its heading", forward.y)
            .put("vx", SPEED, "velocity, m/s", velocity.x)
            .put("vy", SPEED, "velocity, m/s", velocity.y);
    }
    let minutes_left = game.time_left_s(world.resource()).unwrap_or(0.0) / 60.0;
    Group::new(sink, "game", 0)
        .flag("playing", "1 while the ball is in play", game.state == GameState::Playing)
        .put(
            "lead",
            [-10.0, 10.0],
            "goals of blue minus goals of pink",
            game.score.blue as f32 - game.score.pink as f32,
        )
        .put("minutes_left", [0.0, 60.0], "minutes left in this half", minutes_left);
}
