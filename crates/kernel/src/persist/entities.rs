//! Entities in saved state: each saved entity has a number, and a component is a column of values over these numbers.

use std::ops::Range;

use bevy_ecs::archetype::{Archetype, ArchetypeEntity};
use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use crate::persist::{Persistent, Problem, encode};

/// The numbers of the saved entities: all that have a registered component.
pub struct EntityNumbers {
    /// The entities by their numbers.
    entities: Vec<Entity>,
    /// The numbers by the indices of the entities.
    numbers: Vec<u32>,
}

impl EntityNumbers {
    /// Numbers the entities that have any of these components, in the order of their tables.
    pub(super) fn of(world: &World, components: &[ComponentId]) -> Self {
        let archetypes =
            world.archetypes().iter().filter(|archetype| components.iter().any(|&id| archetype.contains(id)));
        let entities: Vec<_> = archetypes.flat_map(Archetype::entities).map(ArchetypeEntity::id).collect();
        let end = entities.iter().map(|entity| entity.index_u32() as usize + 1).max().unwrap_or(0);
        let mut numbers = vec![u32::MAX; end];
        for (entity, number) in entities.iter().zip(0..) {
            numbers[entity.index_u32() as usize] = number;
        }
        Self { entities, numbers }
    }

    /// Returns the entities in the order of their numbers.
    pub(super) fn entities(&self) -> impl Iterator<Item = Entity> {
        self.entities.iter().copied()
    }

    /// Returns the number of entities.
    pub(super) fn len(&self) -> u32 {
        u32::try_from(self.entities.len()).unwrap_or(u32::MAX)
    }

    /// Returns the number of an entity; `None` if it is not saved.
    #[must_use]
    pub fn get(&self, entity: Entity) -> Option<u32> {
        let number = *self.numbers.get(entity.index_u32() as usize)?;
        (self.entities.get(number as usize) == Some(&entity)).then_some(number)
    }
}

/// The entities that stand for the saved ones, by their numbers.
pub struct SavedEntities(Vec<Entity>);

impl SavedEntities {
    /// Spawns the entities, at most `most`.
    pub(super) fn spawn(world: &mut World, count: u32, most: usize) -> Result<Self, Problem> {
        if count as usize > most {
            return Err(format!("it has {count} entities, more than it can hold"));
        }
        Ok(Self(world.spawn_batch((0..count).map(|_| ())).collect()))
    }

    /// Returns the entities with these numbers; `None` if one does not exist.
    fn in_range(&self, numbers: Range<u32>) -> Option<&[Entity]> {
        self.0.get(numbers.start as usize..numbers.end as usize)
    }

    /// Returns the entity with a number.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<Entity> {
        self.0.get(number as usize).copied()
    }
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
    let bytes = encode(&runs)?;
    rows.into_iter()
        .try_fold(bytes, |bytes, (_, value)| postcard::to_extend(value, bytes))
        .map_err(|error| error.to_string())
}

/// Restores the column of a component: the first number and the length of each run of successive entities, then a value for
/// each of these entities.
pub(super) fn restore_column<C: Component + Persistent>(
    world: &mut World,
    bytes: &[u8],
    entities: &SavedEntities,
) -> Result<(), Problem> {
    let (runs, mut rest) = postcard::take_from_bytes::<Vec<[u32; 2]>>(bytes).map_err(|error| error.to_string())?;
    let (mut column, mut end) = (Vec::new(), 0);
    for [first, length] in runs {
        let numbers = first..first.checked_add(length).filter(|_| first >= end).ok_or(NO_ENTITY)?;
        end = numbers.end;
        for entity in entities.in_range(numbers).ok_or(NO_ENTITY)? {
            let (value, more) = postcard::take_from_bytes::<C>(rest).map_err(|error| error.to_string())?;
            rest = more;
            column.push((*entity, value));
        }
    }
    if !rest.is_empty() {
        return Err("there are more bytes than the column has".to_owned());
    }
    world.insert_batch(column);
    Ok(())
}

const NO_ENTITY: &str = "its entities do not exist";
