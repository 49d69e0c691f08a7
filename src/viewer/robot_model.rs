//! Robots: the [appearance's](crate::appearance::robot) NAO, limb by limb.

use bevy::prelude::*;
use core::array;
use std::collections::BTreeMap;

use super::part_mesh::{mesh_of_parts, part_material};
use crate::appearance::posing::Limb;
use crate::appearance::robot::{RobotDesign, RobotPart};
use crate::team::RobotId;

/// Shows robots as they come into the match.
pub struct RobotModelPlugin;

impl Plugin for RobotModelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RobotMeshes>().add_observer(show_robot);
    }
}

/// The entities that a robot is drawn by, its children, one for each limb.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
pub struct RobotLimbs {
    /// Each at the index of its [`Limb`].
    pub limbs: [Entity; Limb::COUNT],
}

/// The meshes of the robots that were shown.
#[derive(Resource)]
struct RobotMeshes {
    material: Handle<StandardMaterial>,
    /// All robots share those of their limbs. The trunk has the number and the team's colour.
    limbs: Option<[Handle<Mesh>; Limb::COUNT]>,
    trunks: BTreeMap<RobotId, Handle<Mesh>>,
}

impl FromWorld for RobotMeshes {
    fn from_world(world: &mut World) -> Self {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(part_material());
        Self { material, limbs: None, trunks: BTreeMap::new() }
    }
}

fn show_robot(
    added: On<Add, RobotId>,
    ids: Query<&RobotId>,
    mut shared: ResMut<RobotMeshes>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Ok(id) = ids.get(added.entity) else { return };
    let RobotMeshes { material, limbs, trunks } = &mut *shared;
    let mut mesh_of_limb = |index: usize, parts: &[RobotPart]| {
        meshes.add(mesh_of_parts(parts.iter().filter(|part| part.frame as usize == index)))
    };
    if limbs.is_none() || !trunks.contains_key(id) {
        let parts = RobotDesign::Nao.parts(*id);
        trunks.insert(*id, mesh_of_limb(Limb::Trunk as usize, &parts));
        limbs.get_or_insert_with(|| array::from_fn(|index| mesh_of_limb(index, &parts)));
    }
    let Some(limbs) = limbs else { return };
    let mut handles = limbs.clone();
    if let Some(trunk) = trunks.get(id) {
        handles[Limb::Trunk as usize] = trunk.clone();
    }
    let robot = added.entity;
    let limbs = handles.map(|mesh| {
        let limb = (ChildOf(robot), Mesh3d(mesh), MeshMaterial3d(material.clone()), Transform::default());
        commands.spawn(limb).id()
    });
    commands.entity(robot).insert(RobotLimbs { limbs });
}
