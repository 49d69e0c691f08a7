//! Reads URDF.

use bevy::math::{DAffine3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::DescriptionError;
use super::meshes;
use super::tree::{Camera, CameraAxes, Fov, Joint, Link, Shape, Tree};
use super::xml::Element;

/// Number of links of a robot at most.
pub(super) const MOST_LINKS: usize = 2000;

/// Reads the robot in a `<robot>` element.
pub(super) fn read(robot: &Element, path: &Path) -> Result<Tree, DescriptionError> {
    let mut warnings = Vec::new();
    let links: Vec<&Element> = robot.all("link").collect();
    let joints: Vec<&Element> = robot.all("joint").collect();
    if links.len() > MOST_LINKS {
        return Err(robot.place.wrong(format!("there are {} links; at most {MOST_LINKS} are read", links.len())));
    }
    // The first of several links with the same name counts.
    let mut indices = BTreeMap::new();
    for (index, link) in links.iter().enumerate() {
        indices.entry(link.attribute("name").unwrap_or_default()).or_insert(index);
    }
    let mut parents: Vec<Option<(usize, &Element)>> = vec![None; links.len()];
    for joint in &joints {
        let end = |word: &str| -> Result<usize, DescriptionError> {
            let element = joint
                .child(word)
                .ok_or_else(|| joint.place.wrong(format!("the joint has no <{word} link=\"...\"/>")))?;
            let name = element.needs("link")?;
            indices.get(name).copied().ok_or_else(|| element.place.wrong(format!("there is no link `{name}`")))
        };
        let (parent, child) = (end("parent")?, end("child")?);
        if parents[child].is_some() {
            return Err(joint.place.wrong(format!("the link `{}` has two parents", links[child].needs("name")?)));
        }
        parents[child] = Some((parent, *joint));
    }
    let roots: Vec<usize> = (0..links.len()).filter(|link| parents[*link].is_none()).collect();
    let &[root] = roots.as_slice() else {
        let names: Vec<&str> = roots.iter().filter_map(|root| links[*root].attribute("name")).collect();
        let problem = match names.as_slice() {
            [] if links.is_empty() => "the robot has no links".to_owned(),
            [] => "the joints form a ring: there is no link without a parent".to_owned(),
            names => format!("{} links have no parent: {}; expected one", names.len(), names.join(", ")),
        };
        return Err(robot.place.wrong(problem));
    };
    // Sort the links, so that parents come before their children.
    let mut children = vec![Vec::new(); links.len()];
    for (link, parent) in parents.iter().enumerate() {
        if let Some((parent, _)) = parent {
            children[*parent].push(link);
        }
    }
    let mut order = vec![root];
    let mut next = 0;
    while let Some(&parent) = order.get(next) {
        order.append(&mut children[parent]);
        next += 1;
    }
    if order.len() < links.len() {
        return Err(robot.place.wrong("some joints form a ring that is not joined to the rest of the robot"));
    }
    let mut places = vec![0; links.len()];
    for (place, link) in order.iter().enumerate() {
        places[*link] = place;
    }
    let mut read = Vec::with_capacity(order.len());
    for &index in &order {
        let mut link = read_link(links[index], path, &mut warnings)?;
        if let Some((parent, joint)) = parents[index] {
            link.parent = Some(places[parent]);
            link.parent_from_link = origin(joint)?;
            link.joints = read_joint(joint)?.into_iter().collect();
        }
        add_camera(&mut link, links[index], parents[index].map(|(_, joint)| joint), robot)?;
        read.push(link);
    }
    let name = robot.attribute("name").unwrap_or_default().to_owned();
    Ok(Tree { name, links: read, warnings })
}

fn read_joint(joint: &Element) -> Result<Option<Joint>, DescriptionError> {
    let kind = joint.needs("type")?;
    let is_hinge = match kind {
        "revolute" | "continuous" => true,
        "prismatic" => false,
        "fixed" | "floating" | "planar" => return Ok(None),
        other => {
            let expected = "revolute, continuous, prismatic, fixed, floating or planar";
            return Err(joint.place.wrong(format!("the type of the joint is \"{other}\"; expected {expected}")));
        }
    };
    let axis = match joint.child("axis") {
        Some(axis) => axis.vector::<3>("xyz")?.map_or(DVec3::X, DVec3::from),
        None => DVec3::X,
    };
    let limit = joint.child("limit").filter(|_| kind != "continuous");
    let limits = match limit {
        Some(limit) => Some([limit.number("lower")?.unwrap_or(0.0), limit.number("upper")?.unwrap_or(0.0)]),
        None => None,
    };
    Ok(Some(Joint {
        name: joint.needs("name")?.to_owned(),
        is_hinge,
        axis: axis.try_normalize().ok_or_else(|| joint.place.wrong("the axis of the joint has no direction"))?,
        point: DVec3::ZERO,
        limits,
        place: joint.place.clone(),
    }))
}

fn read_link(link: &Element, path: &Path, warnings: &mut Vec<String>) -> Result<Link, DescriptionError> {
    let mut shapes = Vec::new();
    for (word, is_collision) in [("collision", true), ("visual", false)] {
        // Visual shapes are used only if the link has no collision shapes.
        for element in link.all(word).filter(|_| is_collision || link.child("collision").is_none()) {
            let Some(geometry) = element.child("geometry").and_then(|geometry| geometry.children.first()) else {
                continue;
            };
            let found = match read_geometry(geometry, path) {
                Ok(found) => found,
                Err(DescriptionError::Mesh(problem)) => {
                    warnings.push(format!("{}: {problem}", geometry.place));
                    continue;
                }
                Err(error) => return Err(error),
            };
            let Some((half, middle)) = found else {
                warnings.push(format!("{}: a <{}> is no shape that is read", geometry.place, geometry.name));
                continue;
            };
            let link_from_box = origin(element)? * DAffine3::from_translation(middle);
            shapes.push(Shape { link_from_box, half });
        }
    }
    Ok(Link {
        name: link.needs("name")?.to_owned(),
        parent: None,
        parent_from_link: DAffine3::IDENTITY,
        joints: Vec::new(),
        shapes,
        cameras: Vec::new(),
    })
}

/// Returns half the size of a geometry and the position of its centre, m.
fn read_geometry(geometry: &Element, path: &Path) -> Result<Option<(DVec3, DVec3)>, DescriptionError> {
    let needs = |name: &str| {
        let number = geometry.number(name)?;
        number.ok_or_else(|| geometry.place.wrong(format!("<{}> has no `{name}`", geometry.name)))
    };
    let half = match geometry.name.as_str() {
        "box" => {
            let size = geometry.vector::<3>("size")?;
            DVec3::from(size.ok_or_else(|| geometry.place.wrong("<box> has no `size`"))?) / 2.0
        }
        "sphere" => DVec3::splat(needs("radius")?),
        "cylinder" => DVec3::new(needs("radius")?, needs("radius")?, needs("length")? / 2.0),
        "capsule" => DVec3::new(needs("radius")?, needs("radius")?, needs("length")? / 2.0 + needs("radius")?),
        "mesh" => {
            let scale = geometry.vector::<3>("scale")?.map_or(DVec3::ONE, DVec3::from);
            let [least, most] = meshes::bounds_of(&mesh_file(geometry.needs("filename")?, path), scale)?;
            return Ok(Some(((most - least) / 2.0, (most + least) / 2.0)));
        }
        _ => return Ok(None),
    };
    Ok(Some((half, DVec3::ZERO)))
}

/// Returns the file of a mesh: relative to the description, or to one of its parent folders for `package://NAME/...`.
fn mesh_file(name: &str, path: &Path) -> PathBuf {
    let folder = path.parent().unwrap_or(Path::new(""));
    if let Some(name) = name.strip_prefix("file://") {
        return PathBuf::from(name);
    }
    let Some(inside) = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://")) else {
        return folder.join(name);
    };
    let in_package = inside.split_once('/').map_or(inside, |(_, rest)| rest);
    let absolute = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let tried = absolute.ancestors().take(6).flat_map(|above| [above.join(inside), above.join(in_package)]);
    tried.into_iter().find(|file| file.is_file()).unwrap_or_else(|| folder.join(in_package))
}

/// Returns the transform in the `<origin>` of an element.
fn origin(element: &Element) -> Result<DAffine3, DescriptionError> {
    let Some(origin) = element.child("origin") else { return Ok(DAffine3::IDENTITY) };
    let xyz = origin.vector::<3>("xyz")?.map_or(DVec3::ZERO, DVec3::from);
    let [roll, pitch, yaw] = origin.vector::<3>("rpy")?.unwrap_or_default();
    let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    Ok(DAffine3::from_rotation_translation(rotation, xyz))
}

/// Words in the names of links and joints of cameras.
const CAMERA_WORDS: [&str; 6] = ["camera", "realsense", "zed_", "rgb", "_cam", "cam_"];

/// Adds the frame of a link that may be a camera, by its name or by a Gazebo sensor.
fn add_camera(
    link: &mut Link,
    element: &Element,
    joint: Option<&Element>,
    robot: &Element,
) -> Result<(), DescriptionError> {
    let of_link = |gazebo: &&Element| gazebo.attribute("reference") == element.attribute("name");
    let sensors = robot.all("gazebo").filter(of_link).flat_map(|gazebo| gazebo.all("sensor"));
    let sensor = sensors.into_iter().find_map(|sensor| sensor.child("camera"));
    let is_named = |name: &str| {
        let name = name.to_lowercase();
        CAMERA_WORDS.iter().any(|word| name.contains(word))
    };
    let joint_name = joint.and_then(|joint| joint.attribute("name")).unwrap_or_default();
    if sensor.is_none() && !is_named(&link.name) && !is_named(joint_name) {
        return Ok(());
    }
    let number = |parent: Option<&Element>, name: &str| -> Option<f64> {
        parent?.child(name)?.text.parse().ok().filter(|number: &f64| number.is_finite())
    };
    let image = sensor.and_then(|sensor| sensor.child("image"));
    let size = [number(image, "width"), number(image, "height")];
    link.cameras.push(Camera {
        name: link.name.clone(),
        link_from_camera: DAffine3::IDENTITY,
        axes: CameraAxes::Unknown,
        size: match size {
            [Some(width), Some(height)] => Some([width as u32, height as u32]),
            _ => None,
        },
        fov: number(sensor, "horizontal_fov").map(Fov::Horizontal),
        place: joint.unwrap_or(element).place.clone(),
    });
    Ok(())
}
