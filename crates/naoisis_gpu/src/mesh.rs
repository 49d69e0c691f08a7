//! Meshes of the [shapes](naoisis_sensing::appearance::shapes), for renderers on a graphics card.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{MeshMergeError, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use naoisis_core::ball::BallLook;
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::appearance::field::{GroundMark, GroundShape};
use naoisis_sensing::appearance::shapes::{Part, Shape};
use naoisis_sensing::appearance::{Label, ball, turf};

/// Number of corners of a circle on the ground.
const CIRCLE_CORNERS: usize = 160;

/// Returns the mesh of a shape in its own frame.
pub fn mesh_of(shape: Shape) -> Mesh {
    match shape {
        Shape::Box { half_size } => Cuboid { half_size }.into(),
        Shape::Ellipsoid { radii } => {
            let sphere = Sphere::new(1.0).mesh().uv(20, 12);
            sphere.transformed_by(Transform::from_scale(radii))
        }
        Shape::Frustum { bottom, top, half_height } => frustum(bottom, top, half_height),
        Shape::Capsule { radius, half_length } => {
            let rod = Capsule3d::new(radius, 2.0 * half_length).mesh().longitudes(16).latitudes(8).build();
            rod.transformed_by(upright(Vec3::ZERO))
        }
    }
}

/// Returns a transform that turns a shape from the y axis to the z axis and moves it to `centre`.
pub fn upright(centre: Vec3) -> Transform {
    Transform::from_translation(centre).with_rotation(Quat::from_rotation_x(FRAC_PI_2))
}

/// Returns the mesh of a frustum: a cylinder of radius 1 whose ends are stretched.
fn frustum(bottom: Vec2, top: Vec2, half_height: f32) -> Mesh {
    let mut mesh = Cylinder::new(1.0, 2.0 * half_height).mesh().resolution(24).build();
    let slant = (bottom - top) / (2.0 * half_height).max(1e-6);
    // The axis of Bevy's cylinder is y.
    let places: Vec<Vec3> = match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(places)) => places.iter().map(|&[x, y, z]| Vec3::new(x, -z, y)).collect(),
        _ => Vec::new(),
    };
    let stretched = places.iter().map(|place| {
        let radii = bottom.lerp(top, (place.z + half_height) / (2.0 * half_height).max(1e-6));
        (place.truncate() * radii).extend(place.z).to_array()
    });
    let stretched: Vec<[f32; 3]> = stretched.collect();
    if let Some(VertexAttributeValues::Float32x3(normals)) = mesh.attribute_mut(Mesh::ATTRIBUTE_NORMAL) {
        for (normal, place) in normals.iter_mut().zip(&places) {
            let [x, y, z] = *normal;
            // The normals of the ends point up and down, those of the side outwards with its slope.
            *normal = if y.abs() > 0.5 {
                [0.0, 0.0, y.signum()]
            } else {
                let radii = (bottom + top) / 2.0;
                let outwards = Vec2::new(x * radii.y, -z * radii.x).normalize_or(place.truncate());
                let rise = (slant * outwards * outwards).element_sum();
                outwards.extend(rise).normalize_or(Vec3::X).to_array()
            };
        }
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, stretched);
    mesh
}

/// Returns the colour of a vertex: red, green and blue from 0 to 1 as in the file (sRGB, not linear), and the number of the label divided
/// by 255 as the alpha value.
pub fn vertex_colour(colour: Colour, label: Label) -> [f32; 4] {
    let [red, green, blue] = colour.0.map(|channel| f32::from(channel) / 255.0);
    [red, green, blue, f32::from(label as u8) / 255.0]
}

/// Returns one mesh of several parts, each in its own frame, with colours and labels in the vertices ([`vertex_colour`]). Without parts,
/// the mesh is an invisible box of size 0.
///
/// # Errors
/// When the meshes of two shapes have different attributes, which would be a mistake in this module.
pub fn labelled_mesh<'a, Frame: 'a>(parts: impl IntoIterator<Item = &'a Part<Frame>>) -> Result<Mesh, MeshMergeError> {
    let mut whole: Option<Mesh> = None;
    for part in parts {
        let mesh = mesh_of(part.shape).transformed_by(Transform::from_matrix(part.frame_from_shape.into()));
        let colours = vec![vertex_colour(part.colour, part.label); mesh.count_vertices()];
        let mesh = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours);
        match &mut whole {
            None => whole = Some(mesh),
            Some(whole) => whole.merge(&mesh)?,
        }
    }
    Ok(whole.unwrap_or_else(|| {
        let speck = Mesh::from(Cuboid::from_length(0.0));
        let colours = vec![[0.0; 4]; speck.count_vertices()];
        speck.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
    }))
}

/// Returns the mesh of a ball with its centre in the origin, and the colour of each of its vertices.
pub fn ball_mesh(radius_m: f32, look: BallLook) -> (Mesh, Vec<Colour>) {
    let patches = ball::patches(look);
    // The edges of patches are as sharp as the mesh is fine.
    let [sectors, stacks] = if patches.is_empty() { [32, 18] } else { [128, 64] };
    let mesh = Sphere::new(radius_m).mesh().uv(sectors, stacks);
    let colours = match mesh.attribute(Mesh::ATTRIBUTE_NORMAL) {
        Some(VertexAttributeValues::Float32x3(normals)) => {
            normals.iter().map(|normal| ball::colour_at(look, &patches, Vec3::from_array(*normal))).collect()
        }
        _ => Vec::new(),
    };
    (mesh, colours)
}

/// Returns the mesh of a ball with colours and labels in the vertices ([`vertex_colour`]).
pub fn labelled_ball_mesh(radius_m: f32, look: BallLook) -> Mesh {
    let (mesh, colours) = ball_mesh(radius_m, look);
    let colours: Vec<[f32; 4]> = colours.into_iter().map(|colour| vertex_colour(colour, Label::Ball)).collect();
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
}

/// Returns one mesh of the marks on the ground, ordered from the bottom up: each lies `step_m` above the previous one, so that the upper
/// ones are visible. The normals are zero, so the colours are flat, without light. `unevenness` is that of the carpet.
pub fn ground_mesh(marks: &[GroundMark], unevenness: f32, lowest_m: f32, step_m: f32) -> Mesh {
    let mut triangles = Vec::new();
    let mut colours = Vec::new();
    for (index, mark) in marks.iter().enumerate() {
        let height = lowest_m + step_m * index as f32;
        match mark.shape {
            GroundShape::Quadrilateral(corners) if mark.label == Label::Carpet && unevenness > 0.0 => {
                for (place, brightness) in carpet_triangles(corners, unevenness) {
                    triangles.push(place.extend(height));
                    let [red, green, blue, label] = vertex_colour(mark.colour, mark.label);
                    colours.push([brightness * red, brightness * green, brightness * blue, label]);
                }
            }
            GroundShape::Quadrilateral([a, b, c, d]) => {
                triangles.extend([a, b, c, a, c, d].map(|at| at.extend(height)));
            }
            GroundShape::Ring { centre, inner, outer } => {
                let at = |corner: usize, radius: f32| {
                    let angle = core::f32::consts::TAU * (corner % CIRCLE_CORNERS) as f32 / CIRCLE_CORNERS as f32;
                    (centre + radius * Vec2::from_angle(angle)).extend(height)
                };
                for corner in 0..CIRCLE_CORNERS {
                    let [a, b] = [corner, corner + 1].map(|corner| at(corner, inner));
                    let [c, d] = [corner + 1, corner].map(|corner| at(corner, outer));
                    triangles.extend([a, d, c, a, c, b]);
                }
            }
        }
        colours.resize(triangles.len(), vertex_colour(mark.colour, mark.label));
    }
    flat_mesh(PrimitiveTopology::TriangleList, triangles, colours)
}

/// Returns the corners of the triangles of an uneven carpet, m, counter-clockwise from above, each with the brightness of the turf there.
/// `corners` are those of the carpet, the least first and the greatest third.
fn carpet_triangles([least, _, most, _]: [Vec2; 4], unevenness: f32) -> impl Iterator<Item = (Vec2, f32)> {
    let counts = ((most - least) / turf::TUFT_M).ceil().max(Vec2::ONE);
    let step = (most - least) / counts;
    let squares = (0..counts.x as u32).flat_map(move |x| (0..counts.y as u32).map(move |y| (x, y)));
    squares.flat_map(move |(x, y)| {
        let corner = |x: u32, y: u32| least + step * Vec2::new(x as f32, y as f32);
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [a, b, c, a, c, d].map(|place| (place, turf::brightness(place, 0.0, unevenness)))
    })
}

/// Returns one mesh of lines, such as the strings of a net.
pub fn line_mesh(lines: &[[Vec3; 2]], colour: Colour, label: Label) -> Mesh {
    let ends: Vec<Vec3> = lines.iter().flatten().copied().collect();
    let colours = vec![vertex_colour(colour, label); ends.len()];
    flat_mesh(PrimitiveTopology::LineList, ends, colours)
}

fn flat_mesh(topology: PrimitiveTopology, places: Vec<Vec3>, colours: Vec<[f32; 4]>) -> Mesh {
    let places: Vec<[f32; 3]> = places.iter().map(Vec3::to_array).collect();
    let normals = vec![[0.0; 3]; places.len()];
    Mesh::new(topology, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, places)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::camera::primitives::MeshAabb;
    use naoisis_core::pitch::Pitch;
    use naoisis_sensing::appearance::{colours, field};

    #[test]
    fn shapes_are_as_large_as_they_say() {
        let frustum = Shape::Frustum { bottom: Vec2::new(0.1, 0.2), top: Vec2::new(0.3, 0.1), half_height: 0.5 };
        for (shape, half_size) in [
            (Shape::Box { half_size: Vec3::new(0.1, 0.2, 0.3) }, Vec3::new(0.1, 0.2, 0.3)),
            (Shape::Ellipsoid { radii: Vec3::new(0.1, 0.2, 0.3) }, Vec3::new(0.1, 0.2, 0.3)),
            (frustum, Vec3::new(0.3, 0.2, 0.5)),
            (Shape::Capsule { radius: 0.1, half_length: 0.4 }, Vec3::new(0.1, 0.1, 0.5)),
        ] {
            let bounds = mesh_of(shape).compute_aabb().unwrap();
            assert!(Vec3::from(bounds.half_extents).abs_diff_eq(half_size, 0.01), "{shape:?}: {bounds:?}");
        }
    }

    #[test]
    fn what_is_upright_points_to_the_sky() {
        let up = upright(Vec3::ZERO).transform_point(Vec3::Y);
        assert!(up.abs_diff_eq(Vec3::Z, 1e-6), "{up}");
    }

    #[test]
    fn a_mesh_is_the_sum_of_its_parts_with_their_labels() {
        let part = |label, shape| Part::at((), label, colours::BALL, shape, Vec3::ZERO);
        let parts = [part(Label::Ball, Shape::sphere(1.0)), part(Label::Post, Shape::Box { half_size: Vec3::ONE })];
        let mesh = labelled_mesh(&parts).unwrap();
        let Some(VertexAttributeValues::Float32x4(colours)) = mesh.attribute(Mesh::ATTRIBUTE_COLOR) else { panic!() };
        let with =
            |label: Label| colours.iter().filter(|colour| (colour[3] * 255.0).round() as u8 == label as u8).count();
        assert_eq!(with(Label::Ball) + with(Label::Post), colours.len());
        assert_eq!(with(Label::Post), 24);
    }

    #[test]
    fn a_football_is_white_with_black_patches() {
        let (mesh, colours) = ball_mesh(0.05, BallLook::Pentagons);
        assert_eq!(mesh.count_vertices(), colours.len());
        let black = colours.iter().filter(|colour| **colour == ball::BLACK).count();
        assert!((0.15..0.45).contains(&(black as f32 / colours.len() as f32)), "{black} of {}", colours.len());
        let (_, plain) = ball_mesh(0.05, BallLook::Orange);
        assert!(plain.iter().all(|colour| *colour == colours::BALL));
    }

    #[test]
    fn upper_marks_lie_higher_and_all_face_up() {
        let marks = field::ground(&Pitch::default());
        let mesh = ground_mesh(&marks, 0.15, 0.0, 0.001);
        let Some(VertexAttributeValues::Float32x3(places)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else { panic!() };
        for [a, b, c] in places.as_chunks::<3>().0 {
            let [a, b, c] = [a, b, c].map(|&place| Vec3::from_array(place));
            assert!((b - a).cross(c - a).z > 0.0);
        }
        let highest = places.iter().map(|place| place[2]).fold(0.0, f32::max);
        assert!((highest - 0.001 * (marks.len() - 1) as f32).abs() < 1e-6);
    }
}
