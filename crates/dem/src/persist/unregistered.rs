//! Finds state that systems change and that no checkpoint would save.

use std::collections::BTreeMap;

use bevy_ecs::archetype::Archetype;
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedScheduleLabel, Schedules};

use crate::persist::Registered;

/// State that no checkpoint would save.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Unregistered {
    /// The name of a system that writes it; `None` if it is only known from an entity.
    pub writer: Option<String>,
    /// Whether it is a resource, and not a component of entities.
    pub is_resource: bool,
}

/// Returns the resources and components that systems write or entities have, and that are neither saved nor derived, by the names of their types.
///
/// Types of bevy do not count: messages and the ECS's own records.
pub fn unregistered(world: &mut World) -> BTreeMap<String, Unregistered> {
    world.init_resource::<Registered>();
    let mut found = on_entities(world);
    let labels: Vec<_> = world.resource::<Schedules>().iter().map(|(_, schedule)| schedule.label()).collect();
    for label in labels {
        written(world, label, &mut found);
    }
    found
}

/// Returns the name of a component, unless it is registered or bevy's own.
fn unknown_name(world: &World, id: ComponentId) -> Option<String> {
    let name = world.components().get_name(id)?.to_string();
    let is_known = name.starts_with("bevy_") || world.resource::<Registered>().knows(id);
    (!is_known).then_some(name)
}

/// Adds what the systems of a schedule write. Exclusive systems declare no access.
fn written(world: &mut World, label: InternedScheduleLabel, found: &mut BTreeMap<String, Unregistered>) {
    // A schedule that cannot be built fails when it runs.
    let _ = world.try_schedule_scope(label, |world, schedule| schedule.initialize(world).map(|_| ()));
    let Some(schedule) = world.resource::<Schedules>().get(label) else { return };
    let Ok(systems) = schedule.systems_with_access() else { return };
    for (_, system) in systems.filter(|(_, system)| system.access().is_shared()) {
        let access = system.access().to_filtered_access_set();
        let Some(writes) = access.combined_access().writes().as_finite_set() else { continue };
        for (id, name) in writes.iter().filter_map(|id| Some((id, unknown_name(world, id)?))) {
            let state = found.entry(name).or_default();
            state.is_resource = world.contains_resource_by_id(id);
            state.writer.get_or_insert_with(|| system.system().name().to_string());
        }
    }
}

/// Returns the components of all entities that are neither resources nor bevy's own.
fn on_entities(world: &World) -> BTreeMap<String, Unregistered> {
    let is_resource = |id: &ComponentId| {
        world.components().get_name(*id).is_some_and(|name| name.to_string().ends_with("::IsResource"))
    };
    let archetypes = world.archetypes().iter().filter(|archetype| !archetype.is_empty());
    let of_entities = archetypes.filter(|archetype| !archetype.components().iter().any(is_resource));
    let components = of_entities.flat_map(Archetype::components);
    components.filter_map(|&id| Some((unknown_name(world, id)?, Unregistered::default()))).collect()
}
