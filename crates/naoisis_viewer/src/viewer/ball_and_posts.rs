//! Models of the ball and the posts.

use bevy::prelude::*;

use super::palette;
use super::part_mesh::{mesh_of_parts, part_material};
use naoisis_core::ball::BallPhysics;
use naoisis_core::pitch::Post;
use naoisis_sensing::appearance::{colours, field};

/// Spawns the models of balls and posts when these enter the match.
pub struct BallAndPostsPlugin;

impl Plugin for BallAndPostsPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(show_ball).add_observer(show_post);
    }
}

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
        ball_mesh(physics, &mut meshes),
        MeshMaterial3d(
            materials.add(StandardMaterial { base_color: palette::from_appearance(colours::BALL), ..part_material() }),
        ),
    ));
}

/// The mesh of a ball with its centre in the origin.
pub(super) fn ball_mesh(physics: &BallPhysics, meshes: &mut Assets<Mesh>) -> impl Bundle {
    let sphere = Sphere::new(physics.radius_m).mesh().uv(32, 18);
    (Mesh3d(meshes.add(sphere)), Transform::from_xyz(0.0, 0.0, physics.radius_m))
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
