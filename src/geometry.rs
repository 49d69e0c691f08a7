//! Poses on the ground, angles, and the frames they are expressed in.
//!
//! All of the simulation happens in the *pitch frame*: origin at the centre mark, +x towards the yellow goal,
//! +y to the left of +x, +z up; metres and radians. A robot's own frame has its origin at the midpoint of the
//! feet on the ground, x to the front and y to the left (paper, Table 1, footnote 3).

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::{PI, TAU};
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;
use crate::state::ReflectState;

/// Position and heading on the ground, in the pitch frame: the simulation's truth of where something is.
///
/// `Transform` exists for display only and is derived from this.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(State, @Knowledge::Truth)]
pub struct Pose {
    /// Position in metres.
    pub position: Vec2,
    /// Heading in radians, counter-clockwise from +x.
    pub heading: f32,
}

impl Pose {
    /// A pose from coordinates in metres and a heading in radians.
    pub const fn new(x: f32, y: f32, heading: f32) -> Self {
        Self { position: Vec2::new(x, y), heading }
    }

    /// The unit vector the pose faces along.
    pub fn forward(self) -> Vec2 {
        unit(self.heading)
    }

    /// A point given in this pose's own frame, in the frame that the pose is given in.
    pub fn transform_point(self, point_in_pose: Vec2) -> Vec2 {
        self.position + self.forward().rotate(point_in_pose)
    }

    /// A point given in the frame that the pose is given in, in this pose's own frame.
    pub fn inverse_transform_point(self, point: Vec2) -> Vec2 {
        unrotate(self.forward(), point - self.position)
    }

    /// A pose given in this pose's own frame, in the frame that this pose is given in.
    pub fn compose(self, pose_in_pose: Pose) -> Pose {
        Pose {
            position: self.transform_point(pose_in_pose.position),
            heading: wrap_angle(self.heading + pose_in_pose.heading),
        }
    }

    /// A pose given in the frame that this pose is given in, in this pose's own frame.
    pub fn relative(self, pose: Pose) -> Pose {
        Pose { position: self.inverse_transform_point(pose.position), heading: wrap_angle(pose.heading - self.heading) }
    }

    /// The pose turned by half a turn about the pitch's centre: from the frame of one team to that of the other.
    pub fn turned_half(self) -> Pose {
        Pose { position: -self.position, heading: wrap_angle(self.heading + PI) }
    }

    /// Whether every number in it is finite.
    pub fn is_finite(self) -> bool {
        self.position.is_finite() && self.heading.is_finite()
    }
}

/// The unit vector at `angle` radians, counter-clockwise from +x.
pub fn unit(angle: f32) -> Vec2 {
    let (sin, cos) = ops::sin_cos(angle);
    Vec2::new(cos, sin)
}

/// `vector` turned back by the angle of the unit vector `direction`: the inverse of `direction.rotate(vector)`.
pub fn unrotate(direction: Vec2, vector: Vec2) -> Vec2 {
    Vec2::new(direction.dot(vector), direction.perp_dot(vector))
}

/// The angle of a vector, in radians, counter-clockwise from +x; zero for a null vector.
pub fn angle_of(vector: Vec2) -> f32 {
    ops::atan2(vector.y, vector.x)
}

/// The same angle within (-π, π].
pub fn wrap_angle(angle: f32) -> f32 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned.min(PI) }
}

/// Degrees of an angle in radians within (-180, 180], as traces print them. Computed in double precision, so that
/// an angle that was given in whole degrees comes back as such.
pub fn wrapped_degrees(angle: f32) -> f32 {
    let degrees = to_degrees(wrap_angle(angle));
    if degrees <= -180.0 { degrees + 360.0 } else { degrees }
}

/// Degrees of an angle in radians: a round number of them, if that is the same angle in single precision.
pub fn to_degrees(radians: f32) -> f32 {
    let degrees = f64::from(radians).to_degrees();
    let round = ((degrees * 1e3).round() / 1e3) as f32;
    if to_radians(round) == radians { round } else { degrees as f32 }
}

/// Radians of an angle in degrees, rounded once.
pub fn to_radians(degrees: f32) -> f32 {
    f64::from(degrees).to_radians() as f32
}

/// How angles and poses are written in files: in degrees. For use with `#[serde(with = "...")]`.
pub mod file_units {
    use super::{Pose, to_degrees, to_radians, wrapped_degrees};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// The heading, radians within (-π, π], of an angle in degrees: so a pose reads the same after it was written.
    fn heading_of(degrees: f32) -> f32 {
        let degrees = f64::from(degrees);
        let wrapped = degrees - 360.0 * (degrees / 360.0).round();
        to_radians(if wrapped <= -180.0 { 180.0 } else { wrapped as f32 })
    }

    /// An angle or angular speed: radians in memory, degrees in the file.
    pub mod degrees {
        use super::*;

        /// Writes radians as degrees.
        pub fn serialize<S: Serializer>(radians: &f32, serializer: S) -> Result<S::Ok, S::Error> {
            to_degrees(*radians).serialize(serializer)
        }

        /// Reads degrees as radians.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
            f32::deserialize(deserializer).map(to_radians)
        }
    }

    /// A pair of angles (a range, or yaw and pitch): radians in memory, degrees in the file.
    pub mod degree_pair {
        use super::*;

        /// Writes radians as degrees.
        pub fn serialize<S: Serializer>(radians: &[f32; 2], serializer: S) -> Result<S::Ok, S::Error> {
            radians.map(to_degrees).serialize(serializer)
        }

        /// Reads degrees as radians.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f32; 2], D::Error> {
            <[f32; 2]>::deserialize(deserializer).map(|degrees| degrees.map(to_radians))
        }
    }

    /// A pose as `[x m, y m, heading deg]`.
    pub mod pose {
        use super::*;

        /// Writes `[x, y, degrees]`.
        pub fn serialize<S: Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
            [pose.position.x, pose.position.y, wrapped_degrees(pose.heading)].serialize(serializer)
        }

        /// Reads `[x, y, degrees]`.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Pose, D::Error> {
            <[f32; 3]>::deserialize(deserializer).map(|[x, y, degrees]| Pose::new(x, y, heading_of(degrees)))
        }
    }

    /// A pose that may be absent, as `[x m, y m, heading deg]` or null.
    pub mod optional_pose {
        use super::*;

        /// Writes `[x, y, degrees]` or null.
        pub fn serialize<S: Serializer>(pose: &Option<Pose>, serializer: S) -> Result<S::Ok, S::Error> {
            pose.map(|pose| [pose.position.x, pose.position.y, wrapped_degrees(pose.heading)]).serialize(serializer)
        }

        /// Reads `[x, y, degrees]` or null.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Pose>, D::Error> {
            Option::<[f32; 3]>::deserialize(deserializer)
                .map(|pose| pose.map(|[x, y, degrees]| Pose::new(x, y, heading_of(degrees))))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn angles_wrap_into_the_half_open_turn() {
        assert_eq!(wrap_angle(PI), PI);
        assert_eq!(wrapped_degrees(-PI), 180.0);
        assert_abs_diff_eq!(wrap_angle(3.0 * PI), PI, epsilon = 1e-6);
        assert_abs_diff_eq!(wrap_angle(-0.5 - TAU), -0.5, epsilon = 1e-6);
        for step in -1000..1000 {
            let wrapped = wrap_angle(step as f32 * 0.1);
            assert!(wrapped > -PI && wrapped <= PI);
        }
    }

    #[test]
    fn whole_degrees_survive_the_round_trip() {
        for degrees in -180..=360 {
            assert_eq!(to_degrees(to_radians(degrees as f32)), degrees as f32);
        }
    }

    #[test]
    fn relative_undoes_compose() {
        let robot = Pose::new(1.0, -2.0, 0.7);
        let ahead = Pose::new(0.3, 0.1, -0.2);
        let back = robot.relative(robot.compose(ahead));
        assert_abs_diff_eq!(back.position.x, 0.3, epsilon = 1e-6);
        assert_abs_diff_eq!(back.position.y, 0.1, epsilon = 1e-6);
        assert_abs_diff_eq!(back.heading, -0.2, epsilon = 1e-6);
    }
}
