//! Stores and restores the present, and puts records into the world.

use bevy::prelude::*;

use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{BallPhysics, BallVelocity, ExtraBall};
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::communication::Inbox;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::CycleEvents;
use naoisis_core::game::{ActivePenalty, Game, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{PreviousPose, Roster, Velocity};
use naoisis_record::record::history::History;
use naoisis_sensing::appearance::stride::Stride;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::cycle_record::{BallRecord, CycleRecord, GameRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::gather::CurrentRecord;

/// The state of the world that is stored while the past is shown.
#[derive(Debug)]
pub(super) struct Present {
    clock: CycleClock,
    game: Game,
    events: CycleEvents,
    record: CycleRecord,
    robots: Vec<(Entity, RobotBundle, Option<Belief>)>,
    balls: Vec<(Entity, BallBundle)>,
}

/// The components of a robot that records describe, except the belief, which some robots lack.
#[derive(Bundle, Clone, Debug)]
struct RobotBundle {
    pose: Pose,
    previous: PreviousPose,
    velocity: Velocity,
    head: HeadAngles,
    posture: Posture,
    penalty: Penalty,
    stride: Stride,
    odometry: Odometry,
    sonar: SonarReading,
    percepts: Percepts,
    inbox: Inbox,
    drawings: Drawings,
}

/// The components of the ball that records describe.
#[derive(Bundle, Clone, Copy, Debug)]
struct BallBundle {
    pose: Pose,
    previous: PreviousPose,
    velocity: BallVelocity,
    flight: BallFlight,
}

impl Present {
    /// Stores the present.
    pub fn put_aside(world: &mut World) -> Present {
        let roster: Vec<Entity> = world.resource::<Roster>().entities().collect();
        let robots = roster.into_iter();
        let robots =
            robots.map(|robot| (robot, robot_state(world, robot), world.get::<Belief>(robot).cloned())).collect();
        let mut balls = world.query::<(Entity, &Pose, &PreviousPose, &BallVelocity, &BallFlight)>();
        let balls = balls.iter(world).map(|(entity, &pose, &previous, &velocity, &flight)| {
            (entity, BallBundle { pose, previous, velocity, flight })
        });
        let balls = balls.collect();
        Present {
            clock: *world.resource(),
            game: world.resource::<Game>().clone(),
            events: world.resource::<CycleEvents>().clone(),
            record: world.resource::<CurrentRecord>().record.clone(),
            robots,
            balls,
        }
    }

    /// Restores the present.
    pub fn put_back(self, world: &mut World) {
        let Present { clock, game, events, record, robots, balls } = self;
        world.insert_resource(clock);
        world.insert_resource(game);
        world.insert_resource(events);
        world.resource_mut::<CurrentRecord>().record = record;
        for (entity, state, belief) in robots {
            put_robot(world, entity, state, belief);
        }
        for (entity, state) in balls {
            put(world, entity, state);
        }
    }
}

fn put(world: &mut World, entity: Entity, state: impl Bundle) {
    // Another match may have been started meanwhile.
    if let Ok(mut entity) = world.get_entity_mut(entity) {
        entity.insert(state);
    }
}

fn put_robot(world: &mut World, robot: Entity, state: RobotBundle, belief: Option<Belief>) {
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

/// The components of a robot; defaults for those that it lacks.
fn robot_state(world: &World, robot: Entity) -> RobotBundle {
    fn of<C: Component + Clone + Default>(world: &World, robot: Entity) -> C {
        world.get::<C>(robot).cloned().unwrap_or_default()
    }
    RobotBundle {
        pose: of(world, robot),
        previous: of(world, robot),
        velocity: of(world, robot),
        head: of(world, robot),
        posture: of(world, robot),
        penalty: of(world, robot),
        stride: of(world, robot),
        odometry: of(world, robot),
        sonar: of(world, robot),
        percepts: of(world, robot),
        inbox: of(world, robot),
        drawings: of(world, robot),
    }
}

/// Puts a record into the world; poses between it and the record before are interpolated for display.
pub(super) fn put_record(
    world: &mut World,
    history: &History,
    fields: &Fields,
    record: CycleRecord,
    previous: Option<&CycleRecord>,
) {
    world.resource_mut::<CurrentRecord>().record.clone_from(&record);
    let mut clock = *world.resource::<CycleClock>();
    clock.cycle = record.cycle;
    world.insert_resource(clock);
    if fields.has("game") {
        put_game(world, &record.game, &clock);
    }
    world.insert_resource(CycleEvents(record.events));
    put_balls(world, (record.ball, record.balls.as_slice()), previous);
    for robot in record.robots {
        let Some(entity) = world.resource::<Roster>().get(robot.id) else { continue };
        let was = previous.and_then(|previous| previous.robots.iter().find(|earlier| earlier.id == robot.id));
        let was = was.map_or(robot.pose, |earlier| earlier.pose);
        let kicks = world.get::<KickSettings>(entity).copied().unwrap_or_default();
        let kick = history.swing(robot.id, record.cycle, clock.period_s, &kicks);
        let stride = world.get::<Stride>(entity).copied().unwrap_or_default();
        let (belief, mut state) =
            (robot.belief.clone(), state_of(robot, was, Stride { kick, ..stride }, clock.period_s));
        if !fields.has("robots.pose") {
            // Without recorded poses the robot stays where it was at the start.
            let place = world.get::<Pose>(entity).copied().unwrap_or_default();
            (state.pose, state.previous) = (place, PreviousPose(place));
        }
        put_robot(world, entity, state, belief);
    }
}

/// Puts the balls of a record into the world: the first, and all if there are several.
fn put_balls(world: &mut World, (first, all): (Option<BallRecord>, &[BallRecord]), previous: Option<&CycleRecord>) {
    type Parts = (
        Option<&'static ExtraBall>,
        &'static mut Pose,
        &'static mut PreviousPose,
        &'static mut BallVelocity,
        &'static mut BallFlight,
        &'static BallPhysics,
    );
    let mut balls = world.query::<Parts>();
    for (number, mut pose, mut was, mut velocity, mut flight, physics) in balls.iter_mut(world) {
        let of = |first: Option<BallRecord>, all: &[BallRecord]| match number {
            None => first,
            Some(ExtraBall(number)) => all.get(usize::from(*number)).copied(),
        };
        let Some(ball) = of(first, all) else { continue };
        let earlier = previous.and_then(|previous| of(previous.ball, &previous.balls));
        pose.position = ball.position_m.truncate();
        was.0 = Pose { position: earlier.unwrap_or(ball).position_m.truncate(), heading: pose.heading };
        velocity.0 = ball.velocity_mps.truncate();
        let height_m = (ball.position_m.z - physics.radius_m).max(0.0);
        *flight = BallFlight { height_m, climb_mps: ball.velocity_mps.z };
    }
}

fn put_game(world: &mut World, record: &GameRecord, clock: &CycleClock) {
    let mut game = world.resource_mut::<Game>();
    (game.state, game.score, game.half) = (record.state, record.score, record.half);
    game.blue_end = record.blue_end;
    game.whistles = record.whistles;
    game.ready_signals = record.ready_signals;
    game.cycles_left = record.time_left_s.map(|left_s| (left_s / clock.period_s).round() as u64);
}

fn state_of(robot: RobotRecord, was: Pose, stride: Stride, period_s: f64) -> RobotBundle {
    RobotBundle {
        pose: robot.pose,
        previous: PreviousPose(was),
        velocity: robot.velocity,
        head: robot.head,
        posture: robot.posture,
        penalty: Penalty(robot.penalised.map(|penalty| ActivePenalty {
            reason: penalty.reason,
            cycles_left: (penalty.time_left_s / period_s).round() as u64,
        })),
        stride,
        odometry: Odometry(robot.odometry),
        sonar: robot.sonar_m,
        percepts: robot.percepts,
        inbox: Inbox(robot.inbox),
        drawings: robot.drawings,
    }
}
