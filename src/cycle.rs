//! The decision cycle: a schedule of its own, in which every robot senses, decides and acts once.
//!
//! All robots sense the same instant, all decide, then all act: nothing that one robot does in a cycle is visible to
//! another in the same cycle. The schedule runs on one thread, and two systems whose order matters but is not
//! declared are an error, so that the same scenario and seed always give the same match.
//!
//! Whoever owns the app drives the cycle: a loop, a test by hand ([`run_cycle`]), or `FixedUpdate`.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::events::CycleEvents;
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
            .init_resource::<CycleEvents>()
            .register_type::<CycleClock>()
            .register_type::<CycleEvents>();
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
    /// The clock advances, last cycle's events are forgotten. Then: a place for whatever must come before everything.
    First,
    /// Sensors are read, all from the same instant.
    Sense,
    /// Messages that were sent in earlier cycles are delivered.
    Communicate,
    /// Beliefs are updated and behaviours decide.
    Decide,
    /// Commands are checked and taken over; heads turn.
    Act,
    /// Robots walk.
    Move,
    /// Kicks under way go on, the ball is struck.
    Kick,
    /// The ball's free path in this cycle is planned.
    RollBall,
    /// Robots, posts and ball collide; robots and ball arrive where they will be at the end of the cycle.
    Collide,
    /// The referee judges.
    Officiate,
    /// What must always hold is checked.
    CheckInvariants,
    /// The cycle is recorded.
    Record,
    /// A place for whatever must come after everything.
    Last,
}

/// The system that begins the cycle: whatever else runs in [`CycleSystems::First`] runs after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BeginCycle;

/// The match's own clock. It counts cycles and knows nothing of the wall clock.
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
    /// Time at the end of the cycle, s since the start.
    pub fn end_time_s(&self) -> f64 {
        self.cycle as f64 * self.period_s
    }

    /// Time at the start of the cycle, s since the start: the instant that the robots sense.
    pub fn start_time_s(&self) -> f64 {
        self.cycle.saturating_sub(1) as f64 * self.period_s
    }

    /// Duration of a cycle in single precision, s.
    pub fn period(&self) -> f32 {
        self.period_s as f32
    }

    /// The number of whole cycles nearest to a duration in seconds.
    pub fn cycles_in(&self, duration_s: f32) -> u32 {
        (f64::from(duration_s) / self.period_s).round() as u32
    }
}

/// Runs one cycle of the match in `world`.
///
/// # Panics
/// When the [`CyclePlugin`] was not added, or when two systems of the schedule are ambiguous.
pub fn run_cycle(world: &mut World) {
    world.run_schedule(Cycle);
}

fn begin_cycle(mut clock: ResMut<CycleClock>, mut events: ResMut<CycleEvents>) {
    clock.cycle += 1;
    events.clear();
}
