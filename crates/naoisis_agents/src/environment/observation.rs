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

use super::entry::{AGE, Entries, Group, ObservationEntry, PLACE, SPEED, Sink, UNIT, Values};
use super::heard::put_messages;
use super::kind::{ObservationForm, ObservationKind, Others};
use super::memory::{Memory, of_team, order_of};
use super::state::ball_of;
use super::tracks::Track;
use naoisis_core::game::{Game, GameState, Penalty, SetPlayKind};
use naoisis_core::geometry::{Pose, angle_of, unrotate};
use naoisis_core::pitch::{GoalColour, Pitch};
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{Belief, RobotBelief, team_from_pitch};
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::{LandmarkKind, LandmarkPercept, Percepts};

/// The number of line junctions in an observation: the nearest ones.
const JUNCTIONS: u8 = 3;

/// The entries of the observation of robot `id` in the match of `world`.
pub fn entries(form: ObservationForm, world: &World, id: RobotId) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    observe_into(&mut entries, form, world, id, &Memory::default(), &TrueState::for_observation(form, world));
    entries.0
}

/// The true positions that several robots observe, looked up once for all of them.
#[derive(Default)]
pub(super) struct TrueState {
    /// The position and velocity of the ball, pitch frame, m and m/s.
    ball: Option<(Vec2, Vec2)>,
    /// The pose of each robot, pitch frame, and whether it is not penalised.
    robots: Vec<(RobotId, Pose, bool)>,
}

impl TrueState {
    /// Returns the true state if observations have it; else nothing.
    pub fn for_observation(form: ObservationForm, world: &World) -> Self {
        if form.kind != ObservationKind::Truth {
            return Self::default();
        }
        let robot = |(id, entity): (RobotId, Entity)| {
            let robot = world.get_entity(entity).ok()?;
            let is_penalised = robot.get::<Penalty>().is_some_and(Penalty::is_active);
            Some((id, robot.get::<Pose>().copied().unwrap_or_default(), !is_penalised))
        };
        Self { ball: ball_of(world), robots: world.resource::<Roster>().iter().filter_map(robot).collect() }
    }
}

/// Fills `array` with the observation of robot `id`, and with zeros if there is no such robot. It has as many numbers as [`entries`] has entries.
pub(super) fn observe(
    array: &mut [f32],
    form: ObservationForm,
    world: &World,
    id: RobotId,
    memory: &Memory,
    truth: &TrueState,
) {
    let mut values = Values { array, filled: 0 };
    observe_into(&mut values, form, world, id, memory, truth);
    values.array[values.filled..].fill(0.0);
}

/// The observation of robot `id` with its entries.
pub(crate) fn observed(
    form: ObservationForm,
    world: &World,
    id: RobotId,
    memory: &Memory,
) -> Vec<(ObservationEntry, f32)> {
    let mut observed = Vec::new();
    observe_into(&mut observed, form, world, id, memory, &TrueState::for_observation(form, world));
    observed
}

fn observe_into(
    sink: &mut impl Sink,
    form: ObservationForm,
    world: &World,
    id: RobotId,
    memory: &Memory,
    truth: &TrueState,
) {
    let roster = world.resource::<Roster>();
    let Some(robot) = roster.get(id).and_then(|entity| world.get_entity(entity).ok()) else { return };
    let status = robot.get::<GameStatus>().copied().unwrap_or_default();
    let (extras, others) = (form.extras, form.others_of(roster, id.team));
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
        ObservationKind::Truth => put_truth(sink, &robot, world, id, others, truth),
        ObservationKind::Body => put_body(sink, &robot, memory),
    }
    put_game(sink, &status, robot.get::<BodyStatus>().copied().unwrap_or_default(), id.team);
    if extras.set_plays {
        put_set_play(sink, &status, id.team);
    }
    if extras.penalties {
        put_penalties(sink, &status, roster, id, others);
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
fn put_truth(
    sink: &mut impl Sink,
    robot: &EntityRef,
    world: &World,
    id: RobotId,
    others: Others,
    TrueState { ball, robots }: &TrueState,
) {
    let own_end = world.resource::<Game>().own_end(id.team);
    let pose = robot.get::<Pose>().copied().unwrap_or_default();
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
    let (place, velocity) = ball.unwrap_or_default();
    let place = if ball.is_some() { pose.inverse_transform_point(place) } else { Vec2::ZERO };
    let velocity = unrotate(pose.forward(), velocity);
    Group::new(sink, "ball", 0)
        .put("x", PLACE, "distance forwards, m", place.x)
        .put("y", PLACE, "distance to the left, m", place.y)
        .put("vx", SPEED, "forward velocity, m/s", velocity.x)
        .put("vy", SPEED, "velocity to the left, m/s", velocity.y);
    for (group, team, count) in
        [("team_mate", id.team, others.team_mates), ("opponent", id.team.opponent(), others.opponents)]
    {
        let mut of_team = robots.iter().filter(|(other, ..)| other.team == team && *other != id);
        for number in 1..=count {
            let other = of_team.next();
            let plays = other.is_some_and(|(.., plays)| *plays);
            let seen = other.map(|(_, other, _)| pose.relative(*other));
            let (place, forward) = seen.map_or((Vec2::ZERO, Vec2::ZERO), |seen| (seen.position, seen.forward()));
            Group::new(sink, group, number)
                .flag("plays", "1 while it is not penalised", plays)
                .put("x", PLACE, "distance forwards, m", place.x)
                .put("y", PLACE, "distance to the left, m", place.y)
                .put("cos", UNIT, "cosine of its heading, robot frame", forward.x)
                .put("sin", UNIT, "sine of its heading, robot frame", forward.y);
        }
    }
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

/// Puts whether the other robots are penalised, in the order of their numbers.
fn put_penalties(sink: &mut impl Sink, status: &GameStatus, roster: &Roster, id: RobotId, others: Others) {
    for (group, team, count) in
        [("told_mate", id.team, others.team_mates), ("told_opponent", id.team.opponent(), others.opponents)]
    {
        let mut of_team = roster.iter().map(|(other, _)| other).filter(|other| other.team == team && *other != id);
        for number in 1..=count {
            let is_penalised = |other: RobotId| status.penalised_numbers[team].contains(other.number);
            let flag = of_team.next().is_some_and(is_penalised);
            Group::new(sink, group, number).flag("penalised", "1 while this robot, by number, is penalised", flag);
        }
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
