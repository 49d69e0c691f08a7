//! The systems of the referee: they fetch what it sees and store what it decides.

use bevy::prelude::*;

use super::decide::{Decisions, decide};
use super::kick_off_shot::KickOffPlay;
use super::memory::RefereeMemory;
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::status::Announcement;
use super::touch::touches_of_cycle;
use crate::ball::{Ball, BallPath, BallPhysics, BallVelocity};
use crate::collision::Contacts;
use crate::cycle::CycleClock;
use crate::events::{CycleEvents, MatchEvent};
use crate::game::{Game, GameState, Interventions, KickOffProcedure, Penalty, Rules, SetPlay, SetPlayKind};
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::body::BodyBounds;
use crate::robot::head::HeadAngles;
use crate::robot::kick::{KickCommand, KickPhase};
use crate::robot::motion::{ExecutedStep, WalkCommand};
use crate::robot::posture::Posture;
use crate::robot::{PreviousPose, Roster, Velocity};
use crate::team::RobotId;

/// The match begins: in the first cycle, before anybody senses or acts, the robots may walk to their places, or the
/// ball comes into play.
pub(super) fn begin_match(
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut events: ResMut<CycleEvents>,
) {
    if game.state != GameState::Initial {
        return;
    }
    game.state = match rules.kick_off {
        KickOffProcedure::Placed => GameState::Playing,
        KickOffProcedure::ReadyAndSet => GameState::Ready,
    };
    events.push(MatchEvent::HalfBegins { half: game.half });
    events.push(MatchEvent::StateChanged { state: game.state });
    if game.state == GameState::Playing {
        game.whistles += 1;
        memory.kick_off = Some(KickOffPlay::new(game.kick_off_team));
        let (team, cycles_in) = (game.kick_off_team, |seconds| u64::from(clock.cycles_in(seconds)));
        game.set_play =
            rules.kick_off_free_s.map(|free_s| SetPlay::new(SetPlayKind::KickOff, team, Vec2::ZERO, cycles_in(free_s)));
    }
    memory.announcement = Announcement::of(&game);
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

pub(super) fn officiate(
    mut scratch: Local<Scratch>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    pitch: Res<Pitch>,
    roster: Res<Roster>,
    contacts: Res<Contacts>,
    mut events: ResMut<CycleEvents>,
    mut game: ResMut<Game>,
    mut memory: ResMut<RefereeMemory>,
    mut interventions: ResMut<Interventions>,
    posts: Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
    mut robots: Query<
        (
            (&mut Pose, &mut PreviousPose, &mut Velocity, &BodyBounds, &ExecutedStep, &HeadAngles),
            (&mut Penalty, &mut Posture, &mut WalkCommand, &mut KickCommand, &mut KickPhase),
        ),
        With<RobotId>,
    >,
    mut balls: Query<
        (&mut Pose, &mut PreviousPose, &mut BallVelocity, &BallPhysics, &BallPath),
        (With<Ball>, Without<RobotId>),
    >,
) {
    let Scratch { entities, robots: seen, posts: discs, contacts: pairs, touches, decisions } = &mut *scratch;
    entities.clear();
    seen.clear();
    for (id, entity) in roster.iter() {
        let Ok(((pose, previous, _, bounds, step, head), (penalty, posture, _, _, phase))) = robots.get(entity) else {
            continue;
        };
        entities.push(entity);
        seen.push(RobotSnapshot {
            id,
            pose: *pose,
            previous: previous.0,
            wanted_velocity: previous.0.forward().rotate(step.0.translation()) / clock.period(),
            head: *head,
            is_kicking: *phase != KickPhase::Ready,
            bounds: *bounds,
            posture: *posture,
            penalty: *penalty,
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
        interventions: &interventions.queue,
        contacts: pairs,
    };
    decide(&snapshot, &mut memory, decisions);

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
        if before == after {
            continue;
        }
        let Ok(((mut pose, mut previous, mut velocity, ..), (mut penalty, mut posture, mut walk, mut kick, mut phase))) =
            robots.get_mut(*entity)
        else {
            continue;
        };
        *penalty = after.penalty;
        if before.pose != after.pose {
            *pose = after.pose;
            previous.0 = after.pose;
            *velocity = Velocity::default();
            *walk = WalkCommand::default();
            *kick = KickCommand::default();
            *phase = KickPhase::default();
            // Whoever is put down is put on its feet.
            *posture = Posture::Upright;
        }
    }
}
