//! A robot as a tree of links, with the joints between them, shapes and cameras.

use bevy::math::{DAffine3, DMat3, DQuat, DVec3};

use super::xml::Place;

/// A robot as a list of links. Parents come before their children.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub name: String,
    pub links: Vec<Link>,
    /// Parts that could not be read, such as missing meshes.
    pub warnings: Vec<String>,
}

/// A rigid body.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub name: String,
    pub parent: Option<usize>,
    /// The transform to its parent, with all joints at 0.
    pub parent_from_link: DAffine3,
    /// The joints that connect the link to its parent. Empty if it is fixed.
    pub joints: Vec<Joint>,
    /// The boxes around its shapes: those of collisions or, if there are none, those that are drawn.
    pub shapes: Vec<Shape>,
    /// Frames that may be cameras.
    pub cameras: Vec<Camera>,
}

/// A joint with one axis.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub name: String,
    pub is_hinge: bool,
    /// The axis, a unit vector in the link's frame.
    pub axis: DVec3,
    /// A point on the axis, m, in the link's frame.
    pub point: DVec3,
    /// The limits, radians or m.
    pub limits: Option<[f64; 2]>,
    pub place: Place,
}

/// A box in a link.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub link_from_box: DAffine3,
    /// Half the size, m.
    pub half: DVec3,
}

/// A frame that may be a camera.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    pub name: String,
    /// The transform to the link. The axes are x ahead, y left and z up, or those of an image ([`CameraAxes`]).
    pub link_from_camera: DAffine3,
    pub axes: CameraAxes,
    /// Width and height of the image, pixels.
    pub size: Option<[u32; 2]>,
    /// Field of view, radians.
    pub fov: Option<Fov>,
    pub place: Place,
}

/// The field of view along one side of the image, radians.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Fov {
    Horizontal(f64),
    Vertical(f64),
}

/// The axes of a camera's frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum CameraAxes {
    /// The file does not say: x ahead or, as in images, z ahead. The axis that points more to the front is used.
    Unknown,
    /// MuJoCo's axes: x right, y up, and the camera looks along -z.
    MuJoCo,
}

impl Camera {
    /// Returns the direction in which the camera looks. `rotation` is its rotation in the frame of the result.
    pub fn forward(&self, rotation: DMat3) -> DVec3 {
        match self.axes {
            CameraAxes::MuJoCo => -rotation.z_axis,
            CameraAxes::Unknown if self.is_optical(rotation) => rotation.z_axis,
            CameraAxes::Unknown => rotation.x_axis,
        }
    }

    /// Returns the direction of the image's right side. `rotation` is the camera's rotation in the frame of the result.
    pub fn right(&self, rotation: DMat3) -> DVec3 {
        match self.axes {
            CameraAxes::MuJoCo => rotation.x_axis,
            CameraAxes::Unknown if self.is_optical(rotation) => rotation.x_axis,
            CameraAxes::Unknown => -rotation.y_axis,
        }
    }

    fn is_optical(&self, rotation: DMat3) -> bool {
        let [body, optical] = [rotation.x_axis.x, rotation.z_axis.x];
        // If the camera looks aside or backwards, its name decides.
        if body.max(optical) > 0.5 { optical > body } else { self.name.to_lowercase().contains("optical") }
    }
}

/// Angles of joints by name, radians. All others are 0.
pub(super) type Posture = Vec<(String, f64)>;

/// A joint of a tree, by the indices of its link and of the joint in it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct JointIndex {
    pub link: usize,
    pub joint: usize,
}

impl Tree {
    /// Returns the transform from each link to the root.
    pub fn places(&self, posture: &Posture) -> Vec<DAffine3> {
        let angle_of = |joint: &Joint| posture.iter().find(|(name, _)| *name == joint.name).map_or(0.0, |(_, at)| *at);
        let mut places: Vec<DAffine3> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let mut place = link.parent.map_or(DAffine3::IDENTITY, |parent| places[parent]) * link.parent_from_link;
            for joint in &link.joints {
                let value = angle_of(joint);
                let moved = if joint.is_hinge {
                    DAffine3::from_translation(joint.point)
                        * DAffine3::from_quat(DQuat::from_axis_angle(joint.axis, value))
                        * DAffine3::from_translation(-joint.point)
                } else {
                    DAffine3::from_translation(value * joint.axis)
                };
                place *= moved;
            }
            places.push(place);
        }
        places
    }

    pub fn joint(&self, index: JointIndex) -> &Joint {
        &self.links[index.link].joints[index.joint]
    }

    /// Returns all joints.
    pub fn joints(&self) -> impl Iterator<Item = (JointIndex, &Joint)> {
        self.links.iter().enumerate().flat_map(|(link, of)| {
            of.joints.iter().enumerate().map(move |(joint, at)| (JointIndex { link, joint }, at))
        })
    }

    /// Returns the links from the root to `link`, both included.
    pub fn ancestry(&self, link: usize) -> Vec<usize> {
        let mut links: Vec<usize> = core::iter::successors(Some(link), |link| self.links[*link].parent).collect();
        links.reverse();
        links
    }

    /// Returns whether `link` is `ancestor` or one of its descendants.
    pub fn is_within(&self, link: usize, ancestor: usize) -> bool {
        core::iter::successors(Some(link), |link| self.links[*link].parent).any(|link| link == ancestor)
    }

    /// Returns the link and the links that are fixed to it.
    pub fn rigid_group(&self, link: usize) -> Vec<usize> {
        let mut group = vec![link];
        let mut is_in_group = vec![false; self.links.len()];
        is_in_group[link] = true;
        // Parents come before their children.
        for (index, other) in self.links.iter().enumerate() {
            if other.joints.is_empty() && other.parent.is_some_and(|parent| is_in_group[parent]) {
                is_in_group[index] = true;
                group.push(index);
            }
        }
        group
    }

    /// Returns the last moving link of each chain.
    pub fn tips(&self) -> Vec<usize> {
        let moves = |link: usize| !self.links[link].joints.is_empty();
        // Whether a descendant of the link moves. Parents come before their children.
        let mut is_above = vec![false; self.links.len()];
        for (link, of) in self.links.iter().enumerate().rev() {
            if let Some(parent) = of.parent {
                is_above[parent] |= is_above[link] || moves(link);
            }
        }
        (0..self.links.len()).filter(|link| moves(*link) && !is_above[*link]).collect()
    }

    /// Returns the hinges from the root to `link`, except those of the links in `common`.
    pub fn chain(&self, link: usize, common: &[usize]) -> Vec<JointIndex> {
        let links = self.ancestry(link).into_iter().filter(|link| !common.contains(link));
        let hinges =
            links.flat_map(|link| (0..self.links[link].joints.len()).map(move |joint| JointIndex { link, joint }));
        hinges.filter(|index| self.joint(*index).is_hinge).collect()
    }

    /// Returns the smallest box around the shapes of links, for these transforms of all links.
    pub fn bounds(&self, links: &[usize], places: &[DAffine3]) -> Option<[DVec3; 2]> {
        let corners = links.iter().flat_map(|link| {
            self.links[*link].shapes.iter().flat_map(move |shape| shape.corners(places[*link] * shape.link_from_box))
        });
        bounds(corners)
    }
}

impl Shape {
    fn corners(&self, place: DAffine3) -> [DVec3; 8] {
        core::array::from_fn(|index| {
            let side = |bit: usize| if index & bit == 0 { -1.0 } else { 1.0 };
            place.transform_point3(self.half * DVec3::new(side(1), side(2), side(4)))
        })
    }
}

/// Returns the smallest box around points.
pub(super) fn bounds(points: impl IntoIterator<Item = DVec3>) -> Option<[DVec3; 2]> {
    points.into_iter().fold(None, |bounds, point| match bounds {
        None => Some([point; 2]),
        Some([least, most]) => Some([least.min(point), most.max(point)]),
    })
}
