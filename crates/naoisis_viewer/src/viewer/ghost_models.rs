//! Models of robots and balls that are no part of the match, opaque or translucent.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::collections::BTreeMap;

use super::ball_and_posts::ball_mesh;
use super::palette;
use super::part_mesh::part_material;
use super::pitch_frame::{PitchRoot, transform_of};
use super::robot_animation::GhostBody;
use super::robot_model::{RobotMeshes, add_limbs};
use naoisis_core::ball::BallPhysics;
use naoisis_core::geometry::Pose;
use naoisis_core::team::Team;

/// The share of a team's colour in the models that are tinted with it.
const TINT: f32 = 0.45;

/// How a model is coated.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Coat {
    /// %.
    pub opacity_percent: u8,
    /// The team whose colour is mixed into all parts of the model.
    pub tint: Option<Team>,
}

impl Coat {
    /// As robots and balls of the match.
    pub const OPAQUE: Coat = Coat::of_opacity(100);

    /// A coat of this opacity, %, without a tint.
    pub const fn of_opacity(opacity_percent: u8) -> Self {
        Self { opacity_percent, tint: None }
    }

    /// The colour by which those of the model are multiplied.
    fn colour(self) -> Color {
        let tint = self.tint.map_or(Color::WHITE, |team| Color::WHITE.mix(&palette::team(team), TINT));
        tint.with_alpha(f32::from(self.opacity_percent) / 100.0)
    }
}

/// Adds models to the pitch.
#[derive(SystemParam)]
pub struct GhostModels<'w, 's> {
    root: Res<'w, PitchRoot>,
    robot_meshes: ResMut<'w, RobotMeshes>,
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    coats: Local<'s, BTreeMap<Coat, Handle<StandardMaterial>>>,
    /// The commands of the system.
    pub commands: Commands<'w, 's>,
}

impl GhostModels<'_, '_> {
    /// Adds a robot, or a ball with this physics if there is none, with the component `tag`. Its parts are its
    /// children. It is hidden at first: new meshes are drawn in the next frame only.
    pub fn add(&mut self, tag: impl Bundle, pose: Pose, robot: Option<GhostBody>, ball: BallPhysics, coat: Coat) {
        let material = self.material(coat);
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

    /// Returns the material of a coat, which all models of a system share.
    pub fn material(&mut self, coat: Coat) -> Handle<StandardMaterial> {
        if coat == Coat::OPAQUE {
            return self.robot_meshes.material.clone();
        }
        let make = || {
            let (base_color, alpha_mode) = (coat.colour(), AlphaMode::Blend);
            self.materials.add(StandardMaterial { base_color, alpha_mode, ..part_material() })
        };
        self.coats.entry(coat).or_insert_with(make).clone()
    }
}
