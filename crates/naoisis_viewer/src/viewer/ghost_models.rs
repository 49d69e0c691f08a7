//! Models of robots and balls that are no part of the match, opaque or translucent.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::collections::BTreeMap;

use super::ball_and_posts::ball_mesh;
use super::part_mesh::part_material;
use super::pitch_frame::{PitchRoot, transform_of};
use super::robot_animation::GhostBody;
use super::robot_model::{RobotMeshes, add_limbs};
use naoisis_core::ball::BallPhysics;
use naoisis_core::geometry::Pose;

/// The opacity of opaque models, %.
pub const OPAQUE: u8 = 100;

/// Adds models to the pitch.
#[derive(SystemParam)]
pub struct GhostModels<'w, 's> {
    root: Res<'w, PitchRoot>,
    robot_meshes: ResMut<'w, RobotMeshes>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    /// Translucent materials by their opacity, %.
    translucent: Local<'s, BTreeMap<u8, Handle<StandardMaterial>>>,
    /// The commands of the system.
    pub commands: Commands<'w, 's>,
}

impl GhostModels<'_, '_> {
    /// Adds a robot, or a ball with this physics if there is none, with the component `tag`. Its parts are its children. It is
    /// hidden at first, because its limbs are posed later.
    pub fn add(
        &mut self,
        tag: impl Component,
        pose: Pose,
        robot: Option<GhostBody>,
        ball: BallPhysics,
        opacity_percent: u8,
    ) {
        let material = self.material(opacity_percent);
        let entity = self.commands.spawn((ChildOf(self.root.0), tag, transform_of(pose), Visibility::Hidden)).id();
        if let Some(robot) = robot {
            self.commands.entity(entity).insert(robot);
            let (id, body) = robot.robot();
            let Self { robot_meshes, meshes, commands, .. } = self;
            add_limbs(entity, (id, &body), Some(material), robot_meshes, meshes, commands);
        } else {
            let mesh = ball_mesh(&ball, &mut self.meshes);
            self.commands.spawn((ChildOf(entity), mesh, MeshMaterial3d(material)));
        }
    }

    /// Returns the material of this opacity, which is shared by all models.
    pub fn material(&mut self, opacity_percent: u8) -> Handle<StandardMaterial> {
        if opacity_percent >= OPAQUE {
            return self.robot_meshes.material.clone();
        }
        let make = || {
            self.materials.add(StandardMaterial {
                base_color: Color::WHITE.with_alpha(f32::from(opacity_percent) / f32::from(OPAQUE)),
                alpha_mode: AlphaMode::Blend,
                ..part_material()
            })
        };
        self.translucent.entry(opacity_percent).or_insert_with(make).clone()
    }
}
