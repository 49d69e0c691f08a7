//! The built-in teams: `chasers`, in which every player goes for the ball; `roles`, with a keeper, a striker and
//! supporters; and `passers`, who pass and tell each other their plans and what they see.
//!
//! The players decide from their [`Belief`], which the [simple estimator](naoisis_sensing::belief::simple) computes from the sensors,
//! and from the [`GameStatus`]. Each behaviour is a plain function from a `Player` to a `Decision`; one system per behaviour fetches
//! the player and stores the decision.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::borrow::Cow;

mod aiming;
mod at_hand;
mod attack;
mod chaser;
mod dribbling;
mod gaze_history;
mod gaze_obstacles;
mod gaze_search;
mod gaze_walking;
mod giving_way;
mod hearing;
mod keeper;
mod kick_off;
mod kick_plan;
mod kicking;
mod needs;
mod obstacles;
mod options;
mod passer;
mod passing;
mod penalty_kicks;
mod player;
mod player_steps;
mod positioning;
mod roles;
mod rule_limits;
mod searching;
mod striker;
mod talking;
mod walk_limits;
mod walking;
mod worth;

pub use gaze_search::{Head, look_at, search};

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
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::{MotionSettings, WalkCommand};
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{Belief, SimpleBelief};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::field_of_view::FieldOfView;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::status::BodyStatus;
use player::{Decision, Player, PlayerMemory};

/// Registers the built-in behaviours and teams.
///
/// Add the plugins of the sensors and of the [simple belief](naoisis_sensing::belief::SimpleBeliefPlugin) first.
pub struct BuiltInTeamsPlugin;

impl Plugin for BuiltInTeamsPlugin {
    fn build(&self, app: &mut App) {
        if !needs::are_met(app) {
            return;
        }
        app.register_type::<PlayerMemory>();
        let chaser = Task(chaser::decide, chaser::reasons);
        let [striker, keeper] = [Task(striker::decide, roles::reasons), Task(keeper::decide, keeper::reasons)];
        let [passer, passing_keeper] =
            [Task(passer::decide, passer::reasons), Task(passer::keep, passer::reasons_of_keeper)];
        add_role::<Chaser>(app, "chaser", chaser, [chaser, chaser]);
        add_role::<Keeper>(app, "keeper", keeper, [striker, keeper]);
        add_role::<Striker>(app, "striker", striker, [striker, keeper]);
        add_role::<Supporter>(app, "supporter", striker, [striker, keeper]);
        add_role::<Passer>(app, "passer", passer, [passer, passing_keeper]);
        add_role::<PassingKeeper>(app, "passing_keeper", passing_keeper, [passer, passing_keeper]);
        app.add_team("chasers", "Everybody goes for the ball.", |_, _| "chaser")
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

/// Decides for a player while the ball is in play.
type Decide = fn(&Player, &mut PlayerMemory) -> Decision;

/// Explains the decision of a player that had this memory before.
type Explain = fn(&Player, PlayerMemory, &Decision) -> Reasons;

/// How a player decides, and how it explains that.
#[derive(Clone, Copy)]
struct Task(Decide, Explain);

/// Registers a behaviour of this name for the robots with the marker `Role`: its `own` task, and those of a player and of the goalkeeper
/// of its team, for two that have changed places by a substitution.
fn add_role<Role: Component + Default + bevy::reflect::GetTypeRegistration>(
    app: &mut App,
    name: &str,
    own: Task,
    changed: [Task; 2],
) {
    app.register_type::<Role>().add_behaviour::<Role, _>(
        name,
        move |clock: Res<CycleClock>, pitch: Res<Pitch>, rules: Res<Rules>, robots: Query<PlayerQuery, With<Role>>| {
            play(&clock, &pitch, &rules, robots, own, changed);
        },
    );
}

macro_rules! roles {
    ($($(#[$doc:meta])* $role:ident)*) => {$(
        $(#[$doc])*
        #[derive(Component, Clone, Copy, Default, Debug, Reflect)]
        #[require(Belief, SimpleBelief, PlayerMemory)]
        #[reflect(Component, @Knowledge::Belief)]
        pub struct $role;
    )*};
}

roles! {
    /// Marks a robot that goes for the ball.
    Chaser
    /// Marks a robot that keeps the goal.
    Keeper
    /// Marks a robot that attacks.
    Striker
    /// Marks a robot that supports the attack. Like a [`Striker`], it attacks when it is the nearest to the ball.
    Supporter
    /// Marks a robot that passes, and waits for passes.
    Passer
    /// Marks the keeper of a team that passes.
    PassingKeeper
}

/// The components that a built-in behaviour reads and writes.
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
    motion: &'static MotionSettings,
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

/// Lets these robots decide, and stores their commands, drawings and messages.
fn play<Role: Component>(
    clock: &CycleClock,
    pitch: &Pitch,
    rules: &Rules,
    mut robots: Query<PlayerQuery, With<Role>>,
    own: Task,
    [field_player, goalkeeper]: [Task; 2],
) {
    for mut robot in &mut robots {
        robot.memory.whistles.note_mates(&robot.inbox.0);
        let status = hearing::as_heard(robot.status, rules, &mut robot.memory.whistles);
        let player = Player {
            id: *robot.id,
            belief: robot.belief,
            heard: &robot.inbox.0,
            status: &status,
            body: *robot.body,
            sonar: *robot.sonar,
            sonar_settings: robot.sonar_settings,
            motion: robot.motion,
            kicks: robot.kicks,
            latency: robot.latency,
            own_body: robot.own_body,
            head: Head::new(&robot.head_limits.reached_from(*robot.head_angles), FieldOfView::of(robot.cameras)),
            rolling: robot.estimator.ball.rolling,
            ball_radius_m: robot.estimator.ball.radius_m,
            pitch,
            rules,
            period: clock.period(),
            forward: robot.belief.pose.forward(),
        };
        let Task(decide, explain) = match status.goalkeeper {
            Some(_) if player.is_goalkeeper(player.id) => goalkeeper,
            Some(_) if player.id.is_goalkeeper() => field_player,
            _ => own,
        };
        let memory = &mut *robot.memory;
        if player.motion.gait.is_some() {
            memory.looked_around.note(player.pose().heading + robot.head_angles.yaw, status.time_s);
        }
        roles::note_attackers(&player, memory);
        let before = robot.reasons.is_some().then(|| memory.clone());
        let decision = decide_in_game(&player, memory, decide);
        if let (Some(reasons), Some(before)) = (&mut robot.reasons, before) {
            let decides = player.status.state == GameState::Playing && !player.status.penalised;
            **reasons = if decides { explain(&player, before, &decision) } else { Reasons::default() };
        }
        memory.walks =
            walking::reckoned_velocity(memory.walks, &decision.walk, player.body, player.motion, player.period);
        *robot.walk = decision.walk;
        *robot.head = decision.head.unwrap_or_else(|| gaze_walking::watch(&player, memory, &decision.walk));
        robot.kick.0 = decision.kick;
        robot.posture.0 = decision.posture.or_else(|| rule_limits::posture(&player));
        draw(&mut robot.drawings, &player, memory, &decision);
        let sends = !player.status.penalised && talking::may_send(&player, memory, talking::longest_pause_s(&decision));
        robot.outbox.0 = sends.then(|| message(&player, &decision));
    }
}

/// Draws the place that the player walks to, and the direction in which it wants to kick the ball.
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

/// Returns the decision in any state of the game: that of `decide` while the ball is in play.
fn decide_in_game(player: &Player, memory: &mut PlayerMemory, decide: Decide) -> Decision {
    kick_off::note_kick_off(player, memory);
    if player.status.penalised {
        return Decision { head: Some(HeadCommand::default()), intention: "wait", ..default() };
    }
    match player.status.state {
        _ if player.status.stopped => Decision { intention: "wait", ..default() },
        GameState::Playing => {
            let decision = decide(player, memory);
            without_pushing(player, rule_limits::apply(player, memory, decision))
        }
        GameState::Ready => without_pushing(player, kick_off::take_place(player)),
        GameState::Initial | GameState::Standby | GameState::Set | GameState::Timeout | GameState::Finished => {
            Decision { intention: "wait", ..default() }
        }
    }
}

/// Removes from a decision what would walk into an opponent, for robots with a gait.
fn without_pushing(player: &Player, decision: Decision) -> Decision {
    // A robot that walks step by step cannot stop at the moment of contact.
    let walk = match player.motion.gait {
        Some(_) => giving_way::give_way(player, decision.walk, &player.belief.opponents),
        None => decision.walk,
    };
    Decision { walk, ..decision }
}

/// Returns the message that the player sends to its team-mates.
fn message(player: &Player, decision: &Decision) -> TeamMessage {
    /// A ball is reported if it was seen within this time, s.
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
