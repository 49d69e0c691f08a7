//! Selects the fields that a trace, or a program's perceptions, contain: all of them, or some by name.

use core::fmt;
use core::str::FromStr;
use serde::ser::{Serialize, SerializeMap, SerializeSeq, SerializeStruct, Serializer};
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

use super::trace_fields::TRACE_FIELDS;
use crate::scenario::wording::{in_words, nearest, one_of, quoted};

/// Fields that every line and every robot have, selected or not, because they identify the rest.
const ALWAYS: [&str; 4] = ["type", "cycle", "time_s", "id"];

/// The fields of a robot in a trace that are also fields of a perception.
const PERCEIVED: [&str; 8] = ["head_deg", "odometry", "sonar_m", "percepts", "inbox", "game", "body", "sensors"];

/// Fields of a trace's lines by name, such as `ball`, `robots.pose` or `events`. By default all fields.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Fields {
    /// The names as given.
    names: Vec<String>,
    chosen: Node,
}

/// The selected parts of a value, by field. If empty, the whole value is selected.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
struct Node(BTreeMap<String, Node>);

/// The error for a name that is no field of a trace.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", .0)]
pub struct NoSuchField(String);

naoisis_core::debug_as_displayed!(NoSuchField);

impl NoSuchField {
    fn in_perception(name: &str) -> Self {
        let meant = meant_by(name, perceived_names).map(|name| format!(": did you mean `{name}`?")).unwrap_or_default();
        let message = format!("there is no field {} in a perception{meant}", quoted(name));
        let expected = format!("{}, or a part of one, such as `percepts.ball`", one_of(PERCEIVED.into_iter()));
        NoSuchField(in_words(&message, &expected))
    }

    fn named(name: &str) -> Self {
        let meant = meant_by(name, known_names).map(|name| format!(": did you mean `{name}`?")).unwrap_or_default();
        let message = format!("there is no field {} in a trace{meant}", quoted(name));
        let wholes = known_names().filter(|name| !name.contains('.') && !ALWAYS.contains(name));
        let expected = format!("{}, or a part of one, such as `robots.pose`", one_of(wholes));
        NoSuchField(in_words(&message, &expected))
    }
}

/// Returns the names of all fields of a perception.
fn perceived_names() -> impl Iterator<Item = &'static str> {
    let is_perceived = |name: &&str| PERCEIVED.contains(&name.split('.').next().unwrap_or(name));
    known_names().filter_map(|name| name.strip_prefix("robots.")).filter(is_perceived)
}

/// Returns the names of all fields.
fn known_names() -> impl Iterator<Item = &'static str> {
    TRACE_FIELDS.keys().map(String::as_str)
}

/// Returns the field that was probably meant: the outermost field with this name, or one that is a few typing errors away.
fn meant_by<I: Iterator<Item = &'static str>>(name: &str, known_names: impl Fn() -> I) -> Option<&'static str> {
    let is_within = |known: &&str| !name.is_empty() && known.strip_suffix(name).is_some_and(|rest| rest.ends_with('.'));
    let depth = |known: &&str| known.split('.').count();
    known_names().filter(is_within).min_by_key(depth).or_else(|| nearest(name, known_names()))
}

impl Fields {
    /// Returns whether all fields are selected.
    pub fn is_all(&self) -> bool {
        self.names.is_empty()
    }

    /// Returns whether a field, or a part of it, is selected.
    pub fn has(&self, name: &str) -> bool {
        let mut node = &self.chosen;
        for step in name.split('.') {
            if node.0.is_empty() {
                return true;
            }
            match node.0.get(step) {
                Some(child) => node = child,
                None => return false,
            }
        }
        true
    }

    /// Returns the names of the selected fields. Empty if all fields are selected.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Selects fields of a perception by their names in it, such as `percepts.ball` or `game.state`. Selects all if there are no names.
    ///
    /// # Errors
    /// If a name is no field of a perception.
    pub fn of_perception(names: &[String]) -> Result<Self, NoSuchField> {
        let names = names.iter().map(String::as_str);
        let is_known = |name: &str| name.starts_with("sensors.") || perceived_names().any(|known| known == name);
        Self::from_names(names, is_known, NoSuchField::in_perception)
    }

    /// Returns a serialisable value that has only the selected fields of `value`.
    pub fn of<'a, T: Serialize>(&'a self, value: &'a T) -> impl Serialize + 'a {
        Part { value, chosen: &self.chosen }
    }

    fn from_names<'a>(
        names: impl Iterator<Item = &'a str>,
        known: impl Fn(&str) -> bool,
        error: fn(&str) -> NoSuchField,
    ) -> Result<Self, NoSuchField> {
        let mut fields = Fields::default();
        let mut wholes: Vec<&str> = Vec::new();
        for name in names.map(str::trim).filter(|name| !name.is_empty()) {
            if !known(name) {
                return Err(error(name));
            }
            fields.names.push(name.to_owned());
            wholes.push(name);
        }
        // Parts of a field that is selected as a whole are redundant.
        let is_within = |name: &str, whole: &str| name.strip_prefix(whole).is_some_and(|rest| rest.starts_with('.'));
        for name in wholes.iter().filter(|name| !wholes.iter().any(|whole| is_within(name, whole))) {
            let mut node = &mut fields.chosen;
            for step in name.split('.') {
                node = node.0.entry(step.to_owned()).or_default();
            }
        }
        Ok(fields)
    }
}

impl FromStr for Fields {
    type Err = NoSuchField;

    fn from_str(list: &str) -> Result<Self, NoSuchField> {
        // Readings of custom sensors have custom names.
        let is_known = |name: &str| {
            name.starts_with("robots.sensors.")
                || known_names()
                    .any(|known| known == name || known.strip_prefix(name).is_some_and(|rest| rest.starts_with('.')))
        };
        let fields = Self::from_names(list.split(','), is_known, NoSuchField::named)?;
        if fields.is_all() { Err(NoSuchField::named("")) } else { Ok(fields) }
    }
}

impl fmt::Display for Fields {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.names.join(", "))
    }
}

impl Serialize for Fields {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.names.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Unknown names are accepted: a later version may have more fields.
        let names = Vec::<String>::deserialize(deserializer)?;
        Self::from_names(names.iter().map(String::as_str), |_| true, NoSuchField::named)
            .map_err(serde::de::Error::custom)
    }
}

/// A value of which only the selected parts are serialised.
struct Part<'a, T: ?Sized> {
    value: &'a T,
    chosen: &'a Node,
}

impl<T: ?Sized + Serialize> Serialize for Part<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.chosen.0.is_empty() {
            self.value.serialize(serializer)
        } else {
            self.value.serialize(FieldFilter { inner: serializer, chosen: self.chosen })
        }
    }
}

/// A serializer that passes on only the selected fields of structs, also inside lists and options.
struct FieldFilter<'a, S> {
    inner: S,
    chosen: &'a Node,
}

macro_rules! pass {
    ($($method:ident($($argument:ident: $type:ty),*) $(-> $compound:ident)?;)*) => {
        $(fn $method(self $(, $argument: $type)*) -> Result<pass!(@ $($compound)?), S::Error> {
            self.inner.$method($($argument),*)
        })*
    };
    (@ $compound:ident) => { S::$compound };
    (@) => { S::Ok };
}

impl<'a, S: Serializer> Serializer for FieldFilter<'a, S> {
    type Ok = S::Ok;
    type Error = S::Error;
    type SerializeSeq = FieldFilter<'a, S::SerializeSeq>;
    type SerializeTuple = S::SerializeTuple;
    type SerializeTupleStruct = S::SerializeTupleStruct;
    type SerializeTupleVariant = S::SerializeTupleVariant;
    type SerializeMap = S::SerializeMap;
    type SerializeStruct = FieldFilter<'a, S::SerializeMap>;
    type SerializeStructVariant = S::SerializeStructVariant;

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<S::Ok, S::Error> {
        self.inner.serialize_some(&Part { value, chosen: self.chosen })
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(self, name: &'static str, value: &T) -> Result<S::Ok, S::Error> {
        self.inner.serialize_newtype_struct(name, &Part { value, chosen: self.chosen })
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<Self::SerializeSeq, S::Error> {
        Ok(FieldFilter { inner: self.inner.serialize_seq(length)?, chosen: self.chosen })
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self::SerializeStruct, S::Error> {
        // The number of fields is not known yet. Only a map can be serialised without it.
        Ok(FieldFilter { inner: self.inner.serialize_map(None)?, chosen: self.chosen })
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<S::Ok, S::Error> {
        self.inner.serialize_newtype_variant(name, index, variant, value)
    }

    pass! {
        serialize_bool(value: bool);
        serialize_i8(value: i8);
        serialize_i16(value: i16);
        serialize_i32(value: i32);
        serialize_i64(value: i64);
        serialize_u8(value: u8);
        serialize_u16(value: u16);
        serialize_u32(value: u32);
        serialize_u64(value: u64);
        serialize_f32(value: f32);
        serialize_f64(value: f64);
        serialize_char(value: char);
        serialize_str(value: &str);
        serialize_bytes(value: &[u8]);
        serialize_none();
        serialize_unit();
        serialize_unit_struct(name: &'static str);
        serialize_unit_variant(name: &'static str, index: u32, variant: &'static str);
        serialize_tuple(length: usize) -> SerializeTuple;
        serialize_tuple_struct(name: &'static str, length: usize) -> SerializeTupleStruct;
        serialize_tuple_variant(name: &'static str, index: u32, variant: &'static str, length: usize) -> SerializeTupleVariant;
        serialize_map(length: Option<usize>) -> SerializeMap;
        serialize_struct_variant(name: &'static str, index: u32, variant: &'static str, length: usize) -> SerializeStructVariant;
    }
}

impl<S: SerializeSeq> SerializeSeq for FieldFilter<'_, S> {
    type Ok = S::Ok;
    type Error = S::Error;

    fn serialize_element<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), S::Error> {
        self.inner.serialize_element(&Part { value, chosen: self.chosen })
    }

    fn end(self) -> Result<S::Ok, S::Error> {
        self.inner.end()
    }
}

impl<S: SerializeMap> SerializeStruct for FieldFilter<'_, S> {
    type Ok = S::Ok;
    type Error = S::Error;

    fn serialize_field<T: ?Sized + Serialize>(&mut self, name: &'static str, value: &T) -> Result<(), S::Error> {
        match self.chosen.0.get(name) {
            Some(chosen) => self.inner.serialize_entry(name, &Part { value, chosen }),
            None if ALWAYS.contains(&name) => self.inner.serialize_entry(name, value),
            None => Ok(()),
        }
    }

    fn end(self) -> Result<S::Ok, S::Error> {
        self.inner.end()
    }
}
