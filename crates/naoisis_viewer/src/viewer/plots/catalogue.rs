//! The list of all fields that can be plotted, from the components of robots and the ball.

use bevy::prelude::*;
use core::any::TypeId;
use std::collections::BTreeSet;

use super::field::{self, Field, KnownField, Source};
use super::wording::Unit;
use super::{Plots, measured};
use crate::viewer::behaviour_state::BehaviourState;
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::rebuild::{Rebuilt, ShownState};
use naoisis_core::ball::Ball;
use naoisis_core::robot::Roster;

/// The time between two searches for components, s.
const LOOK_EVERY_S: f32 = 0.5;

/// All fields that can be plotted in this match.
#[derive(Resource, Default, Debug)]
pub struct FieldList {
    fields: Vec<KnownField>,
    /// The components that have been searched: of robots, and of the ball.
    components: [BTreeSet<TypeId>; 2],
}

impl FieldList {
    /// Returns all fields, grouped by component.
    pub fn all(&self) -> &[KnownField] {
        &self.fields
    }

    /// Returns the entry of a field.
    pub fn find(&self, field: &Field) -> Option<&KnownField> {
        self.fields.iter().find(|known| known.field == *field)
    }

    /// Returns the fields of robots in a component, below the field `first_name`.
    pub fn within<'a>(&'a self, component: TypeId, first_name: &'a str) -> impl Iterator<Item = &'a KnownField> {
        self.fields.iter().filter(move |known| {
            let is_there = matches!(known.source, Source::Component { type_id, .. } if type_id == component);
            let path = known.field.0.rsplit_once('/').map_or("", |(_, path)| path);
            let begins = path.strip_prefix(first_name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
            is_there && !known.of_ball && (first_name.is_empty() || begins)
        })
    }
}

/// Searches the components of robots and the ball, because behaviours may add some.
pub(super) fn list_fields(world: &mut World, mut last_s: Local<Option<f32>>) {
    let now_s = world.get_resource::<Time<Real>>().map_or(0.0, Time::elapsed_secs);
    let is_wanted = world.resource::<DisplaySettings>().plots
        || world.resource::<DisplaySettings>().robot
        || !world.resource::<Plots>().pins.is_empty();
    if !is_wanted || last_s.is_some_and(|last_s| now_s - last_s < LOOK_EVERY_S) {
        return;
    }
    *last_s = Some(now_s);
    let Some(registry) = world.get_resource::<AppTypeRegistry>().cloned() else { return };
    let registry = registry.read();
    let mut balls = world.query_filtered::<Entity, With<Ball>>();
    let ball: Vec<Entity> = balls.iter(world).collect();
    let robots: Vec<Entity> =
        world.get_resource::<Roster>().map(|roster| roster.entities().collect()).unwrap_or_default();
    let of = |entities: &[Entity]| -> BTreeSet<TypeId> {
        let entities = entities.iter().filter_map(|entity| world.get_entity(*entity).ok());
        let components = entities.flat_map(|entity| entity.archetype().components().to_vec());
        let types = components.filter_map(|id| world.components().get_info(id)?.type_id());
        types.filter(|id| field::is_plottable(&registry, *id)).collect()
    };
    let mut components = [of(&robots), of(&ball)];
    // In a match that is only shown, the components of behaviours come from rebuilt moments.
    let of_rebuilt = world.get_resource::<Rebuilt>().into_iter().flat_map(Rebuilt::latest_states);
    let shown = world.get_resource::<ShownState>().and_then(|state| state.0.as_ref().ok());
    let in_mind = |state: &BehaviourState| -> Vec<TypeId> {
        state.components.iter().filter_map(|component| component.type_id).collect()
    };
    components[0].extend(of_rebuilt.chain(shown).flat_map(in_mind));
    // Known components stay in the list, because a robot may lose a component.
    let mut list = world.resource::<FieldList>().components.clone();
    for (known, found) in list.iter_mut().zip(&components) {
        known.extend(found);
    }
    if list == world.resource::<FieldList>().components && !world.resource::<FieldList>().fields.is_empty() {
        return;
    }
    let of_components = list.iter().zip([false, true]).flat_map(|(components, of_ball)| {
        let mut groups: Vec<Vec<KnownField>> =
            components.iter().map(|id| field::fields_of_component(&registry, *id, of_ball)).collect();
        groups.retain(|group| !group.is_empty());
        groups.sort_by(|one, other| one[0].group.cmp(&other[0].group));
        groups.into_iter().flatten()
    });
    let fields = measured_fields().chain(of_components).collect();
    *world.resource_mut::<FieldList>() = FieldList { fields, components: list };
}

/// All measured numbers as fields.
pub(super) fn measured_fields() -> impl Iterator<Item = KnownField> {
    measured::ALL.into_iter().map(|measured| KnownField {
        field: Field(measured.key.to_owned()),
        of_ball: measured.is_of_ball(),
        group: "measured".to_owned(),
        name: measured.name.to_owned(),
        unit: Unit::In(measured.unit),
        source: Source::Measured(measured),
    })
}
