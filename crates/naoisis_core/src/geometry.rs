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

/// Position and heading on the ground, in the pitch frame.
///
/// `Transform` exists for display only and is derived from this.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
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

    /// Transforms `point_in_pose` from the frame of this pose to the parent frame.
    pub fn transform_point(self, point_in_pose: Vec2) -> Vec2 {
        self.position + self.forward().rotate(point_in_pose)
    }

    /// Transforms `point` from the parent frame to the frame of this pose.
    pub fn inverse_transform_point(self, point: Vec2) -> Vec2 {
        unrotate(self.forward(), point - self.position)
    }

    /// Transforms `pose_in_pose` from the frame of this pose to the parent frame.
    pub fn compose(self, pose_in_pose: Pose) -> Pose {
        Pose {
            position: self.transform_point(pose_in_pose.position),
            heading: wrap_angle(self.heading + pose_in_pose.heading),
        }
    }

    /// Transforms `pose` from the parent frame to the frame of this pose.
    pub fn relative(self, pose: Pose) -> Pose {
        Pose { position: self.inverse_transform_point(pose.position), heading: wrap_angle(pose.heading - self.heading) }
    }

    /// The pose rotated by 180° about the centre of the pitch: from the frame of one team to that of the other.
    pub fn turned_half(self) -> Pose {
        Pose { position: -self.position, heading: wrap_angle(self.heading + PI) }
    }

    /// Whether all numbers are finite.
    pub fn is_finite(self) -> bool {
        self.position.is_finite() && self.heading.is_finite()
    }
}

/// The unit vector at `angle` radians, counter-clockwise from +x.
pub fn unit(angle: f32) -> Vec2 {
    let (sin, cos) = ops::sin_cos(angle);
    Vec2::new(cos, sin)
}

/// `vector` rotated back by the angle of the unit vector `direction`: the inverse of `direction.rotate(vector)`.
pub fn unrotate(direction: Vec2, vector: Vec2) -> Vec2 {
    Vec2::new(direction.dot(vector), direction.perp_dot(vector))
}

/// The angle of a vector, in radians, counter-clockwise from +x; zero for a null vector.
pub fn angle_of(vector: Vec2) -> f32 {
    ops::atan2(vector.y, vector.x)
}

/// `angle` wrapped to (-π, π].
pub fn wrap_angle(angle: f32) -> f32 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    let turned = angle - TAU * (angle / TAU).round();
    if turned <= -PI { turned + TAU } else { turned.min(PI) }
}

/// `radians` in degrees: a round number if that is the same angle in single precision.
pub fn to_degrees(radians: f32) -> f32 {
    let degrees = f64::from(radians).to_degrees();
    let round = ((degrees * 1e3).round() / 1e3) as f32;
    if to_radians(round) == radians { round } else { degrees as f32 }
}

/// `degrees` in radians, rounded once.
pub fn to_radians(degrees: f32) -> f32 {
    f64::from(degrees).to_radians() as f32
}

/// `radians` in degrees for files: the shortest decimal number of at least three places that [`radians_of`] converts to the same
/// bits.
pub fn exact_degrees(radians: f32) -> f64 {
    let degrees = f64::from(radians).to_degrees();
    let is_same = |decimal: &f64| radians_of(*decimal).to_bits() == radians.to_bits();
    // Only very small angles need more places than these, and they need all of them.
    let places = [1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12];
    places.into_iter().map(|scale| (degrees * scale).round() / scale).find(is_same).unwrap_or(degrees)
}

/// `degrees` of files in radians, rounded once.
pub fn radians_of(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

/// The format of angles and poses in files: degrees, written [exactly](exact_degrees). For use with `#[serde(with = "...")]`.
pub mod file_units {
    use super::{Pose, exact_degrees, radians_of, wrap_angle};
    use core::fmt;
    use serde::de::{Error, Unexpected, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    /// A number in double precision that is converted to single precision.
    #[derive(Clone, Copy)]
    struct Digits(f64);

    impl<'de> Deserialize<'de> for Digits {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_f64(Digits(0.0))
        }
    }

    impl Visitor<'_> for Digits {
        type Value = Digits;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("f32")
        }

        fn visit_f64<E: Error>(self, number: f64) -> Result<Digits, E> {
            if (number as f32).is_finite() {
                return Ok(Digits(number));
            }
            Err(E::invalid_value(Unexpected::Float(number), &"a finite number, of single precision (at most 3.4e38)"))
        }

        fn visit_i64<E: Error>(self, number: i64) -> Result<Digits, E> {
            Ok(Digits(number as f64))
        }

        fn visit_u64<E: Error>(self, number: u64) -> Result<Digits, E> {
            Ok(Digits(number as f64))
        }
    }

    /// A pose in the format of files, with the heading within (-180, 180].
    fn to_file(pose: Pose) -> (f32, f32, f64) {
        (pose.position.x, pose.position.y, exact_degrees(wrap_angle(pose.heading)))
    }

    fn from_file([Digits(x), Digits(y), Digits(degrees)]: [Digits; 3]) -> Pose {
        Pose::new(x as f32, y as f32, heading_of(degrees))
    }

    /// The heading, radians within (-π, π], of an angle in degrees. It is wrapped before the conversion, so that a pose that was written is
    /// read back exactly.
    fn heading_of(degrees: f64) -> f32 {
        if degrees > -180.0 && degrees <= 180.0 {
            return radians_of(degrees);
        }
        let wrapped = degrees - 360.0 * (degrees / 360.0).round();
        radians_of(if wrapped <= -180.0 { 180.0 } else { wrapped })
    }

    /// An angle or angular speed: radians in memory, degrees in the file.
    pub mod degrees {
        use super::*;

        /// Writes radians as degrees.
        pub fn serialize<S: Serializer>(radians: &f32, serializer: S) -> Result<S::Ok, S::Error> {
            exact_degrees(*radians).serialize(serializer)
        }

        /// Reads degrees as radians.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
            Digits::deserialize(deserializer).map(|Digits(degrees)| radians_of(degrees))
        }
    }

    /// An angle that may be absent: radians in memory, degrees in the file.
    pub mod optional_degrees {
        use super::*;

        /// Writes radians as degrees, or null.
        pub fn serialize<S: Serializer>(radians: &Option<f32>, serializer: S) -> Result<S::Ok, S::Error> {
            radians.map(exact_degrees).serialize(serializer)
        }

        /// Reads degrees as radians, or null.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f32>, D::Error> {
            Ok(Option::<Digits>::deserialize(deserializer)?.map(|Digits(degrees)| radians_of(degrees)))
        }
    }

    /// A pair of angles (a range, or yaw and pitch): radians in memory, degrees in the file.
    pub mod degree_pair {
        use super::*;

        /// Writes radians as degrees.
        pub fn serialize<S: Serializer>(radians: &[f32; 2], serializer: S) -> Result<S::Ok, S::Error> {
            radians.map(exact_degrees).serialize(serializer)
        }

        /// Reads degrees as radians.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f32; 2], D::Error> {
            <[Digits; 2]>::deserialize(deserializer).map(|pair| pair.map(|Digits(degrees)| radians_of(degrees)))
        }
    }

    /// Three angles: radians in memory, degrees in the file.
    #[derive(Clone, Copy, schemars::JsonSchema)]
    pub struct DegreeTriple(pub [f32; 3]);

    impl Serialize for DegreeTriple {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            self.0.map(exact_degrees).serialize(serializer)
        }
    }

    impl<'de> Deserialize<'de> for DegreeTriple {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            <[Digits; 3]>::deserialize(deserializer).map(|three| Self(three.map(|Digits(degrees)| radians_of(degrees))))
        }
    }

    /// A pair of angles that may be absent: radians in memory, degrees in the file.
    pub mod optional_degree_pair {
        use super::*;

        /// Writes radians as degrees, or null.
        pub fn serialize<S: Serializer>(radians: &Option<[f32; 2]>, serializer: S) -> Result<S::Ok, S::Error> {
            radians.map(|pair| pair.map(exact_degrees)).serialize(serializer)
        }

        /// Reads degrees as radians, or null.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f32; 2]>, D::Error> {
            let pair = Option::<[Digits; 2]>::deserialize(deserializer)?;
            Ok(pair.map(|pair| pair.map(|Digits(degrees)| radians_of(degrees))))
        }
    }

    /// A step or velocity: two lengths and a turn. Radians in memory, degrees in the file.
    pub mod step {
        use super::*;

        /// The largest magnitude of a number that is read: it must stay finite in single precision.
        const LARGEST: f64 = 1e30;

        /// Writes `[x, y, degrees]`.
        pub fn serialize<S: Serializer>([x, y, turn]: &[f32; 3], serializer: S) -> Result<S::Ok, S::Error> {
            (x, y, exact_degrees(*turn)).serialize(serializer)
        }

        /// Reads `[x, y, degrees]`.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f32; 3], D::Error> {
            <[f64; 3]>::deserialize(deserializer).map(|step| {
                let [x, y, turn] = step.map(|number| number.clamp(-LARGEST, LARGEST));
                [x as f32, y as f32, radians_of(turn)]
            })
        }
    }

    /// A step that may be absent: two lengths and a turn. Radians in memory, degrees in the file.
    pub mod optional_step {
        use super::*;

        #[derive(Serialize, Deserialize)]
        #[serde(transparent)]
        struct FileStep(#[serde(with = "step")] [f32; 3]);

        /// Writes `[x, y, degrees]`, or null.
        pub fn serialize<S: Serializer>(step: &Option<[f32; 3]>, serializer: S) -> Result<S::Ok, S::Error> {
            step.map(FileStep).serialize(serializer)
        }

        /// Reads `[x, y, degrees]`, or null.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f32; 3]>, D::Error> {
            Option::<FileStep>::deserialize(deserializer).map(|step| step.map(|FileStep(step)| step))
        }
    }

    /// A pose as `[x m, y m, heading deg]`.
    pub mod pose {
        use super::*;

        /// Writes `[x, y, degrees]`.
        pub fn serialize<S: Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
            to_file(*pose).serialize(serializer)
        }

        /// Reads `[x, y, degrees]`.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Pose, D::Error> {
            <[Digits; 3]>::deserialize(deserializer).map(from_file)
        }
    }

    /// A pose that may be absent, as `[x m, y m, heading deg]` or null.
    pub mod optional_pose {
        use super::*;

        /// Writes `[x, y, degrees]` or null.
        pub fn serialize<S: Serializer>(pose: &Option<Pose>, serializer: S) -> Result<S::Ok, S::Error> {
            pose.map(to_file).serialize(serializer)
        }

        /// Reads `[x, y, degrees]` or null.
        pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Pose>, D::Error> {
            Ok(Option::<[Digits; 3]>::deserialize(deserializer)?.map(from_file))
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
