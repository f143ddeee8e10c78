//! Entities in saved state: each saved entity has a number, and a component is a column of values over these numbers.

use bevy_ecs::archetype::{Archetype, ArchetypeEntity};
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::persist::{Persistent, Problem, decode, encode};

/// The numbers of the saved entities: all that have a registered component.
pub struct EntityNumbers(FxHashMap<Entity, u32>);

impl EntityNumbers {
    /// Numbers the entities that have any of these components, in the order of their tables.
    pub(super) fn of(world: &World, components: &[ComponentId]) -> Self {
        let archetypes =
            world.archetypes().iter().filter(|archetype| components.iter().any(|&id| archetype.contains(id)));
        let entities = archetypes.flat_map(Archetype::entities).map(ArchetypeEntity::id);
        Self(entities.zip(0..).collect())
    }

    /// Returns the entities, in any order.
    pub(super) fn entities(&self) -> impl Iterator<Item = Entity> {
        self.0.keys().copied()
    }

    /// Returns the number of entities.
    pub(super) fn len(&self) -> u32 {
        u32::try_from(self.0.len()).unwrap_or(u32::MAX)
    }

    /// Returns the number of an entity; `None` if it is not saved.
    #[must_use]
    pub fn get(&self, entity: Entity) -> Option<u32> {
        self.0.get(&entity).copied()
    }
}

/// Largest number of entities that a checkpoint may ask for: ids of grains have 31 bits.
const MOST_ENTITIES: u32 = 1 << 31;

/// The entities that stand for the saved ones, by their numbers.
pub struct SavedEntities(Vec<Entity>);

impl SavedEntities {
    pub(super) fn spawn(world: &mut World, count: u32) -> Result<Self, Problem> {
        if count > MOST_ENTITIES {
            return Err(format!("it has {count} entities, more than can be"));
        }
        Ok(Self(world.spawn_batch((0..count).map(|_| ())).collect()))
    }

    /// Returns the entity with a number.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<Entity> {
        self.0.get(number as usize).copied()
    }
}

/// The values of a component.
#[derive(Serialize, Deserialize)]
struct Column<C> {
    /// First number and length of each run of successive entities.
    runs: Vec<[u32; 2]>,
    values: Vec<C>,
}

#[derive(Serialize)]
struct ColumnOf<'a, C> {
    runs: Vec<[u32; 2]>,
    values: Vec<&'a C>,
}

pub(super) fn save_column<C: Component + Persistent>(
    world: &mut World,
    numbers: &EntityNumbers,
) -> Result<Vec<u8>, Problem> {
    let mut query = world.query::<(Entity, &C)>();
    let mut rows: Vec<_> =
        query.iter(world).filter_map(|(entity, value)| Some((numbers.get(entity)?, value))).collect();
    rows.sort_unstable_by_key(|&(number, _)| number);
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for &(number, _) in &rows {
        match runs.last_mut() {
            Some([first, length]) if *first + *length == number => *length += 1,
            _ => runs.push([number, 1]),
        }
    }
    encode(&ColumnOf { runs, values: rows.into_iter().map(|(_, value)| value).collect() })
}

pub(super) fn restore_column<C: Component + Persistent>(
    world: &mut World,
    bytes: &[u8],
    entities: &SavedEntities,
) -> Result<(), Problem> {
    let Column::<C> { runs, values } = decode(bytes)?;
    let numbers = runs.into_iter().flat_map(|[first, length]| (0..length).map(move |more| first.saturating_add(more)));
    let found: Option<Vec<Entity>> = numbers.take(values.len()).map(|number| entities.get(number)).collect();
    let found = found.filter(|found| found.len() == values.len()).ok_or("its entities do not exist")?;
    world.insert_batch(found.into_iter().zip(values));
    Ok(())
}
