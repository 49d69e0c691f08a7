//! What happened in a cycle: kicks, collisions, goals, verdicts, refused commands.
//!
//! [`CycleEvents`] holds the events of the current cycle. They are also sent as [messages](Message) to a program's own systems: a
//! [`StampedEvent`] is an event with the cycle in which it happened.
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Resource, Default)]
//! struct Kicks(u32);
//!
//! fn count_kicks(mut events: MessageReader<StampedEvent>, mut kicks: ResMut<Kicks>) {
//!     kicks.0 += events.read().filter(|stamped| matches!(stamped.event, MatchEvent::Kick { .. })).count() as u32;
//! }
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins).init_resource::<Kicks>();
//! app.add_systems(Cycle, count_kicks.in_set(CycleSystems::Last));
//! app.start_match(&Scenario::named("kick_right_straight")?)?.run_cycles(30);
//! assert_eq!(app.world().resource::<Kicks>().0, 1);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! In the [`Cycle`], a system that runs in [`CycleSystems::Record`] or later reads the messages of this cycle, and an earlier one those of
//! the previous cycle. In `Update` and other schedules of a frame, a system reads the messages of all cycles since it last ran. They are
//! ground truth: a behaviour may not read them.
//!
//! For observers, the start and end of a match, goals, kicks, falls and penalties are events: see `naoisis::simulation::triggers`.

mod contacts;
mod details;
mod mistake_kind;

pub use contacts::Contacts;
pub use details::{
    AgentLoss, BoundaryLine, CollisionPartner, CollisionType, CommandKind, DisallowedGoal, FallCause, KickMiss,
    KickResult, LARGEST_COMMAND, Refusal,
};
pub use mistake_kind::MistakeKind;

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

use crate::cycle::{BeginCycle, Cycle, CycleClock, CycleSystems};
use crate::game::{Evidence, GameState, Intervention, PenaltyReason, Score, SetPlayKind};
use crate::geometry::file_units;
use crate::kick_geometry::{KickType, Side};
use crate::knowledge::Knowledge;
use crate::team::{RobotId, Team};

/// Least number of messages that are kept in an app without frames. With frames they are kept like all messages of Bevy.
const KEPT_MESSAGES: usize = 256;

/// Collects the events of the current cycle, and publishes them as messages.
pub struct EventsPlugin;

impl Plugin for EventsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CycleEvents>()
            .register_type::<CycleEvents>()
            .add_message::<StampedEvent>()
            .add_systems(
                Cycle,
                (|mut events: ResMut<CycleEvents>| events.clear()).in_set(BeginCycle).in_set(CycleSystems::First),
            )
            .add_systems(Cycle, publish_events.in_set(PublishEvents).in_set(CycleSystems::CheckInvariants));
    }
}

/// The system that publishes the events as messages, after all systems that create events.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PublishEvents;

/// The events of the current cycle, in the order in which they happened.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, Deref, DerefMut)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct CycleEvents(pub Vec<MatchEvent>);

/// An event with its cycle, as a message.
#[derive(Message, Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct StampedEvent {
    /// The cycle in which it happened.
    pub cycle: u64,
    /// The end of that cycle, s since the start of the match.
    pub time_s: f64,
    /// What happened.
    pub event: MatchEvent,
}

/// Something that happened in a cycle.
#[derive(Clone, PartialEq, Debug, IntoStaticStr, Reflect, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum MatchEvent {
    /// A kick was executed, or missed.
    Kick {
        /// The robot that kicks.
        robot: RobotId,
        /// The requested kick.
        #[serde(rename = "type")]
        kick_type: KickType,
        /// The requested speed, clamped to 0..1; `None` if it is NaN.
        speed: Option<f32>,
        /// The result.
        result: KickResult,
        /// Why the kick missed.
        #[serde(skip_serializing_if = "Option::is_none")]
        reason: Option<KickMiss>,
        /// The direction in which the ball left, in the pitch frame, radians (degrees in files).
        #[serde(
            rename = "direction_deg",
            with = "file_units::optional_degrees",
            default,
            skip_serializing_if = "Option::is_none"
        )]
        direction: Option<f32>,
        /// The launch speed of the ball, m/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        launch_speed_mps: Option<f32>,
    },
    /// A collision of robots, posts and ball. Reported when the contact begins.
    Collision {
        /// The moving robot, the first by id if both move; `None` if the ball hit a post.
        robot: Option<RobotId>,
        /// The other partner of the collision.
        with: CollisionPartner,
        /// The type of the collision.
        #[serde(rename = "type")]
        collision_type: CollisionType,
        /// Approach speed, m/s.
        speed_mps: f32,
        /// Point of contact, m, pitch frame.
        position_m: Vec2,
    },
    /// A robot fell.
    Fall {
        /// The robot.
        robot: RobotId,
        /// The cause.
        #[serde(default)]
        cause: FallCause,
        /// Speed of the collision, or of the walk, m/s.
        speed_mps: f32,
        /// Probability of the fall.
        probability: f32,
    },
    /// A fallen robot stands again.
    GotUp {
        /// The robot.
        robot: RobotId,
    },
    /// The program of a robot stopped, and starts again.
    ProgramRestarts {
        /// The robot.
        robot: RobotId,
        /// Time until the robot acts again, s.
        duration_s: f32,
    },
    /// A robot dives.
    Dive {
        /// The robot.
        robot: RobotId,
        /// The side.
        side: Side,
    },
    /// A behaviour's command was refused, and nothing was done.
    CommandRefused {
        /// The robot of the behaviour.
        robot: RobotId,
        /// The kind of command.
        command: CommandKind,
        /// Why it was refused.
        reason: Refusal,
    },
    /// A goal was scored.
    Goal {
        /// The team that it counts for.
        team: Team,
        /// The robot that touched the ball last, if any, or that kicked the ball before an opponent deflected it.
        scorer: Option<RobotId>,
        /// Whether that robot is of the other team.
        own_goal: bool,
        /// The evidence.
        evidence: Evidence,
    },
    /// The ball left the pitch.
    BallOut {
        /// The line.
        line: BoundaryLine,
        /// Position, m, pitch frame.
        position_m: Vec2,
        /// The team that touched it last.
        last_touch: Option<Team>,
        /// The evidence.
        evidence: Evidence,
    },
    /// A goal was disallowed.
    GoalDisallowed {
        /// The team that the goal does not count for.
        team: Team,
        /// The reason.
        reason: DisallowedGoal,
        /// The evidence.
        evidence: Evidence,
    },
    /// The state of the game changed.
    StateChanged {
        /// The state from now on.
        state: GameState,
    },
    /// A kick-off: ball and robots were placed for it, or the robots may walk to their places.
    KickOff {
        /// The team that kicks off.
        team: Team,
    },
    /// The ball was thrown in, and play continues (2010 rule book, section 3.9).
    ThrowIn {
        /// The team that did not touch the ball last.
        team: Team,
        /// Position at which the ball was placed, m, pitch frame.
        position_m: Vec2,
    },
    /// Play is restarted by a drop ball, which belongs to neither team.
    DropBall {
        /// Position at which the ball was placed, m, pitch frame.
        position_m: Vec2,
    },
    /// A free kick begins; play continues.
    FreeKick {
        /// The kind of the free kick.
        set_play: SetPlayKind,
        /// The team that the ball belongs to.
        team: Team,
        /// Position at which the ball was placed, m, pitch frame.
        position_m: Vec2,
    },
    /// A free kick, or the time in which the ball belongs to the team that kicks off, is over: the ball is free.
    FreeKickOver {
        /// The team that the ball belonged to.
        team: Team,
        /// Whether the team took it; otherwise its time was over.
        taken: bool,
    },
    /// Play was stuck.
    GameStuck {
        /// The robot that was removed from the ball; `None` if play was stopped.
        robot: Option<RobotId>,
        /// The evidence.
        evidence: Evidence,
    },
    /// A robot at an illegal position was placed at a legal one.
    PlacedByHand {
        /// The robot.
        robot: RobotId,
        /// Position at which it was placed, m, pitch frame.
        position_m: Vec2,
        /// The evidence.
        evidence: Evidence,
    },
    /// The taker of a set play touched the ball again before another robot had.
    DoubleTouch {
        /// The robot.
        robot: RobotId,
        /// The evidence.
        evidence: Evidence,
    },
    /// A robot at the position where the ball is placed was moved aside.
    MovedAside {
        /// The robot.
        robot: RobotId,
        /// Its new position, m, pitch frame.
        position_m: Vec2,
    },
    /// An intervention was applied.
    Intervention {
        /// The intervention.
        intervention: Intervention,
    },
    /// An intervention was refused; nothing changed.
    InterventionRefused {
        /// The intervention.
        intervention: Intervention,
        /// Why.
        message: String,
    },
    /// A team has exceeded its message budget: its goals do not count.
    TooManyMessages {
        /// The team.
        team: Team,
        /// The evidence.
        evidence: Evidence,
    },
    /// A robot was penalised and removed from the pitch.
    Penalty {
        /// The robot.
        robot: RobotId,
        /// The offence.
        reason: PenaltyReason,
        /// Earliest end of the penalty, s since the start of the match.
        until_s: f32,
        /// The evidence.
        evidence: Evidence,
    },
    /// A robot was cautioned.
    Caution {
        /// The robot.
        robot: RobotId,
        /// Number of its cautions in this match.
        cautions: u32,
        /// The evidence.
        evidence: Evidence,
    },
    /// A robot returned after a penalty.
    PenaltyOver {
        /// The robot.
        robot: RobotId,
        /// Position at which it was placed, m, pitch frame.
        position_m: Vec2,
    },
    /// A time-out begins.
    Timeout {
        /// The team that takes it; `None` for the referee.
        team: Option<Team>,
        /// Its longest duration, s.
        duration_s: f32,
    },
    /// A substitute replaces a player.
    Substitution {
        /// The substitute.
        robot: RobotId,
        /// The player.
        replaced: RobotId,
    },
    /// A half begins.
    HalfBegins {
        /// Its number, from 1.
        half: u32,
    },
    /// The final whistle.
    FinalWhistle,
    /// A penalty shoot-out begins after a drawn match.
    ShootOutBegins,
    /// A shot of the shoot-out is over.
    Shot {
        /// The team that shot.
        team: Team,
        /// Whether it scored.
        scored: bool,
        /// Goals of the shoot-out so far.
        goals: Score,
        /// The evidence.
        evidence: Evidence,
    },
    /// The shoot-out is decided.
    ShootOutWon {
        /// The team that won.
        team: Team,
    },
    /// The program of a robot was lost: the robot stands still, and the match continues.
    AgentLost {
        /// The robot.
        robot: RobotId,
        /// The kind of loss.
        reason: AgentLoss,
        /// The cause in a sentence.
        message: String,
    },
    /// Something is wrong with a GameController, or with its information. Reported once.
    GameController {
        /// The fault in a sentence.
        message: String,
    },
    /// An invariant of the simulation is broken: a bug.
    InvariantBroken {
        /// The invariant and what was found instead.
        message: String,
    },
}

impl MatchEvent {
    /// The kind of the event, as traces spell it: `ball_out`, and for a penalty with the offence: `penalty pushing`.
    pub fn kind(&self) -> String {
        let kind: &str = self.into();
        match self {
            MatchEvent::Penalty { reason, .. } => format!("{kind} {}", reason.name()),
            _ => kind.to_owned(),
        }
    }
}

fn publish_events(events: Res<CycleEvents>, clock: Res<CycleClock>, mut messages: ResMut<Messages<StampedEvent>>) {
    if events.is_empty() {
        return;
    }
    if messages.iter_current_update_messages().len() >= KEPT_MESSAGES {
        messages.update();
    }
    let (cycle, time_s) = (clock.cycle, clock.end_time_s());
    messages.write_batch(events.iter().map(|event| StampedEvent { cycle, time_s, event: event.clone() }));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kind_is_spelt_as_in_traces() {
        let robot = RobotId::new(Team::Blue, 2);
        for (event, kind) in [
            (MatchEvent::FinalWhistle, "final_whistle"),
            (MatchEvent::Goal { team: Team::Blue, scorer: None, own_goal: false, evidence: default() }, "goal"),
        ] {
            assert_eq!(event.kind(), kind);
            let text = serde_json::to_string(&event).unwrap();
            assert!(text.contains(&format!(r#""kind":"{kind}""#)), "{text}");
        }
        let pushing =
            MatchEvent::Penalty { robot, reason: PenaltyReason::LeavingField, until_s: 45.0, evidence: default() };
        assert_eq!(pushing.kind(), "penalty leaving_field");
    }
}
