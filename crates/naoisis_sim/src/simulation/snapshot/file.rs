//! Snapshots in files: MessagePack with a name and a version, and values under the names of their types.

use bevy::prelude::*;
use bevy::reflect::serde::TypedReflectSerializer;
use bevy::reflect::{TypePathTable, TypeRegistration, TypeRegistry};
use core::fmt;
use serde::de::{DeserializeSeed, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::io::Write as _;
use std::path::Path;

use super::{EntityState, Snapshot, SnapshotError, belongs_to_match};
use crate::scenario::SavedMatchError;
use crate::scenario::saved_match::{FORMAT, NamedValues, VERSION, read_parts};
use naoisis_core::knowledge::is_of_naoisis;
use naoisis_core::read_file::read_file;
use naoisis_core::replace_file::replace_file;

/// Prefix of the names of the simulation's own types in files.
const OWN: &str = "naoisis::";

/// Names of types in older files, and the names of these types now.
const EARLIER_NAMES: [(&str, &str); 3] = [
    ("naoisis::Balance", "naoisis::FallModel"),
    ("naoisis::CyclePart", "naoisis::PendingHalf"),
    ("naoisis::MotionLimits", "naoisis::MotionSettings"),
];

impl Snapshot {
    /// Writes the snapshot to a file atomically, and replaces an earlier file. `world` has the registered types.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path, world: &World) -> Result<(), SnapshotError> {
        let io_error = |error| SnapshotError::Io { path: path.to_owned(), error };
        let bytes = self.to_bytes(world)?;
        replace_file(path, |mut file| file.write_all(&bytes)).map_err(io_error)
    }

    /// Reads a snapshot from a file. `world` has the registered types.
    ///
    /// # Errors
    /// If the file cannot be read, or was not written by [`Snapshot::save`].
    pub fn load(path: &Path, world: &World) -> Result<Snapshot, SnapshotError> {
        let bytes = read_file(path).map_err(|error| SnapshotError::Io { path: path.to_owned(), error })?;
        Snapshot::from_bytes(&bytes, world)
            .map_err(|error| SnapshotError::NotASnapshot { path: path.to_owned(), error })
    }

    /// Returns the snapshot as the bytes of a file.
    ///
    /// # Errors
    /// If a value cannot be encoded. This does not happen with the simulation's own types.
    pub fn to_bytes(&self, world: &World) -> Result<Vec<u8>, SnapshotError> {
        let registry = world.resource::<AppTypeRegistry>().read();
        rmp_serde::to_vec_named(&SnapshotSerializer { snapshot: self, registry: &registry })
            .map_err(|error| SnapshotError::NotEncoded(error.to_string()))
    }

    /// Reads a snapshot from the bytes of a file.
    ///
    /// # Errors
    /// The fault of the bytes.
    pub fn from_bytes(bytes: &[u8], world: &World) -> Result<Snapshot, SavedMatchError> {
        let registry = world.resource::<AppTypeRegistry>().read();
        let (resources, entities) = read_parts(bytes, values_of(&registry), EntitiesSeed(&registry))?;
        Ok(Snapshot { resources, entities })
    }
}

/// Reads values of the types that a snapshot can have. Other types are errors.
fn values_of<'a>(
    registry: &'a TypeRegistry,
) -> NamedValues<'a, impl Fn(&str) -> Result<Option<&'a TypeRegistration>, String>> {
    let find = move |name: &str| match registration_by_name(name, registry) {
        Some(registration) => Ok(Some(registration)),
        None => Err(format!("there is no type `{name}` here")),
    };
    NamedValues { registry, find }
}

/// Returns the name of a type in files. Types of the simulation have a name without their module, so that old files can be read after a
/// type has moved. Other types have their whole path.
fn saved_name(paths: &TypePathTable) -> Cow<'static, str> {
    if is_of_naoisis(paths.path()) {
        Cow::Owned(format!("{OWN}{}", paths.short_path()))
    } else {
        Cow::Borrowed(paths.path())
    }
}

/// Returns the type with this name in files.
fn registration_by_name<'a>(name: &str, registry: &'a TypeRegistry) -> Option<&'a TypeRegistration> {
    if !name.starts_with(OWN) {
        return registry.get_with_type_path(name);
    }
    let name = EARLIER_NAMES.iter().find(|(earlier, _)| *earlier == name).map_or(name, |(_, current)| current);
    saved_types(registry).find(|registration| saved_name(registration.type_info().type_path_table()) == name)
}

/// Returns the types of components and resources that a snapshot can have.
fn saved_types(registry: &TypeRegistry) -> impl Iterator<Item = &TypeRegistration> {
    registry
        .iter()
        .filter(|registration| registration.data::<ReflectComponent>().is_some() && belongs_to_match(registration))
}

/// Serialises a snapshot.
struct SnapshotSerializer<'a> {
    snapshot: &'a Snapshot,
    registry: &'a TypeRegistry,
}

impl Serialize for SnapshotSerializer<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let SnapshotSerializer { snapshot, registry } = *self;
        let mut map = serializer.serialize_map(Some(4))?;
        map.serialize_entry("format", FORMAT)?;
        map.serialize_entry("version", &VERSION)?;
        map.serialize_entry("resources", &WrittenValues { values: &snapshot.resources, registry })?;
        map.serialize_entry("entities", &WrittenEntities { entities: &snapshot.entities, registry })?;
        map.end()
    }
}

struct WrittenEntities<'a> {
    entities: &'a [EntityState],
    registry: &'a TypeRegistry,
}

impl Serialize for WrittenEntities<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.entities.len()))?;
        for entity in self.entities {
            let components = WrittenValues { values: &entity.components, registry: self.registry };
            list.serialize_element(&WrittenEntity { behaviours: &entity.behaviours, components })?;
        }
        list.end()
    }
}

#[derive(Serialize)]
struct WrittenEntity<'a> {
    behaviours: &'a [String],
    components: WrittenValues<'a>,
}

/// Serialises values under the names of their types.
struct WrittenValues<'a> {
    values: &'a [Box<dyn Reflect>],
    registry: &'a TypeRegistry,
}

impl Serialize for WrittenValues<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.values.len()))?;
        for value in self.values {
            let name = saved_name(value.reflect_type_info().type_path_table());
            map.serialize_entry(&name, &TypedReflectSerializer::new(value.as_partial_reflect(), self.registry))?;
        }
        map.end()
    }
}

struct EntitiesSeed<'a>(&'a TypeRegistry);

impl<'de> DeserializeSeed<'de> for EntitiesSeed<'_> {
    type Value = Vec<EntityState>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<EntityState>, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for EntitiesSeed<'_> {
    type Value = Vec<EntityState>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of entities")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<EntityState>, A::Error> {
        let mut entities = Vec::new();
        while let Some(entity) = list.next_element_seed(EntitySeed(self.0))? {
            entities.push(entity);
        }
        Ok(entities)
    }
}

struct EntitySeed<'a>(&'a TypeRegistry);

impl<'de> DeserializeSeed<'de> for EntitySeed<'_> {
    type Value = EntityState;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<EntityState, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for EntitySeed<'_> {
    type Value = EntityState;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an entity")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<EntityState, A::Error> {
        let mut state = EntityState { behaviours: Vec::new(), components: Vec::new() };
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "behaviours" => state.behaviours = map.next_value()?,
                "components" => state.components = map.next_value_seed(values_of(self.0))?,
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        // Otherwise a single byte of a file could make such an entity.
        if state.components.is_empty() {
            return Err(A::Error::custom("there is an entity of nothing"));
        }
        Ok(state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::NaoisisPlugins;
    use std::collections::BTreeSet;

    #[test]
    fn what_is_saved_has_a_name_of_its_own_that_no_module_is_part_of() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins));
        let registry = app.world().resource::<AppTypeRegistry>().read();
        let mut names = BTreeSet::new();
        for registration in saved_types(&registry) {
            let name = saved_name(registration.type_info().type_path_table()).into_owned();
            let own_name = name.strip_prefix(OWN).unwrap_or_else(|| panic!("{name} is not the simulation's"));
            assert!(!own_name.contains("::"), "the name {name} changes when a module does");
            assert_eq!(
                registration_by_name(&name, &registry).map(TypeRegistration::type_id),
                Some(registration.type_id())
            );
            assert!(names.insert(name.clone()), "two types have the name {name}");
        }
        assert!(names.contains("naoisis::RobotId") && names.contains("naoisis::CycleClock"), "{names:?}");
        for (earlier, current) in EARLIER_NAMES {
            assert!(!names.contains(earlier) && names.contains(current), "{earlier} is {current} now");
        }
    }
}
