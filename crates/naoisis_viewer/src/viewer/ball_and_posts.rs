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
