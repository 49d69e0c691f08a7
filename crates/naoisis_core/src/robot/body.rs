//! The body of a robot for collisions, sonars and cameras: two boxes, torso and base, and the limbs that are drawn.
//!
//! The paper's section 3.2 has "two different sets of rectangular bounds, one for its base and one for its
//! torso": the torso's are used between robots and against posts, the base's against the ball.

use bevy::prelude::*;
use parry3d::math::Pose as Isometry;
use parry3d::shape::Cuboid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::jersey::Jersey;
use super::look::Look;
use crate::geometry::Pose;
use crate::knowledge::Knowledge;

/// An upright box in the robot frame.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyBox {
    /// Rear and front, m, robot frame.
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub x_m: [f32; 2],
    /// Half the width; the box is symmetric about y = 0, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1.0))]
    pub half_width_m: f32,
    /// Lower and upper edge above the ground, m.
    #[schemars(inner(range(min = 0.0, max = 2.5)))]
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

/// An oriented rectangle on the ground, on which collisions are computed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Footprint {
    /// Centre, m.
    pub centre: Vec2,
    /// Unit vector along the rectangle's own x axis.
    pub forward: Vec2,
    /// Half extents along its own x and y axes, m.
    pub half_extents: Vec2,
}

/// The body of a robot, for collisions, occlusion and drawing, when it stands. [`Body::in_posture`] is the body in another
/// posture.
///
/// The default is the NAO. Its boxes are its top-view rectangles (B-Human 2025's two-dimensional model: upper body x -3..+5 cm
/// and y ±15 cm, feet x -3..+11 cm and y ±10 cm), with heights to match a robot of 57.3 cm: the feet and legs below the
/// torso, the torso from hip to neck.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Body {
    /// Trunk and arms: collides with robots and posts.
    pub torso: BodyBox,
    /// Feet and legs, or wheels: collides with the ball.
    pub base: BodyBox,
    /// Height of the top of the head, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub height_m: f32,
    /// Height when the robot lies, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub lying_height_m: f32,
    /// Lateral distance of each foot, or wheel, from the middle of the robot, m.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub foot_y_m: f32,
    /// The point about which the head with its cameras turns, m, robot frame (NAO V3.2: straight legs, 459.5 mm).
    #[schemars(with = "[f32; 3]")]
    pub neck_m: Vec3,
    /// The band about the robot's waist in the team's colour.
    pub waistband: Waistband,
    /// The robot's legs; `None` for a robot on wheels.
    pub legs: Option<Legs>,
    /// The robot's arms, if it has any.
    pub arms: Option<Arms>,
    /// The robot's appearance: colours, and the places of its number.
    pub look: Look,
    /// The robot's jersey; `None` for a robot with a waistband only.
    #[reflect(default)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jersey: Option<Jersey>,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            torso: BodyBox { x_m: [-0.03, 0.05], half_width_m: 0.15, z_m: [0.25, 0.46] },
            base: BodyBox { x_m: [-0.03, 0.11], half_width_m: 0.10, z_m: [0.0, 0.25] },
            height_m: 0.573,
            lying_height_m: 0.15,
            foot_y_m: 0.05,
            neck_m: Vec3::new(0.0, 0.0, 0.4595),
            waistband: Waistband::default(),
            legs: Some(Legs::default()),
            arms: Some(Arms::default()),
            look: Look::NAO,
            jersey: None,
        }
    }
}

impl Body {
    /// The body's width as a multiple of the NAO's.
    pub fn width_in_naos(&self) -> f32 {
        self.torso.half_width_m / 0.15
    }

    /// The part of the body in the team's colour, by which robots are recognised: the waistband, with a jersey up to the neck.
    pub fn team_mark(&self) -> Waistband {
        let Waistband { z_m: [lower, upper], half_size_m } = self.waistband;
        let upper = if self.jersey.is_some() { upper.max(self.neck_m.z) } else { upper };
        Waistband { z_m: [lower, upper], half_size_m }
    }

    /// Half the width of the drawn trunk, m, without the arms.
    pub fn drawn_half_width_m(&self) -> f32 {
        self.arms.map_or(self.torso.half_width_m, |arms| 0.75 * arms.shoulder_m.y)
    }
}

/// The band about a robot's waist in its team's colour, by which robots are recognised. The NAO's is 10 cm high (2010 rule book).
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Waistband {
    /// Lower and upper edge, m above the ground when the robot stands.
    #[schemars(inner(range(min = 0.0, max = 2.5)))]
    pub z_m: [f32; 2],
    /// Half its depth and half its width, m.
    #[schemars(with = "[f32; 2]")]
    pub half_size_m: Vec2,
}

impl Default for Waistband {
    fn default() -> Self {
        Self { z_m: [0.25, 0.35], half_size_m: Vec2::new(0.056, 0.074) }
    }
}

impl Waistband {
    /// Its centre, m, robot frame.
    pub fn middle(&self) -> Vec3 {
        Vec3::Z * ((self.z_m[0] + self.z_m[1]) / 2.0)
    }

    /// Its height, m.
    pub fn height(&self) -> f32 {
        self.z_m[1] - self.z_m[0]
    }
}

/// The legs, for drawing only: the simulation has no leg joints. The default is the NAO (Aldebaran's documentation of the V4).
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Legs {
    /// The left hip in the robot frame, m; the right one mirrored.
    #[schemars(with = "[f32; 3]")]
    pub hip_m: Vec3,
    /// From hip to knee, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub thigh_m: f32,
    /// From knee to ankle, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub shank_m: f32,
    /// From the ankle to the sole, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub ankle_m: f32,
}

impl Default for Legs {
    fn default() -> Self {
        Self { hip_m: Vec3::new(0.0, 0.05, 0.2481), thigh_m: 0.1, shank_m: 0.1029, ankle_m: 0.0452 }
    }
}

/// The arms, for drawing only.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Arms {
    /// The left shoulder in the robot frame, m; the right one mirrored. The NAO's is that of Aldebaran's documentation.
    #[schemars(with = "[f32; 3]")]
    pub shoulder_m: Vec3,
    /// From the shoulder to the fingertips, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 2.5))]
    pub length_m: f32,
}

impl Default for Arms {
    fn default() -> Self {
        Self { shoulder_m: Vec3::new(0.0, 0.098, 0.4335), length_m: 0.19 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn footprint_and_shape_agree() {
        let torso = Body::default().torso;
        let pose = Pose::new(1.0, 2.0, core::f32::consts::FRAC_PI_2);
        // Centre 1 cm in front of the origin; the robot faces +y.
        assert_abs_diff_eq!(torso.footprint(pose).centre.y, 2.01, epsilon = 1e-6);
        let corner = torso.isometry(pose).transform_point(torso.shape().half_extents);
        assert_abs_diff_eq!(corner.x, 1.0 - 0.15, epsilon = 1e-6);
        assert_abs_diff_eq!(corner.y, 2.05, epsilon = 1e-6);
        assert_abs_diff_eq!(corner.z, 0.46, epsilon = 1e-6);
    }
}
