//! Models of robots from the limbs of the [appearance](naoisis_sensing::appearance::robot).

use bevy::prelude::*;
use core::array;

use super::part_mesh::{mesh_of_parts, part_material};
use naoisis_core::robot::body::Body;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::appearance::posing::Limb;
use naoisis_sensing::appearance::robot::{RobotDesign, RobotPart};

/// Spawns the models of robots when these enter the match.
pub struct RobotModelPlugin;

impl Plugin for RobotModelPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RobotMeshes>().add_observer(show_robot);
    }
}

/// The entities of a robot's limbs, which are its children.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
pub struct RobotLimbs {
    /// The entities, indexed by [`Limb`].
    pub limbs: [Entity; Limb::COUNT],
}

/// The meshes of robots, for reuse.
#[derive(Resource)]
pub(super) struct RobotMeshes {
    /// The material of all robots.
    pub(super) material: Handle<StandardMaterial>,
    /// Meshes of limbs are shared by robots of a team with the same body.
    limbs: Vec<(Team, Body, [Handle<Mesh>; Limb::COUNT])>,
    /// Meshes of trunks have the number and the colour of the robot.
    trunks: Vec<(RobotId, Body, Handle<Mesh>)>,
}

impl FromWorld for RobotMeshes {
    fn from_world(world: &mut World) -> Self {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(part_material());
        Self { material, limbs: Vec::new(), trunks: Vec::new() }
    }
}

impl RobotMeshes {
    /// The meshes of a robot's limbs.
    fn of(&mut self, id: RobotId, body: &Body, meshes: &mut Assets<Mesh>) -> [Handle<Mesh>; Limb::COUNT] {
        let Self { limbs, trunks, .. } = self;
        let mut mesh_of_limb = |index: usize, parts: &[RobotPart]| {
            meshes.add(mesh_of_parts(parts.iter().filter(|part| part.frame as usize == index)))
        };
        let known =
            limbs.iter().find(|(of, with, _)| *of == id.team && with == body).map(|(.., handles)| handles.clone());
        let trunk = trunks.iter().find(|(of, with, _)| *of == id && with == body).map(|(.., trunk)| trunk.clone());
        if let (Some(mut handles), Some(trunk)) = (known.clone(), trunk) {
            handles[Limb::Trunk as usize] = trunk;
            return handles;
        }
        let parts = RobotDesign::Nao.parts(id, body);
        let mut handles = known.unwrap_or_else(|| {
            let handles: [Handle<Mesh>; Limb::COUNT] = array::from_fn(|index| mesh_of_limb(index, &parts));
            limbs.push((id.team, *body, handles.clone()));
            handles
        });
        handles[Limb::Trunk as usize] = mesh_of_limb(Limb::Trunk as usize, &parts);
        trunks.push((id, *body, handles[Limb::Trunk as usize].clone()));
        handles
    }
}

/// Adds the limbs of a robot to an entity, with the given material or that of robots.
pub(super) fn add_limbs(
    entity: Entity,
    (id, body): (RobotId, &Body),
    material: Option<Handle<StandardMaterial>>,
    shared: &mut RobotMeshes,
    meshes: &mut Assets<Mesh>,
    commands: &mut Commands,
) {
    let handles = shared.of(id, body, meshes);
    let material = material.unwrap_or_else(|| shared.material.clone());
    let limbs = handles.map(|mesh| {
        let limb = (ChildOf(entity), Mesh3d(mesh), MeshMaterial3d(material.clone()), Transform::default());
        commands.spawn(limb).id()
    });
    commands.entity(entity).insert(RobotLimbs { limbs });
}

fn show_robot(
    added: On<Add, RobotId>,
    robots: Query<(&RobotId, &Body)>,
    mut shared: ResMut<RobotMeshes>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Ok((id, body)) = robots.get(added.entity) else { return };
    add_limbs(added.entity, (*id, body), None, &mut shared, &mut meshes, &mut commands);
}
