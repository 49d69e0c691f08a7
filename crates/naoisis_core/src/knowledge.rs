//! Marks that say what a behaviour may access: every component and resource of the simulation is marked as ground truth, a
//! sensor's reading, a command, a belief or public, by a reflection attribute where it is defined:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::knowledge::Knowledge;
//!
//! #[derive(Component, Reflect)]
//! #[reflect(Component, @Knowledge::Truth)]
//! struct BatteryCharge(f32);
//! ```
//!
//! The [information barrier](crate::behaviour) reads these marks when a behaviour is registered.

use bevy::prelude::*;
use bevy::reflect::{TypeInfo, TypeRegistry};
use core::any::TypeId;
use core::fmt;

/// The meaning of a component or resource for a behaviour, which decides about access.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Reflect)]
pub enum Knowledge {
    /// Ground truth, or anything it could be read from: a behaviour may neither read nor write it.
    Truth,
    /// A measurement of a robot, or a message to it: a behaviour may read it.
    Sensor,
    /// A command to a robot: a behaviour may read and write it.
    Command,
    /// A robot's own estimate or memory: a behaviour may read and write it.
    Belief,
    /// Known to everybody, such as the dimensions of the pitch: a behaviour may read it.
    Public,
}

impl Knowledge {
    /// Whether a behaviour may read a component or resource with this mark.
    pub fn is_readable(self) -> bool {
        self != Knowledge::Truth
    }

    /// Whether a behaviour may write a component or resource with this mark.
    pub fn is_writable(self) -> bool {
        matches!(self, Knowledge::Command | Knowledge::Belief)
    }

    /// The mark of a registered type, if it carries one.
    pub fn of_type(registry: &TypeRegistry, type_id: TypeId) -> Option<Knowledge> {
        Self::of_type_info(registry.get_type_info(type_id)?)
    }

    /// The mark of a type, if it carries one.
    pub fn of_type_info(type_info: &TypeInfo) -> Option<Knowledge> {
        match type_info {
            TypeInfo::Struct(info) => info.get_attribute::<Knowledge>(),
            TypeInfo::TupleStruct(info) => info.get_attribute::<Knowledge>(),
            TypeInfo::Enum(info) => info.get_attribute::<Knowledge>(),
            _ => None,
        }
        .copied()
    }
}

impl fmt::Display for Knowledge {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Knowledge::Truth => "ground truth",
            Knowledge::Sensor => "a sensor",
            Knowledge::Command => "a command",
            Knowledge::Belief => "a belief",
            Knowledge::Public => "public",
        })
    }
}

/// Whether the type with this path belongs to naoisis, rather than to Bevy or a user.
pub fn is_of_naoisis(type_path: &str) -> bool {
    const CRATES: [&str; 10] = [
        "naoisis", "naoisis_agents", "naoisis_cli", "naoisis_core", "naoisis_gpu", "naoisis_lab", "naoisis_record",
        "naoisis_sensing", "naoisis_sim", "naoisis_viewer",
    ];
    type_path.split_once("::").is_some_and(|(name, _)| CRATES.contains(&name))
}
