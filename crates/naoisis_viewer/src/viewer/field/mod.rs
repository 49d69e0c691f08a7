//! The models of carpet, lines, goals and nets for the pitch of the scenario, and of the hall around it.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::PrimitiveTopology;
use bevy::prelude::*;

mod hall;
mod quads;
mod simple;
mod turf;

use super::display_settings::DisplaySettings;
use super::palette;
use super::part_mesh::{mesh_of_parts, part_material};
use super::pitch_frame::PitchRoot;
use super::shared::SecondPitch;
use naoisis_core::pitch::{End, Pitch, Post};
use naoisis_sensing::appearance::field::{self, GroundShape};
use naoisis_sensing::appearance::people::{Person, people};
use naoisis_sensing::appearance::shapes::Part;
use naoisis_sensing::appearance::{Label, colours};
use quads::QuadMesh;
use simple::{SimpleMaterial, SimpleMaterialPlugin};

/// The height of the lines above the carpet, m.
const LINE_HEIGHT: f32 = 0.003;

/// Spawns the models of the pitch and the hall, and replaces them when the pitch changes.
pub struct FieldPlugin;

impl Plugin for FieldPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(SimpleMaterialPlugin)
            .init_resource::<SecondPitch>()
            .add_systems(
                Update,
                (
                    lay_out_field.run_if(resource_exists_and_changed::<Pitch>),
                    lay_out_second
                        .run_if(resource_changed::<SecondPitch>.or_else(resource_exists_and_changed::<Pitch>)),
                    choose_material,
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

/// The materials of a matt part, with and without fine drawing.
#[derive(Component, Clone)]
struct Surface {
    fine: MeshMaterial3d<StandardMaterial>,
    simple: MeshMaterial3d<SimpleMaterial>,
}

fn lay_out_field(
    mut commands: Commands,
    pitch: Res<Pitch>,
    root: Res<PitchRoot>,
    old: Query<Entity, With<FieldPart>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut simple: ResMut<Assets<SimpleMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    for part in &old {
        commands.entity(part).despawn();
    }
    let mut part = |mesh: Mesh, height_m: f32| {
        let place = Transform::from_xyz(0.0, 0.0, height_m);
        (FieldPart, ChildOf(root.0), Mesh3d(meshes.add(mesh)), place)
    };
    let mut material = |material| MeshMaterial3d(materials.add(material));
    let matt = || StandardMaterial { perceptual_roughness: 0.95, reflectance: 0.1, ..default() };
    let picture = images.add(turf::picture(&pitch));
    let [turf, plain] = [Some(picture), None].map(|picture| Surface {
        simple: MeshMaterial3d(simple.add(SimpleMaterial::new(picture.clone()))),
        fine: material(StandardMaterial { base_color_texture: picture, ..matt() }),
    });
    let carpet = Rectangle::from_size(2.0 * pitch.carpet_half_extents());
    commands.spawn((part(hall::floor(&pitch).finish(), -hall::FLOOR_DEPTH_M), plain.clone(), Floor));
    commands.spawn((part(carpet.into(), 0.0), turf));
    commands.spawn((part(lines(&pitch).finish(), LINE_HEIGHT), plain.clone()));
    commands.spawn((part(hall::boards(&pitch).finish(), 0.0), plain, hall::NotInRobotsImages));
    let people: Vec<Part<()>> = people(&pitch).iter().flat_map(Person::parts).collect();
    if !people.is_empty() {
        commands.spawn((part(mesh_of_parts(&people), 0.0), material(part_material())));
    }
    let net = material(StandardMaterial {
        base_color: palette::NET.with_alpha(0.45),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..default()
    });
    for end in End::BOTH {
        commands.spawn((part(mesh_of_parts(&field::goal_frame(&pitch, end)), 0.0), material(part_material())));
        commands.spawn((part(net_lines(&field::net_strings(&pitch, end)), 0.0), net.clone()));
    }
}

/// Gives matt parts the material of fine drawing or the simple one.
fn choose_material(display: Res<DisplaySettings>, surfaces: Query<(Entity, Ref<Surface>)>, mut commands: Commands) {
    for (part, surface) in surfaces.iter().filter(|(_, surface)| display.is_changed() || surface.is_added()) {
        let mut part = commands.entity(part);
        if display.fine_drawing {
            part.insert(surface.fine.clone()).remove::<MeshMaterial3d<SimpleMaterial>>();
        } else {
            part.insert(surface.simple.clone()).remove::<MeshMaterial3d<StandardMaterial>>();
        }
    }
}

/// Draws the pitch a second time, for another match, or removes it.
fn lay_out_second(
    second: Res<SecondPitch>,
    root: Res<PitchRoot>,
    old: Query<Entity, With<SecondPart>>,
    matt: Query<(&Mesh3d, &Surface, &Transform), (With<FieldPart>, Without<Floor>)>,
    parts: Query<(&Mesh3d, &MeshMaterial3d<StandardMaterial>, &Transform), (With<FieldPart>, Without<Surface>)>,
    posts: Query<(&Transform, &Children), With<Post>>,
    models: Query<(&Mesh3d, &MeshMaterial3d<StandardMaterial>)>,
    mut commands: Commands,
) {
    old.iter().for_each(|part| commands.entity(part).despawn());
    let Some(distance_m) = second.0 else { return };
    let part = |mesh: &Mesh3d, place: &Transform| {
        let place = place.with_translation(place.translation + Vec3::Y * distance_m);
        (SecondPart, ChildOf(root.0), mesh.clone(), place)
    };
    for (mesh, surface, place) in &matt {
        commands.spawn((part(mesh, place), surface.clone()));
    }
    let posts = posts.iter().flat_map(|(place, children)| children.iter().map(move |child| (place, child)));
    let posts =
        posts.filter_map(|(place, child)| models.get(child).ok().map(|(mesh, material)| (mesh, material, place)));
    for (mesh, material, place) in parts.iter().chain(posts) {
        commands.spawn((part(mesh, place), material.clone()));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_of_both_pitches_is_drawn_once_with_and_without_fine_drawing() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, AssetPlugin::default()))
            .init_asset::<Mesh>()
            .init_asset::<Image>()
            .init_asset::<StandardMaterial>()
            .init_asset::<SimpleMaterial>()
            .init_resource::<PitchRoot>()
            .init_resource::<DisplaySettings>()
            .insert_resource(Pitch::default())
            .insert_resource(SecondPitch(Some(10.0)))
            .add_systems(
                Update,
                (
                    lay_out_field.run_if(resource_exists_and_changed::<Pitch>),
                    lay_out_second.run_if(resource_changed::<SecondPitch>),
                    choose_material,
                )
                    .chain(),
            );
        for fine_drawing in [true, false, true] {
            app.world_mut().resource_mut::<DisplaySettings>().fine_drawing = fine_drawing;
            app.update();
            let parts = app.world_mut().query_filtered::<(
                Has<Surface>,
                Has<MeshMaterial3d<StandardMaterial>>,
                Has<MeshMaterial3d<SimpleMaterial>>,
            ), Or<(With<FieldPart>, With<SecondPart>)>>().iter(app.world()).collect::<Vec<_>>();
            // Floor, carpet, lines and boards, the last three twice.
            assert_eq!(parts.iter().filter(|(is_matt, ..)| *is_matt).count(), 7);
            for (is_matt, is_fine, is_simple) in parts {
                assert_eq!((is_fine, is_simple), (fine_drawing || !is_matt, !fine_drawing && is_matt));
            }
        }
    }
}
