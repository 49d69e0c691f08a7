//! That every number of a scenario is finite, whatever fields it has: a serializer that writes nothing and stops at
//! the first number that is not.

use core::fmt;
use serde::ser::{
    self, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};
use serde_path_to_error::Track;

use super::ScenarioFault;
use crate::scenario::field_path::FieldPath;

/// Finds the first number that is not finite.
pub fn check(value: &impl Serialize) -> Result<(), ScenarioFault> {
    let mut track = Track::new();
    value.serialize(serde_path_to_error::Serializer::new(FiniteOnly, &mut track)).map_err(|NotFinite(what)| {
        ScenarioFault::new(FieldPath::from(&track.path()), what, "a finite number, of single precision")
    })
}

#[derive(Debug)]
struct NotFinite(String);

impl fmt::Display for NotFinite {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for NotFinite {}

impl ser::Error for NotFinite {
    fn custom<T: fmt::Display>(message: T) -> Self {
        NotFinite(message.to_string())
    }
}

struct FiniteOnly;

macro_rules! nothing_to_check {
    ($($method:ident($type:ty))*) => {
        $(fn $method(self, _: $type) -> Result<(), NotFinite> {
            Ok(())
        })*
    };
}

macro_rules! whatever_is_inside {
    ($($trait:ident::$method:ident($($key:ident)?))*) => {
        $(impl $trait for FiniteOnly {
            type Ok = ();
            type Error = NotFinite;

            fn $method<T: ?Sized + Serialize>(&mut self, $($key: &'static str,)? value: &T) -> Result<(), NotFinite> {
                $(let _ = $key;)?
                value.serialize(FiniteOnly)
            }

            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })*
    };
}

whatever_is_inside! {
    SerializeSeq::serialize_element() SerializeTuple::serialize_element() SerializeTupleStruct::serialize_field()
    SerializeTupleVariant::serialize_field() SerializeStruct::serialize_field(key)
    SerializeStructVariant::serialize_field(key)
}

impl SerializeMap for FiniteOnly {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, _key: &T) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NotFinite> {
        value.serialize(FiniteOnly)
    }

    fn end(self) -> Result<(), NotFinite> {
        Ok(())
    }
}

impl Serializer for FiniteOnly {
    type Ok = ();
    type Error = NotFinite;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    nothing_to_check! {
        serialize_bool(bool) serialize_i8(i8) serialize_i16(i16) serialize_i32(i32) serialize_i64(i64)
        serialize_u8(u8) serialize_u16(u16) serialize_u32(u32) serialize_u64(u64) serialize_char(char)
        serialize_str(&str) serialize_bytes(&[u8]) serialize_unit_struct(&'static str)
    }

    fn serialize_f32(self, number: f32) -> Result<(), NotFinite> {
        self.serialize_f64(f64::from(number))
    }

    fn serialize_f64(self, number: f64) -> Result<(), NotFinite> {
        if number.is_finite() { Ok(()) } else { Err(NotFinite(format!("{number} is not a finite number"))) }
    }

    fn serialize_none(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, _: &'static str, value: &T) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_struct_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::motion::{MotionError, MotionLimits};
    use crate::scenario::types::{BehaviourSpec, RobotSpec, Scenario, ScriptEntry};
    use bevy::utils::default;

    #[test]
    fn the_first_number_that_is_not_finite_is_named_as_in_files() {
        let entry = ScriptEntry { walk: Some([0.0, 0.0, f32::INFINITY]), ..default() };
        let behaviour = BehaviourSpec::Script(vec![ScriptEntry::default(), entry]);
        let scenario = Scenario { robots: vec![RobotSpec { behaviour, ..default() }], ..default() };
        assert_eq!(check(&scenario).unwrap_err().path.to_string(), "robots[0].behaviour.script[1].walk[2]");
        let error_sd = MotionError { dtheta: f32::NAN, ..default() };
        let scenario = Scenario { motion: MotionLimits { error_sd, ..default() }, ..default() };
        assert_eq!(check(&scenario).unwrap_err().path.to_string(), "motion.error_sd.dtheta_deg");
        assert_eq!(check(&Scenario::default()), Ok(()));
    }
}
