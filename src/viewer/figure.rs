//! Robots: the [appearance's](crate::appearance::robot) NAO, limb by limb.

use bevy::prelude::*;
use core::array;
use std::collections::BTreeMap;

use super::sculpture::{self, Sculpture};
use crate::appearance::posing::Limb;
use crate::appearance::robot::{RobotDesign, RobotPart};
use crate::team::RobotId;

/// Shows robots as they come into the match.
pub struct FigurePlugin;

impl Plugin for FigurePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<FigureParts>().add_observer(show_robot);
    }
}

/// The limbs of a robot's figure, children of the robot, each at the index of its [`Limb`].
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug)]
pub struct Figure {
    /// The limbs.
    pub limbs: [Entity; Limb::COUNT],
}

/// The meshes of the robots that were shown.
#[derive(Resource)]
struct FigureParts {
    material: Handle<StandardMaterial>,
    /// All robots share those of their limbs. The trunk has the number and the team's colour.
    limbs: Option<[Handle<Mesh>; Limb::COUNT]>,
    trunks: BTreeMap<RobotId, Handle<Mesh>>,
}

impl FromWorld for FigureParts {
    fn from_world(world: &mut World) -> Self {
        let material = world.resource_mut::<Assets<StandardMaterial>>().add(sculpture::material());
        Self { material, limbs: None, trunks: BTreeMap::new() }
    }
}

fn show_robot(
    added: On<Add, RobotId>,
    ids: Query<&RobotId>,
    mut figures: ResMut<FigureParts>,
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let Ok(id) = ids.get(added.entity) else { return };
    let FigureParts { material, limbs, trunks } = &mut *figures;
    let mut sculpt = |index: usize, parts: &[RobotPart]| {
        meshes.add(Sculpture::of(parts.iter().filter(|part| part.frame as usize == index)))
    };
    if limbs.is_none() || !trunks.contains_key(id) {
        let parts = RobotDesign::Nao.parts(*id);
        trunks.insert(*id, sculpt(Limb::Trunk as usize, &parts));
        limbs.get_or_insert_with(|| array::from_fn(|index| sculpt(index, &parts)));
    }
    let Some(shared) = limbs else { return };
    let mut handles = shared.clone();
    if let Some(trunk) = trunks.get(id) {
        handles[Limb::Trunk as usize] = trunk.clone();
    }
    let robot = added.entity;
    let limbs = handles.map(|mesh| {
        let limb = (ChildOf(robot), Mesh3d(mesh), MeshMaterial3d(material.clone()), Transform::default());
        commands.spawn(limb).id()
    });
    commands.entity(robot).insert(Figure { limbs });
}
