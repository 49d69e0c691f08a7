//! Checks that every number of a scenario or of a saved match is finite and in bounds, whatever its fields: a serializer that writes
//! nothing and stops at the first invalid number.

use core::fmt;
use serde::ser::{
    self, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};

use super::ScenarioFault;
use crate::scenario::field_path::{FieldPath, Segment};

/// The numbers that are allowed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Numbers {
    /// The largest absolute value of a number that is no count. Every number must be finite.
    pub largest: f32,
    /// Whether counts of 64 bits must be far from the largest one, as those of cycles are added up. Counts of 32 bits stop at the
    /// largest.
    pub counts_go_on: bool,
}

impl Numbers {
    /// Allows all finite numbers.
    pub const FINITE: Numbers = Numbers { largest: f32::MAX, counts_go_on: false };

    /// Checks all numbers of a value.
    ///
    /// # Errors
    /// The place of the first number that is not allowed.
    pub fn check(self, value: &(impl ?Sized + Serialize)) -> Result<(), ScenarioFault> {
        value.serialize(Check(self)).map_err(|WrongNumber { what, steps }| {
            let path = steps.iter().rev().fold(FieldPath::default(), |path, step| match step {
                Segment::Field(name) => path.field(name),
                Segment::Index(index) => path.index(*index),
            });
            ScenarioFault::new(path, what, "a finite number, of single precision")
        })
    }
}

/// The number found, and the steps that lead to it, in reverse order.
#[derive(Debug)]
struct WrongNumber {
    what: String,
    steps: Vec<Segment>,
}

impl WrongNumber {
    fn inside(mut self, step: Segment) -> Self {
        self.steps.push(step);
        self
    }

    fn inside_field(self, name: &str) -> Self {
        self.inside(Segment::Field(name.to_owned()))
    }
}

impl fmt::Display for WrongNumber {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.what)
    }
}

impl std::error::Error for WrongNumber {}

impl ser::Error for WrongNumber {
    fn custom<T: fmt::Display>(message: T) -> Self {
        WrongNumber { what: message.to_string(), steps: Vec::new() }
    }
}

#[derive(Clone, Copy)]
struct Check(Numbers);

/// A list, an object or a variant with contents. `index` counts the elements that are done.
struct PathTracker {
    check: Check,
    index: usize,
    key: String,
    variant: Option<&'static str>,
}

impl PathTracker {
    fn new(check: Check, variant: Option<&'static str>) -> Self {
        Self { check, index: 0, key: String::new(), variant }
    }

    fn check(&self, value: &(impl ?Sized + Serialize), step: Segment) -> Result<(), WrongNumber> {
        value.serialize(self.check).map_err(|found| match self.variant {
            Some(variant) => found.inside(step).inside_field(variant),
            None => found.inside(step),
        })
    }

    fn element(&mut self, value: &(impl ?Sized + Serialize)) -> Result<(), WrongNumber> {
        self.index += 1;
        self.check(value, Segment::Index(self.index - 1))
    }

    fn field(&mut self, name: &str, value: &(impl ?Sized + Serialize)) -> Result<(), WrongNumber> {
        self.check(value, Segment::Field(name.to_owned()))
    }
}

macro_rules! lists {
    ($($trait:ident::$method:ident)*) => {
        $(impl $trait for PathTracker {
            type Ok = ();
            type Error = WrongNumber;

            fn $method<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), WrongNumber> {
                self.element(value)
            }

            fn end(self) -> Result<(), WrongNumber> {
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
        $(impl $trait for PathTracker {
            type Ok = ();
            type Error = WrongNumber;

            fn serialize_field<T: ?Sized + Serialize>(&mut self, key: &'static str, value: &T) -> Result<(), WrongNumber> {
                self.field(key, value)
            }

            fn end(self) -> Result<(), WrongNumber> {
                Ok(())
            }
        })*
    };
}

structs! { SerializeStruct SerializeStructVariant }

impl SerializeMap for PathTracker {
    type Ok = ();
    type Error = WrongNumber;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, key: &T) -> Result<(), WrongNumber> {
        self.key = serde_json::to_value(key).ok().and_then(|key| key.as_str().map(str::to_owned)).unwrap_or_default();
        Ok(())
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), WrongNumber> {
        let key = core::mem::take(&mut self.key);
        self.field(&key, value)
    }

    fn end(self) -> Result<(), WrongNumber> {
        Ok(())
    }
}

impl Check {
    fn count(self, count: u64) -> Result<(), WrongNumber> {
        if self.0.counts_go_on && count > u64::MAX / 4 {
            return Err(ser::Error::custom(format!("{count} is too large a count")));
        }
        Ok(())
    }
}

macro_rules! nothing_to_check {
    ($($method:ident($type:ty))*) => {
        $(fn $method(self, _: $type) -> Result<(), WrongNumber> {
            Ok(())
        })*
    };
}

impl Serializer for Check {
    type Ok = ();
    type Error = WrongNumber;
    type SerializeSeq = PathTracker;
    type SerializeTuple = PathTracker;
    type SerializeTupleStruct = PathTracker;
    type SerializeTupleVariant = PathTracker;
    type SerializeMap = PathTracker;
    type SerializeStruct = PathTracker;
    type SerializeStructVariant = PathTracker;

    nothing_to_check! {
        serialize_bool(bool) serialize_i8(i8) serialize_i16(i16) serialize_i32(i32) serialize_u8(u8) serialize_u16(u16)
        serialize_u32(u32) serialize_char(char) serialize_str(&str) serialize_bytes(&[u8]) serialize_unit_struct(&'static str)
    }

    fn serialize_f32(self, number: f32) -> Result<(), WrongNumber> {
        self.serialize_f64(f64::from(number))
    }

    fn serialize_f64(self, number: f64) -> Result<(), WrongNumber> {
        if !number.is_finite() {
            Err(ser::Error::custom(format!("{number} is not a finite number")))
        } else if number.abs() > f64::from(self.0.largest) {
            Err(ser::Error::custom(format!("{number} is too large a number")))
        } else {
            Ok(())
        }
    }

    fn serialize_u64(self, count: u64) -> Result<(), WrongNumber> {
        self.count(count)
    }

    fn serialize_i64(self, count: i64) -> Result<(), WrongNumber> {
        self.count(count.unsigned_abs())
    }

    fn serialize_none(self) -> Result<(), WrongNumber> {
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), WrongNumber> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), WrongNumber> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), WrongNumber> {
        Ok(())
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, name: &'static str, value: &T) -> Result<(), WrongNumber> {
        // A random stream consists of bits, not of counts.
        if name == "RandomStream" { Ok(()) } else { value.serialize(self) }
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), WrongNumber> {
        value.serialize(self).map_err(|found| found.inside_field(variant))
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, None))
    }

    fn serialize_tuple(self, _: usize) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, None))
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, None))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, Some(variant)))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, None))
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, None))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<PathTracker, WrongNumber> {
        Ok(PathTracker::new(self, Some(variant)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::robot_settings::RobotSettings;
    use crate::scenario::robot_spec::{BehaviourSpec, RobotSpec};
    use crate::scenario::types::Scenario;
    use bevy::utils::default;
    use naoisis_core::behaviour::script::ScriptEntry;
    use naoisis_core::robot::motion::{MotionError, MotionSettings};

    #[test]
    fn the_first_number_that_is_not_finite_is_named_as_in_files() {
        let entry = ScriptEntry { walk: Some([0.0, 0.0, f32::INFINITY]), ..default() };
        let behaviour = BehaviourSpec::Script(vec![ScriptEntry::default(), entry]);
        let scenario = Scenario { robots: vec![RobotSpec { behaviour, ..default() }], ..default() };
        assert_eq!(
            Numbers::FINITE.check(&scenario).unwrap_err().path.to_string(),
            "robots[0].behaviour.script[1].walk[2]"
        );
        let error_sd = MotionError { dtheta: f32::NAN, ..default() };
        let motion = MotionSettings { error_sd, ..default() };
        let scenario = Scenario { settings: RobotSettings { motion, ..default() }, ..default() };
        assert_eq!(Numbers::FINITE.check(&scenario).unwrap_err().path.to_string(), "motion.error_sd.dtheta_deg");
        assert_eq!(Numbers::FINITE.check(&Scenario::default()), Ok(()));
    }

    #[test]
    fn counts_and_sizes_have_limits_where_that_is_asked_for_but_random_streams_do_not() {
        let limits = Numbers { largest: 1e9, counts_go_on: true };
        assert_eq!(limits.check(&(0.5, -1e9, u32::MAX, 1_u64 << 61, u8::MAX)), Ok(()));
        for (index, wrong) in [(2e9, 0), (0.0, u64::MAX)].into_iter().enumerate() {
            let fault = limits.check(&wrong).unwrap_err();
            assert_eq!(fault.path.to_string(), ["[0]", "[1]"][index], "{fault}");
            assert_eq!(Numbers::FINITE.check(&wrong), Ok(()));
        }
        assert_eq!(limits.check(&naoisis_core::random::RandomStream::for_match(1, "all bits")), Ok(()));
    }
}
