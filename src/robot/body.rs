//! The body of a NAO as collisions, sonars and cameras see it: two boxes, torso and base.
//!
//! The paper's section 3.2 has "two different sets of rectangular bounds, one for its base and one for its
//! torso": the torso's are used between robots and against posts, the base's against the ball.

use bevy::prelude::*;
use parry3d::math::Pose as Isometry;
use parry3d::shape::Cuboid;
use serde::{Deserialize, Serialize};

use crate::geometry::Pose;
use crate::knowledge::Knowledge;

/// An upright box in the robot frame.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyBox {
    /// Rear and front, m, robot frame.
    pub x_m: [f32; 2],
    /// Half the width; the box is symmetric about y = 0, m.
    pub half_width_m: f32,
    /// Lower and upper edge above the ground, m.
    pub z_m: [f32; 2],
}

impl BodyBox {
    /// Half extents on the ground (x, y), m.
    pub fn half_extents(&self) -> Vec2 {
        Vec2::new((self.x_m[1] - self.x_m[0]) / 2.0, self.half_width_m)
    }

    /// The centre's x in the robot frame, m.
    pub fn centre_x(&self) -> f32 {
        (self.x_m[0] + self.x_m[1]) / 2.0
    }

    /// The box's footprint for a robot at `pose`.
    pub fn footprint(&self, pose: Pose) -> Footprint {
        let forward = pose.forward();
        Footprint { centre: pose.position + forward * self.centre_x(), forward, half_extents: self.half_extents() }
    }

    /// The greatest distance of a point of the box from the robot's origin, on the ground, m.
    pub fn reach(&self) -> f32 {
        Vec2::new(self.x_m[0].abs().max(self.x_m[1].abs()), self.half_width_m).length()
    }

    /// The box as a parry shape, centred at its own origin (z up).
    pub fn shape(&self) -> Cuboid {
        Cuboid::new(self.half_extents().extend((self.z_m[1] - self.z_m[0]) / 2.0))
    }

    /// The placement of [`BodyBox::shape`] in the pitch frame (z up) for a robot at `pose`.
    pub fn isometry(&self, pose: Pose) -> Isometry {
        let centre = pose.transform_point(Vec2::new(self.centre_x(), 0.0));
        Isometry::from_parts(centre.extend((self.z_m[0] + self.z_m[1]) / 2.0), Quat::from_rotation_z(pose.heading))
    }
}

/// A rectangle on the ground, anywhere and at any angle: what collisions are computed on.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Footprint {
    /// Centre, m.
    pub centre: Vec2,
    /// Unit vector along the rectangle's own x axis.
    pub forward: Vec2,
    /// Half extents along its own x and y axes, m.
    pub half_extents: Vec2,
}

/// The two boxes of a robot on its feet; [`BodyBounds::in_posture`] has the room that it takes otherwise. The defaults are the top-view rectangles of the NAO (B-Human 2025's two-dimensional
/// model: upper body x -3..+5 cm and y ±15 cm, feet x -3..+11 cm and y ±10 cm), with heights to match a robot of
/// 57.3 cm: the feet and legs below the torso, the torso from hip to neck.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
#[serde(default, deny_unknown_fields)]
pub struct BodyBounds {
    /// Trunk and arms.
    pub torso: BodyBox,
    /// Feet and legs.
    pub base: BodyBox,
    /// Height of the top of the head, m.
    pub height_m: f32,
}

impl Default for BodyBounds {
    fn default() -> Self {
        Self {
            torso: BodyBox { x_m: [-0.03, 0.05], half_width_m: 0.15, z_m: [0.25, 0.46] },
            base: BodyBox { x_m: [-0.03, 0.11], half_width_m: 0.10, z_m: [0.0, 0.25] },
            height_m: 0.573,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn footprint_and_shape_agree() {
        let torso = BodyBounds::default().torso;
        let pose = Pose::new(1.0, 2.0, core::f32::consts::FRAC_PI_2);
        // Centre 1 cm in front of the origin; the robot faces +y.
        assert_abs_diff_eq!(torso.footprint(pose).centre.y, 2.01, epsilon = 1e-6);
        let corner = torso.isometry(pose).transform_point(torso.shape().half_extents);
        assert_abs_diff_eq!(corner.x, 1.0 - 0.15, epsilon = 1e-6);
        assert_abs_diff_eq!(corner.y, 2.05, epsilon = 1e-6);
        assert_abs_diff_eq!(corner.z, 0.46, epsilon = 1e-6);
    }
}
