//! What happened in a cycle: kicks, collisions, goals, verdicts, refused commands.
//!
//! [`CycleEvents`] has those of the cycle under way. They are [messages](Message) besides, for systems of a program's own:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Resource, Default)]
//! struct Kicks(u32);
//!
//! fn count_kicks(mut events: MessageReader<MatchEvent>, mut kicks: ResMut<Kicks>) {
//!     kicks.0 += events.read().filter(|event| matches!(event, MatchEvent::Kick { .. })).count() as u32;
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
//! In the [`Cycle`] a system has those of this cycle from [`CycleSystems::Record`] on, and before that those of the last one; in
//! `Update` and other schedules of a frame those of all cycles since it last ran. They are the referee's truth: a behaviour may
//! not read them.

mod details;
mod mistake_kind;

pub use details::{
    AgentLoss, BoundaryLine, CollisionPartner, CollisionType, CommandKind, DisallowedGoal, FallCause, KickMiss,
    KickResult, LARGEST_COMMAND, Refusal,
};
pub use mistake_kind::MistakeKind;

use bevy::prelude::*;
use bevy::reflect::enums::Enum;
use serde::{Deserialize, Serialize};

use crate::cycle::{BeginCycle, Cycle, CycleSystems};
use crate::game::{Evidence, GameState, Intervention, PenaltyReason, Score, SetPlayKind};
use crate::geometry::file_units;
use crate::kick_geometry::{KickType, Side};
use crate::knowledge::Knowledge;
use crate::team::{RobotId, Team};

/// Messages are kept until the frame after the next, as Bevy's are, and where there are no frames, so many at least.
const KEPT_MESSAGES: usize = 256;

/// Keeps the events of the cycle under way, and publishes them as messages.
pub struct EventsPlugin;

impl Plugin for EventsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CycleEvents>()
            .register_type::<CycleEvents>()
            .add_message::<MatchEvent>()
            .add_systems(
                Cycle,
                (|mut events: ResMut<CycleEvents>| events.clear()).in_set(BeginCycle).in_set(CycleSystems::First),
            )
            .add_systems(Cycle, publish_events.in_set(PublishEvents).in_set(CycleSystems::CheckInvariants));
    }
}

/// The events become messages: whatever makes events comes before.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PublishEvents;

/// The events of the cycle under way, in the order in which they happened.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, Deref, DerefMut)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct CycleEvents(pub Vec<MatchEvent>);

/// Something that happened in a cycle.
#[derive(Message, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum MatchEvent {
    /// A kick command was carried out, or not.
    Kick {
        /// The robot that was to kick.
        robot: RobotId,
        /// Which kick was wanted.
        #[serde(rename = "type")]
        kick_type: KickType,
        /// The speed wanted, after clamping to 0..1; none if it was not a number.
        speed: Option<f32>,
        /// What came of it.
        result: KickResult,
        /// Why nothing did.
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
        /// The speed with which it left, m/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        launch_speed_mps: Option<f32>,
    },
    /// Two things came to touch. Reported when the contact begins.
    Collision {
        /// The moving robot; the first in order if both move; none if the ball hit a post.
        robot: Option<RobotId>,
        /// What it ran into.
        with: CollisionPartner,
        /// The type of the collision.
        #[serde(rename = "type")]
        collision_type: CollisionType,
        /// Speed at which the two approached each other, m/s.
        speed_mps: f32,
        /// Where they touched, m, pitch frame.
        position_m: Vec2,
    },
    /// A robot fell.
    Fall {
        /// Which robot.
        robot: RobotId,
        /// What made it fall.
        #[serde(default)]
        cause: FallCause,
        /// Speed at which the two met in a collision, or at which it walked, m/s.
        speed_mps: f32,
        /// How probable that made a fall.
        probability: f32,
    },
    /// A fallen robot stands again.
    GotUp {
        /// Which robot.
        robot: RobotId,
    },
    /// A robot dives.
    Dive {
        /// Which robot.
        robot: RobotId,
        /// To which side.
        side: Side,
    },
    /// A behaviour's command was refused, and nothing was done.
    CommandRefused {
        /// The robot whose behaviour gave it.
        robot: RobotId,
        /// The kind of command.
        command: CommandKind,
        /// What is wrong with it.
        reason: Refusal,
    },
    /// A goal was scored.
    Goal {
        /// The team that it counts for.
        team: Team,
        /// Who touched the ball last, if anybody did.
        scorer: Option<RobotId>,
        /// Whether that robot is of the other team.
        own_goal: bool,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// The ball left the pitch.
    BallOut {
        /// Over which line.
        line: BoundaryLine,
        /// Where, m, pitch frame.
        position_m: Vec2,
        /// The team that touched it last.
        last_touch: Option<Team>,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// The ball was in the goal, but it does not count.
    GoalDisallowed {
        /// The team that it does not count for.
        team: Team,
        /// Why not, in a word.
        reason: DisallowedGoal,
        /// What was measured, and which rule says so.
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
    /// The ball was thrown in, and play runs on (2010 rule book, section 3.9).
    ThrowIn {
        /// The team that did not touch it last.
        team: Team,
        /// Where it was put down, m, pitch frame.
        position_m: Vec2,
    },
    /// Play is restarted with neither team having a right to the ball.
    DropBall {
        /// Where it was put down, m, pitch frame.
        position_m: Vec2,
    },
    /// A free kick begins; play runs on.
    FreeKick {
        /// What the free kick is given for.
        set_play: SetPlayKind,
        /// The team that the ball belongs to.
        team: Team,
        /// Where it was put down, m, pitch frame.
        position_m: Vec2,
    },
    /// A free kick, or the time in which the kick-off is a team's own, is over: the ball is free.
    FreeKickOver {
        /// The team that the ball belonged to.
        team: Team,
        /// Whether it took it; else its time was over.
        taken: bool,
    },
    /// Play was stuck.
    GameStuck {
        /// The robot that was taken from the ball; without one, play was stopped.
        robot: Option<RobotId>,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// A robot at an illegal place was put at a legal one.
    PlacedByHand {
        /// Which robot.
        robot: RobotId,
        /// Where it was put down, m, pitch frame.
        position_m: Vec2,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// The referee was made to do something.
    Intervention {
        /// What was asked for.
        intervention: Intervention,
    },
    /// The referee was to do something that cannot be done; nothing changed.
    InterventionRefused {
        /// What was asked for.
        intervention: Intervention,
        /// Why it cannot be done.
        message: String,
    },
    /// A team has sent more messages than it may: its goals do not count.
    TooManyMessages {
        /// Which team.
        team: Team,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// A robot was penalised and removed from the pitch.
    Penalty {
        /// Which robot.
        robot: RobotId,
        /// The offence.
        reason: PenaltyReason,
        /// When it may come back if play runs on, s since the start of the match.
        until_s: f32,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// A robot was cautioned.
    Caution {
        /// Which robot.
        robot: RobotId,
        /// How often it has been in this match.
        cautions: u32,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// A robot's penalty is over, and it is back.
    PenaltyOver {
        /// Which robot.
        robot: RobotId,
        /// Where it was put down, m, pitch frame.
        position_m: Vec2,
    },
    /// A half begins.
    HalfBegins {
        /// Its number, from 1.
        half: u32,
    },
    /// The final whistle.
    FinalWhistle,
    /// A drawn match goes on with a penalty shoot-out.
    ShootOutBegins,
    /// A shot of the shoot-out is over.
    Shot {
        /// The team that shot.
        team: Team,
        /// Whether it scored.
        scored: bool,
        /// Goals of the shoot-out so far.
        goals: Score,
        /// What was measured, and which rule says so.
        evidence: Evidence,
    },
    /// The shoot-out is decided.
    ShootOutWon {
        /// For this team.
        team: Team,
    },
    /// The program that played a robot does so no more: the robot stands still, and the match goes on.
    AgentLost {
        /// Which robot.
        robot: RobotId,
        /// Why, in a word.
        reason: AgentLoss,
        /// Why, in a sentence.
        message: String,
    },
    /// Something that must always hold does not: a bug.
    InvariantBroken {
        /// What should hold, and what was found, in words.
        message: String,
    },
}

impl MatchEvent {
    /// The kind of the event, as traces spell it: `ball_out`, and of a penalty also what it is for: `penalty pushing`.
    pub fn kind(&self) -> String {
        let kind = snake_case(self.variant_name());
        match self {
            MatchEvent::Penalty { reason, .. } => format!("{kind} {}", reason.name()),
            _ => kind,
        }
    }
}

/// The name of a variant as files spell it: as serde's `rename_all = "snake_case"`.
fn snake_case(name: &str) -> String {
    let mut word = String::with_capacity(name.len() + 4);
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !word.is_empty() {
            word.push('_');
        }
        word.push(letter.to_ascii_lowercase());
    }
    word
}

fn publish_events(events: Res<CycleEvents>, mut messages: ResMut<Messages<MatchEvent>>) {
    if events.is_empty() {
        return;
    }
    if messages.iter_current_update_messages().len() >= KEPT_MESSAGES {
        messages.update();
    }
    messages.write_batch(events.iter().cloned());
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
