//! The state of a robot's behaviour, of any types, read by reflection.

use bevy::ecs::component::ComponentInfo;
use bevy::prelude::*;
use bevy::reflect::{PartialReflect, ReflectRef, TypeRegistry};
use core::any::TypeId;
use std::collections::BTreeMap;

use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::behaviour::script::Script;
use naoisis_core::knowledge::{Knowledge, is_of_naoisis};
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{Belief, SimpleBelief};

/// The greatest length of a value, characters. Longer ones are cut.
const LONGEST_VALUE: usize = 120;

/// The name and state of a robot's behaviour.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct BehaviourState {
    /// The name; `None` if the robot has no behaviour.
    pub name: Option<String>,
    /// The components of the behaviour on the robot.
    pub components: Vec<StateComponent>,
    /// The options that the behaviour considered in its last decision, if it records them.
    pub reasons: Option<Reasons>,
}

/// A component with state of a behaviour.
#[derive(Clone, PartialEq, Debug)]
pub struct StateComponent {
    /// The short name of its type.
    pub name: String,
    /// Its type, if it is registered.
    pub type_id: Option<TypeId>,
    /// Its fields with their values. For a component without `Reflect`, an explanation.
    pub fields: Vec<(String, String)>,
}

/// Returns the behaviour states of all robots in `world`.
pub fn all_states(world: &World) -> BTreeMap<RobotId, BehaviourState> {
    let roster = world.resource::<Roster>();
    roster.iter().map(|(id, robot)| (id, state_of(world, robot))).collect()
}

/// Returns the behaviour state of a robot.
pub fn state_of(world: &World, robot: Entity) -> BehaviourState {
    let Ok(entity) = world.get_entity(robot) else { return BehaviourState::default() };
    let Some(registry) = world.get_resource::<AppTypeRegistry>() else { return BehaviourState::default() };
    let (registry, behaviours) = (registry.read(), world.resource::<BehaviourRegistry>());
    let mut state = BehaviourState { name: entity.contains::<Script>().then(|| "script".to_owned()), ..default() };
    state.reasons = entity.get::<Reasons>().filter(|reasons| !reasons.options.is_empty()).cloned();
    for id in entity.archetype().components() {
        let Some(info) = world.components().get_info(*id) else { continue };
        if let Some(name) = info.type_id().and_then(|id| behaviours.name_of_marker(id)) {
            state.name = Some(name.to_owned());
        }
        if !belongs_to_behaviour(info, &registry) {
            continue;
        }
        let reflected = info.type_id().and_then(|id| registry.get_type_data::<ReflectComponent>(id));
        let fields = match reflected.and_then(|component| component.reflect(entity)) {
            Some(value) => fields_of(value.as_partial_reflect()),
            None if info.layout().size() == 0 => Vec::new(),
            None => vec![(String::new(), "derive and register `Reflect` to show it here".to_owned())],
        };
        state.components.push(StateComponent {
            name: short_name(&info.name().to_string()),
            type_id: info.type_id(),
            fields,
        });
    }
    state.components.sort_by(|one, other| one.name.cmp(&other.name));
    state
}

/// Whether a component is state of a behaviour: marked so, or defined by the user's program.
fn belongs_to_behaviour(info: &ComponentInfo, registry: &TypeRegistry) -> bool {
    let Some(type_id) = info.type_id() else { return false };
    // The belief and the reasons are shown separately, and the settings of the estimator are not part of the behaviour's state.
    if [TypeId::of::<Belief>(), TypeId::of::<SimpleBelief>(), TypeId::of::<Reasons>()].contains(&type_id) {
        return false;
    }
    match Knowledge::of_type(registry, type_id) {
        Some(knowledge) => knowledge == Knowledge::Belief,
        None => {
            let name = info.name().to_string();
            !(is_of_naoisis(&name) || ["bevy_", "core::", "alloc::"].iter().any(|own| name.starts_with(own)))
        }
    }
}

fn fields_of(value: &dyn PartialReflect) -> Vec<(String, String)> {
    match value.reflect_ref() {
        ReflectRef::Struct(fields) => {
            let named = fields.iter_fields().enumerate();
            let named = named.map(|(index, (_, field))| (fields.name_at(index).unwrap_or_default(), field));
            named.flat_map(|(name, field)| field_of(name, field)).collect()
        }
        ReflectRef::TupleStruct(fields) => fields.iter_fields().map(|field| (String::new(), words(field))).collect(),
        _ => vec![(String::new(), words(value))],
    }
}

/// The lines of a field: one, or one for each entry of a map.
fn field_of(name: &str, field: &dyn PartialReflect) -> Vec<(String, String)> {
    let ReflectRef::Map(map) = field.reflect_ref() else { return vec![(name.to_owned(), words(field))] };
    let mut lines: Vec<_> =
        map.iter().map(|(key, value)| (format!("{name}: {}", words(key).trim_matches('"')), words(value))).collect();
    lines.sort();
    lines
}

/// A value on one line.
fn words(value: &dyn PartialReflect) -> String {
    let mut text = format!("{value:?}");
    if let Some(some) = text.strip_prefix("Some(").and_then(|rest| rest.strip_suffix(')')) {
        text = some.to_owned();
    }
    if text.chars().count() > LONGEST_VALUE {
        text = text.chars().take(LONGEST_VALUE - 1).chain(['…']).collect();
    }
    text
}

/// The name of a type without its modules.
fn short_name(path: &str) -> String {
    path.rsplit("::").next().unwrap_or(path).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::behaviour::BehaviourApp;
    use naoisis_sim::prelude::{HeadCommand, Scenario, Team};
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[derive(Component, Default, Reflect)]
    #[reflect(Component, @Knowledge::Belief)]
    #[require(Dreams)]
    struct Dreamer;

    #[derive(Component, Default, Reflect)]
    #[reflect(Component, @Knowledge::Belief)]
    struct Dreams {
        count: u32,
        of: Option<Vec2>,
        places: BTreeMap<String, f32>,
    }

    fn dream(mut robots: Query<(&mut Dreams, &mut HeadCommand), With<Dreamer>>) {
        for (mut dreams, mut head) in &mut robots {
            dreams.count += 1;
            dreams.of = Some(Vec2::X);
            dreams.places = [("home".to_owned(), 0.5), ("away".to_owned(), 2.0)].into();
            head.yaw += 0.01;
        }
    }

    #[test]
    fn the_components_of_a_behaviour_are_read_field_by_field() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins)).register_type::<Dreamer>().register_type::<Dreams>();
        app.add_behaviour::<Dreamer, _>("dreamer", dream);
        let scenario = r#"{ "rules": "free", "robots": [{ "number": 1, "behaviour": "dreamer" }] }"#;
        app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap().run_cycles(3);
        let states = all_states(app.world());
        let state = &states[&RobotId::new(Team::Blue, 1)];
        assert_eq!(state.name.as_deref(), Some("dreamer"));
        let names: Vec<&str> = state.components.iter().map(|component| component.name.as_str()).collect();
        assert_eq!(names, ["Dreamer", "Dreams"]);
        let fields = &state.components[1].fields;
        assert_eq!(fields[0], ("count".to_owned(), "3".to_owned()));
        assert_eq!(
            fields[2..],
            [("places: away", "2.0"), ("places: home", "0.5")].map(|(a, b)| (a.to_owned(), b.to_owned()))
        );
    }

    #[test]
    fn built_in_behaviours_show_their_memory() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap().run_cycles(3);
        let robot = app.world().resource::<Roster>().get(RobotId::new(Team::Blue, 2)).unwrap();
        let state = state_of(app.world(), robot);
        assert_eq!(state.name.as_deref(), Some("striker"));
        let memory = state.components.iter().find(|component| component.name == "PlayerMemory").unwrap();
        assert!(memory.fields.iter().any(|(name, _)| name == "attacks"));
        assert!(state.components.iter().all(|component| component.name != "Pose"), "no truth");
    }

    #[test]
    fn long_values_are_cut_and_options_unwrapped() {
        assert_eq!(words(&Some(3_u32)), "3");
        assert_eq!(words(&"x".repeat(500)).chars().count(), LONGEST_VALUE);
        assert_eq!(short_name("my_team::brain::Mind"), "Mind");
    }
}
