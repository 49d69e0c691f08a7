//! Gathers the record of each cycle once, after everything in the cycle has happened, for all users of records.

use bevy::ecs::change_detection::Tick;
use bevy::ecs::query::QueryData;
use bevy::ecs::system::{SystemChangeTick, SystemParam};
use bevy::prelude::*;
use std::collections::BTreeMap;

use super::cycle_record::{BallRecord, CycleRecord, GameRecord, PenaltyRecord, RobotRecord};
use super::vocabulary::{Commanded, Perceived, RobotCommand};
use crate::simulation::sensors::ReadingsAreRecorded;
use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{BallPhysics, BallVelocity, ExtraBall};
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::communication::StatusReport;
use naoisis_core::cycle::{Cycle, CycleClock, CycleHalf, CycleSystems};
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{Game, Penalty, Rules};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::condition::Condition;
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;

/// Gathers the [`CurrentRecord`] of every cycle, if this resource exists.
pub struct GatherPlugin;

impl Plugin for GatherPlugin {
    fn build(&self, app: &mut App) {
        let is_recorded = resource_exists::<CurrentRecord>;
        app.init_resource::<ReadingsAreRecorded>()
            .configure_sets(Cycle, (RecordSystems::Gather, RecordSystems::Keep).chain().in_set(CycleSystems::Record))
            .add_systems(
                Cycle,
                (
                    note_commands
                        .after(CycleSystems::Decide)
                        .before(CycleSystems::Act)
                        .in_set(CycleHalf::Act)
                        .run_if(is_recorded),
                    gather_record.in_set(RecordSystems::Gather).run_if(is_recorded),
                ),
            );
    }
}

/// The system sets that make and use the record of a cycle.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RecordSystems {
    /// Gathers the record.
    Gather,
    /// Stores the record in memory.
    Keep,
    /// Writes the record to files.
    Write,
}

/// The record of the last completed cycle, or of the start. Users of records have to insert this resource.
#[derive(Resource, Clone, Debug, Default)]
pub struct CurrentRecord {
    /// The record.
    pub record: CycleRecord,
    /// The commands of the robots in the current cycle.
    commands: BTreeMap<RobotId, RobotCommand>,
    /// The change tick of the last gathering. Head commands that are newer are new.
    gathered: Tick,
    /// Whether the record is gathered only when [`record_now`] asks for it, for users that need only a few cycles of a match.
    is_on_demand: bool,
}

/// The components of a robot that are recorded in addition to what it perceives.
#[derive(QueryData)]
struct RecordedRobot {
    pose: &'static Pose,
    velocity: &'static Velocity,
    posture: &'static Posture,
    penalty: &'static Penalty,
    belief: Option<&'static Belief>,
    drawings: Option<&'static Drawings>,
    remarks: Option<&'static Remarks>,
    reasons: Option<&'static Reasons>,
    reported: Option<&'static StatusReport>,
    perceived: Perceived,
}

/// What is recorded of a ball.
#[derive(QueryData)]
struct RecordedBall {
    which: Option<&'static ExtraBall>,
    pose: &'static Pose,
    velocity: &'static BallVelocity,
    flight: &'static BallFlight,
    physics: &'static BallPhysics,
}

/// The resources and components that a record is made of.
#[derive(SystemParam)]
pub struct RecordedMatch<'w, 's> {
    clock: Res<'w, CycleClock>,
    events: Res<'w, CycleEvents>,
    roster: Res<'w, Roster>,
    game: Res<'w, Game>,
    rules: Res<'w, Rules>,
    balls: Query<'w, 's, RecordedBall>,
    robots: Query<'w, 's, RecordedRobot>,
    ticks: SystemChangeTick,
}

impl RecordedMatch<'_, '_> {
    /// Returns the current cycle; 0 at the start.
    pub fn cycle(&self) -> u64 {
        self.clock.cycle
    }

    /// Gathers the record of the current cycle, or of the start.
    pub fn gather(&self, current: &mut CurrentRecord) {
        let mut commands = core::mem::take(&mut current.commands);
        for event in self.events.iter() {
            if let MatchEvent::CommandRefused { robot, command, reason } = event
                && let Some(refused) = commands.get_mut(robot)
            {
                refused.refuse(*command, *reason);
            }
        }
        let (ball, balls) = self.balls();
        let robot = |(id, entity)| self.robot(id, entity, commands.remove(&id));
        current.record = CycleRecord {
            cycle: self.clock.cycle,
            time_s: self.clock.end_time_s(),
            ball,
            balls,
            robots: self.roster.iter().filter_map(robot).collect(),
            game: GameRecord::of(&self.game, &self.rules, &self.clock),
            events: self.events.0.clone(),
        };
        current.gathered = self.ticks.this_run();
    }

    /// The first ball, and all if there are several.
    fn balls(&self) -> (Option<BallRecord>, Vec<BallRecord>) {
        let record = |ball: RecordedBallItem| BallRecord {
            position_m: ball.pose.position.extend(ball.physics.radius_m + ball.flight.height_m),
            velocity_mps: ball.velocity.0.extend(ball.flight.climb_mps),
        };
        if self.balls.iter().len() < 2 {
            return (self.balls.iter().next().map(record), Vec::new());
        }
        let mut balls: Vec<RecordedBallItem> = self.balls.iter().collect();
        balls.sort_by_key(|ball| ball.which);
        let balls: Vec<BallRecord> = balls.into_iter().map(record).collect();
        (balls.first().copied(), balls)
    }

    fn robot(&self, id: RobotId, entity: Entity, command: Option<RobotCommand>) -> Option<RobotRecord> {
        let robot = self.robots.get(entity).ok()?;
        let record = RobotRecord {
            pose: *robot.pose,
            velocity: *robot.velocity,
            posture: *robot.posture,
            penalised: robot
                .penalty
                .0
                .map(|active| PenaltyRecord { reason: active.reason, time_left_s: active.left_s(&self.clock) }),
            belief: robot.belief.cloned(),
            command,
            drawings: robot.drawings.cloned().unwrap_or_default(),
            intention: robot.remarks.and_then(|remarks| remarks.intention.clone()),
            values: robot.remarks.map(|remarks| remarks.values.clone()).unwrap_or_default(),
            reasons: robot.reasons.cloned(),
            reported: robot.reported.copied(),
            ..RobotRecord::new(id)
        };
        Some(record.with_perception(robot.perceived.perception()))
    }
}

/// Gathers the record of the start, which replaces an earlier record.
pub fn gather_start(world: &mut World) {
    world.insert_resource(CurrentRecord::default());
    // This fails only if there is no match.
    let _ = world.run_system_cached(gather_record);
}

/// Gathers the record of the start. From then on the record is gathered only when [`record_now`] is called, not in each cycle.
pub fn gather_on_demand(world: &mut World) {
    gather_start(world);
    world.resource_mut::<CurrentRecord>().is_on_demand = true;
}

/// Returns the record of the last completed cycle. If it is gathered on demand, it is gathered now.
pub fn record_now(world: &mut World) -> &CycleRecord {
    let is_stale = world.get_resource_or_init::<CurrentRecord>().is_on_demand;
    if is_stale {
        // This fails only if there is no match.
        let _ = world.run_system_cached(gather_again);
    }
    &world.resource::<CurrentRecord>().record
}

/// Gathers the record again, with the commands that were noted in its cycle.
fn gather_again(mut current: ResMut<CurrentRecord>, recorded: RecordedMatch) {
    let (commands, gathered) = (current.commands.clone(), current.gathered);
    recorded.gather(&mut current);
    (current.commands, current.gathered) = (commands, gathered);
}

fn note_commands(
    mut current: ResMut<CurrentRecord>,
    robots: Query<(&RobotId, Commanded, Option<&Condition>)>,
    ticks: SystemChangeTick,
) {
    let (since, now) = (current.gathered, ticks.this_run());
    current.commands.clear();
    current.commands.extend(robots.iter().map(|(id, robot, condition)| {
        // What a player decides while its program restarts reaches nobody.
        let is_running = condition.is_none_or(Condition::is_running);
        (*id, if is_running { robot.command(since, now) } else { RobotCommand::default() })
    }));
}

fn gather_record(mut current: ResMut<CurrentRecord>, recorded: RecordedMatch) {
    if current.is_on_demand {
        current.gathered = recorded.ticks.this_run();
    } else {
        recorded.gather(&mut current);
    }
}
