//! Robots: the [appearance's](crate::appearance::robot) NAO, limb by limb.

use bevy::prelude::*;
use core::array;

use super::part_mesh::{mesh_of_parts, part_material};
use crate::appearance::posing::Limb;
use crate::appearance::robot::{RobotDesign, RobotPart};
use crate::robot::body::Body;
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
    /// Robots with the same body share those of their limbs.
    limbs: Vec<(Body, [Handle<Mesh>; Limb::COUNT])>,
    /// The trunk has the number and the team's colour.
    trunks: Vec<(RobotId, Body, Handle<Mesh>)>,
}

impl FromWorld for RobotMeshes {
    fn from_world(world: &mut World) -> Self {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(part_material());
        Self { material, limbs: Vec::new(), trunks: Vec::new() }
    }
}

fn show_robot(
    added: On<Add, RobotId>,
    robots: Query<(&RobotId, &Body)>,
    mut shared: ResMut<RobotMeshes>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Ok((id, body)) = robots.get(added.entity) else { return };
    let RobotMeshes { material, limbs, trunks } = &mut *shared;
    let mut mesh_of_limb = |index: usize, parts: &[RobotPart]| {
        meshes.add(mesh_of_parts(parts.iter().filter(|part| part.frame as usize == index)))
    };
    let known = limbs.iter().find(|(of, _)| of == body).map(|(_, handles)| handles.clone());
    let trunk = trunks.iter().find(|(of, with, _)| of == id && with == body).map(|(.., trunk)| trunk.clone());
    let handles = match (known, trunk) {
        (Some(mut handles), Some(trunk)) => {
            handles[Limb::Trunk as usize] = trunk;
            handles
        }
        (known, _) => {
            let parts = RobotDesign::Nao.parts(*id, body);
            let mut handles = known.unwrap_or_else(|| {
                let handles: [Handle<Mesh>; Limb::COUNT] = array::from_fn(|index| mesh_of_limb(index, &parts));
                limbs.push((*body, handles.clone()));
                handles
            });
            handles[Limb::Trunk as usize] = mesh_of_limb(Limb::Trunk as usize, &parts);
            trunks.push((*id, *body, handles[Limb::Trunk as usize].clone()));
            handles
        }
    };
    let robot = added.entity;
    let limbs = handles.map(|mesh| {
        let limb = (ChildOf(robot), Mesh3d(mesh), MeshMaterial3d(material.clone()), Transform::default());
        commands.spawn(limb).id()
    });
    commands.entity(robot).insert(RobotLimbs { limbs });
}
