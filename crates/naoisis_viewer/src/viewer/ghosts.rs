//! Ghosts: the robots and the ball of another branch of the match, translucent, on the same pitch at the same moment.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::ball_and_posts::ball_mesh;
use super::branches::Branches;
use super::overlays::{Brush, OverlaySystems};
use super::palette;
use super::part_mesh::part_material;
use super::pitch_frame::{PitchFrameSystems, PitchRoot, between, transform_of};
use super::robot_animation::GhostBody;
use super::robot_model::{RobotMeshes, add_limbs};
use super::shared::{DisplayFraction, Notice};
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// The opacity of a ghost, 0 to 1.
const COVER: f32 = 0.38;
/// The least distance between a ghost and the robot or ball itself, m. Nearer ghosts are hidden, because they would
/// flicker.
const SAME_M: f32 = 0.01;

/// Shows the [`Ghosts`].
pub struct GhostsPlugin;

impl Plugin for GhostsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Ghosts>().add_systems(
            PostUpdate,
            (
                place_ghosts.in_set(PitchFrameSystems).before(TransformSystems::Propagate),
                draw_names.after(OverlaySystems),
            ),
        );
    }
}

/// The branch whose ghosts are shown.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Ghosts {
    /// The index in the [`Branches`].
    pub of: Option<usize>,
    /// The number of visible ghosts.
    pub seen: usize,
}

/// The ghost of a robot, or of the ball.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
struct Ghost(Option<RobotId>);

/// The records of the other branch around the moment that is shown.
#[derive(Default)]
struct Read {
    of: Option<(usize, u64)>,
    now: Option<CycleRecord>,
    before: Option<CycleRecord>,
}

/// The place of a ghost.
struct Place {
    pose: Pose,
    body: Option<GhostBody>,
}

fn place_ghosts(
    mut ghosts: ResMut<Ghosts>,
    mut branches: ResMut<Branches>,
    (clock, fraction): (Res<CycleClock>, Res<DisplayFraction>),
    (roster, bodies, balls): (Res<Roster>, Query<(&Body, &Pose)>, Query<(&BallPhysics, &Pose), With<Ball>>),
    mut present: Query<(Entity, &Ghost, &mut Transform, &mut Visibility, Option<&mut GhostBody>)>,
    mut making: (
        Local<Option<Handle<StandardMaterial>>>,
        ResMut<RobotMeshes>,
        ResMut<Assets<Mesh>>,
        ResMut<Assets<StandardMaterial>>,
    ),
    (mut read, mut commands, root): (Local<Read>, Commands, Res<PitchRoot>),
    mut notice: ResMut<Notice>,
) {
    let is_other = |index: &usize| *index < branches.list().len() && *index != branches.shown();
    let Some(index) = ghosts.of.filter(is_other) else {
        if !present.is_empty() || ghosts.of.is_some() || ghosts.seen > 0 {
            present.iter().for_each(|(entity, ..)| commands.entity(entity).despawn());
            *ghosts = Ghosts::default();
            *read = Read::default();
        }
        return;
    };
    let cycle = clock.cycle;
    if read.of != Some((index, cycle)) {
        if read.of.is_none_or(|(of, _)| of != index) {
            let common = branches.common(index, branches.shown());
            if cycle <= common {
                notice
                    .tell(format!("Ghosts: both branches are the same until {:.1} s", common as f64 * clock.period_s));
            }
        }
        let before = cycle.checked_sub(1).and_then(|before| branches.bypass_change_detection().record(index, before));
        let now = branches.bypass_change_detection().record(index, cycle).filter(|record| record.cycle == cycle);
        *read = Read { of: Some((index, cycle)), now, before };
    }
    let wanted = read.now.as_ref().map(|now| places(now, read.before.as_ref(), fraction.0, &clock)).unwrap_or_default();
    let real = |who: Option<RobotId>| match who {
        Some(id) => roster.get(id).and_then(|robot| bodies.get(robot).ok()).map(|(_, pose)| *pose),
        None => balls.iter().next().map(|(_, pose)| *pose),
    };
    let mut missing: BTreeMap<Option<RobotId>, Place> = wanted;
    let mut seen = 0;
    for (entity, ghost, mut transform, mut visibility, body) in &mut present {
        let Some(place) = missing.remove(&ghost.0) else {
            visibility.set_if_neq(Visibility::Hidden);
            if ghost.0.is_some_and(|id| roster.get(id).is_none()) {
                commands.entity(entity).despawn();
            }
            continue;
        };
        let is_same = real(ghost.0).is_some_and(|real| real.position.distance(place.pose.position) < SAME_M);
        visibility.set_if_neq(if is_same { Visibility::Hidden } else { Visibility::Inherited });
        seen += usize::from(!is_same);
        transform.set_if_neq(transform_of(place.pose));
        if let (Some(mut body), Some(new)) = (body, place.body) {
            body.update(new);
        }
    }
    ghosts.set_if_neq(Ghosts { seen, ..*ghosts });
    let (material, robot_meshes, meshes, materials) = &mut making;
    for (who, place) in missing {
        let root = (ChildOf(root.0), Ghost(who), transform_of(place.pose), Visibility::Hidden);
        let entity = commands.spawn(root).id();
        let translucent = |colour: Color, materials: &mut Assets<StandardMaterial>| {
            materials.add(StandardMaterial {
                base_color: colour.with_alpha(COVER),
                alpha_mode: AlphaMode::Blend,
                ..part_material()
            })
        };
        match (who, place.body) {
            (Some(id), Some(ghost_body)) => {
                let material = material.get_or_insert_with(|| translucent(Color::WHITE, materials)).clone();
                let body = roster
                    .get(id)
                    .and_then(|robot| bodies.get(robot).ok())
                    .map_or_else(Body::default, |(body, _)| *body);
                commands.entity(entity).insert(ghost_body.with_body(body));
                add_limbs(entity, (id, &body), Some(material), robot_meshes, meshes, &mut commands);
            }
            _ => {
                let physics = balls.iter().next().map(|(physics, _)| *physics).unwrap_or_default();
                let ball = ball_mesh(&physics, meshes);
                commands.spawn((ChildOf(entity), ball, MeshMaterial3d(translucent(Color::WHITE, materials))));
            }
        }
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

/// Draws the names of the ghosts.
fn draw_names(ghosts: Query<(&Ghost, &Transform, &Visibility)>, mut brush: Brush) {
    for (ghost, transform, visibility) in &ghosts {
        if let (Some(id), true) = (ghost.0, *visibility != Visibility::Hidden) {
            let place = transform.translation.truncate();
            brush.circle(place, 0.14, palette::ink(DrawColour::White).with_alpha(0.5));
            brush.words(
                place + Vec2::Y * 0.22,
                format!("{id}, ghost"),
                palette::ink(DrawColour::White).with_alpha(0.8),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::{BallRecord, PenaltyRecord, RobotRecord};

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
