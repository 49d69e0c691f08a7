//! Vectors that files write with two numbers (on the ground) or with three.

use bevy::math::Vec3;
use core::fmt;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserializer, Serialize, Serializer};

/// Writes two numbers if z is zero, otherwise three.
pub(super) fn serialize<S: Serializer>(vector: &Vec3, serializer: S) -> Result<S::Ok, S::Error> {
    match vector.to_array() {
        [x, y, 0.0] => [x, y].serialize(serializer),
        all => all.serialize(serializer),
    }
}

/// Reads two or three numbers. Without a third one, z is zero.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec3, D::Error> {
    deserializer.deserialize_seq(TwoOrThree)
}

struct TwoOrThree;

impl<'de> Visitor<'de> for TwoOrThree {
    type Value = Vec3;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("two or three numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Vec3, A::Error> {
        let mut read = [0.0; 3];
        let mut count = 0;
        while let Some(number) = numbers.next_element::<f32>()? {
            if let Some(place) = read.get_mut(count) {
                *place = number;
            }
            count += 1;
        }
        if (2..=3).contains(&count) { Ok(read.into()) } else { Err(A::Error::invalid_length(count, &self)) }
    }
}
