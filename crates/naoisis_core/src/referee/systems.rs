//! The systems of the referee: they fetch what it sees and store what it decides.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use super::decide::{Decisions, decide};
use super::kick_off_shot::KickOffPlay;
use super::memory::RefereeMemory;
use super::own_rules::OwnRules;
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::status::{GameStatus, SetPlayStatus};
use super::touch::touches_of_cycle;
use crate::ball::{Ball, BallPath, BallPhysics, BallVelocity};
use crate::collision::Contacts;
use crate::communication::{MessageLimits, MessageSettings, MessageStatistics};
use crate::cycle::CycleClock;
use crate::events::{CycleEvents, MatchEvent};
use crate::game::{
    Game, GameState, Interventions, KickOffProcedure, OutsideReferee, Penalty, Rules, SetPlay, SetPlayKind,
};
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::body::Body;
use crate::robot::head::HeadAngles;
use crate::robot::kick::{KickCommand, KickPhase};
use crate::robot::motion::{ExecutedStep, WalkCommand};
use crate::robot::posture::Posture;
use crate::robot::{PreviousPose, Roster, Velocity};
use crate::team::{PerTeam, RobotId, Team};

/// The match begins: in the first cycle, before anybody senses or acts, the robots may walk to their places, or the
/// ball comes into play.
pub(super) fn begin_match(
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    outside: Option<Res<OutsideReferee>>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut events: ResMut<CycleEvents>,
) {
    // Who decides from outside begins it, too.
    if game.state != GameState::Initial || outside.is_some() {
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
        game.whistles += 1;
        memory.kick_off = Some(KickOffPlay::new(game.kick_off_team));
        let (team, cycles_in) = (game.kick_off_team, |seconds| u64::from(clock.cycles_in(seconds)));
        game.set_play =
            rules.kick_off_free_s.map(|free_s| SetPlay::new(SetPlayKind::KickOff, team, Vec2::ZERO, cycles_in(free_s)));
    }
}

/// What [`officiate`] works with, kept between cycles so that a steady match allocates nothing.
#[derive(Default)]
pub(super) struct Scratch {
    entities: Vec<Entity>,
    robots: Vec<RobotSnapshot>,
    posts: Vec<Disc>,
    contacts: Vec<[usize; 2]>,
    touches: Vec<(RobotId, bool)>,
    decisions: Decisions,
}

/// A robot as the referee sees it, and what it can do to it.
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

pub(super) fn officiate(
    mut scratch: Local<Scratch>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    own_rules: Res<OwnRules>,
    pitch: Res<Pitch>,
    roster: Res<Roster>,
    contacts: Res<Contacts>,
    messages: Res<MessageStatistics>,
    outside: Option<Res<OutsideReferee>>,
    mut events: ResMut<CycleEvents>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut interventions: ResMut<Interventions>,
    posts: Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
    mut robots: Query<JudgedRobot, With<RobotId>>,
    mut balls: Query<
        (&mut Pose, &mut PreviousPose, &mut BallVelocity, &BallPhysics, &BallPath),
        (With<Ball>, Without<RobotId>),
    >,
) {
    let Scratch { entities, robots: seen, posts: discs, contacts: pairs, touches, decisions } = &mut *scratch;
    entities.clear();
    seen.clear();
    for (id, entity) in roster.iter() {
        let Ok(robot) = robots.get(entity) else { continue };
        entities.push(entity);
        seen.push(RobotSnapshot {
            id,
            pose: *robot.pose,
            previous: robot.previous.0,
            wanted_velocity: robot.previous.0.forward().rotate(robot.step.0.translation()) / clock.period(),
            head: *robot.head,
            is_kicking: *robot.kick_phase != KickPhase::Ready,
            bounds: *robot.bounds,
            posture: *robot.posture,
            penalty: *robot.penalty,
        });
    }
    let index_of = |id: RobotId| seen.binary_search_by_key(&id, |robot| robot.id).ok();
    pairs.clear();
    pairs.extend(contacts.robots_in_contact().filter_map(|(a, b)| Some([index_of(a)?, index_of(b)?])));
    discs.clear();
    discs.extend(posts.iter().map(|(pose, post)| Disc { centre: pose.position, radius: post.radius }));
    touches_of_cycle(&events, contacts.robots_at_ball(), touches);
    interventions.fall_due(clock.end_time_s());
    let mut balls = balls.iter_mut();
    let mut ball = balls.next();
    let snapshot = MatchSnapshot {
        clock: *clock,
        pitch: &pitch,
        rules: &rules,
        game: &game,
        ball: ball.as_ref().map(|(pose, _, velocity, physics, path)| BallSnapshot {
            path: &path.corners,
            position: pose.position,
            velocity: velocity.0,
            radius: physics.radius_m,
        }),
        robots: seen,
        posts: discs,
        touches,
        last_touch: memory.last_touch,
        messages_sent: PerTeam { blue: messages.blue.sent, pink: messages.pink.sent },
        interventions: &interventions.queue,
        outside: outside.as_deref(),
        contacts: pairs,
    };
    decide(&snapshot, &own_rules, &mut memory, decisions);

    if !interventions.queue.is_empty() {
        interventions.queue.clear();
    }
    if *game != decisions.game {
        game.clone_from(&decisions.game);
    }
    events.append(&mut decisions.events);
    if let (Some(place), Some((pose, previous, velocity, ..))) = (decisions.ball, &mut ball) {
        pose.position = place;
        previous.0 = **pose;
        velocity.0 = decisions.ball_velocity;
    }
    for ((before, after), entity) in seen.iter().zip(&decisions.robots).zip(entities) {
        if before.pose == after.pose && before.penalty == after.penalty {
            continue;
        }
        let Ok(mut robot) = robots.get_mut(*entity) else { continue };
        *robot.penalty = after.penalty;
        let is_put_down = before.pose != after.pose;
        if is_put_down || before.is_present() && !after.is_present() {
            *robot.velocity = Velocity::default();
            *robot.walk = WalkCommand::default();
            *robot.kick = KickCommand::default();
            *robot.kick_phase = KickPhase::default();
        }
        if is_put_down {
            *robot.pose = after.pose;
            robot.previous.0 = after.pose;
            // Whoever is put down is put on its feet.
            *robot.posture = Posture::Upright;
        }
    }
}

/// Tells the robots the state of the game, as far as they may know it yet.
pub(super) fn tell_status(
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    game: Res<Game>,
    memory: Res<RefereeMemory>,
    radio: Res<MessageSettings>,
    messages: Res<MessageStatistics>,
    mut robots: Query<(&RobotId, &Penalty, Option<&MessageLimits>, &mut GameStatus)>,
) {
    let told = memory.announcement.told(&game);
    let set_play = told.set_play.map(|set_play| SetPlayStatus::told_of(&set_play, &rules, &clock));
    let messages_left = |team: Team, own: Option<&MessageLimits>| {
        let by_the_rules = game.messages_left.map(|left| left[team]);
        let by_radio = radio.limits_with(own.unwrap_or(&radio.robots)).messages_left(messages[team].sent);
        by_the_rules.into_iter().chain(by_radio).min()
    };
    // When the whistle comes, nobody is told.
    let secondary = told.secondary_cycles_left(&rules, &clock).filter(|_| told.state != GameState::Set);
    for (id, penalty, own_limits, mut status) in &mut robots {
        let record = memory.record(*id);
        *status = GameStatus {
            state: told.state,
            score: told.score,
            half: told.half,
            time_left_s: told.time_left_s(&clock),
            secondary_time_left_s: secondary.map(|cycles| (cycles as f64 * clock.period_s) as f32),
            time_s: clock.start_time_s() as f32,
            own_end: told.own_end(id.team),
            kick_off_team: told.kick_off_team,
            drop_ball: told.drop_ball,
            set_play,
            messages_left: messages_left(id.team, own_limits),
            shoot_out: told.shoot_out.map(|shoot_out| shoot_out.team),
            penalised: penalty.is_active(),
            penalty: penalty.0.map(|penalty| penalty.reason),
            restarts: record.map_or(0, |record| record.restarts),
            hand_placements: record.map_or(0, |record| record.hand_placements),
            whistles: game.whistles,
            ready_signals: game.ready_signals,
        };
    }
}
