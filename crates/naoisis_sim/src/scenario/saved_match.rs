//! Saved matches: the format of their files, and the packed form in scenarios that continue them.
//!
//! A file is a MessagePack map: the name and version of the format, the resources of the match, and its entities. Values are stored under
//! the names of their types.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bevy::prelude::*;
use bevy::reflect::serde::TypedReflectDeserializer;
use bevy::reflect::{ReflectFromReflect, TypeRegistration, TypeRegistry};
use core::fmt;
use schemars::JsonSchema;
use serde::de::{DeserializeSeed, Error as _, IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::message_pack::{self, MessagePackError};
use naoisis_core::read_file::LARGEST_FILE_BYTES;

/// Extension of the file names of saved matches.
pub const EXTENSION: &str = "naoisis";
/// Name of the format in files.
pub const FORMAT: &str = "naoisis-snapshot";
/// Version of the format in files.
pub const VERSION: u32 = 9;
/// Compression level of the packed match. A higher level would delay the reading of tests and save little.
const PACKING: i32 = 9;

/// Why bytes are no saved match.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SavedMatchError {
    /// The bytes are not MessagePack.
    #[error(transparent)]
    Structure(#[from] MessagePackError),
    /// The bytes are MessagePack with other contents, or have types that are not registered here.
    #[error("{0}")]
    Content(String),
    /// There are bytes after the end of the match.
    #[error("there is something behind its end")]
    Trailing,
    /// The packed bytes are damaged.
    #[error("it is damaged")]
    Damaged,
    /// The match cannot be packed.
    #[error("{0}")]
    Packing(String),
}

naoisis_core::debug_as_displayed!(SavedMatchError);

/// A saved match in packed form.
#[derive(Clone, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SavedMatch {
    /// The last completed cycle.
    pub cycle: u64,
    /// The bytes of the file, compressed by zstd, in base64.
    #[serde(rename = "match")]
    packed: String,
}

impl SavedMatch {
    /// Packs the bytes of a file.
    ///
    /// # Errors
    /// The reason why they cannot be packed.
    pub(super) fn pack(cycle: u64, bytes: &[u8]) -> Result<SavedMatch, SavedMatchError> {
        let packed =
            zstd::bulk::compress(bytes, PACKING).map_err(|error| SavedMatchError::Packing(error.to_string()))?;
        Ok(SavedMatch { cycle, packed: STANDARD.encode(packed) })
    }

    /// Returns the bytes of the original file.
    ///
    /// # Errors
    /// If the packed bytes are damaged.
    pub fn bytes(&self) -> Result<Vec<u8>, SavedMatchError> {
        let packed = STANDARD.decode(&self.packed).map_err(|_| SavedMatchError::Damaged)?;
        let size = zstd::bulk::Decompressor::upper_bound(&packed).unwrap_or(LARGEST_FILE_BYTES as usize);
        zstd::bulk::decompress(&packed, size.min(LARGEST_FILE_BYTES as usize)).map_err(|_| SavedMatchError::Damaged)
    }
}

/// Reads the two parts of a file, each with its own seed.
///
/// # Errors
/// The fault of the bytes.
pub(crate) fn read_parts<'de, R: DeserializeSeed<'de>, E: DeserializeSeed<'de>>(
    bytes: &'de [u8],
    resources: R,
    entities: E,
) -> Result<(R::Value, E::Value), SavedMatchError> {
    message_pack::check(bytes)?;
    let mut deserializer = rmp_serde::Deserializer::from_read_ref(bytes);
    let parts = deserializer
        .deserialize_map(Parts { resources, entities })
        .map_err(|error| SavedMatchError::Content(without_expected(&error.to_string())))?;
    match IgnoredAny::deserialize(&mut deserializer) {
        // Nothing is left to read.
        Err(rmp_serde::decode::Error::InvalidMarkerRead(_)) => Ok(parts),
        _ => Err(SavedMatchError::Trailing),
    }
}

/// An error of a decoder in other words than "expected": the error of the file says what was expected of it.
fn without_expected(message: &str) -> String {
    message.replacen(", expected ", " instead of ", 1)
}

/// Visits the map of a file.
struct Parts<R, E> {
    resources: R,
    entities: E,
}

impl<'de, R: DeserializeSeed<'de>, E: DeserializeSeed<'de>> Visitor<'de> for Parts<R, E> {
    type Value = (R::Value, E::Value);

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a saved match")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let (mut resources_seed, mut entities_seed) = (Some(self.resources), Some(self.entities));
        let (mut resources, mut entities) = (None, None);
        let mut is_one = false;
        let other = || A::Error::custom("it is something else");
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "format" => is_one = map.next_value::<String>()? == FORMAT,
                "version" => {
                    let version: u32 = map.next_value()?;
                    if version != VERSION {
                        return Err(A::Error::custom(format!("it has version {version}, not {VERSION}")));
                    }
                }
                "resources" if is_one => {
                    resources = Some(map.next_value_seed(resources_seed.take().ok_or_else(other)?)?);
                }
                "entities" if is_one => {
                    entities = Some(map.next_value_seed(entities_seed.take().ok_or_else(other)?)?);
                }
                _ => return Err(other()),
            }
        }
        resources.zip(entities).ok_or_else(|| A::Error::custom("it is empty"))
    }
}

/// Reads values that are stored under the names of their types. `find` returns the type for a name, `None` for values to skip, or an error.
pub(crate) struct NamedValues<'a, F> {
    pub(crate) registry: &'a TypeRegistry,
    pub(crate) find: F,
}

impl<'a, 'de, F: Fn(&str) -> Result<Option<&'a TypeRegistration>, String>> DeserializeSeed<'de> for NamedValues<'a, F> {
    type Value = Vec<Box<dyn Reflect>>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'a, 'de, F: Fn(&str) -> Result<Option<&'a TypeRegistration>, String>> Visitor<'de> for NamedValues<'a, F> {
    type Value = Vec<Box<dyn Reflect>>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("values by the names of their types")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut values: Self::Value = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            let Some(registration) = (self.find)(&name).map_err(A::Error::custom)? else {
                map.next_value::<IgnoredAny>()?;
                continue;
            };
            let value = map.next_value_seed(TypedReflectDeserializer::new(registration, self.registry))?;
            if values.iter().any(|value| value.as_any().type_id() == registration.type_id()) {
                return Err(A::Error::custom(format!("there are two of `{name}`")));
            }
            let from_reflect = registration.data::<ReflectFromReflect>();
            let value = from_reflect
                .and_then(|from_reflect| from_reflect.from_reflect(&*value))
                .ok_or_else(|| A::Error::custom(format!("this is not all of a `{name}`")))?;
            values.push(value);
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::marker::PhantomData;

    #[test]
    fn a_file_of_something_else_is_not_said_to_be_expected_to_be_a_saved_match() {
        let error = read_parts(b"{", PhantomData::<IgnoredAny>, PhantomData::<IgnoredAny>).unwrap_err().to_string();
        assert!(error.ends_with("instead of a saved match") && !error.contains("expected"), "{error}");
    }
}
