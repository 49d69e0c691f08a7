//! Events for observers: the start and the end of a match, goals, and events of single robots.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Resource, Default)]
//! struct Scoreboard(u32, u32);
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins).init_resource::<Scoreboard>();
//! app.add_observer(|goal: On<GoalScored>, mut board: ResMut<Scoreboard>| {
//!     *board = Scoreboard(goal.score.blue, goal.score.pink);
//! });
//! let rolling = r#"{ "ball": { "position_m": [2.0, 0.0], "velocity_mps": [2.0, 0.0] } }"#;
//! app.start_match(&Scenario::from_json(rolling)?)?.run_cycles(60);
//! let board = app.world().resource::<Scoreboard>();
//! assert_eq!((board.0, board.1), (1, 0));
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! | event | target | when |
//! |---|---|---|
//! | [`MatchStarted`] | | a match has been put into the world |
//! | [`MatchNotStarted`] | | [`MatchCommands::start_match`](super::MatchCommands::start_match) had a scenario that cannot be started |
//! | [`MatchEnded`] | | the final whistle, the end of the scenario's time, or [`MatchCommands::end_match`](super::MatchCommands::end_match) |
//! | [`GoalScored`] | | a goal counts |
//! | [`Kicked`] | the robot | a robot has struck the ball |
//! | [`Fell`] | the robot | a robot has fallen |
//! | [`Penalised`] | the robot | a robot has been penalised |
//!
//! Goals, kicks, falls and penalties are triggered at the end of a cycle, after [`CycleSystems::Last`], in the order in which they
//! happened. An observer may therefore start another match. All other events are [messages](naoisis_core::events). All of them are ground
//! truth, so a behaviour cannot be an observer.

use bevy::prelude::*;

use crate::scenario::ScenarioFault;
use naoisis_core::cycle::{Cycle, CycleHalf, CycleSystems};
use naoisis_core::events::{CycleEvents, FallCause, MatchEvent};
use naoisis_core::game::{Game, PenaltyReason, Score};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};

/// A match has been put into the world: a new one, or one that continues a saved match. The [`Scenario`](crate::scenario::Scenario) is a
/// resource.
#[derive(Event, Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct MatchStarted;

/// A match could not be started by a command. The world is as it was before the command.
#[derive(Event, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct MatchNotStarted {
    /// What is wrong with the scenario.
    pub fault: ScenarioFault,
}

/// A match is over.
#[derive(Event, Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub struct MatchEnded {
    /// The reason for the end.
    pub reason: MatchEnd,
    /// The score.
    pub score: Score,
}

/// The reason why a match has ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum MatchEnd {
    /// The final whistle.
    FinalWhistle,
    /// The scenario's [time](crate::scenario::Scenario::last_cycle) is over. This occurs only if a
    /// [schedule](super::NaoisisPlugins::in_schedule) runs the cycles; otherwise the owner of the app decides when to stop.
    TimeOver,
    /// The match was taken out of the world before its end.
    Removed,
}

/// A goal counts.
#[derive(Event, Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub struct GoalScored {
    /// The team that scored.
    pub team: Team,
    /// The robot that touched the ball last. `None` if no robot did.
    pub scorer: Option<RobotId>,
    /// Whether the scorer is of the other team.
    pub own_goal: bool,
    /// The score, including this goal.
    pub score: Score,
}

/// A robot has struck the ball. A kick that misses the ball is no such event.
#[derive(EntityEvent, Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct Kicked {
    /// The robot's entity.
    pub entity: Entity,
    /// The robot.
    pub robot: RobotId,
    /// The type of the kick.
    pub kick_type: KickType,
    /// The direction in which the ball left, pitch frame, radians.
    pub direction: f32,
    /// The speed with which the ball left, m/s.
    pub speed_mps: f32,
}

/// A robot has fallen.
#[derive(EntityEvent, Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub struct Fell {
    /// The robot's entity.
    pub entity: Entity,
    /// The robot.
    pub robot: RobotId,
    /// The cause of the fall.
    pub cause: FallCause,
}

/// A robot has been penalised.
#[derive(EntityEvent, Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct Penalised {
    /// The robot's entity.
    pub entity: Entity,
    /// The robot.
    pub robot: RobotId,
    /// The offence.
    pub reason: PenaltyReason,
    /// Earliest time at which the robot may come back, if play is not interrupted, s since the start of the match.
    pub until_s: f32,
}

/// Triggers the events of each cycle.
pub(super) fn add_triggers(app: &mut App) {
    app.add_systems(
        Cycle,
        trigger_events
            .run_if(|events: Option<Res<CycleEvents>>| events.is_some_and(|events| !events.is_empty()))
            .in_set(CycleHalf::Act)
            .after(CycleSystems::Last)
            // A system without a set may run before or after this one. All systems with a set have run.
            .ambiguous_with_all(),
    );
}

/// An event to trigger, with the values that had to be looked up for it.
enum Trigger {
    Goal(GoalScored),
    Kick(Kicked),
    Fall(Fell),
    Penalty(Penalised),
    End(MatchEnded),
}

impl Trigger {
    /// Converts an event of the match to an event for observers, if there is one.
    fn of(event: &MatchEvent, score: Score, roster: &Roster) -> Option<Trigger> {
        match *event {
            MatchEvent::Goal { team, scorer, own_goal, .. } => {
                Some(Trigger::Goal(GoalScored { team, scorer, own_goal, score }))
            }
            MatchEvent::Kick {
                robot,
                kick_type,
                direction: Some(direction),
                launch_speed_mps: Some(speed_mps),
                ..
            } => {
                let entity = roster.get(robot)?;
                Some(Trigger::Kick(Kicked { entity, robot, kick_type, direction, speed_mps }))
            }
            MatchEvent::Fall { robot, cause, .. } => {
                Some(Trigger::Fall(Fell { entity: roster.get(robot)?, robot, cause }))
            }
            MatchEvent::Penalty { robot, reason, until_s, .. } => {
                Some(Trigger::Penalty(Penalised { entity: roster.get(robot)?, robot, reason, until_s }))
            }
            MatchEvent::FinalWhistle => Some(Trigger::End(MatchEnded { reason: MatchEnd::FinalWhistle, score })),
            _ => None,
        }
    }
}

fn trigger_events(world: &mut World) {
    let (events, roster) = (world.resource::<CycleEvents>(), world.resource::<Roster>());
    let score = world.resource::<Game>().score;
    let triggers: Vec<Trigger> = events.iter().filter_map(|event| Trigger::of(event, score, roster)).collect();
    for trigger in triggers {
        match trigger {
            Trigger::Goal(goal) => world.trigger(goal),
            Trigger::Kick(kick) => world.trigger(kick),
            Trigger::Fall(fall) => world.trigger(fall),
            Trigger::Penalty(penalty) => world.trigger(penalty),
            Trigger::End(end) => world.trigger(end),
        }
    }
}
