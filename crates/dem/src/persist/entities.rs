//! Entities in saved state: each saved entity has a number, and a component is a column of values over these numbers.

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

    /// Returns the entities of a column, and the bytes of its values.
    fn in_runs<'a>(&self, column: &'a [u8]) -> Result<(Vec<Entity>, &'a [u8]), Problem> {
        let (runs, values) = postcard::take_from_bytes::<Vec<[u32; 2]>>(column).map_err(|error| error.to_string())?;
        let mut entities = Vec::new();
        let mut end = 0;
        for [first, length] in runs {
            let next = first.checked_add(length).filter(|_| first >= end).ok_or(NO_ENTITY)?;
            entities.extend(self.0.get(first as usize..next as usize).ok_or(NO_ENTITY)?);
            end = next;
        }
        Ok((entities, values))
    }

    /// Returns the entity with a number.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<Entity> {
        self.0.get(number as usize).copied()
    }
}

/// Returns the column of a component: the first number and the length of each run of successive entities, then a value for each of
/// these entities.
pub(super) fn save_column<C: Component + Persistent>(
    world: &mut World,
    numbers: &EntityNumbers,
) -> Result<Vec<u8>, Problem> {
    let mut query = world.query::<(Entity, &C)>();
    let (numbers, values): (Vec<u32>, Vec<&C>) =
        query.iter(world).filter_map(|(entity, value)| Some((numbers.get(entity)?, value))).unzip();
    let (order, runs) = in_runs(&numbers);
    let bytes = encode(&runs)?;
    order
        .into_iter()
        .try_fold(bytes, |bytes, place| postcard::to_extend(values[place], bytes))
        .map_err(|error| error.to_string())
}

/// Returns the places of numbers in ascending order of the numbers, and the first number and the length of each run of successive
/// numbers.
fn in_runs(numbers: &[u32]) -> (Vec<usize>, Vec<[u32; 2]>) {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_unstable_by_key(|&place| numbers[place]);
    let mut runs: Vec<[u32; 2]> = Vec::new();
    for number in order.iter().map(|&place| numbers[place]) {
        match runs.last_mut() {
            Some([first, length]) if *first + *length == number => *length += 1,
            _ => runs.push([number, 1]),
        }
    }
    (order, runs)
}

/// Restores the column of a component, as [`save_column`] returns it. `check` refuses values.
pub(super) fn restore_column<C: Component + Persistent>(
    world: &mut World,
    bytes: &[u8],
    entities: &SavedEntities,
    check: fn(&C) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let (entities, mut rest) = entities.in_runs(bytes)?;
    let mut values = Vec::with_capacity(entities.len());
    for _ in &entities {
        let (value, more) = postcard::take_from_bytes::<C>(rest).map_err(|error| error.to_string())?;
        check(&value)?;
        rest = more;
        values.push(value);
    }
    if !rest.is_empty() {
        return Err("there are more bytes than the column has".to_owned());
    }
    world.insert_batch(entities.into_iter().zip(values));
    Ok(())
}

const NO_ENTITY: &str = "its entities do not exist";
