//! The scene as Bevy entities: pitch, posts, ball and robots, each on the render layers of the cameras that see it.
//!
//! There are no transforms to propagate: the frame of this world is the pitch frame, and poses are written directly to the
//! [`GlobalTransform`]s that Bevy's renderer reads.

use bevy::camera::visibility::RenderLayers;
use bevy::math::{Affine3A, Mat3};
use bevy::mesh::MeshMergeError;
use bevy::prelude::*;
use std::collections::BTreeMap;

use super::material::{SceneMaterial, Surface};
use crate::mesh::{ground_mesh, labelled_ball_mesh, labelled_mesh, line_mesh};
use naoisis_core::ball::BallLook;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::field::{self, GroundMark, GroundShape};
use naoisis_sensing::appearance::people::{Person, people};
use naoisis_sensing::appearance::posing::Limb;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::scene::{Scene, ScenePost, SceneRobot};
use naoisis_sensing::appearance::shapes::Part;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::appearance::{Label, colours};
use naoisis_sensing::sensing::camera::software::light::SUN;

/// Height of each mark on the ground above the one below it, m: too little to be visible.
const STEP_M: f32 = 0.000_1;
/// Heights of the ground in shadow, of the ground in light and of the shadows, m. A shadow hides the ground in light below it.
const SHADED_M: f32 = -0.003;
const LIT_M: f32 = 0.0;
const SHADOW_M: f32 = 0.003;
/// Half the side of the hall's floor, m.
const FLOOR_HALF_M: f32 = 400.0;

/// Variant of the scene that a camera sees.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct SceneVariant {
    /// Appearance of robots.
    pub(super) design: RobotDesign,
    /// Whether bodies cast shadows.
    pub(super) shadows: bool,
    /// Whether distances are drawn instead of colours.
    pub(super) depth: bool,
}

/// Layers of everything except robots: bodies and the ground, shadows and the ground in them, and distances.
const COMMON: usize = 0;
const COMMON_SHADOWS: usize = 1;
const COMMON_DEPTH: usize = 2;
/// First layer of robots. Each robot has layers for its body, its shadow and its distances, in both designs.
const FIRST_OF_ROBOTS: usize = 3;
const LAYERS_PER_ROBOT: usize = 6;

/// An entity that moves with the ball or with a limb of a robot.
struct PlacedEntity {
    entity: Entity,
    /// The limb of a robot that it is of, or the number of the ball.
    limb: usize,
    is_shadow: bool,
}

/// The entities of a robot.
#[derive(Default)]
struct RobotEntities {
    /// Number of the robot, which determines its layers.
    index: usize,
    /// Bodies, shadows and distances of each design, as far as they were needed.
    parts: [Vec<PlacedEntity>; 2],
    has: [[bool; 3]; 2],
}

/// The entities of a scene.
#[derive(Default)]
pub(super) struct RenderScene {
    materials: BTreeMap<usize, Handle<SceneMaterial>>,
    pitch: Option<Pitch>,
    posts: Vec<ScenePost>,
    /// Entities that do not move.
    fixed: Vec<Entity>,
    balls: Vec<PlacedEntity>,
    ball_count: usize,
    /// Radius of the balls, m, and their colours.
    ball: (f32, BallLook),
    robots: BTreeMap<RobotId, RobotEntities>,
    has_shadows: bool,
    has_depth: bool,
}

impl RenderScene {
    /// Updates the entities to a scene, with all variants that the cameras see. Returns whether there are new entities, for which the
    /// renderer has to warm up.
    pub(super) fn set(
        &mut self,
        world: &mut World,
        scene: &Scene,
        variants: &[SceneVariant],
    ) -> Result<bool, MeshMergeError> {
        let shadows = self.has_shadows || variants.iter().any(|variant| variant.shadows);
        let depth = self.has_depth || variants.iter().any(|variant| variant.depth);
        let is_other = self.pitch.as_ref() != Some(&scene.pitch)
            || self.posts != scene.posts
            || (shadows, depth) != (self.has_shadows, self.has_depth)
            || scene.balls().count() > self.ball_count
            || scene.ball.is_some_and(|ball| (ball.radius, ball.look) != self.ball);
        let mut is_new = is_other;
        if is_other {
            (self.has_shadows, self.has_depth) = (shadows, depth);
            self.lay_out(world, scene)?;
        }
        for part in &self.balls {
            let place =
                scene.balls().nth(part.limb).map(|ball| Affine3A::from_mat3_translation(ball.turn(), ball.centre()));
            put(world, part, place);
        }
        for robot in &scene.robots {
            let count = self.robots.len();
            let entities = self.robots.entry(robot.id).or_insert_with(|| RobotEntities { index: count, ..default() });
            for variant in variants {
                is_new |= entities.add_missing(world, &mut self.materials, robot, *variant)?;
            }
        }
        for (id, robot) in &self.robots {
            let limbs = scene.robot(*id).map(SceneRobot::world_from_limbs);
            for part in robot.parts.iter().flatten() {
                put(world, part, limbs.map(|limbs| limbs[part.limb]));
            }
        }
        Ok(is_new)
    }

    /// Returns the layers that a camera sees.
    pub(super) fn layers(&self, view: &View, variant: SceneVariant) -> RenderLayers {
        let mut layers = vec![if variant.depth { COMMON_DEPTH } else { COMMON }];
        let casts = variant.shadows && !variant.depth;
        if casts {
            layers.push(COMMON_SHADOWS);
        }
        for (id, robot) in &self.robots {
            if Some(*id) != view.hidden {
                let kinds: &[usize] = if variant.depth {
                    &[2]
                } else if casts {
                    &[0, 1]
                } else {
                    &[0]
                };
                layers.extend(kinds.iter().map(|kind| robot.layer(variant.design, *kind)));
            }
        }
        RenderLayers::from_layers(&layers)
    }

    /// What stays where it is as long as the pitch and the posts are the same, and the balls.
    fn lay_out(&mut self, world: &mut World, scene: &Scene) -> Result<(), MeshMergeError> {
        let gone = self.fixed.drain(..).chain(self.balls.drain(..).map(|part| part.entity));
        for entity in gone.collect::<Vec<_>>() {
            world.despawn(entity);
        }
        let mut marks = vec![floor()];
        marks.extend(field::ground(&scene.pitch));
        let ground = |lowest| ground_mesh(&marks, scene.pitch.unevenness, lowest, STEP_M);
        let surfaces = self.surfaces();
        let mut spawn = |mesh: Mesh, surface, layer| spawn(world, &mut self.materials, mesh, surface, layer);
        self.fixed.push(spawn(ground(LIT_M), Surface::Ground, COMMON));
        if self.has_shadows {
            self.fixed.push(spawn(ground(SHADED_M), Surface::ShadedGround, COMMON_SHADOWS));
        }
        if self.has_depth {
            self.fixed.push(spawn(ground_mesh(&marks[..1], 0.0, 0.0, 0.0), Surface::Depth, COMMON_DEPTH));
        }
        let mut standing: Vec<Part<()>> =
            scene.posts.iter().map(|post| field::post(&post.post, post.position)).collect();
        standing.extend(people(&scene.pitch).iter().flat_map(Person::parts));
        for end in End::BOTH {
            standing.extend(field::goal_frame(&scene.pitch, end));
            let net = line_mesh(&field::net_strings(&scene.pitch, end), colours::NET, Label::GoalFrame);
            self.fixed.push(spawn(net, Surface::Net, COMMON));
        }
        let standing = labelled_mesh(&standing)?;
        let (radius_m, look) = scene.ball.map_or(self.ball, |ball| (ball.radius, ball.look));
        let ball_mesh = labelled_ball_mesh(radius_m.max(1e-3), look);
        let ball_count = scene.balls().count().max(1);
        for (surface, layer) in surfaces {
            let entity = spawn(standing.clone(), surface, layer);
            self.fixed.push(entity);
            for limb in 0..ball_count {
                let entity = spawn(ball_mesh.clone(), surface, layer);
                self.balls.push(PlacedEntity { entity, limb, is_shadow: surface == Surface::Shadow });
            }
        }
        // Shadows of bodies that do not move stay in place, too.
        for entity in &self.fixed {
            let is_shadow = world.get::<MeshMaterial3d<SceneMaterial>>(*entity).is_some_and(|material| {
                self.materials.get(&(Surface::Shadow as usize)).is_some_and(|shadow| *shadow == material.0)
            });
            let place = if is_shadow { on_ground() } else { Affine3A::IDENTITY };
            world.entity_mut(*entity).insert(GlobalTransform::from(place));
        }
        (self.pitch, self.posts) = (Some(scene.pitch.clone()), scene.posts.clone());
        (self.ball_count, self.ball) = (ball_count, (radius_m, look));
        Ok(())
    }

    /// Returns the surfaces with which the bodies other than robots are drawn, with their layers.
    fn surfaces(&self) -> Vec<(Surface, usize)> {
        let mut surfaces = vec![(Surface::Body, COMMON)];
        if self.has_shadows {
            surfaces.push((Surface::Shadow, COMMON_SHADOWS));
        }
        if self.has_depth {
            surfaces.push((Surface::Depth, COMMON_DEPTH));
        }
        surfaces
    }
}

impl RobotEntities {
    fn layer(&self, design: RobotDesign, kind: usize) -> usize {
        FIRST_OF_ROBOTS + LAYERS_PER_ROBOT * self.index + 3 * (design as usize) + kind
    }

    /// Adds the entities that are missing for a variant. Returns whether there were any.
    fn add_missing(
        &mut self,
        world: &mut World,
        materials: &mut BTreeMap<usize, Handle<SceneMaterial>>,
        robot: &SceneRobot,
        variant: SceneVariant,
    ) -> Result<bool, MeshMergeError> {
        let design = variant.design as usize;
        let wanted = [!variant.depth, variant.shadows && !variant.depth, variant.depth];
        let surfaces = [Surface::Body, Surface::Shadow, Surface::Depth];
        let mut is_new = false;
        let parts = variant.design.parts(robot.id, &robot.body);
        for kind in 0..3 {
            if !wanted[kind] || self.has[design][kind] {
                continue;
            }
            (self.has[design][kind], is_new) = (true, true);
            let layer = self.layer(variant.design, kind);
            for limb in 0..Limb::COUNT {
                let mesh = labelled_mesh(parts.iter().filter(|part| part.frame as usize == limb))?;
                let entity = spawn(world, materials, mesh, surfaces[kind], layer);
                self.parts[design].push(PlacedEntity { entity, limb, is_shadow: surfaces[kind] == Surface::Shadow });
            }
        }
        Ok(is_new)
    }
}

fn spawn(
    world: &mut World,
    materials: &mut BTreeMap<usize, Handle<SceneMaterial>>,
    mesh: Mesh,
    surface: Surface,
    layer: usize,
) -> Entity {
    let material = materials
        .entry(surface as usize)
        .or_insert_with(|| world.resource_mut::<Assets<SceneMaterial>>().add(SceneMaterial::new(surface)))
        .clone();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
    world.spawn((Mesh3d(mesh), MeshMaterial3d(material), RenderLayers::layer(layer))).id()
}

/// Moves an entity to a place, or hides it.
fn put(world: &mut World, part: &PlacedEntity, place: Option<Affine3A>) {
    let mut entity = world.entity_mut(part.entity);
    match place {
        None => {
            entity.insert(Visibility::Hidden);
        }
        Some(place) => {
            let place = if part.is_shadow { on_ground() * place } else { place };
            entity.insert((GlobalTransform::from(place), Visibility::Inherited));
        }
    }
}

/// Returns the transform that flattens bodies along the sun's rays onto the ground.
fn on_ground() -> Affine3A {
    let along = -SUN / SUN.z;
    let flat = Mat3::from_cols(Vec3::X, Vec3::Y, along.with_z(0.0));
    Affine3A::from_mat3_translation(flat, Vec3::Z * SHADOW_M)
}

/// Returns the floor of the hall.
fn floor() -> GroundMark {
    let corner = |x: f32, y: f32| Vec2::new(x, y) * FLOOR_HALF_M;
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    GroundMark { label: Label::Floor, colour: colours::FLOOR, shape: GroundShape::Quadrilateral(corners) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shadows_fall_away_from_the_sun_onto_the_ground() {
        let tip = Vec3::new(1.0, 2.0, 0.5);
        let shadow = on_ground().transform_point3(tip);
        // From the tip along the sun's rays: tip - sun (tip.z / sun.z).
        let expected = tip - SUN * (tip.z / SUN.z);
        assert!(shadow.abs_diff_eq(expected.with_z(SHADOW_M), 1e-6), "{shadow}");
    }
}
