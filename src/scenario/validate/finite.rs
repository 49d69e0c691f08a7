//! That every number of a scenario is finite, whatever fields it has: a serializer that writes nothing and stops at
//! the first number that is not.

use core::fmt;
use serde::ser::{
    self, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};

use super::ScenarioFault;
use crate::scenario::field_path::{FieldPath, Segment};

/// Finds the first number that is not finite.
pub fn check(value: &impl Serialize) -> Result<(), ScenarioFault> {
    value.serialize(FiniteOnly).map_err(|NotFinite { what, steps }| {
        let path = steps.iter().rev().fold(FieldPath::default(), |path, step| match step {
            Segment::Field(name) => path.field(name),
            Segment::Index(index) => path.index(*index),
        });
        ScenarioFault::new(path, what, "a finite number, of single precision")
    })
}

/// What was found, and the steps that lead there, the last one first.
#[derive(Debug)]
struct NotFinite {
    what: String,
    steps: Vec<Segment>,
}

impl NotFinite {
    fn inside(mut self, step: Segment) -> Self {
        self.steps.push(step);
        self
    }

    fn inside_field(self, name: &str) -> Self {
        self.inside(Segment::Field(name.to_owned()))
    }
}

impl fmt::Display for NotFinite {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.what)
    }
}

impl std::error::Error for NotFinite {}

impl ser::Error for NotFinite {
    fn custom<T: fmt::Display>(message: T) -> Self {
        NotFinite { what: message.to_string(), steps: Vec::new() }
    }
}

struct FiniteOnly;

/// A list, an object or a variant with contents, of which the elements up to `index` are done.
#[derive(Default)]
struct Inside {
    index: usize,
    key: String,
    variant: Option<&'static str>,
}

impl Inside {
    fn check(&self, value: &(impl ?Sized + Serialize), step: Segment) -> Result<(), NotFinite> {
        value.serialize(FiniteOnly).map_err(|found| match self.variant {
            Some(variant) => found.inside(step).inside_field(variant),
            None => found.inside(step),
        })
    }

    fn element(&mut self, value: &(impl ?Sized + Serialize)) -> Result<(), NotFinite> {
        self.index += 1;
        self.check(value, Segment::Index(self.index - 1))
    }

    fn field(&mut self, name: &str, value: &(impl ?Sized + Serialize)) -> Result<(), NotFinite> {
        self.check(value, Segment::Field(name.to_owned()))
    }
}

macro_rules! lists {
    ($($trait:ident::$method:ident)*) => {
        $(impl $trait for Inside {
            type Ok = ();
            type Error = NotFinite;

            fn $method<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NotFinite> {
                self.element(value)
            }

            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })*
    };
}

lists! {
    SerializeSeq::serialize_element SerializeTuple::serialize_element SerializeTupleStruct::serialize_field
    SerializeTupleVariant::serialize_field
}

macro_rules! structs {
    ($($trait:ident)*) => {
        $(impl $trait for Inside {
            type Ok = ();
            type Error = NotFinite;

            fn serialize_field<T: ?Sized + Serialize>(&mut self, key: &'static str, value: &T) -> Result<(), NotFinite> {
                self.field(key, value)
            }

            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })*
    };
}

structs! { SerializeStruct SerializeStructVariant }

impl SerializeMap for Inside {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, key: &T) -> Result<(), NotFinite> {
        self.key = serde_json::to_value(key).ok().and_then(|key| key.as_str().map(str::to_owned)).unwrap_or_default();
        Ok(())
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NotFinite> {
        let key = core::mem::take(&mut self.key);
        self.field(&key, value)
    }

    fn end(self) -> Result<(), NotFinite> {
        Ok(())
    }
}

macro_rules! nothing_to_check {
    ($($method:ident($type:ty))*) => {
        $(fn $method(self, _: $type) -> Result<(), NotFinite> {
            Ok(())
        })*
    };
}

impl Serializer for FiniteOnly {
    type Ok = ();
    type Error = NotFinite;
    type SerializeSeq = Inside;
    type SerializeTuple = Inside;
    type SerializeTupleStruct = Inside;
    type SerializeTupleVariant = Inside;
    type SerializeMap = Inside;
    type SerializeStruct = Inside;
    type SerializeStructVariant = Inside;

    nothing_to_check! {
        serialize_bool(bool) serialize_i8(i8) serialize_i16(i16) serialize_i32(i32) serialize_i64(i64)
        serialize_u8(u8) serialize_u16(u16) serialize_u32(u32) serialize_u64(u64) serialize_char(char)
        serialize_str(&str) serialize_bytes(&[u8]) serialize_unit_struct(&'static str)
    }

    fn serialize_f32(self, number: f32) -> Result<(), NotFinite> {
        self.serialize_f64(f64::from(number))
    }

    fn serialize_f64(self, number: f64) -> Result<(), NotFinite> {
        if number.is_finite() { Ok(()) } else { Err(ser::Error::custom(format!("{number} is not a finite number"))) }
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
        variant: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        value.serialize(self).map_err(|found| found.inside_field(variant))
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Inside, NotFinite> {
        Ok(Inside::default())
    }

    fn serialize_tuple(self, _: usize) -> Result<Inside, NotFinite> {
        Ok(Inside::default())
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Inside, NotFinite> {
        Ok(Inside::default())
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Inside, NotFinite> {
        Ok(Inside { variant: Some(variant), ..Inside::default() })
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Inside, NotFinite> {
        Ok(Inside::default())
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Inside, NotFinite> {
        Ok(Inside::default())
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Inside, NotFinite> {
        Ok(Inside { variant: Some(variant), ..Inside::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behaviour::script::ScriptEntry;
    use crate::robot::motion::{MotionError, MotionLimits};
    use crate::scenario::types::{BehaviourSpec, RobotSpec, Scenario};
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
