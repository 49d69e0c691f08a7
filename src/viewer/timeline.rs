//! The past of the match, to be looked at again: of the match that is played here, or of one that a trace was written of.
//!
//! Of every cycle a record is kept ([`History`]). To look at an earlier cycle, the match stands, its present is put aside,
//! and what the record says is put in its place: whatever shows the match shows that cycle then, and need not know. Before
//! the next cycle is run the present comes back as it was, bit for bit, so that looking back changes nothing.
//!
//! A replay is a match without a present: its records come from a file, and its robots decide nothing.

use bevy::prelude::*;
use bevy::time::TimeSystems;

use super::drive::{DisplayFraction, Playback, Speed};
use super::event_log::EventLog;
use crate::appearance::gait::Gait;
use crate::ball::{Ball, BallVelocity};
use crate::behaviour::drawings::Drawings;
use crate::belief::Belief;
use crate::communication::Inbox;
use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::CycleEvents;
use crate::geometry::Pose;
use crate::record::history::{History, ReadTrace};
use crate::record::read::{CycleRecord, RobotRecord};
use crate::record::trace::MatchLine;
use crate::referee::{ActivePenalty, Game, Penalty};
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::robot::{PreviousPose, Roster, Velocity};
use crate::scenario::{BehaviourSpec, Scenario, ScenarioFault};
use crate::sensing::odometry::Odometry;
use crate::sensing::sonar::SonarReading;
use crate::sensing::vision::Percepts;
use crate::simulation;

/// The past is shown this many times as fast as it was when it is to go as fast as possible.
const FASTEST: f64 = 64.0;

/// Keeps the [`History`] and shows the past.
pub struct TimelinePlugin;

impl Plugin for TimelinePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<History>()
            .init_resource::<Timeline>()
            .add_message::<TimelineCommand>()
            .add_systems(Cycle, keep_cycle.in_set(CycleSystems::Record))
            .add_systems(First, (keep_start, obey_timeline_commands).chain().before(TimeSystems))
            .add_systems(RunFixedMainLoop, play_past.in_set(TimelineSystems));
    }
}

/// The system that lets the past go on.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TimelineSystems;

/// What the user wants to see.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum TimelineCommand {
    /// The end of this cycle; of one that is not there yet, the present.
    GoTo(u64),
    /// So many cycles later; earlier, if negative. The match stands then.
    Step(i64),
    /// So many seconds later; earlier, if negative.
    Skip(f64),
    /// The match as it is now; of a replay, its end.
    Present,
}

/// Which moment of the match is shown.
#[derive(Resource, Default, Debug)]
pub struct Timeline {
    /// The moment that is shown, in cycles since the start, if it is not the present.
    cursor: Option<f64>,
    /// The cycle whose record is in the world.
    shown: Option<u64>,
    /// The present, put aside.
    present: Option<Box<Present>>,
    /// Whether a trace is shown.
    replay: bool,
}

impl Timeline {
    /// Whether the past is shown.
    pub fn is_past(&self) -> bool {
        self.cursor.is_some()
    }

    /// The moment that is shown, in cycles since the start; none for the present.
    pub fn cursor(&self) -> Option<f64> {
        self.cursor
    }

    /// Whether a trace is shown, and no match is played.
    pub fn is_replay(&self) -> bool {
        self.replay
    }
}

/// What is put aside while the past is shown.
#[derive(Debug)]
struct Present {
    clock: CycleClock,
    game: Game,
    events: CycleEvents,
    robots: Vec<(Entity, RobotState, Option<Belief>)>,
    ball: Option<(Entity, BallState)>,
}

/// Of a robot, all that a record has something of, but for its belief, which not every robot has.
#[derive(Bundle, Clone, Debug)]
struct RobotState {
    pose: Pose,
    previous: PreviousPose,
    velocity: Velocity,
    head: HeadAngles,
    posture: Posture,
    penalty: Penalty,
    gait: Gait,
    odometry: Odometry,
    sonar: SonarReading,
    percepts: Percepts,
    inbox: Inbox,
    drawings: Drawings,
}

/// Of the ball, all that a record has something of.
#[derive(Bundle, Clone, Copy, Debug)]
struct BallState {
    pose: Pose,
    previous: PreviousPose,
    velocity: BallVelocity,
}

/// Forgets the match that was shown, for another.
pub fn forget(world: &mut World) {
    *world.resource_mut::<Timeline>() = Timeline::default();
    world.resource_mut::<History>().clear();
}

/// Shows a trace, in place of any match that is there.
///
/// # Errors
/// [`ScenarioFault`] when the trace's scenario cannot be set up here.
pub fn start_replay(world: &mut World, trace: ReadTrace) -> Result<(), ScenarioFault> {
    let mut scenario = simulation::resolved(world, &trace.scenario);
    for robot in &mut scenario.robots {
        robot.behaviour = BehaviourSpec::default();
    }
    scenario.interventions.clear();
    simulation::start_match(world, &scenario)?;
    let mut log = world.resource_mut::<EventLog>();
    log.clear();
    for (time_s, event) in &trace.events {
        log.note(*time_s, [event]);
    }
    let first = trace.history.cycles().map_or(0, |cycles| *cycles.start());
    world.insert_resource(trace.history);
    *world.resource_mut::<Timeline>() = Timeline { replay: true, ..default() };
    go_to(world, first as f64);
    Ok(())
}

/// Shows a moment of the match, in cycles since the start. That of a match that is played here goes on from its end.
pub fn go_to(world: &mut World, cursor: f64) {
    let Some(cycles) = world.resource::<History>().cycles() else { return };
    let (first, last) = (*cycles.start() as f64, *cycles.end() as f64);
    let timeline = world.resource::<Timeline>();
    if !timeline.replay && (cursor >= last || !cursor.is_finite()) {
        return_to_present(world);
        return;
    }
    if timeline.present.is_none() && !timeline.replay {
        let present = put_aside(world);
        world.resource_mut::<Timeline>().present = Some(Box::new(present));
    }
    world.resource_mut::<Timeline>().cursor = Some(cursor.clamp(first, last));
    show_past(world);
}

/// Shows a moment some cycles later, or earlier.
pub fn step(world: &mut World, cycles: i64) {
    let now = match world.resource::<Timeline>().cursor {
        // Back from between two cycles is to the nearer one.
        Some(cursor) if cycles < 0 => cursor.ceil(),
        Some(cursor) => cursor.floor(),
        None => world.resource::<CycleClock>().cycle as f64,
    };
    go_to(world, now + cycles as f64);
}

/// Puts the present back as it was. In a replay, shows its end.
pub fn return_to_present(world: &mut World) {
    if world.resource::<Timeline>().replay {
        if let Some(last) = world.resource::<History>().last_cycle() {
            go_to(world, last as f64);
        }
        return;
    }
    let mut timeline = world.resource_mut::<Timeline>();
    (timeline.cursor, timeline.shown) = (None, None);
    let Some(present) = timeline.present.take() else { return };
    let Present { clock, game, events, robots, ball } = *present;
    world.insert_resource(clock);
    world.insert_resource(game);
    world.insert_resource(events);
    for (entity, state, belief) in robots {
        put_robot(world, entity, state, belief);
    }
    if let Some((entity, state)) = ball {
        put(world, entity, state);
    }
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
}

fn put(world: &mut World, entity: Entity, state: impl Bundle) {
    // Another match may have been started meanwhile.
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert(state);
    }
}

fn put_robot(world: &mut World, robot: Entity, state: RobotState, belief: Option<Belief>) {
    put(world, robot, state);
    match (belief, world.get_entity_mut(robot)) {
        (Some(belief), Ok(mut robot)) => {
            robot.insert(belief);
        }
        (None, Ok(mut robot)) if robot.contains::<Belief>() => {
            robot.remove::<Belief>();
        }
        _ => {}
    }
}

fn put_aside(world: &mut World) -> Present {
    let roster: Vec<Entity> = world.resource::<Roster>().entities().collect();
    let robots = roster.into_iter();
    let robots = robots.map(|robot| (robot, robot_state(world, robot), world.get::<Belief>(robot).cloned())).collect();
    let mut balls = world.query_filtered::<(Entity, &Pose, &PreviousPose, &BallVelocity), With<Ball>>();
    let ball = balls.iter(world).next().map(|(entity, pose, previous, velocity)| {
        (entity, BallState { pose: *pose, previous: *previous, velocity: *velocity })
    });
    Present {
        clock: *world.resource(),
        game: world.resource::<Game>().clone(),
        events: world.resource::<CycleEvents>().clone(),
        robots,
        ball,
    }
}

/// What the robot has; of what it does not have, nothing.
fn robot_state(world: &World, robot: Entity) -> RobotState {
    fn of<C: Component + Clone + Default>(world: &World, robot: Entity) -> C {
        world.get::<C>(robot).cloned().unwrap_or_default()
    }
    RobotState {
        pose: of(world, robot),
        previous: of(world, robot),
        velocity: of(world, robot),
        head: of(world, robot),
        posture: of(world, robot),
        penalty: of(world, robot),
        gait: of(world, robot),
        odometry: of(world, robot),
        sonar: of(world, robot),
        percepts: of(world, robot),
        inbox: of(world, robot),
        drawings: of(world, robot),
    }
}

/// Puts what the records say of the moment into the world.
fn show_past(world: &mut World) {
    let Some(cursor) = world.resource::<Timeline>().cursor else { return };
    let cycle = cursor.ceil() as u64;
    let fraction = (cursor - (cycle as f64 - 1.0)) as f32;
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(fraction);
    if world.resource::<Timeline>().shown == Some(cycle) {
        return;
    }
    world.resource_mut::<Timeline>().shown = Some(cycle);
    world.resource_scope(|world, mut history: Mut<History>| {
        let records = history.record(cycle).and_then(|record| {
            let previous = cycle.checked_sub(1).map(|earlier| history.record(earlier));
            Ok((record, previous.transpose()?.flatten()))
        });
        match records {
            Ok((Some(record), previous)) => put_record(world, &history, record, previous.as_ref()),
            Ok((None, _)) => {}
            Err(error) => world.resource_mut::<Playback>().problem = Some(error.to_string()),
        }
    });
}

fn put_record(world: &mut World, history: &History, record: CycleRecord, previous: Option<&CycleRecord>) {
    let mut clock = *world.resource::<CycleClock>();
    clock.cycle = record.cycle;
    world.insert_resource(clock);
    let mut game = world.resource::<Game>().clone();
    if game.half.abs_diff(record.game.half) % 2 == 1 {
        game.blue_end = game.blue_end.opposite();
    }
    (game.state, game.score, game.half) = (record.game.state, record.game.score, record.game.half);
    game.cycles_left = record.game.time_left_s.map(|left_s| (left_s / clock.period_s).round() as u64);
    world.insert_resource(game);
    world.insert_resource(CycleEvents(record.events));
    let mut balls = world.query_filtered::<(&mut Pose, &mut PreviousPose, &mut BallVelocity), With<Ball>>();
    if let (Some(ball), Some((mut pose, mut was, mut velocity))) = (record.ball, balls.iter_mut(world).next()) {
        pose.position = ball.position_m.truncate();
        let earlier = previous.and_then(|previous| previous.ball);
        was.0 = Pose { position: earlier.unwrap_or(ball).position_m.truncate(), heading: pose.heading };
        velocity.0 = ball.velocity_mps.truncate();
    }
    for robot in record.robots {
        let Some(entity) = world.resource::<Roster>().get(robot.id) else { continue };
        let was = previous.and_then(|previous| previous.robots.iter().find(|earlier| earlier.id == robot.id));
        let was = was.map_or(robot.pose, |earlier| earlier.pose);
        let kick = history.last_kick(robot.id, record.cycle);
        let kick = kick.map(|kick| (kick.kick_type, (kick.cycle as f64 - 1.0) * clock.period_s));
        let gait = world.get::<Gait>(entity).copied().unwrap_or_default();
        let belief = robot.belief.clone();
        put_robot(world, entity, state_of(robot, was, Gait { kick, ..gait }, clock.period_s), belief);
    }
}

fn state_of(robot: RobotRecord, was: Pose, gait: Gait, period_s: f64) -> RobotState {
    RobotState {
        pose: robot.pose,
        previous: PreviousPose(was),
        velocity: robot.velocity(),
        head: robot.head(),
        posture: robot.posture,
        penalty: Penalty(robot.penalised.map(|penalty| ActivePenalty {
            reason: penalty.reason,
            cycles_left: (penalty.time_left_s / period_s).round() as u64,
        })),
        gait,
        odometry: Odometry(robot.odometry),
        sonar: robot.sonar_m,
        percepts: robot.percepts,
        inbox: Inbox(robot.inbox),
        drawings: robot.drawings,
    }
}

fn keep_cycle(line: MatchLine, mut history: ResMut<History>, mut playback: ResMut<Playback>) {
    if let Err(error) = history.push(line.clock.cycle, &line.line(), &line.events) {
        playback.problem = Some(error.to_string());
    }
}

/// Keeps what a match starts from, whoever started it.
fn keep_start(
    line: MatchLine,
    scenario: Option<Res<Scenario>>,
    timeline: Res<Timeline>,
    history: ResMut<History>,
    playback: ResMut<Playback>,
) {
    let kept = history.last_cycle() == Some(line.clock.cycle);
    if scenario.is_some() && !timeline.is_past() && !timeline.replay && !kept {
        keep_cycle(line, history, playback);
    }
}

fn obey_timeline_commands(world: &mut World) {
    let commands: Vec<TimelineCommand> = world.resource_mut::<Messages<TimelineCommand>>().drain().collect();
    for command in commands {
        match command {
            TimelineCommand::GoTo(cycle) => go_to(world, cycle as f64),
            TimelineCommand::Step(cycles) => {
                world.resource_mut::<Playback>().paused = true;
                step(world, cycles);
            }
            TimelineCommand::Skip(seconds) => {
                let clock = *world.resource::<CycleClock>();
                let now = world.resource::<Timeline>().cursor.unwrap_or(clock.cycle as f64);
                go_to(world, now + seconds / clock.period_s);
            }
            TimelineCommand::Present => return_to_present(world),
        }
    }
}

/// The past goes on at the wanted speed, and into the present.
fn play_past(world: &mut World) {
    let Some(cursor) = world.resource::<Timeline>().cursor else { return };
    let playback = world.resource::<Playback>();
    if playback.paused {
        return;
    }
    let elapsed_s = match playback.speed {
        Speed::Times(_) => world.resource::<Time<Virtual>>().delta_secs_f64(),
        Speed::Unlimited => FASTEST * world.resource::<Time<Real>>().delta_secs_f64(),
    };
    let cycles = elapsed_s / world.resource::<CycleClock>().period_s;
    world.resource_mut::<Playback>().note_progress(cycles);
    go_to(world, cursor + cycles);
    let timeline = world.resource::<Timeline>();
    let last = world.resource::<History>().last_cycle();
    // At its end a replay stands.
    if timeline.replay && timeline.shown == last && timeline.cursor == last.map(|last| last as f64) {
        world.resource_mut::<Playback>().paused = true;
    }
}

#[cfg(test)]
mod tests {
    use super::super::drive::{DrivePlugin, ViewerCommand};
    use super::super::event_log::EventLogPlugin;
    use super::*;
    use crate::record::trace::{TracePlugin, TraceRecorder, record_cycle};
    use crate::robot::{RobotId, Team};
    use crate::simulation::{MatchApp, NaoisisPlugins};
    use bevy::time::TimeUpdateStrategy;
    use core::time::Duration;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    /// A match at 60 frames/s of 1/30 s a cycle.
    fn app(scenario: &Scenario) -> App {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, TracePlugin, EventLogPlugin, DrivePlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(16_667)));
        app.start_match(scenario).unwrap();
        // The first frame only starts the clock.
        app.update();
        app
    }

    fn match3v3() -> App {
        app(&Scenario::named("match3v3").unwrap())
    }

    fn frames(app: &mut App, count: usize) {
        for _ in 0..count {
            app.update();
        }
    }

    fn send<M: Message>(app: &mut App, message: M) {
        app.world_mut().write_message(message);
        app.update();
    }

    fn cursor(app: &App) -> Option<f64> {
        app.world().resource::<Timeline>().cursor()
    }

    #[test]
    fn the_past_is_shown_as_it_was_and_the_present_comes_back() {
        let mut app = match3v3();
        let seen = |app: &App| {
            let percepts = app.robot::<Percepts>(BLUE2).cloned();
            (app.robot_pose(BLUE2).unwrap(), app.ball().unwrap(), percepts, app.cycle())
        };
        let mut earlier = None;
        while app.cycle() < 200 {
            app.update();
            if app.cycle() == 100 {
                earlier = Some(seen(&app));
            }
        }
        let now = (seen(&app), app.game().clone());
        send(&mut app, TimelineCommand::GoTo(100));
        send(&mut app, ViewerCommand::TogglePause);
        send(&mut app, TimelineCommand::GoTo(100));
        let (shown, earlier) = (seen(&app), earlier.unwrap());
        // A record has degrees and decimal places.
        assert!(shown.0.position.abs_diff_eq(earlier.0.position, 1e-5));
        assert!((shown.0.heading - earlier.0.heading).abs() < 1e-5);
        assert_eq!((shown.1.position, shown.3), (earlier.1.position, 100));
        let count = |percepts: &Option<Percepts>| percepts.as_ref().map(|percepts| percepts.landmarks.len());
        assert_eq!(count(&shown.2), count(&earlier.2));
        frames(&mut app, 20);
        assert_eq!(cursor(&app), Some(100.0));
        send(&mut app, TimelineCommand::Present);
        assert_eq!((seen(&app), app.game().clone()), now);
        assert_eq!(cursor(&app), None);
    }

    #[test]
    fn the_past_goes_on_into_the_present_and_the_match_with_it() {
        let mut app = match3v3();
        while app.cycle() < 60 {
            app.update();
        }
        send(&mut app, TimelineCommand::Skip(-1.0));
        // 30 frames are 15 of the 30 cycles; the match itself stands.
        frames(&mut app, 29);
        assert!((44.0..46.5).contains(&cursor(&app).unwrap()), "{:?}", cursor(&app));
        assert_eq!(app.world().resource::<History>().last_cycle(), Some(60));
        frames(&mut app, 60);
        assert_eq!(cursor(&app), None);
        assert!((70..80).contains(&app.cycle()), "{}", app.cycle());
    }

    #[test]
    fn steps_lead_back_and_forth_and_out_of_the_past() {
        let mut app = match3v3();
        while app.cycle() < 10 {
            app.update();
        }
        for expected in [9, 8, 7] {
            send(&mut app, TimelineCommand::Step(-1));
            assert_eq!((app.cycle(), app.world().resource::<Playback>().paused), (expected, true));
        }
        for expected in [8, 9, 10, 11, 12] {
            send(&mut app, ViewerCommand::Step);
            assert_eq!(app.cycle(), expected);
        }
        assert_eq!(cursor(&app), None);
        for _ in 0..20 {
            send(&mut app, TimelineCommand::Step(-1));
        }
        assert_eq!(app.cycle(), 0, "there is nothing before the start");
    }

    #[test]
    fn robots_without_a_belief_have_none_afterwards() {
        let scenario = Scenario::from_json(r#"{ "rules": "free", "robots": [{ "number": 2 }] }"#).unwrap();
        let mut app = app(&scenario);
        frames(&mut app, 40);
        send(&mut app, TimelineCommand::GoTo(3));
        send(&mut app, TimelineCommand::Present);
        assert!(app.robot::<Belief>(BLUE2).is_none());
    }

    #[test]
    fn a_trace_is_shown_as_the_match_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("match.jsonl.zst");
        let mut played = match3v3();
        let mut recorder = TraceRecorder::create(&path).unwrap();
        recorder.write_header(&simulation::resolved(played.world(), &Scenario::named("match3v3").unwrap()));
        played.insert_resource(recorder);
        played.world_mut().run_system_cached(record_cycle).unwrap();
        while played.cycle() < 150 {
            played.update();
        }
        let recorder = played.world_mut().remove_resource::<TraceRecorder>().unwrap();
        recorder.finish(default(), default(), 150, default()).unwrap();

        let mut replay = app(&Scenario::default());
        start_replay(replay.world_mut(), ReadTrace::open(&path).unwrap()).unwrap();
        send(&mut replay, TimelineCommand::GoTo(150));
        let place = replay.robot_pose(BLUE2).unwrap().position;
        assert!(place.abs_diff_eq(played.robot_pose(BLUE2).unwrap().position, 1e-5));
        assert!(replay.robot::<Belief>(BLUE2).is_some());
        // It stands at its end, and begins again.
        frames(&mut replay, 10);
        assert_eq!((replay.cycle(), replay.world().resource::<Playback>().paused), (150, true));
        send(&mut replay, ViewerCommand::TogglePause);
        frames(&mut replay, 30);
        assert!((14..18).contains(&replay.cycle()), "{}", replay.cycle());
        send(&mut replay, ViewerCommand::SetSpeed(Speed::Times(4.0)));
        frames(&mut replay, 30);
        assert!((74..80).contains(&replay.cycle()), "{}", replay.cycle());
        // A match can be played in its place.
        send(&mut replay, ViewerCommand::Load("match3v3"));
        frames(&mut replay, 30);
        assert!(!replay.world().resource::<Timeline>().is_replay());
        assert!(replay.robot_pose(RobotId::new(Team::Pink, 3)).is_some());
    }
}
