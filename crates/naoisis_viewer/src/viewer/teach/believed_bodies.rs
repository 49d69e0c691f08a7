//! The bodies in the world of one robot: the robot itself, other robots and the ball, where it believes them to be.
//!
//! A robot knows its own head, legs and posture, so its model has them. Beliefs have no headings and postures of other robots: these
//! stand upright and face the believed ball or, without one, the goal that their team attacks. The images of robots' cameras have a
//! renderer of their own, without these bodies; in the window's view through a robot's camera they are hidden, too.

use bevy::prelude::*;
use core::f32::consts::PI;

use crate::viewer::camera::{CameraMode, ViewerCamera};
use crate::viewer::ghost_models::{Coat, GhostModels};
use crate::viewer::overlays::{SEEN_LATELY_S, faded};
use crate::viewer::pitch_frame::{between, transform_of};
use crate::viewer::robot_animation::GhostBody;
use crate::viewer::shared::{DisplayFraction, RobotsWorld, Selection};
use naoisis_core::ball::BallPhysics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_core::geometry::{Pose, angle_of};
use naoisis_core::pitch::End;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{Belief, RobotBelief, pitch_from_team};

/// The opacity of another robot, or of a ball out of sight, when it was seen just now, in steps of [`STEP_PERCENT`].
const COVER_STEPS: u8 = 8;
/// The steps of opacities, %. There is one material for each.
const STEP_PERCENT: u8 = 10;
const TINTS: [Option<Team>; 3] = [None, Some(Team::Blue), Some(Team::Pink)];
/// The number of robots that are known by their team only; it is not written on models.
const UNKNOWN: u8 = 0;

/// The number of bodies that are drawn, the ball included.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct BelievedBodies(pub usize);

/// A believed body, and what its model depends on.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
pub(super) enum Model {
    Robot(RobotId, Body),
    Ball(BallPhysics),
}

/// The last two places of a believed body, pitch frame, so that it moves smoothly between cycles.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
pub(super) struct Motion {
    cycle: u64,
    from: Pose,
    to: Pose,
}

impl Motion {
    fn at(cycle: u64, pose: Pose) -> Self {
        Self { cycle, from: pose, to: pose }
    }

    /// The motion to the pose in a cycle. After a jump in time, the body is there at once.
    fn on_to(self, cycle: u64, pose: Pose) -> Self {
        match cycle.checked_sub(self.cycle) {
            Some(0) => Self { to: pose, ..self },
            Some(1) => Self { cycle, from: self.to, to: pose },
            _ => Self::at(cycle, pose),
        }
    }
}

/// A body in the world of a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Place {
    /// The robot, whose number may be [`UNKNOWN`]; `None` for the ball.
    of: Option<RobotId>,
    /// Pitch frame.
    pose: Pose,
    coat: Coat,
}

/// Whether bodies must be shown or removed.
pub(super) fn is_needed(world: Res<RobotsWorld>) -> bool {
    world.0 || world.is_changed()
}

/// The robots that are there.
type Robots<'w, 's> = Query<
    'w,
    's,
    (
        (&'static RobotId, Option<&'static Belief>, &'static Body),
        (&'static Pose, &'static Velocity, &'static HeadAngles, &'static Posture),
    ),
>;

/// The bodies that are drawn.
type Present<'w, 's> = Query<
    'w,
    's,
    (
        (Entity, &'static Model, &'static Children, &'static mut Motion),
        (&'static mut Transform, &'static mut Visibility, Option<&'static mut GhostBody>),
    ),
>;

/// Draws the believed bodies of the selected robot, and removes them when the truth is shown again. Bodies that are not needed in a
/// cycle are hidden until then.
pub(super) fn show(
    (world, selection, roster, game): (Res<RobotsWorld>, Res<Selection>, Res<Roster>, Res<Game>),
    (clock, fraction): (Res<CycleClock>, Res<DisplayFraction>),
    cameras: Query<&ViewerCamera>,
    (robots, balls): (Robots, Query<&BallPhysics>),
    mut present: Present,
    mut materials: Query<&mut MeshMaterial3d<StandardMaterial>>,
    mut models: GhostModels,
    mut drawn: ResMut<BelievedBodies>,
) {
    if !world.0 {
        for ((entity, ..), _) in &present {
            models.commands.entity(entity).despawn();
        }
        drawn.0 = 0;
        return;
    }
    if world.is_changed() {
        // A material that is new in a frame is not drawn in it, so there are all of them from the beginning.
        for (steps, tint) in (1..=COVER_STEPS).flat_map(|steps| TINTS.map(|tint| (steps, tint))) {
            models.material(Coat { opacity_percent: steps * STEP_PERCENT, tint });
        }
    }
    let is_outside = !cameras.iter().any(|camera| matches!(camera.mode, CameraMode::RobotCamera(_)));
    let whose = selection.0.filter(|_| is_outside).and_then(|id| robots.get(roster.get(id)?).ok());
    let believed = whose.and_then(|((id, belief, _), _)| Some((id, belief?)));
    let ball = balls.iter().next().copied().unwrap_or_default();
    let mut wanted: Vec<(Model, Place)> = believed
        .map(|(id, belief)| places(*id, belief, game.own_end(id.team)))
        .unwrap_or_default()
        .into_iter()
        .map(|place| (place.of.map_or(Model::Ball(ball), |id| Model::Robot(id, body_of(id, &roster, &robots))), place))
        .collect();
    let limbs_of = |of: Option<RobotId>, pose: Pose| {
        let id = of?;
        // The robot's own limbs; how others walk and look is not believed.
        let own = whose
            .filter(|((own, ..), _)| **own == id)
            .map(|(_, (pose, velocity, head, posture))| GhostBody::new(id, *pose, *velocity, *head, *posture));
        let other = || GhostBody::new(id, pose, Velocity::default(), HeadAngles::default(), Posture::Upright);
        Some(own.unwrap_or_else(other))
    };
    drawn.0 = 0;
    for ((_, model, parts, mut motion), (mut transform, mut visibility, limbs)) in &mut present {
        // Opponents are all of the same model: each goes on with the nearest place.
        let away = |place: &Place| place.pose.position.distance_squared(motion.to.position);
        let same = wanted.iter().enumerate().filter(|(_, (other, _))| other == model);
        let nearest = same.min_by(|(_, (_, one)), (_, (_, other))| away(one).total_cmp(&away(other)));
        let Some(index) = nearest.map(|(index, _)| index) else {
            visibility.set_if_neq(Visibility::Hidden);
            continue;
        };
        let (_, Place { of, pose, coat }) = wanted.remove(index);
        visibility.set_if_neq(Visibility::Inherited);
        drawn.0 += 1;
        *motion = motion.on_to(clock.cycle, pose);
        transform.set_if_neq(transform_of(between(motion.from, motion.to, fraction.0, clock.period())));
        if let (Some(mut limbs), Some(new)) = (limbs, limbs_of(of, pose)) {
            limbs.update(new);
        }
        let material = MeshMaterial3d(models.material(coat));
        let mut of_parts = materials.iter_many_mut(parts);
        while let Some(mut of_part) = of_parts.fetch_next() {
            of_part.set_if_neq(material.clone());
        }
    }
    for (model, Place { of, pose, coat }) in wanted {
        let body = |id| body_of(id, &roster, &robots);
        let robot = limbs_of(of, pose).map(|limbs| limbs.with_body(body(limbs.robot().0)));
        models.add((model, Motion::at(clock.cycle, pose)), pose, robot, ball, coat);
    }
}

/// The body of a robot, or of its team's first one if its number is unknown.
fn body_of(id: RobotId, roster: &Roster, robots: &Robots) -> Body {
    let first = || roster.iter().find(|(other, _)| other.team == id.team).map(|(_, robot)| robot);
    let robot = roster.get(id).or_else(first).and_then(|robot| robots.get(robot).ok());
    robot.map(|((.., body), _)| *body).unwrap_or_default()
}

/// The bodies in the world of a robot, whose team defends `own_end`.
fn places(id: RobotId, belief: &Belief, own_end: End) -> Vec<Place> {
    let itself = Place { of: Some(id), pose: belief.pose, coat: Coat::OPAQUE };
    let ball = belief.ball.map(|ball| {
        let is_seen = ball.heard_from.is_none() && ball.age_s <= SEEN_LATELY_S;
        let coat = if is_seen { Coat::OPAQUE } else { translucent(ball.age_s, None) };
        Place { of: None, pose: Pose { position: ball.position_m, heading: 0.0 }, coat }
    });
    let other = |robot: &RobotBelief, team: Team| {
        let attacks = if team == id.team { 0.0 } else { PI };
        let heading = belief.ball.map_or(attacks, |ball| angle_of(ball.position_m - robot.position_m));
        let of = robot.id.unwrap_or(RobotId::new(team, UNKNOWN));
        let pose = Pose { position: robot.position_m, heading };
        Place { of: Some(of), pose, coat: translucent(robot.age_s, Some(team)) }
    };
    let team_mates = belief.team_mates.iter().map(|robot| other(robot, id.team));
    let opponents = belief.opponents.iter().map(|robot| other(robot, id.team.opponent()));
    core::iter::once(itself)
        .chain(ball)
        .chain(team_mates)
        .chain(opponents)
        // Programs may believe anything.
        .filter(|place| place.pose.is_finite())
        .map(|place| Place { pose: pitch_from_team(place.pose, own_end), ..place })
        .collect()
}

/// The coat of something that was seen so long ago, s.
fn translucent(age_s: f32, tint: Option<Team>) -> Coat {
    let steps = (f32::from(COVER_STEPS) * faded(age_s)).round() as u8;
    Coat { opacity_percent: steps * STEP_PERCENT, tint }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::ball_and_posts::BallAndPostsPlugin;
    use crate::viewer::camera::viewpoint::Viewpoint;
    use crate::viewer::pitch_frame::PitchFramePlugin;
    use crate::viewer::robot_animation::RobotAnimationPlugin;
    use crate::viewer::robot_model::RobotModelPlugin;
    use crate::viewer::shared::DisplayFraction;
    use naoisis_core::camera_model::CameraName;
    use naoisis_sensing::belief::BallBelief;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    const BLUE1: RobotId = RobotId::new(Team::Blue, 1);
    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    fn seen(id: Option<RobotId>, x: f32, age_s: f32) -> RobotBelief {
        RobotBelief { id, position_m: Vec2::new(x, 0.0), covariance: [0.01, 0.0, 0.01], age_s }
    }

    /// One team-mate, two opponents and a ball.
    fn belief() -> Belief {
        Belief {
            ball: Some(BallBelief { position_m: Vec2::new(1.0, 2.0), ..default() }),
            team_mates: vec![seen(Some(BLUE2), 1.0, 0.0)],
            opponents: vec![seen(None, 2.0, 0.0), seen(None, -1.0, 60.0)],
            ..Belief::at(Pose::new(-1.0, 0.5, 0.25))
        }
    }

    #[test]
    fn others_face_the_ball_and_fade() {
        let [own, ball, mate, near, far] = places(BLUE1, &belief(), End::PositiveX).try_into().unwrap();
        assert_eq!((own.of, own.pose.position, own.coat), (Some(BLUE1), Vec2::new(1.0, -0.5), Coat::OPAQUE));
        assert_eq!((ball.of, ball.pose.position, ball.coat), (None, Vec2::new(-1.0, -2.0), Coat::OPAQUE));
        assert_eq!((mate.of, mate.coat), (Some(BLUE2), Coat { opacity_percent: 80, tint: Some(Team::Blue) }));
        // The ball is at the same x as the team-mate, 2 m from it in -y.
        assert!(mate.pose.forward().abs_diff_eq(Vec2::NEG_Y, 1e-6), "{mate:?}");
        assert_eq!(near.of, Some(RobotId::new(Team::Pink, UNKNOWN)));
        let [near_percent, far_percent] = [near, far].map(|place| place.coat.opacity_percent);
        assert!(far_percent < near_percent && far_percent > 0);
        let unknown = Belief { ball: None, ..belief() };
        let [_, mate, near, _] = places(BLUE1, &unknown, End::NegativeX).try_into().unwrap();
        assert!(mate.pose.forward().abs_diff_eq(Vec2::X, 1e-6) && near.pose.forward().abs_diff_eq(Vec2::NEG_X, 1e-6));
    }

    #[test]
    fn bodies_move_on_from_the_cycle_before_and_jump_in_time() {
        let pose = |x| Pose::new(x, 0.0, 0.0);
        let motion = Motion::at(10, pose(1.0)).on_to(11, pose(1.2));
        assert_eq!(motion, Motion { cycle: 11, from: pose(1.0), to: pose(1.2) });
        assert_eq!(motion.on_to(11, pose(1.3)).from, pose(1.0), "changed within a cycle");
        assert_eq!(motion.on_to(12, pose(1.4)).from, pose(1.2));
        for cycle in [9, 10, 13, 500] {
            assert_eq!(motion.on_to(cycle, pose(2.0)), Motion::at(cycle, pose(2.0)));
        }
    }

    #[test]
    fn a_ball_that_is_not_seen_now_is_translucent() {
        let opacity = |age_s, heard_from| {
            let ball = Some(BallBelief { age_s, heard_from, ..default() });
            places(BLUE1, &Belief { ball, ..default() }, End::NegativeX)[1].coat.opacity_percent
        };
        assert_eq!(opacity(0.2, None), 100);
        assert!(opacity(0.2, Some(BLUE2)) < 100 && opacity(3.0, None) < opacity(1.0, None));
    }

    /// The visible bodies: their robots, and their places in the pitch frame.
    fn bodies(app: &mut App) -> Vec<(Option<RobotId>, Vec2)> {
        let mut bodies = app.world_mut().query::<(&Model, &Transform, &Visibility)>();
        let visible = bodies.iter(app.world()).filter(|(.., visibility)| **visibility != Visibility::Hidden);
        let mut found: Vec<_> = visible
            .map(|(model, place, _)| match model {
                Model::Robot(id, _) => (Some(*id), place.translation.truncate()),
                Model::Ball(_) => (None, place.translation.truncate()),
            })
            .collect();
        found.sort_by_key(|(id, place)| (*id, (1000.0 * place.x) as i32));
        found
    }

    fn set(app: &mut App, belief: Belief) {
        let robot = app.world().resource::<Roster>().get(BLUE1).unwrap();
        app.world_mut().entity_mut(robot).insert(belief);
        // New bodies are shown in the frame after, when the graphics card has their meshes.
        app.update();
        app.update();
    }

    #[test]
    fn as_many_bodies_are_drawn_as_are_believed_and_none_with_the_truth() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), NaoisisPlugins)).init_resource::<DisplayFraction>();
        app.init_asset::<Mesh>().init_asset::<StandardMaterial>();
        app.add_plugins((PitchFramePlugin, RobotModelPlugin, RobotAnimationPlugin, BallAndPostsPlugin));
        app.init_resource::<RobotsWorld>().init_resource::<BelievedBodies>().insert_resource(Selection(Some(BLUE1)));
        app.add_systems(PostUpdate, show.run_if(is_needed));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        set(&mut app, belief());
        assert!(bodies(&mut app).is_empty());

        app.insert_resource(RobotsWorld(true));
        set(&mut app, belief());
        let pink = Some(RobotId::new(Team::Pink, UNKNOWN));
        let own_end = app.world().resource::<Game>().own_end(Team::Blue);
        let place = |x, y| pitch_from_team(Pose::new(x, y, 0.0), own_end).position;
        let mut expected = vec![
            (None, place(1.0, 2.0)),
            (Some(BLUE1), place(-1.0, 0.5)),
            (Some(BLUE2), place(1.0, 0.0)),
            (pink, place(-1.0, 0.0)),
            (pink, place(2.0, 0.0)),
        ];
        expected.sort_by_key(|(id, place)| (*id, (1000.0 * place.x) as i32));
        assert_eq!(bodies(&mut app), expected);
        assert_eq!(app.world().resource::<BelievedBodies>().0, 5);

        set(&mut app, Belief { ball: None, opponents: vec![seen(None, 3.0, 0.0)], ..belief() });
        assert_eq!(bodies(&mut app).len(), 3);
        assert_eq!(bodies(&mut app)[2], (pink, place(3.0, 0.0)));
        let view = Viewpoint::behind(Pose::default());
        let through = ViewerCamera { current: view, wanted: view, mode: CameraMode::RobotCamera(CameraName::TOP) };
        let camera = app.world_mut().spawn(through).id();
        app.update();
        assert!(bodies(&mut app).is_empty(), "nothing is in the view of the robot's camera");
        app.world_mut().despawn(camera);

        app.insert_resource(RobotsWorld(false));
        app.update();
        let left = app.world_mut().query::<&Model>().iter(app.world()).count();
        assert_eq!((left, app.world().resource::<BelievedBodies>().0), (0, 0));
    }
}
