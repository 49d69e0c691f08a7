//! The decision cycle: a schedule of its own, in which every robot senses, decides and acts once.
//!
//! All robots sense the same instant, all decide, then all act: nothing that one robot does in a cycle is visible to
//! another in the same cycle. The schedule runs on one thread, and two systems whose order matters but is not
//! declared are an error, so that the same scenario and seed always give the same match.
//!
//! The owner of the app drives the cycle: a loop, a test by hand ([`run_cycle`]), or `FixedUpdate`. A program that decides for
//! robots from outside the app stops it between its [halves](CycleHalf): [`perceive`] runs the first, and [`run_cycle`] the rest.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;
use core::any::Any;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::knowledge::Knowledge;

/// Sets up the [`Cycle`] schedule, its [`CycleSystems`] and its [`CycleClock`].
pub struct CyclePlugin {
    /// Duration of a cycle, s.
    pub period_s: f64,
}

impl Default for CyclePlugin {
    fn default() -> Self {
        Self { period_s: CycleClock::default().period_s }
    }
}

impl Plugin for CyclePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(CycleClock { period_s: self.period_s, ..default() })
            .init_resource::<PendingHalf>()
            .register_type::<CycleClock>()
            .register_type::<PendingHalf>();
        app.init_schedule(Cycle).edit_schedule(Cycle, |schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
            schedule.set_build_settings(ScheduleBuildSettings { ambiguity_detection: LogLevel::Error, ..default() });
            schedule.configure_sets(
                (
                    CycleSystems::First,
                    CycleSystems::Sense,
                    CycleSystems::Communicate,
                    CycleSystems::Decide,
                    CycleSystems::Act,
                    CycleSystems::Move,
                    CycleSystems::Kick,
                    CycleSystems::RollBall,
                    CycleSystems::Collide,
                    CycleSystems::Officiate,
                    CycleSystems::CheckInvariants,
                    CycleSystems::Record,
                    CycleSystems::Last,
                )
                    .chain(),
            );
            schedule.configure_sets((
                (CycleSystems::First, CycleSystems::Sense, CycleSystems::Communicate).in_set(CycleHalf::Perceive),
                (
                    CycleSystems::Act,
                    CycleSystems::Move,
                    CycleSystems::Kick,
                    CycleSystems::RollBall,
                    CycleSystems::Collide,
                    CycleSystems::Officiate,
                    CycleSystems::CheckInvariants,
                    CycleSystems::Record,
                    CycleSystems::Last,
                )
                    .in_set(CycleHalf::Act),
                CycleHalf::Perceive.run_if(|part: Res<PendingHalf>| *part != PendingHalf::Act),
                CycleHalf::Act.run_if(|part: Res<PendingHalf>| *part != PendingHalf::Perceive),
            ));
            // Refusals are reported in one list, in this order.
            schedule.configure_sets(
                (ActSystems::Say, ActSystems::Body, ActSystems::Head, ActSystems::Kick, ActSystems::Walk)
                    .chain()
                    .in_set(CycleSystems::Act),
            );
        });
        app.add_systems(Cycle, begin_cycle.in_set(BeginCycle).in_set(CycleSystems::First));
    }
}

/// The schedule of one decision cycle of all robots.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Cycle;

/// The parts of a [`Cycle`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CycleSystems {
    /// The cycle begins ([`BeginCycle`]): the clock advances, last cycle's events are cleared. Then: systems that must run
    /// before all others.
    First,
    /// Sensors are read, all from the same instant.
    Sense,
    /// Messages that were sent in earlier cycles are delivered.
    Communicate,
    /// Beliefs are updated and behaviours decide.
    Decide,
    /// Commands are checked and executed; heads turn.
    Act,
    /// Robots walk.
    Move,
    /// Kicks under way continue, the ball is struck.
    Kick,
    /// The ball's path in this cycle without collisions is planned.
    RollBall,
    /// Collisions of robots, posts and ball determine their poses at the end of the cycle.
    Collide,
    /// The referee judges.
    Officiate,
    /// Invariants are checked.
    CheckInvariants,
    /// The cycle is recorded.
    Record,
    /// Systems that must run after all others.
    Last,
}

/// The halves of a cycle, between which [`perceive`] stops. Beliefs belong to the first, behaviours to the second. A system
/// that is in none of the [`CycleSystems`] must be in one of the halves, or it runs with both.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CycleHalf {
    /// From the beginning to the update of beliefs.
    Perceive,
    /// From the decisions of behaviours to the end.
    Act,
}

/// Which half of the cycle [`run_cycle`] runs next.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub enum PendingHalf {
    /// Both halves.
    #[default]
    Whole,
    /// The first half.
    Perceive,
    /// The second half: [`perceive`] has run the first.
    Act,
}

/// The parts of [`CycleSystems::Act`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ActSystems {
    /// Messages are sent.
    Say,
    /// Robots get up, and dive.
    Body,
    /// Heads turn.
    Head,
    /// Kicks begin.
    Kick,
    /// Walk commands are executed.
    Walk,
}

/// The systems that begin the cycle: all others in [`CycleSystems::First`] run after them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BeginCycle;

/// The clock of the match. It counts cycles, independently of the wall clock.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Public)]
pub struct CycleClock {
    /// The cycle under way, or the last one; 0 before the first.
    pub cycle: u64,
    /// Duration of a cycle, s. The default, 1/30 s, is the rate of the NAO's cameras.
    pub period_s: f64,
}

impl Default for CycleClock {
    fn default() -> Self {
        Self { cycle: 0, period_s: 1.0 / 30.0 }
    }
}

impl CycleClock {
    /// Time at the end of the cycle, s since the start of the match.
    pub fn end_time_s(&self) -> f64 {
        self.cycle as f64 * self.period_s
    }

    /// Time at the start of the cycle, s since the start of the match: the instant that the robots sense.
    pub fn start_time_s(&self) -> f64 {
        self.cycle.saturating_sub(1) as f64 * self.period_s
    }

    /// Duration of a cycle in single precision, s.
    pub fn period(&self) -> f32 {
        self.period_s as f32
    }

    /// `duration_s` in cycles, rounded.
    pub fn cycles_in(&self, duration_s: f32) -> u32 {
        // `round` would be a function call for each robot in each cycle.
        (f64::from(duration_s) / self.period_s + 0.5) as u32
    }
}

/// Runs one cycle of the match in `world`, or the second half of the cycle that [`perceive`] has begun.
///
/// # Panics
/// If the [`CyclePlugin`] was not added, or two systems of the schedule are ambiguous.
pub fn run_cycle(world: &mut World) {
    world.run_schedule(Cycle);
    set_half(world, PendingHalf::Whole);
}

/// Runs the first half of a cycle: the clock advances, all robots sense, receive messages and update their beliefs. Commands
/// given before [`run_cycle`] runs the second half belong to this cycle. Does nothing if the first half has already run.
///
/// # Panics
/// Like [`run_cycle`].
pub fn perceive(world: &mut World) {
    if *world.resource::<PendingHalf>() != PendingHalf::Act {
        set_half(world, PendingHalf::Perceive);
        world.run_schedule(Cycle);
        set_half(world, PendingHalf::Act);
    }
}

fn set_half(world: &mut World, half: PendingHalf) {
    *world.resource_mut::<PendingHalf>() = half;
}

/// Error of a cycle in which a system panicked. The match cannot go on.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("a system of the match panicked: {message}")]
pub struct CyclePanic {
    /// The message of the panic.
    pub message: String,
}

debug_as_displayed!(CyclePanic);

/// Runs one cycle, or the second half of the cycle that [`perceive`] has begun, and catches panics of its systems, such as behaviours.
/// Another match can be started in `world` afterwards.
///
/// # Errors
/// If a system panics.
pub fn try_run_cycle(world: &mut World) -> Result<(), CyclePanic> {
    let result = run_caught(world);
    set_half(world, PendingHalf::Whole);
    result
}

/// Runs the first half of a cycle like [`perceive`], and catches panics of its systems.
///
/// # Errors
/// If a system panics.
pub fn try_perceive(world: &mut World) -> Result<(), CyclePanic> {
    if *world.resource::<PendingHalf>() == PendingHalf::Act {
        return Ok(());
    }
    set_half(world, PendingHalf::Perceive);
    let result = run_caught(world);
    set_half(world, if result.is_ok() { PendingHalf::Act } else { PendingHalf::Whole });
    result
}

fn run_caught(world: &mut World) -> Result<(), CyclePanic> {
    let run = |world: &mut World, schedule: &mut Schedule| {
        let result = catch_unwind(AssertUnwindSafe(|| schedule.run(world)));
        result.map_err(|payload| {
            // The old executor still takes that system for running.
            schedule.set_executor(SingleThreadedExecutor::new());
            CyclePanic { message: words_of(&*payload) }
        })
    };
    let result = world.try_schedule_scope(Cycle, run);
    result.unwrap_or_else(|error| Err(CyclePanic { message: error.to_string() }))
}

fn words_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "without a word".to_owned())
}

fn begin_cycle(mut clock: ResMut<CycleClock>) {
    clock.cycle += 1;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Resource, Default)]
    struct Ran(u32);

    #[test]
    fn a_panic_in_a_cycle_is_survived_and_the_next_cycles_are_whole() {
        let mut app = App::new();
        app.add_plugins(CyclePlugin::default()).init_resource::<Ran>().add_systems(
            Cycle,
            (
                |clock: Res<CycleClock>| assert!(clock.cycle != 2, "cycle {}", clock.cycle),
                |mut ran: ResMut<Ran>| ran.0 += 1,
            )
                .chain()
                .in_set(CycleSystems::Decide),
        );
        assert_eq!(try_run_cycle(app.world_mut()), Ok(()));
        let panic = try_run_cycle(app.world_mut()).expect_err("a panic");
        assert_eq!(panic.to_string(), "a system of the match panicked: cycle 2");
        assert_eq!(try_run_cycle(app.world_mut()), Ok(()));
        assert_eq!((app.world().resource::<CycleClock>().cycle, app.world().resource::<Ran>().0), (3, 2));
    }

    #[test]
    fn a_panic_in_the_first_half_ends_the_cycle() {
        let mut app = App::new();
        app.add_plugins(CyclePlugin::default()).add_systems(
            Cycle,
            (|clock: Res<CycleClock>| assert!(clock.cycle != 2, "cycle {}", clock.cycle)).in_set(CycleSystems::Sense),
        );
        let world = app.world_mut();
        assert_eq!((try_perceive(world), try_perceive(world), try_run_cycle(world)), (Ok(()), Ok(()), Ok(())));
        assert!(try_perceive(world).is_err());
        assert_eq!(*world.resource::<PendingHalf>(), PendingHalf::Whole);
        assert_eq!((try_run_cycle(world), world.resource::<CycleClock>().cycle), (Ok(()), 3));
    }
}
