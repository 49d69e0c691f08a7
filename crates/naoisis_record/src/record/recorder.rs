//! Recorders, which write matches. A new format needs a type that implements [`Recorder`], and a line that adds it.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//! use naoisis::interface::cycle_record::CycleRecord;
//! use naoisis::record::recorder::{self, EndReason, MatchEnd, RecordError, Recorder};
//! use naoisis::record::RecordPlugin;
//!
//! /// How far the ball rolls.
//! #[derive(Default)]
//! struct Odometer {
//!     last: Option<Vec3>,
//!     way_m: f32,
//! }
//!
//! impl Recorder for Odometer {
//!     fn record(&mut self, record: &CycleRecord, _: &mut World) {
//!         let place = record.ball.map(|ball| ball.position_m);
//!         self.way_m += self.last.zip(place).map_or(0.0, |(last, place)| place.distance(last));
//!         self.last = place;
//!     }
//!
//!     fn finish(self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
//!         Ok(Some(format!("the ball rolled {:.1} m", self.way_m)))
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins((NaoisisPlugins, RecordPlugin));
//! app.start_match(&Scenario::named("kick_right_straight")?)?;
//! recorder::start(app.world_mut(), vec![Box::new(Odometer::default())]);
//! app.run_cycles(500);
//! let said = recorder::finish(app.world_mut(), EndReason::Duration);
//! assert_eq!(said[0].as_ref().unwrap().as_deref(), Some("the ball rolled 4.0 m"));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

pub use super::error::RecordError;
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, MatchResult, Rules, Score};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::gather::{self, CurrentRecord, record_now};
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::resolved;

/// Writes a match. Errors are kept until the end.
pub trait Recorder: Send + Sync + 'static {
    /// Called when a match begins or continues. `scenario` has all values that the match started from, `record` its present state.
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        let _ = scenario;
        self.record(record, world);
    }

    /// Records a cycle that has ended. The world is that of the match, for data that the record lacks. It must not be changed.
    fn record(&mut self, record: &CycleRecord, world: &mut World);

    /// Returns whether this recorder needs the record of the next cycle. A record that no recorder needs is not gathered.
    fn needs_record(&self) -> bool {
        true
    }

    /// Returns whether an error occurred, after which nothing more is written.
    fn has_failed(&self) -> bool {
        false
    }

    /// Ends recording with the `last` record of the match. Returns a text to print, if there is one.
    ///
    /// # Errors
    /// The first error that occurred.
    fn finish(self: Box<Self>, end: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError>;

    /// Ends recording a match whose end is not known, as that of a trace that breaks off. Ends it like an interrupted match by default.
    ///
    /// # Errors
    /// The first error that occurred.
    fn break_off(self: Box<Self>, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        let reason = EndReason::Interrupted;
        self.finish(&MatchEnd { reason, score: last.game.score, cycles: last.cycle, ..MatchEnd::default() }, last)
    }
}

/// Why recording ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndReason {
    /// The final whistle.
    FinalWhistle,
    /// The duration is over.
    #[default]
    Duration,
    /// The user or the system stopped the run.
    Interrupted,
    /// An error stopped the run.
    Failed,
}

/// How a match ended.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(tag = "type", rename = "end")]
pub struct MatchEnd {
    /// What ended it.
    pub reason: EndReason,
    /// Goals of both teams.
    #[serde(default)]
    pub score: Score,
    /// The result, and how it came about.
    #[serde(default)]
    pub result: Option<MatchResult>,
    /// Cycles since the start.
    #[serde(default)]
    pub cycles: u64,
    /// Statistics of all messages between robots.
    #[serde(default)]
    pub messages: MessageStatistics,
}

/// The recorders of the match that is being played.
#[derive(Resource, Default)]
pub struct Recorders(Vec<Box<dyn Recorder>>);

impl Recorders {
    /// Returns whether a recorder cannot write any more.
    pub fn has_failed(&self) -> bool {
        self.0.iter().any(|recorder| recorder.has_failed())
    }

    /// Calls `act` with each recorder, the current record and the world.
    fn each(&mut self, world: &mut World, act: impl Fn(&mut dyn Recorder, &CycleRecord, &mut World)) {
        world.resource_scope(|world, current: Mut<CurrentRecord>| {
            for recorder in &mut self.0 {
                act(&mut **recorder, &current.record, world);
            }
        });
    }
}

/// Starts recording the match in the world. The app must have the [`RecordPlugin`](super::RecordPlugin).
pub fn start(world: &mut World, recorders: Vec<Box<dyn Recorder>>) {
    if recorders.iter().any(|recorder| recorder.needs_record()) {
        gather::gather_start(world);
    } else {
        gather::gather_on_demand(world);
    }
    let Some(scenario) = world.get_resource::<Scenario>() else { return };
    let scenario = resolved(world, scenario);
    let mut recorders = Recorders(recorders);
    recorders.each(world, |recorder, record, world| recorder.start(&scenario, record, world));
    world.insert_resource(recorders);
}

/// Passes the last completed cycle to the recorders.
pub(super) fn record_cycle(world: &mut World) {
    world.resource_scope(|world, mut recorders: Mut<Recorders>| {
        if !recorders.0.iter().any(|recorder| recorder.needs_record()) {
            return;
        }
        record_now(world);
        recorders.each(world, |recorder, record, world| recorder.record(record, world));
    });
}

/// Ends recording the match in the world. Returns the final text of each recorder, in the order in which they were added.
pub fn finish(world: &mut World, reason: EndReason) -> Vec<Result<Option<String>, RecordError>> {
    let Some(Recorders(recorders)) = world.remove_resource() else { return Vec::new() };
    let end = MatchEnd {
        reason,
        score: world.resource::<Game>().score,
        result: Some(world.resource::<Game>().result(world.resource::<Rules>())),
        cycles: world.resource::<CycleClock>().cycle,
        messages: *world.resource::<MessageStatistics>(),
    };
    let last = record_now(world).clone();
    recorders.into_iter().map(|recorder| recorder.finish(&end, &last)).collect()
}
