//! The built-in teams: `chasers`, of which everybody goes for the ball; `roles`, with a keeper, a striker and
//! supporters; and `passers`, who pass, and tell each other what they are about and what they see.
//!
//! They play on their [`Belief`], which the [simple estimator](naoisis_sensing::belief::simple) builds from what they sense, and on what
//! they are told of the game. Each behaviour is a plain function from what a [`Player`] knows to a [`Decision`]; one system a
//! behaviour fetches and stores.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::borrow::Cow;

pub mod aiming;
pub mod at_hand;
pub mod attack;
pub mod chaser;
pub mod giving_way;
pub mod hearing;
pub mod keeper;
pub mod kicking;
pub mod looked_around;
pub mod looking;
pub mod lookout;
pub mod obeying;
pub mod options;
pub mod passer;
pub mod passing;
pub mod penalty_kicks;
pub mod player;
pub mod roles;
pub mod striker;
pub mod supporter;
pub mod talking;
pub mod waiting;
pub mod walking;
pub mod watching;
pub mod worth;

pub use looking::{Head, look_at, search};
pub use player::{Decision, Player, PlayerMemory};

use naoisis_core::behaviour::BehaviourApp;
use naoisis_core::behaviour::drawings::{DrawColour, Drawings, Frame};
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::communication::{Inbox, Outbox, TeamMessage};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{GameState, Rules};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::Pitch;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::{HeadAngles, HeadCommand, HeadLimits};
use naoisis_core::robot::kick::{KickCommand, KickSettings};
use naoisis_core::robot::motion::{MotionLimits, WalkCommand};
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{Belief, SimpleBelief};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::field_of_view::FieldOfView;
use naoisis_sensing::sensing::latency::Latency;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::status::BodyStatus;

/// Registers the built-in behaviours and teams.
///
/// Needs the plugins of the sensors and of the [simple belief](naoisis_sensing::belief::SimpleBeliefPlugin) to be added before.
pub struct BuiltInTeamsPlugin;

impl Plugin for BuiltInTeamsPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<PlayerMemory>()
            .register_type::<Chaser>()
            .register_type::<Keeper>()
            .register_type::<Striker>()
            .register_type::<Supporter>()
            .register_type::<Passer>()
            .register_type::<PassingKeeper>()
            .add_behaviour::<Chaser, _>("chaser", play::<Chaser>)
            .add_behaviour::<Keeper, _>("keeper", play::<Keeper>)
            .add_behaviour::<Striker, _>("striker", play::<Striker>)
            .add_behaviour::<Supporter, _>("supporter", play::<Supporter>)
            .add_behaviour::<Passer, _>("passer", play::<Passer>)
            .add_behaviour::<PassingKeeper, _>("passing_keeper", play::<PassingKeeper>)
            .add_team("chasers", "Everybody goes for the ball.", |_, _| "chaser")
            .add_team(
                "roles",
                "A keeper, a striker, and supporters who take the striker's place when they are nearer to the ball.",
                |number, size| match number {
                    1 if size > 1 => "keeper",
                    0..=2 => "striker",
                    _ => "supporter",
                },
            )
            .add_team(
                "passers",
                "A keeper, and players who pass, wait where a pass can reach them, and tell each other of both.",
                |number, size| if number == 1 && size > 1 { "passing_keeper" } else { "passer" },
            );
    }
}

/// A built-in behaviour.
trait Role: Component {
    /// Decides while the ball is in play.
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision;

    /// What speaks for that decision, of a player with this memory before it.
    fn reasons(player: &Player, memory: PlayerMemory, decision: &Decision) -> Reasons;
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

/// Marks a robot that passes, and waits for passes.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Passer;

/// Marks a keeper of a team that passes.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, PlayerMemory)]
#[reflect(Component, @Knowledge::Belief)]
pub struct PassingKeeper;

impl Role for PassingKeeper {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        passer::keep(player, memory)
    }

    fn reasons(player: &Player, _memory: PlayerMemory, decision: &Decision) -> Reasons {
        keeper::reasons(player, decision)
    }
}

impl Role for Passer {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        passer::decide(player, memory)
    }

    fn reasons(player: &Player, memory: PlayerMemory, decision: &Decision) -> Reasons {
        passer::reasons(player, memory, decision)
    }
}

impl Role for Chaser {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        chaser::decide(player, memory)
    }

    fn reasons(player: &Player, _memory: PlayerMemory, decision: &Decision) -> Reasons {
        roles::reasons(player, decision)
    }
}

impl Role for Keeper {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        keeper::decide(player, memory)
    }

    fn reasons(player: &Player, _memory: PlayerMemory, decision: &Decision) -> Reasons {
        keeper::reasons(player, decision)
    }
}

impl Role for Striker {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        striker::decide(player, memory)
    }

    fn reasons(player: &Player, _memory: PlayerMemory, decision: &Decision) -> Reasons {
        roles::reasons(player, decision)
    }
}

impl Role for Supporter {
    fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
        supporter::decide(player, memory)
    }

    fn reasons(player: &Player, _memory: PlayerMemory, decision: &Decision) -> Reasons {
        roles::reasons(player, decision)
    }
}

/// What a built-in behaviour reads and writes of its robots.
#[derive(QueryData)]
#[query_data(mutable)]
struct PlayerQuery {
    id: &'static RobotId,
    belief: &'static Belief,
    estimator: &'static SimpleBelief,
    inbox: &'static Inbox,
    status: &'static GameStatus,
    body: &'static BodyStatus,
    sonar: &'static SonarReading,
    sonar_settings: &'static SonarSettings,
    limits: &'static MotionLimits,
    kicks: &'static KickSettings,
    latency: &'static Latency,
    own_body: &'static Body,
    head_limits: &'static HeadLimits,
    head_angles: &'static HeadAngles,
    cameras: &'static CameraSettings,
    memory: &'static mut PlayerMemory,
    walk: &'static mut WalkCommand,
    head: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    outbox: &'static mut Outbox,
    posture: &'static mut PostureCommand,
    drawings: &'static mut Drawings,
    reasons: Option<&'static mut Reasons>,
}

fn play<R: Role>(
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    rules: Res<Rules>,
    mut robots: Query<PlayerQuery, With<R>>,
) {
    for mut robot in &mut robots {
        let status = hearing::as_heard(robot.status, &rules, &mut robot.memory.whistles);
        let player = Player {
            id: *robot.id,
            belief: robot.belief,
            heard: &robot.inbox.0,
            status: &status,
            body: *robot.body,
            sonar: *robot.sonar,
            sonar_settings: robot.sonar_settings,
            limits: robot.limits,
            kicks: robot.kicks,
            latency: robot.latency,
            own_body: robot.own_body,
            head: Head::new(&robot.head_limits.reached_from(*robot.head_angles), FieldOfView::of(robot.cameras)),
            rolling: robot.estimator.ball.rolling,
            ball_radius_m: robot.estimator.ball.radius_m,
            pitch: &pitch,
            rules: &rules,
            period: clock.period(),
            forward: robot.belief.pose.forward(),
        };
        let memory = &mut *robot.memory;
        if player.limits.gait.is_some() {
            memory.looked_around.note(player.pose().heading + robot.head_angles.yaw, status.time_s);
        }
        let before = robot.reasons.is_some().then(|| memory.clone());
        let decision = decide_in_game(&player, memory, R::decide);
        if let (Some(reasons), Some(before)) = (&mut robot.reasons, before) {
            let decides = player.status.state == GameState::Playing && !player.status.penalised;
            **reasons = if decides { R::reasons(&player, before, &decision) } else { Reasons::default() };
        }
        *robot.walk = decision.walk;
        *robot.head = decision.head.unwrap_or_else(|| watching::watch(&player, memory, &decision.walk));
        robot.kick.0 = decision.kick;
        robot.posture.0 = decision.posture.or_else(|| obeying::posture(&player));
        draw(&mut robot.drawings, &player, memory, &decision);
        let speaks = !player.status.penalised && talking::may_speak(&player, memory, decision.pass.is_some());
        robot.outbox.0 = speaks.then(|| message(&player, &decision));
    }
}

/// Draws where the player goes, and where it wants the ball to go.
fn draw(drawings: &mut Drawings, player: &Player, memory: &PlayerMemory, decision: &Decision) {
    /// Length of the line from the ball, m.
    const AIM_M: f32 = 1.0;
    if let Some(target) = decision.target {
        drawings.target(Frame::Team, target, decision.intention, DrawColour::White);
    }
    if let (Some(ball), Some(aim), "attack" | "kick") = (player.ball(), memory.aim, decision.intention) {
        drawings.line(Frame::Team, ball.position_m, ball.position_m + AIM_M * aim, DrawColour::Yellow);
        if let Some(kick) = memory.kick {
            drawings.text(Frame::Team, ball.position_m + AIM_M * aim, kick.words(), DrawColour::Yellow);
        }
    }
}

/// What to do in any state of the game; `decide` tells it while the ball is in play.
fn decide_in_game(
    player: &Player,
    memory: &mut PlayerMemory,
    decide: impl FnOnce(&Player, &mut PlayerMemory) -> Decision,
) -> Decision {
    obeying::note_kick_off(player, memory);
    if player.status.penalised {
        return Decision { head: Some(HeadCommand::default()), intention: "wait", ..default() };
    }
    match player.status.state {
        GameState::Playing => {
            let decision = decide(player, memory);
            without_pushing(player, obeying::obey(player, memory, decision))
        }
        GameState::Ready => without_pushing(player, obeying::take_place(player)),
        GameState::Initial | GameState::Standby | GameState::Set | GameState::Finished => {
            Decision { intention: "wait", ..default() }
        }
    }
}

/// The decision without what would run into an opponent.
fn without_pushing(player: &Player, decision: Decision) -> Decision {
    // Who walks step by step cannot stop when it touches.
    let walk = match player.limits.gait {
        Some(_) => giving_way::give_way(player, decision.walk, &player.belief.opponents),
        None => decision.walk,
    };
    Decision { walk, ..decision }
}

/// What the player tells its team-mates.
fn message(player: &Player, decision: &Decision) -> TeamMessage {
    /// A ball seen within this time is worth telling of, s.
    const FRESH_BALL_S: f32 = 0.5;
    let ball = player.ball().filter(|ball| ball.heard_from.is_none() && ball.age_s < FRESH_BALL_S);
    TeamMessage {
        pose: Some(player.pose()),
        ball_m: ball.map(|ball| ball.position_m),
        robots_m: if decision.reports_opponents { player.fresh_opponents().collect() } else { Vec::new() },
        intention: Some(Cow::Borrowed(decision.intention)),
        payload: decision.pass.map(|pass| Cow::Owned(pass.to_string())),
        datagram: None,
    }
}
