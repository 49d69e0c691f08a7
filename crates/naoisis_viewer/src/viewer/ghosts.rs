//! Another branch, or the match before, at the same moment as the match that is shown: its robots and ball as translucent
//! ghosts on the same pitch, or opaque on a pitch of its own.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::branches::Branches;
use super::commands::Compare;
use super::ghost_models::{Coat, GhostModels};
use super::match_before::Kept;
use super::overlays::{Brush, OverlaySystems};
use super::palette;
use super::pitch_frame::{PitchFrameSystems, between, transform_of};
use super::robot_animation::GhostBody;
use super::shared::{DisplayFraction, KeysSystems, Notice, SecondPitch};
use super::theme::minutes;
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// The look of a ghost that is not on a pitch of its own.
const COVER: Coat = Coat::of_opacity(38);
/// The least distance between a ghost and the robot or ball itself, m. Nearer ghosts are hidden, because they would
/// flicker.
const SAME_M: f32 = 0.01;
/// The distance between the carpets of two pitches, m.
const BETWEEN_PITCHES_M: f32 = 1.0;

/// Shows the [`Ghosts`].
pub struct GhostsPlugin;

impl Plugin for GhostsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ghosts>()
            .init_resource::<SecondPitch>()
            .init_resource::<Kept>()
            .init_resource::<Read>()
            .add_message::<Compare>()
            .add_systems(Update, compare.after(KeysSystems))
            .add_systems(
                PostUpdate,
                (
                    (end_ghosts, read_records, place_ghosts, add_ghosts)
                        .chain()
                        .in_set(PitchFrameSystems)
                        .before(TransformSystems::Propagate),
                    draw_names.after(OverlaySystems),
                ),
            );
    }
}

/// The branch or match whose ghosts are shown.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Ghosts {
    /// The branch or match; `None` without ghosts.
    pub of: Option<GhostsOf>,
    /// Whether it has a pitch of its own.
    pub beside: bool,
    /// The number of visible ghosts.
    pub seen: usize,
}

/// A branch or match that is compared with the one that is shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GhostsOf {
    /// The index in the [`Branches`].
    Branch(usize),
    /// The match before this one.
    MatchBefore,
}

/// The ghost of a robot, or of the ball.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
struct Ghost {
    of: Option<RobotId>,
    is_opaque: bool,
}

/// The records of the other match around the moment that is shown, and the places in them that have no ghost yet.
#[derive(Resource, Default)]
struct Read {
    of: Option<(GhostsOf, u64)>,
    now: Option<CycleRecord>,
    before: Option<CycleRecord>,
    missing: BTreeMap<Option<RobotId>, Place>,
}

/// The place of a ghost.
struct Place {
    pose: Pose,
    body: Option<GhostBody>,
}

/// Shows another branch or match on a pitch of its own, or ends this.
fn compare(
    mut requests: MessageReader<Compare>,
    (mut ghosts, branches, kept): (ResMut<Ghosts>, Res<Branches>, Res<Kept>),
    (pitch, clock): (Res<Pitch>, Res<CycleClock>),
    mut notice: ResMut<Notice>,
) {
    if requests.read().count() == 0 {
        return;
    }
    if ghosts.beside {
        *ghosts = Ghosts::default();
        return;
    }
    let before = kept.stage();
    match other(ghosts.of, &branches, before.map(|(_, stage)| stage.fits(&pitch, clock.period_s))) {
        Ok(of) => {
            *ghosts = Ghosts { of: Some(of), beside: true, seen: 0 };
            let name = match (of, before) {
                (GhostsOf::MatchBefore, Some((name, _))) => name,
                (GhostsOf::Branch(index), _) => branches.list().get(index).map_or("", |branch| &branch.name),
                _ => "",
            };
            notice.tell(format!("Behind this match, at the same time: {name}. Z: ends it"));
        }
        Err(message) => notice.tell(message),
    }
}

/// Chooses what to compare the match with: the one that has ghosts, or else the match before, or else the last other
/// branch. `before` is whether there is a match before, and whether it was played on the same pitch with the same cycle.
fn other(ghosts: Option<GhostsOf>, branches: &Branches, before: Option<bool>) -> Result<GhostsOf, &'static str> {
    let branch = (0..branches.list().len()).rev().find(|index| *index != branches.shown()).map(GhostsOf::Branch);
    let before_if_same = (before == Some(true)).then_some(GhostsOf::MatchBefore);
    ghosts.or(before_if_same).or(branch).ok_or(match before {
        Some(_) => "The match before this one was played on another pitch, or with cycles of another length",
        None => "There is nothing to compare with: branch this match (F), or open another one; the match before is then shown, too",
    })
}

/// Ends ghosts whose branch or match is no longer there or is the one that is shown, and moves the second pitch.
fn end_ghosts(
    mut ghosts: ResMut<Ghosts>,
    (branches, kept, pitch, clock): (Res<Branches>, Res<Kept>, Res<Pitch>, Res<CycleClock>),
    present: Query<(Entity, &Ghost)>,
    (mut second, mut read): (ResMut<SecondPitch>, ResMut<Read>),
    mut commands: Commands,
) {
    let is_there = match ghosts.of {
        Some(GhostsOf::Branch(index)) => index < branches.list().len() && index != branches.shown(),
        Some(GhostsOf::MatchBefore) => kept.stage().is_some_and(|(_, stage)| stage.fits(&pitch, clock.period_s)),
        None => false,
    };
    if !is_there {
        ghosts.set_if_neq(Ghosts::default());
        if read.of.is_some() {
            *read = Read::default();
        }
    }
    let distance_m = 2.0 * pitch.carpet_half_extents().y + BETWEEN_PITCHES_M;
    second.set_if_neq(SecondPitch(ghosts.beside.then_some(distance_m)));
    for (entity, _) in present.iter().filter(|(_, ghost)| ghosts.of.is_none() || ghost.is_opaque != ghosts.beside) {
        commands.entity(entity).despawn();
    }
}

/// Reads the records of the other match for the moment that is shown.
fn read_records(
    ghosts: Res<Ghosts>,
    (mut branches, mut kept): (ResMut<Branches>, ResMut<Kept>),
    (clock, fraction): (Res<CycleClock>, Res<DisplayFraction>),
    mut read: ResMut<Read>,
    mut notice: ResMut<Notice>,
) {
    let Some(of) = ghosts.of else { return };
    let last = match of {
        GhostsOf::Branch(index) => branches.list().get(index).map(|branch| branch.last_cycle),
        GhostsOf::MatchBefore => kept.last_cycle(),
    };
    // On a pitch of its own, a match that has ended stands at its end.
    let cycle = if ghosts.beside { clock.cycle.min(last.unwrap_or_default()) } else { clock.cycle };
    if read.of != Some((of, cycle)) {
        if let GhostsOf::Branch(index) = of
            && read.of.is_none_or(|(before, _)| before != of)
            && cycle <= branches.common(index, branches.shown())
        {
            let common_s = branches.common(index, branches.shown()) as f64 * clock.period_s;
            let (what, end) = if ghosts.beside { ("Behind this match", ". Z: ends it") } else { ("Ghosts", "") };
            notice.tell(format!("{what}: both branches are the same until {common_s:.1} s{end}"));
        }
        if last.is_some_and(|last| cycle > last) && read.of.is_none_or(|(other, at)| other != of || Some(at) <= last) {
            let end = minutes((last.unwrap_or_default() as f64 * clock.period_s) as f32);
            notice.tell(format!("Ghosts: the other match ends at {end}"));
        }
        let mut record = |cycle| match of {
            GhostsOf::Branch(index) => branches.bypass_change_detection().record(index, cycle),
            GhostsOf::MatchBefore => kept.bypass_change_detection().record(cycle),
        };
        let before = cycle.checked_sub(1).and_then(&mut record);
        let now = record(cycle).filter(|record| record.cycle == cycle);
        *read = Read { of: Some((of, cycle)), now, before, ..default() };
    }
    let places = |now| places(now, read.before.as_ref(), fraction.0, &clock);
    read.missing = read.now.as_ref().map(places).unwrap_or_default();
}

/// Moves the ghosts that are there.
fn place_ghosts(
    (mut ghosts, second, mut read): (ResMut<Ghosts>, Res<SecondPitch>, ResMut<Read>),
    (roster, poses, balls): (Res<Roster>, Query<&Pose>, Query<&Pose, With<Ball>>),
    mut present: Query<(&Ghost, &mut Transform, &mut Visibility, Option<&mut GhostBody>)>,
) {
    let real = |of: Option<RobotId>| match of {
        Some(id) => roster.get(id).and_then(|robot| poses.get(robot).ok()).copied(),
        None => balls.iter().next().copied(),
    };
    let mut seen = 0;
    for (ghost, mut transform, mut visibility, body) in &mut present {
        let Some(place) = read.missing.remove(&ghost.of) else {
            visibility.set_if_neq(Visibility::Hidden);
            continue;
        };
        let is_near = |real: Pose| real.position.distance(place.pose.position) < SAME_M;
        let is_same = second.0.is_none() && real(ghost.of).is_some_and(is_near);
        visibility.set_if_neq(if is_same { Visibility::Hidden } else { Visibility::Inherited });
        seen += usize::from(!is_same);
        let mut shown = transform_of(place.pose);
        shown.translation.y += second.0.unwrap_or_default();
        transform.set_if_neq(shown);
        if let (Some(mut body), Some(new)) = (body, place.body) {
            body.update(new);
        }
    }
    ghosts.set_if_neq(Ghosts { seen, ..*ghosts });
}

/// Adds the ghosts that are not there yet.
fn add_ghosts(
    (ghosts, kept, mut read): (Res<Ghosts>, Res<Kept>, ResMut<Read>),
    (roster, bodies, balls): (Res<Roster>, Query<&Body>, Query<&BallPhysics>),
    mut models: GhostModels,
) {
    let is_opaque = ghosts.beside;
    let coat = if is_opaque { Coat::OPAQUE } else { COVER };
    for (of, place) in core::mem::take(&mut read.missing) {
        let robot = of.zip(place.body).map(|(id, ghost_body)| {
            let here = || roster.get(id).and_then(|robot| bodies.get(robot).ok()).copied();
            let there = kept.stage().filter(|_| ghosts.of == Some(GhostsOf::MatchBefore));
            let there = there.and_then(|(_, stage)| stage.bodies.get(&id).copied());
            ghost_body.with_body(there.or_else(here).unwrap_or_default())
        });
        let ball = balls.iter().next().copied().unwrap_or_default();
        models.add(Ghost { of, is_opaque }, place.pose, robot, ball, coat);
    }
}

/// The places of all robots on the pitch and of the ball, interpolated between two records.
fn places(
    now: &CycleRecord,
    before: Option<&CycleRecord>,
    fraction: f32,
    clock: &CycleClock,
) -> BTreeMap<Option<RobotId>, Place> {
    let mut places = BTreeMap::new();
    for robot in now.robots.iter().filter(|robot| robot.penalised.is_none()) {
        let earlier = before.and_then(|before| before.robot(robot.id)).map_or(robot.pose, |earlier| earlier.pose);
        let pose = between(earlier, robot.pose, fraction, clock.period());
        let body = GhostBody::new(robot.id, robot.pose, robot.velocity, robot.head, robot.posture);
        places.insert(Some(robot.id), Place { pose, body: Some(body) });
    }
    if let Some(ball) = now.ball {
        let at = |ball: naoisis_sim::interface::cycle_record::BallRecord| Pose {
            position: ball.position_m.truncate(),
            heading: 0.0,
        };
        let earlier = before.and_then(|before| before.ball).map_or(at(ball), at);
        places.insert(None, Place { pose: between(earlier, at(ball), fraction, clock.period()), body: None });
    }
    places
}

/// Draws the names of the ghosts, and the score above a second pitch.
fn draw_names(
    ghosts: Query<(&Ghost, &Transform, &Visibility)>,
    (second, read, pitch): (Res<SecondPitch>, Res<Read>, Res<Pitch>),
    mut brush: Brush,
) {
    let white = palette::ink(DrawColour::White);
    for (ghost, transform, visibility) in &ghosts {
        if let (Some(id), true) = (ghost.of, *visibility != Visibility::Hidden) {
            let place = transform.translation.truncate();
            if ghost.is_opaque {
                brush.words(place + Vec2::Y * 0.22, id.to_string(), white.with_alpha(0.8));
                continue;
            }
            brush.circle(place, 0.14, white.with_alpha(0.5));
            brush.words(place + Vec2::Y * 0.22, format!("{id}, ghost"), white.with_alpha(0.8));
        }
    }
    if let (Some(distance_m), Some(record)) = (second.0, &read.now) {
        let score = &record.game.score;
        let above = Vec2::new(0.0, distance_m + pitch.carpet_half_extents().y);
        let at = minutes(record.time_s as f32);
        brush.words(above, format!("the other match, {at}: {} : {}", score.blue, score.pink), white);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::{BallRecord, PenaltyRecord, RobotRecord};

    #[test]
    fn the_match_is_compared_with_what_has_ghosts_or_with_the_match_before() {
        let none = Branches::default();
        assert_eq!(other(None, &none, Some(true)), Ok(GhostsOf::MatchBefore));
        assert_eq!(other(Some(GhostsOf::Branch(2)), &none, Some(true)), Ok(GhostsOf::Branch(2)));
        assert!(other(None, &none, Some(false)).unwrap_err().contains("another pitch"));
        assert!(other(None, &none, None).unwrap_err().contains("nothing to compare"));
    }

    #[test]
    fn ghosts_are_between_two_records_and_penalised_robots_have_none() {
        let [one, two] = [RobotId::new(Team::Blue, 1), RobotId::new(Team::Pink, 1)];
        let record = |x: f32| {
            let penalised = Some(PenaltyRecord { reason: naoisis_core::game::PenaltyReason::Manual, time_left_s: 1.0 });
            CycleRecord {
                robots: vec![
                    RobotRecord { pose: Pose::new(x, 0.0, 0.0), ..RobotRecord::new(one) },
                    RobotRecord { penalised, ..RobotRecord::new(two) },
                ],
                ball: Some(BallRecord { position_m: Vec3::new(2.0 * x, 0.0, 0.0), velocity_mps: Vec3::ZERO }),
                ..default()
            }
        };
        let clock = CycleClock::default();
        let places = places(&record(0.1), Some(&record(0.0)), 0.5, &clock);
        assert_eq!(places.keys().copied().collect::<Vec<_>>(), [None, Some(one)]);
        assert!((places[&Some(one)].pose.position.x - 0.05).abs() < 1e-6);
        assert!((places[&None].pose.position.x - 0.1).abs() < 1e-6);
    }
}
