//! The built-in teams: `chasers`, of which everybody goes for the ball, and `roles`, with a keeper, a striker and
//! supporters.
//!
//! They play on their [`Belief`], which the [simple estimator](crate::belief::simple) builds from what they sense, and on what
//! they are told of the game. Each behaviour is a plain function from what a [`Player`] knows to a [`Decision`]; one system a
//! behaviour fetches and stores.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::borrow::Cow;

pub mod attack;
pub mod chaser;
pub mod keeper;
pub mod kicking;
pub mod looking;
pub mod player;
pub mod roles;
pub mod striker;
pub mod supporter;
pub mod walking;

pub use player::{Decision, Player, PlayerMemory};

use super::BehaviourApp;
use crate::belief::{Belief, SimpleBelief};
use crate::communication::{Outbox, TeamMessage};
use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::pitch::{End, Pitch};
use crate::referee::{GameState, GameStatus, Rules, formation};
use crate::robot::RobotId;
use crate::robot::head::HeadCommand;
use crate::robot::kick::{KickCommand, KickSettings};
use crate::robot::motion::{MotionLimits, WalkCommand};
use crate::robot::posture::{PostureCommand, PostureRequest};
use crate::sensing::sonar::{SonarReading, SonarSettings};
use crate::sensing::status::BodyStatus;

/// Registers the built-in behaviours and teams.
///
/// Needs the plugins of the sensors and of the [simple belief](crate::belief::SimpleBeliefPlugin) to be added before.
pub struct BuiltInTeamsPlugin;

impl Plugin for BuiltInTeamsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<PlayerMemory>()
            .register_type::<Chaser>()
            .register_type::<Keeper>()
            .register_type::<Striker>()
            .register_type::<Supporter>()
            .add_behaviour::<Chaser, _>("chaser", play::<Chaser>)
            .add_behaviour::<Keeper, _>("keeper", play::<Keeper>)
            .add_behaviour::<Striker, _>("striker", play::<Striker>)
            .add_behaviour::<Supporter, _>("supporter", play::<Supporter>)
            .add_team("chasers", "Everybody goes for the ball.", |_, _| "chaser")
            .add_team(
                "roles",
                "A keeper, a striker, and supporters who take the striker's place when they are nearer to the ball.",
                |number, size| match number {
                    1 if size > 1 => "keeper",
                    0..=2 => "striker",
                    _ => "supporter",
                },
            );
    }
}

/// A built-in behaviour.
trait Role: Component {
    /// Decides while the ball is in play.
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision;
}

/// Marks a robot that goes for the ball.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Chaser;

/// Marks a robot that keeps the goal.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Keeper;

/// Marks a robot that attacks.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Striker;

/// Marks a robot that supports the attack.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Supporter;

impl Role for Chaser {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        chaser::decide(player, memory)
    }
}

impl Role for Keeper {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        keeper::decide(player, memory)
    }
}

impl Role for Striker {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        striker::decide(player, memory)
    }
}

impl Role for Supporter {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        supporter::decide(player, memory)
    }
}

/// What a built-in behaviour reads and writes of its robots.
#[derive(QueryData)]
#[query_data(mutable)]
struct PlayerQuery {
    id: &'static RobotId,
    belief: &'static Belief,
    status: &'static GameStatus,
    body: &'static BodyStatus,
    sonar: &'static SonarReading,
    sonar_settings: &'static SonarSettings,
    limits: &'static MotionLimits,
    kicks: &'static KickSettings,
    memory: &'static mut PlayerMemory,
    walk: &'static mut WalkCommand,
    head: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    outbox: &'static mut Outbox,
    posture: &'static mut PostureCommand,
}

fn play<R: Role>(
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    rules: Res<Rules>,
    mut robots: Query<PlayerQuery, With<R>>,
) {
    for mut robot in &mut robots {
        let player = Player {
            id: *robot.id,
            belief: robot.belief,
            status: robot.status,
            body: *robot.body,
            sonar: *robot.sonar,
            sonar_settings: robot.sonar_settings,
            limits: robot.limits,
            kicks: robot.kicks,
            pitch: &pitch,
            team_size: rules.team_size,
            period: clock.period(),
            forward: robot.belief.pose.forward(),
        };
        let memory = &mut *robot.memory;
        let decision = decide_in_game(&player, memory, R::decide);
        *robot.walk = decision.walk;
        *robot.head = decision.head.unwrap_or_else(|| attack::watch(&player, memory));
        robot.kick.0 = decision.kick;
        robot.posture.0 = (player.body == BodyStatus::Fallen).then_some(PostureRequest::GetUp);
        robot.outbox.0 = (!player.status.penalised).then(|| message(&player, decision.intention));
    }
}

/// What to do in any state of the game; `decide` tells it while the ball is in play.
fn decide_in_game(
    player: &Player,
    memory: &mut PlayerMemory,
    decide: impl FnOnce(&Player, &mut PlayerMemory) -> Decision,
) -> Decision {
    note_kick_off(player, memory);
    if player.status.penalised {
        return Decision { head: Some(HeadCommand::default()), intention: "wait", ..default() };
    }
    match player.status.state {
        GameState::Playing => {
            let decision = decide(player, memory);
            if keeps_off_the_kick_off(player, memory) { stay_off_the_circle(player, decision) } else { decision }
        }
        GameState::Ready => {
            let place = kick_off_place(player);
            let walk = player.travel_to(place.position, place.forward(), &player.obstacles());
            Decision { walk, intention: "ready", ..default() }
        }
        GameState::Initial | GameState::Set | GameState::Finished => Decision { intention: "wait", ..default() },
    }
}

/// The player's place for the kick-off, team frame.
fn kick_off_place(player: &Player) -> crate::geometry::Pose {
    let kicking_off = player.status.kick_off_team == player.id.team;
    formation(player.pitch, player.team_size, player.id.number, End::NegativeX, kicking_off)
}

/// Takes note of kick-offs, and of when they are over: the ball has left the mark, or it takes too long.
fn note_kick_off(player: &Player, memory: &mut PlayerMemory) {
    /// After this time the ball is free for everybody, s (2025 rule book).
    const KICK_OFF_S: f32 = 10.0;
    /// A ball this far from the centre mark is in play, m.
    const IN_PLAY_M: f32 = 0.2;
    let now = player.status.time_s;
    let placed = match memory.restarts {
        // At the start of the match, whoever stands at its kick-off place has been placed there.
        None => kick_off_place(player).position.distance(player.position()) < 0.1,
        Some(restarts) => restarts != player.status.restarts,
    };
    memory.restarts = Some(player.status.restarts);
    if placed {
        *memory =
            PlayerMemory { restarts: memory.restarts, kick_off_since_s: Some(now), last_glance_s: now, ..default() };
    }
    let in_play = player.ball().is_some_and(|ball| ball.position_m.length_squared() > IN_PLAY_M * IN_PLAY_M);
    if memory.kick_off_since_s.is_some_and(|since| in_play || now - since > KICK_OFF_S) {
        memory.kick_off_since_s = None;
    }
}

/// Whether the opponents have a kick-off that is not over yet.
fn keeps_off_the_kick_off(player: &Player, memory: &PlayerMemory) -> bool {
    memory.kick_off_since_s.is_some() && player.status.kick_off_team != player.id.team
}

/// Stops a player before the centre circle.
fn stay_off_the_circle(player: &Player, decision: Decision) -> Decision {
    let least = player.pitch.centre_circle_diameter_m / 2.0 + 0.2;
    if player.position().length_squared() > least * least {
        return Decision { kick: None, ..decision };
    }
    Decision { walk: WalkCommand::default(), kick: None, ..decision }
}

/// What the player tells its team-mates.
fn message(player: &Player, intention: &'static str) -> TeamMessage {
    /// A ball seen within this time is worth telling of, s.
    const FRESH_BALL_S: f32 = 0.5;
    let ball = player.ball().filter(|ball| ball.heard_from.is_none() && ball.age_s < FRESH_BALL_S);
    TeamMessage {
        pose: Some(player.pose()),
        ball_m: ball.map(|ball| ball.position_m),
        robots_m: Vec::new(),
        intention: Some(Cow::Borrowed(intention)),
        payload: None,
    }
}
