//! The true distances to objects in the sectors of a robot's sonars.

use bevy::prelude::*;
use core::cell::LazyCell;

use super::sector::{Sector, nearer};
use super::{SonarSettings, SonarSource};
use crate::appearance::scene::{Scene, ScenePost, SceneRobot};
use naoisis_core::geometry::{Pose, unit, unrotate};
use naoisis_core::team::RobotId;

/// Tolerance at the ends of the range, for rounding, m.
pub(super) const EDGE_M: f32 = 1e-6;

/// The true distances to the nearest points in the sectors of the left and the right sonar, up to the greatest range of the settings.
pub fn echoes(settings: &SonarSettings, own_id: RobotId, own_pose: Pose, scene: &Scene) -> [Option<f32>; 2] {
    let range = match settings.source {
        SonarSource::Echo => settings.max_m,
        SonarSource::Truth => f32::INFINITY,
    };
    let may_hear = |place: Vec2, reach: f32| is_near(place - own_pose.position, reach + range + EDGE_M);
    // Computed on first use, as usually nothing is near.
    let sectors = LazyCell::new(|| SonarSectors::of(settings, own_pose.forward()));
    let mut nearest = [None, None];
    let mut hear = |distance_to: &dyn Fn(Vec2) -> Option<f32>| {
        nearest[0] = nearer(nearest[0], distance_to(sectors.left_axis));
        nearest[1] = nearer(nearest[1], distance_to(sectors.right_axis));
    };
    for robot in &scene.robots {
        if robot.id != own_id && may_hear(robot.pose.position, robot.reach) {
            let centre = unrotate(sectors.forward, robot.pose.position - own_pose.position);
            let facing = unrotate(sectors.forward, robot.forward);
            hear(&|axis| distance_to_body(sectors.sector, axis, robot, centre, facing, settings.height_m));
        }
    }
    for ScenePost { position, post } in &scene.posts {
        if post.height >= settings.height_m && may_hear(*position, post.radius) {
            let centre = unrotate(sectors.forward, *position - own_pose.position);
            hear(&|axis| sectors.sector.distance_to_disc(unrotate(axis, centre), post.radius));
        }
    }
    nearest.map(|distance| distance.filter(|&distance| distance <= range + EDGE_M))
}

/// The sectors of a robot's two sonars.
#[derive(Clone, Copy)]
pub(super) struct SonarSectors {
    /// The unit vector along which the robot faces, pitch frame.
    pub(super) forward: Vec2,
    /// The unit vectors along the sonars' axes, robot frame.
    left_axis: Vec2,
    right_axis: Vec2,
    sector: Sector,
}

impl SonarSectors {
    pub(super) fn of(settings: &SonarSettings, forward: Vec2) -> Self {
        let left_axis = unit(settings.heading);
        let right_axis = Vec2::new(left_axis.x, -left_axis.y);
        Self { forward, left_axis, right_axis, sector: Sector::new(settings.half_angle) }
    }

    /// Whether `place`, m, robot frame, is in the sector of the left sonar, and of the right one.
    pub(super) fn contain(&self, place: Vec2) -> [bool; 2] {
        [self.left_axis, self.right_axis].map(|axis| self.sector.contains(unrotate(axis, place)))
    }
}

pub(super) fn is_near(offset: Vec2, distance: f32) -> bool {
    offset.length_squared() <= distance * distance
}

/// The distance to the boxes of a robot's body at the height of the sonar: at the default height, its torso. The robot stands at `centre`
/// and faces along `facing`, both in the frame of the robot with the sonar.
fn distance_to_body(
    sector: Sector,
    axis: Vec2,
    robot: &SceneRobot,
    centre: Vec2,
    facing: Vec2,
    height: f32,
) -> Option<f32> {
    let (centre, facing) = (unrotate(axis, centre), unrotate(axis, facing));
    if !sector.may_contain(centre, robot.reach + EDGE_M) {
        return None;
    }
    let distance_to = |body: naoisis_core::robot::body::BodyBox| {
        let [rear, front] = body.x_m;
        let half_width = body.half_width_m;
        let corners = [(rear, -half_width), (front, -half_width), (front, half_width), (rear, half_width)];
        sector.distance_to_polygon(corners.map(|(x, y)| centre + facing.rotate(Vec2::new(x, y))))
    };
    robot
        .boxes
        .into_iter()
        .filter(|body| (body.z_m[0]..=body.z_m[1]).contains(&height))
        .filter_map(distance_to)
        .reduce(f32::min)
}
