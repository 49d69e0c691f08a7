//! Bodies of robots for collisions, and their overlaps.

use bevy::prelude::*;

use super::footprints::Overlap;
use crate::geometry::Pose;
use crate::robot::body::BodyBox;

/// A robot for collisions.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RobotBody {
    /// Its pose at the start of the cycle.
    pub start: Pose,
    /// Its intended pose at the end of the cycle; after [`resolve_robots`](super::robots::resolve_robots), its actual one.
    pub end: Pose,
    /// Its torso.
    pub torso: BodyBox,
    /// Greatest displacement by pushing in the cycle, m. The robot's own step may be longer.
    pub most_way: f32,
}

impl RobotBody {
    /// Whether it intends to move.
    pub fn is_moving(&self) -> bool {
        self.start != self.end
    }
}

/// An upright cylinder on the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cylinder {
    /// Its centre, m, pitch frame.
    pub centre: Vec2,
    /// Radius, m.
    pub radius: f32,
}

/// The other body of a contact.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Touched {
    /// The robot with this index.
    Robot(usize),
    /// The cylinder with this index.
    Cylinder(usize),
}

/// Calls `visit` with every overlap of the torsos at `poses`: index, other body, overlap.
pub(super) fn for_each_overlap(
    robots: &[RobotBody],
    cylinders: &[Cylinder],
    poses: &[Pose],
    mut visit: impl FnMut(usize, Touched, Overlap),
) {
    for (index, robot) in robots.iter().enumerate() {
        let pose = poses[index];
        let reach = robot.torso.reach();
        let near = |point: Vec2, other_reach: f32| {
            let distance = reach + other_reach;
            pose.position.distance_squared(point) < distance * distance
        };
        for (other, other_robot) in robots.iter().enumerate().skip(index + 1) {
            if near(poses[other].position, other_robot.torso.reach())
                && let Some(overlap) = robot.torso.footprint(pose).overlap(&other_robot.torso.footprint(poses[other]))
            {
                visit(index, Touched::Robot(other), overlap);
            }
        }
        for (other, cylinder) in cylinders.iter().enumerate() {
            if near(cylinder.centre, cylinder.radius)
                && let Some(overlap) = robot.torso.footprint(pose).overlap_disc(cylinder.centre, cylinder.radius)
            {
                visit(index, Touched::Cylinder(other), overlap);
            }
        }
    }
}
