//! Models of the ball and the posts.

use bevy::prelude::*;

use super::palette;
use super::part_mesh::{mesh_of_parts, part_material};
use naoisis_core::ball::BallPhysics;
use naoisis_core::pitch::Post;
use naoisis_sensing::appearance::field;

/// Spawns the models of balls and posts when these enter the match.
pub struct BallAndPostsPlugin;

impl Plugin for BallAndPostsPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(show_ball).add_observer(show_post);
        app.add_systems(PostUpdate, roll_balls.before(TransformSystems::Propagate));
    }
}

/// The model of a ball, and the place where it was drawn last.
#[derive(Component)]
struct BallModel {
    /// m, pitch frame.
    place: Vec2,
    radius_m: f32,
}

/// The greatest way from one frame to the next on which a ball is drawn rolling, m. On longer ones it is moved.
const LONGEST_ROLL_M: f32 = 1.0;

fn show_ball(
    added: On<Add, BallPhysics>,
    balls: Query<&BallPhysics>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Ok(physics) = balls.get(added.entity) else { return };
    commands.spawn((
        ChildOf(added.entity),
        BallModel { place: Vec2::ZERO, radius_m: physics.radius_m },
        ball_mesh(physics, &mut meshes),
        MeshMaterial3d(materials.add(part_material())),
    ));
}

/// The mesh of a ball with its centre in the origin, with its colours in the vertices.
pub(super) fn ball_mesh(physics: &BallPhysics, meshes: &mut Assets<Mesh>) -> impl Bundle {
    let (mesh, colours) = naoisis_gpu::mesh::ball_mesh(physics.radius_m, physics.look);
    let linear = |colour| LinearRgba::from(palette::from_appearance(colour)).to_f32_array();
    let colours: Vec<[f32; 4]> = colours.into_iter().map(linear).collect();
    let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours);
    (Mesh3d(meshes.add(mesh)), Transform::from_xyz(0.0, 0.0, physics.radius_m))
}

/// Turns the models of balls as they roll.
fn roll_balls(
    mut models: Query<(&ChildOf, &mut BallModel, &mut Transform)>,
    balls: Query<&Transform, Without<BallModel>>,
) {
    for (of, mut model, mut transform) in &mut models {
        let Ok(ball) = balls.get(of.parent()) else { continue };
        let place = ball.translation.truncate();
        let way = place - model.place;
        if way == Vec2::ZERO {
            continue;
        }
        model.place = place;
        if way.length() < LONGEST_ROLL_M {
            // The ball itself may be turned, too.
            let axis = ball.rotation.inverse() * way.normalize().perp().extend(0.0);
            transform.rotation =
                (Quat::from_axis_angle(axis, way.length() / model.radius_m) * transform.rotation).normalize();
        }
    }
}

fn show_post(
    added: On<Add, Post>,
    posts: Query<&Post>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Ok(post) = posts.get(added.entity) else { return };
    commands.spawn((
        ChildOf(added.entity),
        Mesh3d(meshes.add(mesh_of_parts([&field::post(post, Vec2::ZERO)]))),
        MeshMaterial3d(materials.add(part_material())),
        Transform::default(),
    ));
}

#[cfg(test)]
mod tests {
    use super::super::pitch_frame::PitchFramePlugin;
    use super::super::robot_model::RobotModelPlugin;
    use super::super::shared::DisplayFraction;
    use super::*;
    use naoisis_core::team::RobotId;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins, Snapshot};

    /// The numbers of balls, robots and posts that have a visible mesh.
    fn drawn(app: &mut App) -> [usize; 3] {
        fn count<C: Component>(world: &mut World) -> usize {
            let mut things = world.query_filtered::<(&Children, &Visibility), With<C>>();
            let mut meshes = world.query::<&Mesh3d>();
            let seen = things.iter(world).filter(|(children, visibility)| {
                **visibility != Visibility::Hidden && children.iter().any(|child| meshes.get(world, child).is_ok())
            });
            seen.count()
        }
        let world = app.world_mut();
        [count::<BallPhysics>(world), count::<RobotId>(world), count::<Post>(world)]
    }

    #[test]
    fn a_restored_match_is_drawn_as_the_one_before() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), NaoisisPlugins)).init_resource::<DisplayFraction>();
        app.init_asset::<Mesh>().init_asset::<StandardMaterial>();
        app.add_plugins((PitchFramePlugin, RobotModelPlugin, BallAndPostsPlugin));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap().run_cycles(3);
        app.update();
        let before = drawn(&mut app);
        assert_eq!(before[..2], [1, 6]);
        let snapshot = Snapshot::take(app.world_mut()).unwrap();
        for _ in 0..2 {
            snapshot.restore(app.world_mut()).unwrap();
            app.update();
            assert_eq!(drawn(&mut app), before);
        }
    }
}
