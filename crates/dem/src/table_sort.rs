//! Keeps the rows of ECS tables in the order of slots, so that passes over components and over the store run through
//! memory in the same order.
//!
//! The ECS keeps rows in the order in which entities were spawned. When many grains enter at the start, they are
//! spawned in the order of their future slots. Tables are sorted in place in two cases:
//! * After a renumbering, if more than a tenth of the rows are out of order.
//! * Every [`SORT_CHECK_INTERVAL`] steps, if any row is out of order.
//!
//! A sort exchanges rows through the last row. A grain that gets the component `OutOfTable` leaves its table, and the
//! last row moves into its place. When the component is removed again, the grain becomes the last row. In this way any
//! row can be exchanged with the last one. A cycle of k rows takes k + 1 exchanges. No second table is filled, so the
//! ECS does not keep memory for one. No result of the simulation depends on the order of rows.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::particle::{DENSE, Fixed, GrainBundle, Slot};
use crate::space::Space;
use crate::step::{Clock, Part, Step};
use crate::store::{Plan, SORT_CHECK_INTERVAL, SpatialOrder, has_renumbered, sort_check_is_due};

/// Marks a grain that is temporarily out of its table.
#[derive(Component, Clone, Copy, Debug)]
struct OutOfTable;

/// The smallest number of grains that is sorted; sorting fewer saves too little.
const MIN_SORTED: usize = 512;

fn sort_rows(world: &mut World, rows: &mut QueryState<(Entity, &Slot), Without<Fixed>>) {
    let mut all = 0;
    let mut out_of_order = 0;
    for (_, slots) in rows.contiguous_iter(world).expect(DENSE) {
        all += slots.len();
        out_of_order += slots.windows(2).filter(|pair| pair[1].index() < pair[0].index()).count();
    }
    let tolerated = if world.resource::<Clock>().steps.is_multiple_of(SORT_CHECK_INTERVAL) { 0 } else { all / 10 };
    if all < MIN_SORTED || out_of_order <= tolerated {
        return;
    }
    let tables = rows.contiguous_iter(world).expect(DENSE);
    let tables: Vec<_> = tables.map(|(grains, slots)| (grains.to_vec(), ranks(slots))).collect();
    for (grains, ranks) in tables {
        arrange(world, grains, ranks);
    }
}

/// Returns the target row of each entity.
fn ranks(slots: &[Slot]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).zip(slots).map(|(row, _)| row).collect();
    order.sort_unstable_by_key(|&row| slots[row as usize].index());
    let mut ranks = vec![0; order.len()];
    for (rank, row) in (0..).zip(order) {
        ranks[row as usize] = rank;
    }
    ranks
}

/// Moves the entities of a table, given by row, to the rows `ranks`.
fn arrange(world: &mut World, mut grains: Vec<Entity>, mut ranks: Vec<u32>) {
    let Some(last) = grains.len().checked_sub(1) else { return };
    let mut exchange = |row: usize, ranks: &mut [u32]| {
        world.entity_mut(grains[row]).insert(OutOfTable).remove::<OutOfTable>();
        grains.swap(row, last);
        ranks.swap(row, last);
    };
    for row in 0..last {
        // The last entity goes to its target row, until the entity in the last row belongs there.
        while ranks[last] as usize != last {
            exchange(ranks[last] as usize, &mut ranks);
        }
        if ranks[row] as usize != row {
            exchange(row, &mut ranks);
        }
    }
    while ranks[last] as usize != last {
        exchange(ranks[last] as usize, &mut ranks);
    }
}

/// Sorts grains before they are spawned into the order of their future slots. Few grains are left as they are.
pub fn sort_newcomers<V: Space, T>(newcomers: &mut [(GrainBundle<V>, T)]) {
    if newcomers.len() < MIN_SORTED {
        return;
    }
    let grains = || newcomers.iter().map(|(grain, _)| &grain.particle);
    let largest = grains().map(|grain| grain.radius.0).fold(0.0, f64::max);
    let order = SpatialOrder::of(grains().map(|grain| grain.position.0), 2.0 * largest);
    newcomers.sort_by_cached_key(|(grain, _)| (order.place(grain.particle.position.0), grain.particle.id));
}

/// Whether systems copy components of grains in many steps.
fn are_mirrored(plan: Option<Res<Plan>>) -> bool {
    plan.is_some_and(|plan| plan.mirrors_grains())
}

/// Keeps table rows in the order of slots.
pub struct TableSortPlugin;

impl Plugin for TableSortPlugin {
    fn build(&self, app: &mut App) {
        let due = has_renumbered.or_eager(sort_check_is_due);
        app.add_systems(Step, sort_rows.in_set(Part::Sort).run_if(due).run_if(are_mirrored));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Component)]
    struct Rank(u32);

    #[derive(Component)]
    struct Other;

    #[test]
    fn a_table_is_sorted_in_place() {
        for size in [0u32, 1, 2, 3, 10, 1009] {
            // Multiples of a number without a common divisor give every row once, in cycles of several lengths.
            let ranks: Vec<u32> = (0..size).map(|row| row * 7 % size).collect();
            let mut world = World::new();
            let grains: Vec<_> = ranks.iter().map(|&rank| world.spawn((Rank(rank), Other)).id()).collect();
            world.spawn(Rank(0));
            arrange(&mut world, grains, ranks);
            let mut rows = world.query_filtered::<&Rank, With<Other>>();
            assert!(rows.iter(&world).map(|rank| rank.0).eq(0..size), "{size}");
            assert!(world.query_filtered::<(), With<OutOfTable>>().iter(&world).next().is_none());
        }
    }
}
