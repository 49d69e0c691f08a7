//! The systems of the referee: they fetch the input of its decisions and store the results.

use bevy::ecs::query::QueryData;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::custom_rules::CustomRules;
use super::decide::{Decisions, decide};
use super::hearing::HeardWhistles;
use super::indirect_goal::Plays;
use super::kick_off_shot::KickOffPlay;
use super::memory::RefereeMemory;
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::status::{GameStatus, SetPlayStatus};
use super::touch::touches_of_cycle;
use crate::ball::flight::BallFlight;
use crate::ball::{Ball, BallPath, BallPhysics, BallVelocity};
use crate::communication::{MessageLimits, MessageSettings, MessageStatistics};
use crate::cycle::CycleClock;
use crate::events::{CommandKind, Contacts, CycleEvents, MatchEvent, Refusal};
use crate::game::{
    Game, GameState, Intervention, Interventions, KickOffProcedure, OutsideReferee, Penalty, Rules, SetPlay,
    SetPlayKind,
};
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::body::Body;
use crate::robot::head::HeadAngles;
use crate::robot::kick::{KickCommand, KickPhase};
use crate::robot::motion::{ExecutedStep, WalkCommand};
use crate::robot::posture::Posture;
use crate::robot::request::RequestCommand;
use crate::robot::{PreviousPose, Roster, Velocity};
use crate::team::{JerseyNumbers, PerTeam, RobotId, Team};

/// Begins the match in the first cycle, before robots sense and act: robots may walk to their positions, or the ball comes into play.
pub(super) fn begin_match(
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    outside: Option<Res<OutsideReferee>>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut events: ResMut<CycleEvents>,
) {
    // A referee outside the match begins the match itself.
    if game.state != GameState::Initial || game.half > 1 || outside.is_some() {
        return;
    }
    if rules.kick_off == KickOffProcedure::ReadyAndSet && rules.initial_s > 0.0 {
        if game.state_cycles == 0 {
            events.push(MatchEvent::HalfBegins { half: game.half });
        }
        return;
    }
    game.state = match rules.kick_off {
        KickOffProcedure::Placed => GameState::Playing,
        KickOffProcedure::ReadyAndSet if rules.standby_s > 0.0 => GameState::Standby,
        KickOffProcedure::ReadyAndSet => GameState::Ready,
    };
    memory.draw_standby(&rules, &clock);
    events.push(MatchEvent::HalfBegins { half: game.half });
    events.push(MatchEvent::StateChanged { state: game.state });
    if game.state == GameState::Playing {
        game.whistles = game.whistles.saturating_add(1);
        memory.kick_off = Some(KickOffPlay::new(game.kick_off_team));
        memory.plays = Plays::after(SetPlayKind::KickOff, game.kick_off_team);
        let (team, cycles_in) = (game.kick_off_team, |seconds| u64::from(clock.cycles_in(seconds)));
        game.set_play =
            rules.kick_off_free_s.map(|free_s| SetPlay::new(SetPlayKind::KickOff, team, Vec2::ZERO, cycles_in(free_s)));
    }
}

/// The data of the match that the referee reads, besides robots and ball.
#[derive(SystemParam)]
pub(super) struct Surroundings<'w, 's> {
    clock: Res<'w, CycleClock>,
    rules: Res<'w, Rules>,
    custom_rules: Res<'w, CustomRules>,
    pitch: Res<'w, Pitch>,
    roster: Res<'w, Roster>,
    contacts: Res<'w, Contacts>,
    messages: Res<'w, MessageStatistics>,
    outside: Option<Res<'w, OutsideReferee>>,
    posts: Query<'w, 's, (&'static Pose, &'static Post), (Without<RobotId>, Without<Ball>)>,
}

/// A robot as the referee sees it, with the components that the referee can change.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct JudgedRobot {
    pose: &'static mut Pose,
    previous: &'static mut PreviousPose,
    velocity: &'static mut Velocity,
    bounds: &'static Body,
    step: &'static ExecutedStep,
    head: &'static HeadAngles,
    penalty: &'static mut Penalty,
    posture: &'static mut Posture,
    walk: &'static mut WalkCommand,
    kick: &'static mut KickCommand,
    kick_phase: &'static mut KickPhase,
}

impl JudgedRobotItem<'_, '_> {
    /// Applies the decisions of the referee about this robot.
    fn write(&mut self, before: &RobotSnapshot, after: &RobotSnapshot, keeps_posture: bool) {
        *self.penalty = after.penalty;
        let is_put_down = before.pose != after.pose;
        if is_put_down || before.is_present() && !after.is_present() {
            *self.velocity = Velocity::default();
            *self.walk = WalkCommand::default();
            *self.kick = KickCommand::default();
            *self.kick_phase = KickPhase::default();
        }
        if is_put_down {
            *self.pose = after.pose;
            self.previous.0 = after.pose;
            // A robot that is put down is put on its feet.
            if !keeps_posture {
                *self.posture = Posture::Upright;
            }
        }
    }
}

/// The ball as the referee sees it, with the components that the referee can change.
#[derive(QueryData)]
#[query_data(mutable)]
pub(super) struct JudgedBall {
    pose: &'static mut Pose,
    previous: &'static mut PreviousPose,
    velocity: &'static mut BallVelocity,
    flight: &'static mut BallFlight,
    physics: &'static BallPhysics,
    path: &'static BallPath,
}

/// The buffers of [`officiate`], kept between cycles so that a steady match allocates nothing.
#[derive(Default)]
pub(super) struct Scratch {
    entities: Vec<Entity>,
    robots: Vec<RobotSnapshot>,
    posts: Vec<Disc>,
    contacts: Vec<[usize; 2]>,
    touches: Vec<(RobotId, bool)>,
    decisions: Decisions,
}

impl Scratch {
    /// Collects robots, posts, contacts and touches of the ball.
    fn gather(&mut self, seen: &Surroundings, events: &CycleEvents, robots: Query<JudgedRobotReadOnly, With<RobotId>>) {
        self.entities.clear();
        self.robots.clear();
        for (id, entity) in seen.roster.iter() {
            let Ok(robot) = robots.get(entity) else { continue };
            self.entities.push(entity);
            self.robots.push(RobotSnapshot {
                id,
                pose: *robot.pose,
                previous: robot.previous.0,
                wanted_velocity: robot.previous.0.forward().rotate(robot.step.0.translation()) / seen.clock.period(),
                head: *robot.head,
                is_kicking: *robot.kick_phase != KickPhase::Ready,
                bounds: *robot.bounds,
                posture: *robot.posture,
                penalty: *robot.penalty,
            });
        }
        let index_of = |id: RobotId| self.robots.binary_search_by_key(&id, |robot| robot.id).ok();
        let contacts = seen.contacts.robots_in_contact();
        self.contacts.clear();
        self.contacts.extend(contacts.filter_map(|(a, b)| Some([index_of(a)?, index_of(b)?])));
        self.posts.clear();
        self.posts.extend(seen.posts.iter().map(|(pose, post)| Disc { centre: pose.position, radius: post.radius }));
        touches_of_cycle(events, seen.contacts.robots_at_ball(), &mut self.touches);
    }
}

/// Passes the requests of teams on to the referee.
pub(super) fn pass_on_requests(
    roster: Res<Roster>,
    mut interventions: ResMut<Interventions>,
    mut commands: Query<&mut RequestCommand>,
) {
    for (id, entity) in roster.iter() {
        let Ok(mut command) = commands.get_mut(entity) else { continue };
        if command.0.is_some()
            && let Some(request) = command.0.take()
        {
            let intervention = request.intervention(id);
            interventions.queue.push(intervention);
            interventions.requested.push((id, intervention));
        }
    }
}

/// Judges the cycle: gathers a snapshot, [decides](decide), and writes the decisions back.
pub(super) fn officiate(
    mut scratch: Local<Scratch>,
    surroundings: Surroundings,
    mut events: ResMut<CycleEvents>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut interventions: ResMut<Interventions>,
    mut robots: Query<JudgedRobot, With<RobotId>>,
    mut balls: Query<JudgedBall, (With<Ball>, Without<RobotId>)>,
) {
    let scratch = &mut *scratch;
    scratch.gather(&surroundings, &events, robots.as_readonly());
    interventions.fall_due(surroundings.clock.end_time_s());
    let mut ball = balls.iter_mut().next();
    let messages = &surroundings.messages;
    let snapshot = MatchSnapshot {
        clock: *surroundings.clock,
        pitch: &surroundings.pitch,
        rules: &surroundings.rules,
        game: &game,
        ball: ball.as_ref().map(|ball| BallSnapshot {
            path: &ball.path.corners,
            heights_m: &ball.path.heights_m,
            position: ball.pose.position,
            velocity: ball.velocity.0,
            radius: ball.physics.radius_m,
        }),
        robots: &scratch.robots,
        posts: &scratch.posts,
        touches: &scratch.touches,
        last_touch: memory.last_touch,
        messages_sent: PerTeam { blue: messages.blue.sent, pink: messages.pink.sent },
        interventions: &interventions.queue,
        outside: surroundings.outside.as_deref(),
        contacts: &scratch.contacts,
    };
    let decisions = &mut scratch.decisions;
    decide(&snapshot, &surroundings.custom_rules, &mut memory, decisions);

    if !interventions.queue.is_empty() {
        interventions.queue.clear();
    }
    if *game != decisions.game {
        game.clone_from(&decisions.game);
    }
    if !interventions.requested.is_empty() {
        refuse_requests(&mut interventions.requested, &mut decisions.events);
    }
    events.append(&mut decisions.events);
    if let (Some(place), Some(ball)) = (decisions.ball, &mut ball) {
        ball.pose.position = place;
        ball.previous.0 = *ball.pose;
        ball.velocity.0 = decisions.ball_velocity;
        *ball.flight = BallFlight::default();
    }
    for ((before, after), entity) in scratch.robots.iter().zip(&decisions.robots).zip(&scratch.entities) {
        if (before.pose != after.pose || before.penalty != after.penalty)
            && let Ok(mut robot) = robots.get_mut(*entity)
        {
            robot.write(before, after, decisions.moved_aside.contains(&after.id));
        }
    }
}

/// Adds an event for each robot whose request was refused. Requests are in the order in which they were decided.
fn refuse_requests(requested: &mut Vec<(RobotId, Intervention)>, events: &mut Vec<MatchEvent>) {
    let mut refused = Vec::new();
    let mut decided = events.iter().filter_map(|event| match event {
        MatchEvent::Intervention { intervention } => Some((*intervention, false)),
        MatchEvent::InterventionRefused { intervention, .. } => Some((*intervention, true)),
        _ => None,
    });
    for (robot, intervention) in requested.drain(..) {
        let decision = decided.find(|(of, _)| *of == intervention);
        if decision.is_some_and(|(_, is_refused)| is_refused) {
            refused.push(MatchEvent::CommandRefused {
                robot,
                command: CommandKind::Request,
                reason: Refusal::NotAllowed,
            });
        }
    }
    events.append(&mut refused);
}

/// Updates the [`GameStatus`] of each robot.
pub(super) fn update_status(
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    game: Res<Game>,
    memory: Res<RefereeMemory>,
    radio: Res<MessageSettings>,
    messages: Res<MessageStatistics>,
    mut robots: Query<(&RobotId, &Penalty, Option<&MessageLimits>, &HeardWhistles, &mut GameStatus)>,
) {
    let announced = memory.announcement.announced(&game);
    let set_play = announced.set_play.map(|set_play| SetPlayStatus::of(&set_play, &rules, &clock));
    let messages_left = |team: Team, own: Option<&MessageLimits>| {
        let by_the_rules = game.messages_left.map(|left| left[team]);
        let by_radio = radio.limits_with(&own.copied().unwrap_or_default()).messages_left(messages[team].sent);
        by_the_rules.into_iter().chain(by_radio).min()
    };
    // The GameController does not send the time of the whistle.
    let secondary = announced.secondary_cycles_left(&rules, &clock).filter(|_| announced.state != GameState::Set);
    let mut penalised_numbers = PerTeam::<JerseyNumbers>::default();
    for (id, ..) in robots.iter().filter(|(_, penalty, ..)| penalty.is_active()) {
        penalised_numbers[id.team].insert(id.number);
    }
    for (id, penalty, own_limits, whistles, mut status) in &mut robots {
        let record = memory.record(*id);
        *status = GameStatus {
            state: announced.state,
            score: announced.score,
            half: announced.half,
            time_left_s: announced.time_left_s(&clock),
            secondary_time_left_s: secondary.map(|cycles| (cycles as f64 * clock.period_s) as f32),
            time_s: clock.start_time_s() as f32,
            own_end: announced.own_end(id.team),
            kick_off_team: announced.kick_off_team,
            drop_ball: announced.drop_ball,
            set_play,
            goalkeeper: game.goalkeepers[id.team],
            timeouts_left: game.timeouts_left[id.team],
            messages_left: messages_left(id.team, own_limits),
            shoot_out: announced.shoot_out.map(|shoot_out| shoot_out.team),
            stopped: game.stop.is_some(),
            penalised: penalty.is_active(),
            penalty: penalty.0.map(|penalty| penalty.reason),
            penalised_numbers,
            restarts: record.map_or(0, |record| record.restarts),
            hand_placements: record.map_or(0, |record| record.hand_placements),
            whistles: whistles.heard(),
            ready_signals: game.ready_signals,
        };
    }
}
