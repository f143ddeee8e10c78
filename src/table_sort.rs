//! The order of rows in the ECS tables: that of slots, so that passes over components and columns go along both.
//!
//! The ECS keeps rows in the order in which entities came. Many grains of the start enter in the order of the slots that
//! they will get. When slots are dealt out anew and more than a tenth of the rows would be read out of order, and every
//! [`SORT_CHECK_INTERVAL`] steps if any would, the tables are sorted in place: a grain that leaves its table ([`OutOfTable`] is added to it) leaves its row to the last one, and when it
//! comes back (it is taken away again) it becomes the last one itself. So any row is exchanged with the last, and a cycle of
//! k rows takes k + 1 exchanges. No second table is filled, whose memory the ECS would keep. Nothing that is computed hangs
//! on the order of rows.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::particle::{Fixed, GrainBundle, Slot};
use crate::space::Space;
use crate::step::{Clock, Part, Step};
use crate::store::{DENSE, Plan, SORT_CHECK_INTERVAL, SpatialOrder, has_renumbered, sort_check_is_due};

/// On a grain that is out of its table.
#[derive(Component, Clone, Copy, Debug)]
struct OutOfTable;

/// Below this number it is not worth the trouble.
const WORTHWHILE: usize = 512;

fn sort_rows(world: &mut World, rows: &mut QueryState<(Entity, &Slot), Without<Fixed>>) {
    let (mut all, mut out_of_table) = (0, 0);
    for (_, slots) in rows.contiguous_iter(world).expect(DENSE) {
        all += slots.len();
        out_of_table += slots.windows(2).filter(|pair| pair[1].index() < pair[0].index()).count();
    }
    let tolerated = if world.resource::<Clock>().steps.is_multiple_of(SORT_CHECK_INTERVAL) { 0 } else { all / 10 };
    if all < WORTHWHILE || out_of_table <= tolerated {
        return;
    }
    let tables = rows.contiguous_iter(world).expect(DENSE);
    let tables: Vec<_> = tables.map(|(grains, slots)| (grains.to_vec(), ranks(slots))).collect();
    for (grains, ranks) in tables {
        arrange(world, grains, ranks);
    }
}

/// The row that each one belongs to.
fn ranks(slots: &[Slot]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).zip(slots).map(|(row, _)| row).collect();
    order.sort_unstable_by_key(|&row| slots[row as usize].index());
    let mut ranks = vec![0; order.len()];
    for (rank, row) in (0..).zip(order) {
        ranks[row as usize] = rank;
    }
    ranks
}

/// Brings the entities of a table, row by row, to the rows `ranks`.
fn arrange(world: &mut World, mut grains: Vec<Entity>, mut ranks: Vec<u32>) {
    let Some(last) = grains.len().checked_sub(1) else { return };
    let mut exchange = |row: usize, ranks: &mut [u32]| {
        world.entity_mut(grains[row]).insert(OutOfTable).remove::<OutOfTable>();
        grains.swap(row, last);
        ranks.swap(row, last);
    };
    for row in 0..last {
        // Whoever is last goes where it belongs, until one comes back that belongs there.
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

/// Brings grains that will be spawned into order: many into that of the slots that they will get; few stay as they come.
pub(crate) fn sort_newcomers<V: Space, T>(newcomers: &mut [(GrainBundle<V>, T)]) {
    if newcomers.len() < WORTHWHILE {
        return;
    }
    let grains = || newcomers.iter().map(|(grain, _)| &grain.particle);
    let largest = grains().map(|grain| grain.radius.0).fold(0.0, f64::max);
    let order = SpatialOrder::of(grains().map(|grain| grain.position.0), 2.0 * largest);
    newcomers.sort_by_cached_key(|(grain, _)| (order.place(grain.particle.position.0), grain.particle.id));
}

/// Whether components of grains are copied in many steps.
fn are_mirrored(plan: Option<Res<Plan>>) -> bool {
    plan.is_some_and(|plan| plan.mirrors_grains())
}

/// Keeps rows in the order of slots.
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
            // Multiples of a number without common divisor: all of them, in cycles of several lengths.
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
