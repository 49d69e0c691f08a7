//! Settings that are written as the name of a preset, or as an object with the fields that differ from one.

use core::fmt;
use core::marker::PhantomData;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Deserializer, Error, MapAccess, Unexpected, Visitor};

/// Settings that have presets.
pub(crate) trait Preset: Sized + Default {
    /// The fields that an object may change, none of them required, and `preset`.
    type Changes: DeserializeOwned;

    /// The names of the presets.
    const NAMES: &'static [&'static str];

    /// The preset of this name.
    fn preset(name: &str) -> Option<Self>;

    /// The preset that an object starts from, if it names one; the default otherwise.
    fn base(changes: &Self::Changes) -> Option<&str>;

    /// With the fields of an object.
    fn changed(self, changes: Self::Changes) -> Self;
}

/// Reads the name of a preset, or an object of changes. Without an untagged enum, so that errors keep their place.
pub(crate) fn deserialize<'de, T: Preset, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(PresetVisitor(PhantomData))
}

struct PresetVisitor<T>(PhantomData<T>);

impl<'de, T: Preset> Visitor<'de> for PresetVisitor<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "one of the presets `{}`, or an object of fields", T::NAMES.join("`, `"))
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        T::preset(name).ok_or_else(|| E::invalid_value(Unexpected::Str(name), &self))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        let changes: T::Changes = serde::Deserialize::deserialize(MapAccessDeserializer::new(map))?;
        let base = match T::base(&changes) {
            Some(name) => self.visit_str(name)?,
            None => T::default(),
        };
        Ok(base.changed(changes))
    }
}

/// Reads a field that is there. For the fields of [`Preset::Changes`], where plain options would want `Some(...)` in RON.
pub(crate) fn present<'de, T: serde::Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}
