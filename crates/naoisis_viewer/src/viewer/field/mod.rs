//! The models of carpet, lines, goals and nets for the pitch of the scenario, and of the hall around it.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;

mod hall;
mod quads;
mod turf;

use super::display_settings::DisplaySettings;
use super::palette;
use super::part_mesh::{mesh_of_parts, part_material};
use super::pitch_frame::{PitchRoot, light_on};
use super::shared::SecondPitch;
use naoisis_core::pitch::{End, Pitch, Post};
use naoisis_sensing::appearance::field::{self, GroundShape};
use naoisis_sensing::appearance::people::{Person, people};
use naoisis_sensing::appearance::shapes::Part;
use naoisis_sensing::appearance::{Label, colours};
use quads::QuadMesh;

/// The height of the lines above the carpet, m.
const LINE_HEIGHT: f32 = 0.003;

/// Spawns the models of the pitch and the hall, and replaces them when the pitch changes.
pub struct FieldPlugin;

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<SecondPitch>()
            .add_systems(
                Update,
                (
                    lay_out_field.run_if(resource_exists_and_changed::<Pitch>),
                    lay_out_second
                        .run_if(resource_changed::<SecondPitch>.or_else(resource_exists_and_changed::<Pitch>)),
                    light_ground,
                )
                    .chain(),
            )
            .add_systems(PostUpdate, hall::hide_from_robots);
    }
}

/// Marks the parts of the model.
#[derive(Component)]
struct FieldPart;

/// Marks the parts of the pitch for another match.
#[derive(Component)]
struct SecondPart;

/// Marks the floor of the hall.
#[derive(Component)]
struct Floor;

/// Marks the parts that lie on the ground.
#[derive(Component)]
struct Ground;

fn lay_out_field(
    mut commands: Commands,
    pitch: Res<Pitch>,
    root: Res<PitchRoot>,
    old: Query<Entity, With<FieldPart>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    for part in &old {
        commands.entity(part).despawn();
    }
    let mut spawn = |mesh: Mesh, material: StandardMaterial, height: f32| {
        let model = (Mesh3d(meshes.add(mesh)), MeshMaterial3d(materials.add(material)));
        commands.spawn((FieldPart, ChildOf(root.0), model, Transform::from_xyz(0.0, 0.0, height))).id()
    };
    let matt = || StandardMaterial { perceptual_roughness: 0.95, reflectance: 0.1, ..default() };
    let picture = images.add(turf::picture(&pitch));
    let carpet = Rectangle::from_size(2.0 * pitch.carpet_half_extents());
    let floor = spawn(hall::floor(&pitch).finish(), matt(), -hall::FLOOR_DEPTH_M);
    let ground = [
        floor,
        spawn(carpet.into(), StandardMaterial { base_color_texture: Some(picture), ..matt() }, 0.0),
        spawn(lines(&pitch).finish(), matt(), LINE_HEIGHT),
    ];
    let boards = spawn(hall::boards(&pitch).finish(), matt(), 0.0);
    let people: Vec<Part<()>> = people(&pitch).iter().flat_map(Person::parts).collect();
    if !people.is_empty() {
        spawn(mesh_of_parts(&people), part_material(), 0.0);
    }
    for end in End::BOTH {
        spawn(mesh_of_parts(&field::goal_frame(&pitch, end)), part_material(), 0.0);
        let net = StandardMaterial {
            base_color: palette::NET.with_alpha(0.45),
            alpha_mode: AlphaMode::Blend,
            unlit: true,
            ..default()
        };
        spawn(net_lines(&field::net_strings(&pitch, end)), net, 0.0);
    }
    commands.entity(floor).insert(Floor);
    for part in ground {
        commands.entity(part).insert(Ground);
    }
    commands.entity(boards).insert(hall::NotInRobotsImages);
}

/// Computes the light on the ground for each pixel in fine drawing, with shadows, and once for all pixels otherwise, which
/// saves time without a graphics card.
fn light_ground(
    display: Res<DisplaySettings>,
    ground: Query<Ref<MeshMaterial3d<StandardMaterial>>, With<Ground>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for material in ground.iter().filter(|material| display.is_changed() || material.is_added()) {
        let is_lit_before = !display.fine_drawing;
        let light = if is_lit_before { light_on(Vec3::Z) } else { LinearRgba::WHITE };
        if let Some(mut material) = materials.get_mut(&material.0).filter(|material| material.unlit != is_lit_before) {
            material.unlit = is_lit_before;
            material.base_color = light.into();
        }
    }
}

/// Draws the pitch a second time, for another match, or removes it.
fn lay_out_second(
    second: Res<SecondPitch>,
    root: Res<PitchRoot>,
    old: Query<Entity, With<SecondPart>>,
    parts: Query<(&Mesh3d, &MeshMaterial3d<StandardMaterial>, &Transform), (With<FieldPart>, Without<Floor>)>,
    posts: Query<(&Transform, &Children), With<Post>>,
    models: Query<(&Mesh3d, &MeshMaterial3d<StandardMaterial>)>,
    mut commands: Commands,
) {
    old.iter().for_each(|part| commands.entity(part).despawn());
    let Some(distance_m) = second.0 else { return };
    let posts = posts.iter().flat_map(|(place, children)| children.iter().map(move |child| (place, child)));
    let posts =
        posts.filter_map(|(place, child)| models.get(child).ok().map(|(mesh, material)| (mesh, material, place)));
    for (mesh, material, place) in parts.iter().chain(posts) {
        let place = place.with_translation(place.translation + Vec3::Y * distance_m);
        commands.spawn((SecondPart, ChildOf(root.0), mesh.clone(), material.clone(), place));
    }
}

/// The lines and marks of the pitch.
fn lines(pitch: &Pitch) -> QuadMesh {
    let mut lines = QuadMesh::default();
    for mark in field::ground(pitch).into_iter().filter(|mark| mark.label == Label::Line) {
        match mark.shape {
            GroundShape::Quadrilateral(corners) => lines.add(corners.map(|corner| corner.extend(0.0)), colours::CHALK),
            GroundShape::Ring { centre, inner, outer } => lines.ring(centre, inner, outer, colours::CHALK),
        }
    }
    lines
}

/// The strings of a net as lines.
fn net_lines(strings: &[[Vec3; 2]]) -> Mesh {
    let ends: Vec<[f32; 3]> = strings.as_flattened().iter().map(|end| end.to_array()).collect();
    let count = ends.len();
    Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, ends)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; count])
}
