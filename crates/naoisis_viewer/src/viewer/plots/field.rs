//! Fields that can be plotted of robots and the ball: every number in their components, by reflection, and measured
//! numbers.

use bevy::prelude::*;
use bevy::reflect::enums::VariantInfo;
use bevy::reflect::{PartialReflect, ReflectRef, TypeInfo, TypeRegistry};
use core::any::TypeId;
use heck::{AsSnakeCase, ToSnakeCase};
use serde::{Deserialize, Serialize};

use super::measured::Measured;
pub use super::subject::Subject;
use super::wording::{self, Unit};
use naoisis_core::knowledge::{Knowledge, is_of_naoisis};

/// The greatest depth of nested values.
const DEEPEST: usize = 6;
/// The longest array whose elements are listed. Of longer ones only the length is plotted.
const LONGEST_ARRAY: usize = 4;

/// The identifier of a field: the type of a component and the path to the number, or the key of a measured number.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Field(pub String);

/// A field with all that is needed to read and to show it.
#[derive(Clone, PartialEq, Debug)]
pub struct KnownField {
    /// The identifier.
    pub field: Field,
    /// Whether it is of the ball, not of each robot.
    pub of_ball: bool,
    /// The group in the window: a component, or "measured".
    pub group: String,
    /// The name in its group.
    pub name: String,
    /// The unit.
    pub unit: Unit,
    /// Where its values come from.
    pub(super) source: Source,
}

impl KnownField {
    /// Returns the name with the group.
    pub fn full_name(&self) -> String {
        match &self.source {
            Source::Measured(_) => self.name.clone(),
            Source::Component { .. } if self.name.is_empty() => self.group.clone(),
            Source::Component { .. } => format!("{}: {}", self.group, self.name),
        }
    }
}

/// Where the values of a field come from.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Source {
    /// From records.
    Measured(Measured),
    /// From a component of the robot or the ball.
    Component { type_id: TypeId, steps: Vec<Step>, factor: f32 },
}

/// A step of the path from a component to a number.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Step {
    Name(&'static str),
    Index(usize),
    /// A field of a variant, while the value is that variant.
    Variant(&'static str, usize),
    /// The number of elements.
    Count,
}

/// Returns the fields of a component, in order; none if it has no numbers or is not registered for reflection.
pub fn fields_of_component(registry: &TypeRegistry, type_id: TypeId, of_ball: bool) -> Vec<KnownField> {
    let Some(registration) = registry.get(type_id).filter(|known| known.data::<ReflectComponent>().is_some()) else {
        return Vec::new();
    };
    let info = registration.type_info();
    let table = info.type_path_table();
    let mut leaves = Leaves::default();
    leaves.look(info, &mut Vec::new(), &mut Vec::new(), 0);
    let group = wording::component(table.short_path());
    let of_leaf = |(steps, names, what): (Vec<Step>, Vec<String>, Leaf)| {
        let (unit, factor) = match what {
            Leaf::Number => wording::unit(table.short_path(), &names),
            Leaf::Truth => (Unit::YesNo, 1.0),
            Leaf::OneOf(variants) => (Unit::OneOf(variants), 1.0),
            Leaf::Count => (Unit::Plain, 1.0),
        };
        let owner = if of_ball { "ball:" } else { "" };
        KnownField {
            field: Field(format!("{owner}{}/{}", table.path(), names.join("."))),
            of_ball,
            group: if of_ball { format!("ball, {group}") } else { group.clone() },
            name: wording::path(&names),
            unit,
            source: Source::Component { type_id, steps, factor },
        }
    };
    leaves.0.into_iter().map(of_leaf).collect()
}

/// Returns whether a component can be plotted: marked by [`Knowledge`], or defined by the
/// user's program.
pub fn is_plottable(registry: &TypeRegistry, type_id: TypeId) -> bool {
    let Some(info) = registry.get_type_info(type_id) else { return false };
    let path = info.type_path();
    // These are measured already, repeat another component, or are removed before the end of a cycle.
    let beside = ["HeadAngles", "SonarReading", "PreviousPose", "RobotId", "WalkCommand", "KickCommand"];
    if is_of_naoisis(path) && beside.contains(&info.type_path_table().short_path()) {
        return false;
    }
    Knowledge::of_type_info(info).is_some()
        || !(is_of_naoisis(path) || ["bevy_", "core::", "alloc::"].iter().any(|own| path.starts_with(own)))
}

/// The type of a number.
enum Leaf {
    Number,
    Truth,
    OneOf(Vec<String>),
    Count,
}

/// The numbers in a value, each with its path and the names along it.
#[derive(Default)]
struct Leaves(Vec<(Vec<Step>, Vec<String>, Leaf)>);

impl Leaves {
    fn look(&mut self, info: &'static TypeInfo, steps: &mut Vec<Step>, names: &mut Vec<String>, depth: usize) {
        if depth > DEEPEST {
            return;
        }
        let deeper = depth + 1;
        match info {
            TypeInfo::Struct(fields) => {
                for field in fields.iter() {
                    self.go(field.type_info(), (Step::Name(field.name()), Some(field.name())), steps, names, deeper);
                }
            }
            TypeInfo::TupleStruct(fields) => {
                let is_only = fields.field_len() == 1;
                for field in fields.iter() {
                    let name = (!is_only).then(|| (field.index() + 1).to_string());
                    self.go(field.type_info(), (Step::Index(field.index()), name.as_deref()), steps, names, deeper);
                }
            }
            TypeInfo::Tuple(fields) => {
                for field in fields.iter() {
                    let name = (field.index() + 1).to_string();
                    self.go(field.type_info(), (Step::Index(field.index()), Some(&name)), steps, names, deeper);
                }
            }
            TypeInfo::Array(array) if array.capacity() <= LONGEST_ARRAY => {
                for index in 0..array.capacity() {
                    let name = (index + 1).to_string();
                    self.go(array.item_info(), (Step::Index(index), Some(&name)), steps, names, deeper);
                }
            }
            TypeInfo::Enum(variants) => {
                let is_option = info.type_path_table().module_path() == Some("core::option");
                if !is_option {
                    let words = variants.variant_names().iter().map(|name| wording::variant(name)).collect();
                    self.0.push((steps.clone(), names.clone(), Leaf::OneOf(words)));
                }
                for variant in variants.iter() {
                    self.look_into_variant(variant, is_option, steps, names, deeper);
                }
            }
            TypeInfo::List(_) | TypeInfo::Set(_) | TypeInfo::Map(_) | TypeInfo::Array(_) => {
                let steps = steps.iter().cloned().chain([Step::Count]).collect();
                let names = names.iter().cloned().chain(["count".to_owned()]).collect();
                self.0.push((steps, names, Leaf::Count));
            }
            TypeInfo::Opaque(opaque) => {
                let leaf = if opaque.is::<bool>() {
                    Leaf::Truth
                } else if is_number(opaque.type_id()) {
                    Leaf::Number
                } else {
                    return;
                };
                self.0.push((steps.clone(), names.clone(), leaf));
            }
        }
    }

    fn look_into_variant(
        &mut self,
        variant: &VariantInfo,
        is_option: bool,
        steps: &mut Vec<Step>,
        names: &mut Vec<String>,
        depth: usize,
    ) {
        let fields: Vec<(usize, String, Option<&'static TypeInfo>)> = match variant {
            VariantInfo::Struct(fields) => {
                let fields = fields.iter().enumerate();
                fields.map(|(index, field)| (index, field.name().to_owned(), field.type_info())).collect()
            }
            VariantInfo::Tuple(fields) => {
                let is_only = fields.field_len() == 1;
                let name = |index: usize| if is_only { String::new() } else { (index + 1).to_string() };
                fields.iter().map(|field| (field.index(), name(field.index()), field.type_info())).collect()
            }
            VariantInfo::Unit(_) => Vec::new(),
        };
        for (index, name, info) in fields {
            let name = match (is_option, name.as_str()) {
                (true, _) => None,
                (false, "") => Some(variant.name().to_snake_case()),
                (false, name) => Some(format!("{}.{name}", AsSnakeCase(variant.name()))),
            };
            self.go(info, (Step::Variant(variant.name(), index), name.as_deref()), steps, names, depth);
        }
    }

    fn go(
        &mut self,
        info: Option<&'static TypeInfo>,
        (step, name): (Step, Option<&str>),
        steps: &mut Vec<Step>,
        names: &mut Vec<String>,
        depth: usize,
    ) {
        let Some(info) = info else { return };
        steps.push(step);
        names.extend(name.map(str::to_owned));
        self.look(info, steps, names, depth);
        steps.pop();
        if name.is_some() {
            names.pop();
        }
    }
}

macro_rules! for_numbers {
    ($name:ident) => {
        $name!(f32, f64, u8, u16, u32, u64, usize, i8, i16, i32, i64, isize)
    };
}

fn is_number(type_id: TypeId) -> bool {
    macro_rules! any_of {
        ($($number:ty),*) => { [$(TypeId::of::<$number>()),*].contains(&type_id) };
    }
    for_numbers!(any_of)
}

/// The number at the end of a path, if there is one now.
pub(super) fn read(value: &dyn PartialReflect, steps: &[Step]) -> Option<f32> {
    let Some((step, rest)) = steps.split_first() else { return number(value) };
    match (step, value.reflect_ref()) {
        (Step::Name(name), ReflectRef::Struct(fields)) => read(fields.field(name)?, rest),
        (Step::Index(index), ReflectRef::TupleStruct(fields)) => read(fields.field(*index)?, rest),
        (Step::Index(index), ReflectRef::Tuple(fields)) => read(fields.field(*index)?, rest),
        (Step::Index(index), ReflectRef::Array(array)) => read(array.get(*index)?, rest),
        (Step::Variant(name, index), ReflectRef::Enum(value)) if value.variant_name() == *name => {
            read(value.field_at(*index)?, rest)
        }
        (Step::Count, ReflectRef::List(list)) => Some(list.len() as f32),
        (Step::Count, ReflectRef::Array(array)) => Some(array.len() as f32),
        (Step::Count, ReflectRef::Set(set)) => Some(set.len() as f32),
        (Step::Count, ReflectRef::Map(map)) => Some(map.len() as f32),
        _ => None,
    }
}

fn number(value: &dyn PartialReflect) -> Option<f32> {
    if let Some(truth) = value.try_downcast_ref::<bool>() {
        return Some(f32::from(u8::from(*truth)));
    }
    if let ReflectRef::Enum(value) = value.reflect_ref() {
        return Some(value.variant_index() as f32);
    }
    macro_rules! first_of {
        ($($number:ty),*) => { None$(.or_else(|| value.try_downcast_ref::<$number>().map(|value| *value as f32)))* };
    }
    for_numbers!(first_of)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Reflect, Clone, Copy)]
    enum Plan {
        Wait,
        GoTo { place_m: Vec2 },
        Kick(f32),
        Turn(f32, u8),
    }

    #[derive(Component, Reflect)]
    #[reflect(Component, @Knowledge::Belief)]
    struct GameMind {
        is_brave: bool,
        seen_s: Option<f64>,
        plan: Plan,
        tries: [u8; 2],
        others: Vec<Vec2>,
        said: String,
    }

    fn known() -> Vec<KnownField> {
        let mut registry = TypeRegistry::new();
        registry.register::<GameMind>();
        assert!(is_plottable(&registry, TypeId::of::<GameMind>()));
        fields_of_component(&registry, TypeId::of::<GameMind>(), false)
    }

    #[test]
    fn every_number_in_a_component_is_found_and_worded() {
        let names: Vec<String> = known().iter().map(KnownField::full_name).collect();
        assert_eq!(
            names,
            [
                "game mind: is brave",
                "game mind: seen",
                "game mind: plan",
                "game mind: plan, go to, place x",
                "game mind: plan, go to, place y",
                "game mind: plan, kick",
                "game mind: plan, turn 1",
                "game mind: plan, turn 2",
                "game mind: tries 1",
                "game mind: tries 2",
                "game mind: others, count",
            ]
        );
        let units: Vec<&str> = known().iter().map(|field| field.unit.symbol()).collect();
        assert_eq!(units, ["", "s", "", "m", "m", "", "", "", "", "", ""]);
    }

    #[test]
    fn values_are_read_where_they_are_and_not_where_they_are_not() {
        let mut mind = GameMind {
            is_brave: true,
            seen_s: None,
            plan: Plan::Wait,
            tries: [3, 4],
            others: vec![Vec2::ZERO; 5],
            said: String::new(),
        };
        let values = |mind: &GameMind| -> Vec<Option<f32>> {
            let read = |field: KnownField| match field.source {
                Source::Component { steps, .. } => read(mind.as_partial_reflect(), &steps),
                Source::Measured(_) => None,
            };
            known().into_iter().map(read).collect()
        };
        let tail = [Some(3.0), Some(4.0), Some(5.0)];
        assert_eq!(values(&mind), [&[Some(1.0), None, Some(0.0), None, None, None, None, None][..], &tail].concat());
        (mind.seen_s, mind.plan) = (Some(2.5), Plan::GoTo { place_m: Vec2::new(7.0, 8.0) });
        let going = [Some(1.0), Some(2.5), Some(1.0), Some(7.0), Some(8.0), None, None, None];
        assert_eq!(values(&mind), [&going[..], &tail].concat());
        mind.plan = Plan::Kick(0.5);
        assert_eq!(values(&mind)[2..8], [Some(2.0), None, None, Some(0.5), None, None]);
        mind.plan = Plan::Turn(0.25, 3);
        assert_eq!(values(&mind)[2..8], [Some(3.0), None, None, None, Some(0.25), Some(3.0)]);
    }
}
