//! Reads MJCF, MuJoCo's descriptions, with includes, default classes, and the compiler's settings.

use bevy::math::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::DescriptionError;
use super::meshes;
use super::tree::{Camera, CameraAxes, Fov, Joint, Link, Shape, Tree};
use super::urdf::MOST_LINKS;
use super::xml::Element;

/// Depth of nested includes at most.
const DEEPEST_INCLUDE: usize = 20;

/// The attributes of elements, by the elements' names.
type Attributes = BTreeMap<String, BTreeMap<String, String>>;

/// The settings of the `<compiler>`.
struct Compiler {
    /// The unit of angles, radians.
    angle: f64,
    euler_order: String,
    mesh_folder: PathBuf,
    has_automatic_limits: bool,
}

struct Reader {
    compiler: Compiler,
    classes: BTreeMap<String, Attributes>,
    /// Files and scales of meshes, by the meshes' names.
    meshes: BTreeMap<String, (PathBuf, DVec3)>,
    links: Vec<Link>,
    warnings: Vec<String>,
}

/// The context in which elements of a body are read.
#[derive(Clone, Copy)]
struct Scope<'a> {
    link: usize,
    /// The transform from the present frame to the link's, for `<frame>` elements.
    link_from_here: DAffine3,
    class: &'a str,
}

/// Reads the robot in a `<mujoco>` element.
pub(super) fn read(model: Element, path: &Path) -> Result<Tree, DescriptionError> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let model = with_includes(model, &folder, &folder, 0)?;
    let mut reader = Reader {
        compiler: compiler(&model, &folder)?,
        classes: BTreeMap::new(),
        meshes: BTreeMap::new(),
        links: Vec::new(),
        warnings: Vec::new(),
    };
    reader.classes.insert("main".to_owned(), Attributes::new());
    for defaults in model.all("default") {
        reader.add_class(defaults, defaults.attribute("class").unwrap_or("main"), "main")?;
    }
    for mesh in model.all("asset").flat_map(|assets| assets.all("mesh")) {
        reader.add_mesh(mesh)?;
    }
    let world: Vec<&Element> = model.all("worldbody").collect();
    let mut bodies: Vec<&Element> = world.iter().flat_map(|world| world.all("body")).collect();
    bodies.extend(world.iter().flat_map(|world| world.all("frame")).flat_map(|frame| frame.all("body")));
    // The file may also contain a ball and posts.
    let Some(robot) = bodies.iter().rev().max_by_key(|body| count_bodies(body)) else {
        return Err(model.place.wrong("there is no <body> in the <worldbody>"));
    };
    if count_bodies(robot) > MOST_LINKS {
        return Err(robot.place.wrong(format!("there are more than {MOST_LINKS} bodies")));
    }
    reader.add_body(robot, None, "main")?;
    let name = model.attribute("model").unwrap_or_default().to_owned();
    let Reader { links, warnings, .. } = reader;
    Ok(Tree { name, links, warnings })
}

/// Returns the number of bodies in a body, itself included.
fn count_bodies(body: &Element) -> usize {
    let inner = body.children.iter().filter(|child| child.name == "body" || child.name == "frame");
    usize::from(body.name == "body") + inner.map(count_bodies).sum::<usize>()
}

/// Replaces `<include>` elements by the contents of their files, which are in `main` or otherwise in `folder`.
fn with_includes(element: Element, main: &Path, folder: &Path, depth: usize) -> Result<Element, DescriptionError> {
    let mut children = Vec::with_capacity(element.children.len());
    for child in element.children {
        if child.name != "include" {
            children.push(with_includes(child, main, folder, depth)?);
            continue;
        }
        if depth >= DEEPEST_INCLUDE {
            return Err(child.place.wrong(format!("files are included more than {DEEPEST_INCLUDE} deep")));
        }
        let name = child.needs("file")?;
        let path = [main, folder].map(|folder| folder.join(name)).into_iter().find(|path| path.is_file());
        let path = path.ok_or_else(|| child.place.wrong(format!("the included file {name} is not there")))?;
        let included = with_includes(Element::read(&path)?, main, path.parent().unwrap_or(main), depth + 1)?;
        children.extend(included.children);
    }
    Ok(Element { children, ..element })
}

fn compiler(model: &Element, folder: &Path) -> Result<Compiler, DescriptionError> {
    let mut compiler = Compiler {
        angle: 1.0_f64.to_radians(),
        euler_order: "xyz".to_owned(),
        mesh_folder: folder.to_owned(),
        has_automatic_limits: true,
    };
    for element in model.all("compiler") {
        match element.attribute("angle") {
            Some("radian") => compiler.angle = 1.0,
            Some("degree") => compiler.angle = 1.0_f64.to_radians(),
            Some(other) => {
                return Err(element.place.wrong(format!("`angle` is \"{other}\"; expected degree or radian")));
            }
            None => {}
        }
        if let Some(order) = element.attribute("eulerseq") {
            if order.len() != 3 || !order.chars().all(|axis| "xyzXYZ".contains(axis)) {
                let expected = "three of x, y, z, X, Y, Z";
                return Err(element.place.wrong(format!("`eulerseq` is \"{order}\"; expected {expected}")));
            }
            order.clone_into(&mut compiler.euler_order);
        }
        if let Some(inside) = element.attribute("assetdir").or(element.attribute("meshdir")) {
            compiler.mesh_folder = folder.join(inside);
        }
        if let Some(inside) = element.attribute("meshdir") {
            compiler.mesh_folder = folder.join(inside);
        }
        compiler.has_automatic_limits &= element.attribute("autolimits") != Some("false");
    }
    Ok(compiler)
}

impl Reader {
    /// Adds the class of a `<default>` and those inside it. `outer` is the enclosing class.
    fn add_class(&mut self, defaults: &Element, name: &str, outer: &str) -> Result<(), DescriptionError> {
        let mut class = self.classes.get(name).or(self.classes.get(outer)).cloned().unwrap_or_default();
        for element in defaults.children.iter().filter(|child| child.name != "default") {
            class.entry(element.name.clone()).or_default().extend(element.attributes.iter().cloned());
        }
        self.classes.insert(name.to_owned(), class);
        for inner in defaults.all("default") {
            self.add_class(inner, inner.needs("class")?, name)?;
        }
        Ok(())
    }

    /// Returns an element with the default attributes of its class. `class` is that of its body.
    fn with_defaults(&self, element: &Element, class: &str) -> Result<Element, DescriptionError> {
        let own = element.attribute("class");
        let Some(defaults) = self.classes.get(own.unwrap_or(class)) else {
            let place = &element.place;
            return Err(place.wrong(format!("there is no default class `{}`", own.unwrap_or(class))));
        };
        let mut element = element.clone();
        for (name, value) in defaults.get(&element.name).into_iter().flatten() {
            if element.attribute(name).is_none() {
                element.attributes.push((name.clone(), value.clone()));
            }
        }
        Ok(element)
    }

    fn add_mesh(&mut self, mesh: &Element) -> Result<(), DescriptionError> {
        let mesh = self.with_defaults(mesh, "main")?;
        // A mesh of points in the description itself is not read.
        let Some(file) = mesh.attribute("file") else { return Ok(()) };
        let path = self.compiler.mesh_folder.join(file);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let scale = mesh.vector::<3>("scale")?.map_or(DVec3::ONE, DVec3::from);
        self.meshes.insert(mesh.attribute("name").map_or(stem, str::to_owned), (path, scale));
        Ok(())
    }

    /// Adds a body and the bodies in it. The first one is the robot's root.
    fn add_body(&mut self, body: &Element, around: Option<Scope>, class: &str) -> Result<(), DescriptionError> {
        let link = self.links.len();
        let place = self.placement(body)?;
        let class = body.attribute("childclass").unwrap_or(class);
        self.links.push(Link {
            name: body.attribute("name").map_or_else(|| format!("body {link}"), str::to_owned),
            parent: around.map(|scope| scope.link),
            // The position of the robot in its world is irrelevant.
            parent_from_link: around.map_or(DAffine3::IDENTITY, |scope| scope.link_from_here * place),
            joints: Vec::new(),
            shapes: Vec::new(),
            cameras: Vec::new(),
        });
        let scope = Scope { link, link_from_here: DAffine3::IDENTITY, class };
        self.add_content(body, scope)?;
        // Geoms that are only drawn are used if the body has no collisions.
        if self.links[link].shapes.is_empty() {
            self.add_geoms(body, scope, false)?;
        }
        Ok(())
    }

    /// Adds the geoms of a body: those that collide, or those that are only drawn.
    fn add_geoms(&mut self, element: &Element, scope: Scope, is_collision: bool) -> Result<(), DescriptionError> {
        for child in &element.children {
            match child.name.as_str() {
                "geom" => self.add_geom(child, scope, is_collision)?,
                "frame" => self.add_geoms(child, self.in_frame(child, scope)?, is_collision)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the scope of the elements in a `<frame>`.
    fn in_frame<'a>(&self, frame: &'a Element, scope: Scope<'a>) -> Result<Scope<'a>, DescriptionError> {
        let class = frame.attribute("childclass").unwrap_or(scope.class);
        Ok(Scope { link_from_here: scope.link_from_here * self.placement(frame)?, class, ..scope })
    }

    fn add_content(&mut self, element: &Element, scope: Scope) -> Result<(), DescriptionError> {
        for child in &element.children {
            match child.name.as_str() {
                "body" => self.add_body(child, Some(scope), scope.class)?,
                "frame" => self.add_content(child, self.in_frame(child, scope)?)?,
                "joint" => self.add_joint(child, scope)?,
                "geom" => self.add_geom(child, scope, true)?,
                "camera" => self.add_camera(child, scope)?,
                "replicate" | "attach" | "composite" | "flexcomp" => {
                    self.warnings.push(format!("{}: <{}> is not read", child.place, child.name));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn add_joint(&mut self, joint: &Element, scope: Scope) -> Result<(), DescriptionError> {
        let joint = self.with_defaults(joint, scope.class)?;
        let is_hinge = match joint.attribute("type").unwrap_or("hinge") {
            "hinge" => true,
            "slide" => false,
            "free" => return Ok(()),
            other => {
                self.warnings.push(format!("{}: a joint of the type {other} is taken as fixed", joint.place));
                return Ok(());
            }
        };
        let axis = joint.vector::<3>("axis")?.map_or(DVec3::Z, DVec3::from);
        let axis = axis.try_normalize().ok_or_else(|| joint.place.wrong("the axis of the joint has no direction"))?;
        let point = joint.vector::<3>("pos")?.map_or(DVec3::ZERO, DVec3::from);
        let is_limited = match joint.attribute("limited") {
            Some("true") => true,
            Some("false") => false,
            _ => self.compiler.has_automatic_limits,
        };
        let unit = if is_hinge { self.compiler.angle } else { 1.0 };
        let limits = joint.vector::<2>("range")?.filter(|_| is_limited).map(|range| range.map(|end| end * unit));
        let link = &mut self.links[scope.link];
        let name = joint.attribute("name").map_or_else(|| format!("joint of {}", link.name), str::to_owned);
        let axis = scope.link_from_here.transform_vector3(axis);
        let point = scope.link_from_here.transform_point3(point);
        link.joints.push(Joint { name, is_hinge, axis, point, limits, place: joint.place });
        Ok(())
    }

    fn add_geom(&mut self, geom: &Element, scope: Scope, is_collision: bool) -> Result<(), DescriptionError> {
        let geom = self.with_defaults(geom, scope.class)?;
        let collides = |name: &str| geom.attribute(name).is_none_or(|bits| bits.trim() != "0");
        if is_collision != (collides("contype") || collides("conaffinity")) {
            return Ok(());
        }
        let size = geom.numbers("size", 1, 3)?.unwrap_or_default();
        let size_of = |index: usize| size.get(index).copied().unwrap_or(0.0);
        let kind = geom.attribute("type").unwrap_or("sphere");
        let mut place = self.placement(&geom)?;
        let ends = geom.vector::<6>("fromto")?;
        if let Some([x1, y1, z1, x2, y2, z2]) = ends {
            let (from, to) = (DVec3::new(x1, y1, z1), DVec3::new(x2, y2, z2));
            let direction = (to - from).try_normalize().unwrap_or(DVec3::Z);
            let turn = DQuat::from_rotation_arc(DVec3::Z, direction);
            place = DAffine3::from_rotation_translation(turn, (from + to) / 2.0);
        }
        let half_length = match ends {
            Some([x1, y1, z1, x2, y2, z2]) => DVec3::new(x2 - x1, y2 - y1, z2 - z1).length() / 2.0,
            None => size_of(1),
        };
        let half = match (geom.attribute("mesh"), kind) {
            (Some(mesh), _) => {
                let Some((path, scale)) = self.meshes.get(mesh) else {
                    self.warnings.push(format!("{}: the mesh `{mesh}` has no file", geom.place));
                    return Ok(());
                };
                match meshes::bounds_of(path, *scale) {
                    Ok([least, most]) => {
                        place *= DAffine3::from_translation((least + most) / 2.0);
                        (most - least) / 2.0
                    }
                    Err(problem) => {
                        self.warnings.push(format!("{}: {problem}", geom.place));
                        return Ok(());
                    }
                }
            }
            (None, "sphere") => DVec3::splat(size_of(0)),
            (None, "capsule") => DVec3::new(size_of(0), size_of(0), half_length + size_of(0)),
            (None, "cylinder") => DVec3::new(size_of(0), size_of(0), half_length),
            (None, "box" | "ellipsoid") if ends.is_some() => {
                DVec3::new(size_of(0), size.get(1).copied().unwrap_or(size_of(0)), half_length)
            }
            (None, "box" | "ellipsoid") => DVec3::new(size_of(0), size_of(1), size_of(2)),
            _ => return Ok(()),
        };
        let link_from_box = scope.link_from_here * place;
        self.links[scope.link].shapes.push(Shape { link_from_box, half });
        Ok(())
    }

    fn add_camera(&mut self, camera: &Element, scope: Scope) -> Result<(), DescriptionError> {
        let camera = self.with_defaults(camera, scope.class)?;
        let size = camera.vector::<2>("resolution")?.filter(|size| size.iter().all(|side| *side > 1.0));
        // `fovy` is in degrees, whatever the compiler's unit of angles is.
        let mut vertical = camera.number("fovy")?.map(f64::to_radians);
        if let (Some([_, focal]), Some([_, height])) = (camera.vector::<2>("focalpixel")?, size) {
            vertical = Some(2.0 * libm::atan(height / 2.0 / focal));
        }
        let link_from_camera = scope.link_from_here * self.placement(&camera)?;
        let link = &mut self.links[scope.link];
        link.cameras.push(Camera {
            name: camera.attribute("name").map_or_else(|| format!("camera of {}", link.name), str::to_owned),
            link_from_camera,
            axes: CameraAxes::MuJoCo,
            size: size.map(|size| size.map(|side| side as u32)),
            fov: vertical.map(Fov::Vertical),
            place: camera.place,
        });
        Ok(())
    }

    /// Returns the transform in the attributes of an element.
    fn placement(&self, element: &Element) -> Result<DAffine3, DescriptionError> {
        let place = element.vector::<3>("pos")?.map_or(DVec3::ZERO, DVec3::from);
        Ok(DAffine3::from_rotation_translation(self.rotation(element)?, place))
    }

    fn rotation(&self, element: &Element) -> Result<DQuat, DescriptionError> {
        let wrong = |name: &str| element.place.wrong(format!("`{name}` of <{}> has no direction", element.name));
        if let Some([w, x, y, z]) = element.vector("quat")? {
            let quat = DQuat::from_xyzw(x, y, z, w);
            return if quat.length_squared() > 0.0 { Ok(quat.normalize()) } else { Err(wrong("quat")) };
        }
        if let Some([x, y, z, angle]) = element.vector("axisangle")? {
            let axis = DVec3::new(x, y, z).try_normalize().ok_or_else(|| wrong("axisangle"))?;
            return Ok(DQuat::from_axis_angle(axis, angle * self.compiler.angle));
        }
        if let Some(angles) = element.vector::<3>("euler")? {
            return Ok(self.euler(angles));
        }
        if let Some([x1, x2, x3, y1, y2, y3]) = element.vector("xyaxes")? {
            let x = DVec3::new(x1, x2, x3).try_normalize().ok_or_else(|| wrong("xyaxes"))?;
            let y = DVec3::new(y1, y2, y3);
            let y = (y - y.dot(x) * x).try_normalize().ok_or_else(|| wrong("xyaxes"))?;
            return Ok(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))));
        }
        if let Some(axis) = element.vector::<3>("zaxis")? {
            let axis = DVec3::from(axis).try_normalize().ok_or_else(|| wrong("zaxis"))?;
            return Ok(DQuat::from_rotation_arc(DVec3::Z, axis));
        }
        Ok(DQuat::IDENTITY)
    }

    /// Returns the rotation for Euler angles: about the turned axes for lower-case letters, about the fixed axes for upper-case letters.
    fn euler(&self, angles: [f64; 3]) -> DQuat {
        let mut rotation = DQuat::IDENTITY;
        for (letter, angle) in self.compiler.euler_order.chars().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => DVec3::X,
                'y' => DVec3::Y,
                _ => DVec3::Z,
            };
            let turn = DQuat::from_axis_angle(axis, angle * self.compiler.angle);
            rotation = if letter.is_lowercase() { rotation * turn } else { turn * rotation };
        }
        rotation
    }
}
