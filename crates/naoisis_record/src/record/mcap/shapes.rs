//! Converts positions, colours and shapes of the simulation to Foxglove's types.

use bevy::math::{Affine3A, Quat, Vec2, Vec3};
use foxglove::messages::{
    Color, CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneEntityDeletion,
    SceneUpdate, SpherePrimitive, TextPrimitive, Timestamp, TriangleListPrimitive, Vector3, line_primitive,
    scene_entity_deletion,
};

use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::appearance::shapes::{Part, Shape};
use naoisis_sensing::belief::PlaceCovariance;
use naoisis_sensing::belief::covariance::half_axes_95;

/// Name of the pitch frame, which is the world frame.
pub(super) const PITCH: &str = "pitch";
const NANOSECONDS: u64 = 1_000_000_000;
/// Resolution: steps in a metre and in a unit of a quaternion's components, a quarter of a millimetre. Numbers with few binary digits make
/// smaller files.
const STEPS: f32 = 4096.0;

fn stepped(number: f32) -> f64 {
    f64::from((number * STEPS).round() / STEPS)
}

pub(super) fn timestamp(time_ns: u64) -> Option<Timestamp> {
    let seconds = u32::try_from(time_ns / NANOSECONDS).unwrap_or(u32::MAX);
    Some(Timestamp::new(seconds, (time_ns % NANOSECONDS) as u32))
}

pub(super) fn vector(of: Vec3) -> Option<Vector3> {
    let [x, y, z] = of.to_array().map(stepped);
    Some(Vector3 { x, y, z })
}

fn point(of: Vec3) -> Point3 {
    let [x, y, z] = of.to_array().map(stepped);
    Point3 { x, y, z }
}

pub(super) fn quaternion(of: Quat) -> Option<Quaternion> {
    let [x, y, z, w] = of.to_array().map(stepped);
    Some(Quaternion { x, y, z, w })
}

pub(super) fn pose(of: Affine3A) -> Option<Pose> {
    let rotation = Quat::from_mat3a(&of.matrix3);
    Some(Pose { position: vector(of.translation.into()), orientation: quaternion(rotation) })
}

pub(super) fn at(place: Vec3) -> Option<Pose> {
    pose(Affine3A::from_translation(place))
}

/// Returns a colour with this opacity, from 0 to 1.
pub(super) fn colour(Colour(of): Colour, opacity: f64) -> Option<Color> {
    let [r, g, b] = of.map(|part| f64::from(part) / 255.0);
    Some(Color { r, g, b, a: opacity })
}

/// A collection of shapes in one frame.
pub(super) struct Entity(pub SceneEntity);

impl Entity {
    /// Creates an empty entity in `frame`. It stays where the frame was at `time_ns`.
    pub(super) fn new(id: &str, frame: &str, time_ns: u64) -> Self {
        Self(SceneEntity {
            id: id.to_owned(),
            frame_id: frame.to_owned(),
            timestamp: timestamp(time_ns),
            ..SceneEntity::default()
        })
    }

    /// Makes the entity move with its frame.
    pub(super) fn locked(mut self) -> Self {
        self.0.frame_locked = true;
        self
    }

    pub(super) fn sphere(&mut self, centre: Vec3, radius: f32, colour: Option<Color>) {
        self.ellipsoid(Affine3A::from_translation(centre), Vec3::splat(radius), colour);
    }

    fn ellipsoid(&mut self, place: Affine3A, radii: Vec3, color: Option<Color>) {
        self.0.spheres.push(SpherePrimitive { pose: pose(place), size: vector(2.0 * radii), color });
    }

    /// Adds an upright cylinder on the ground.
    pub(super) fn pillar(&mut self, foot: Vec2, radius: f32, height: f32, colour: Option<Color>) {
        let place = Affine3A::from_translation(foot.extend(height / 2.0));
        self.cylinder(place, Vec2::splat(2.0 * radius).extend(height), [1.0, 1.0], colour);
    }

    fn cylinder(&mut self, place: Affine3A, size: Vec3, scales: [f32; 2], color: Option<Color>) {
        let [bottom_scale, top_scale] = scales.map(f64::from);
        self.0.cylinders.push(CylinderPrimitive {
            pose: pose(place),
            size: vector(size),
            bottom_scale,
            top_scale,
            color,
        });
    }

    /// Adds the 95 % ellipse as a flat cylinder of this height (m) on the ground, if the matrix is a valid covariance.
    pub(super) fn ellipse(&mut self, centre: Vec2, covariance: PlaceCovariance, height: f32, colour: Option<Color>) {
        let Some([long, short]) = half_axes_95(covariance) else { return };
        // The rotation from x to the longer axis.
        let along = long.normalize_or(Vec2::X);
        let rotation = Quat::from_rotation_arc_2d(Vec2::X, along);
        let size = Vec3::new(2.0 * long.length(), 2.0 * short.length(), height);
        let place = Affine3A::from_rotation_translation(rotation, centre.extend(height / 2.0));
        self.cylinder(place, size, [1.0, 1.0], colour);
    }

    /// Adds a line of this width (m) from each first to each second point.
    pub(super) fn lines(&mut self, ends: impl IntoIterator<Item = [Vec3; 2]>, width_m: f32, color: Option<Color>) {
        let points: Vec<Point3> = ends.into_iter().flatten().map(point).collect();
        if !points.is_empty() {
            self.0.lines.push(LinePrimitive {
                r#type: line_primitive::Type::LineList.into(),
                pose: at(Vec3::ZERO),
                thickness: f64::from(width_m),
                points,
                color,
                ..LinePrimitive::default()
            });
        }
    }

    /// Adds triangles, with three corners each.
    pub(super) fn triangles(&mut self, corners: impl IntoIterator<Item = Vec3>, color: Option<Color>) {
        let points = corners.into_iter().map(point).collect();
        let pose = at(Vec3::ZERO);
        self.0.triangles.push(TriangleListPrimitive { pose, points, color, ..TriangleListPrimitive::default() });
    }

    /// Adds a text that faces the viewer.
    pub(super) fn text(&mut self, place: Vec3, text: &str, height_m: f32, color: Option<Color>) {
        self.0.texts.push(TextPrimitive {
            pose: at(place),
            billboard: true,
            font_size: f64::from(height_m),
            color,
            text: text.to_owned(),
            ..TextPrimitive::default()
        });
    }

    /// Adds a part. `entity_from_frame` is the transform from the part's frame.
    pub(super) fn part<Frame>(&mut self, part: &Part<Frame>, entity_from_frame: Affine3A, opacity: f64) {
        let (place, color) = (entity_from_frame * part.frame_from_shape, colour(part.colour, opacity));
        match part.shape {
            Shape::Box { half_size } => {
                self.0.cubes.push(CubePrimitive { pose: pose(place), size: vector(2.0 * half_size), color });
            }
            Shape::Ellipsoid { radii } => self.ellipsoid(place, radii, color),
            Shape::Frustum { bottom, top, half_height } => {
                let widest = bottom.max(top).max(Vec2::splat(f32::MIN_POSITIVE));
                let scales = [bottom, top].map(|end| (end / widest).max_element());
                self.cylinder(place, (2.0 * widest).extend(2.0 * half_height), scales, color);
            }
            Shape::Capsule { radius, half_length } => {
                self.cylinder(place, Vec2::splat(2.0 * radius).extend(2.0 * half_length), [1.0, 1.0], color);
                for end in [-half_length, half_length] {
                    self.sphere(place.transform_point3(Vec3::Z * end), radius, color);
                }
            }
        }
    }

    /// Returns an update that replaces all entities of the topic by this one.
    pub(super) fn scene(self) -> SceneUpdate {
        scene([self])
    }
}

/// Returns an update that replaces all entities of the topic by these.
pub(super) fn scene(entities: impl IntoIterator<Item = Entity>) -> SceneUpdate {
    let all = SceneEntityDeletion { r#type: scene_entity_deletion::Type::All.into(), ..SceneEntityDeletion::default() };
    SceneUpdate { deletions: vec![all], entities: entities.into_iter().map(|Entity(entity)| entity).collect() }
}
