//! The order of rows in the ECS tables: that of slots, so that passes over components and columns go along both.
//!
//! The ECS keeps rows in the order in which entities came. When slots are dealt out anew and more than a tenth of the rows
//! would be read out of order, every grain is moved to another archetype and so to the end of its table, slot by slot: a
//! marker without data, [`Sorted`], is added to all, or taken away again. Nothing that is computed hangs on the order of
//! rows.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{DENSE, Order, Renumbering, Slot};
use crate::grains::file::GrainRow;
use crate::particle::Fixed;
use crate::space::Space;
use crate::step::{Phase, Step};

/// On the grains of every second sorting.
#[derive(Component, Clone, Copy, Debug)]
struct Sorted;

/// Below this number all of them are in the caches.
const WORTHWHILE: usize = 4096;

fn sort_rows(
    world: &mut World,
    rows: &mut QueryState<&Slot, Without<Fixed>>,
    grains: &mut QueryState<(Entity, &Slot, Has<Sorted>), Without<Fixed>>,
) {
    let (mut all, mut astray) = (0, 0);
    for slots in rows.contiguous_iter(world).expect(DENSE) {
        all += slots.len();
        astray += slots.windows(2).filter(|pair| pair[1].index() < pair[0].index()).count();
    }
    if all < WORTHWHILE || 10 * astray < all {
        return;
    }
    let mut grains: Vec<_> = grains.iter(world).map(|(entity, slot, marked)| (slot.index(), entity, marked)).collect();
    let are_marked = 2 * grains.iter().filter(|grain| grain.2).count() > all;
    grains.sort_unstable_by_key(|grain| grain.0);
    if are_marked {
        for (_, entity, _) in grains {
            world.entity_mut(entity).remove::<Sorted>();
        }
    } else {
        world.insert_batch(grains.into_iter().map(|(_, entity, _)| (entity, Sorted)));
    }
}

/// In which order grains are spawned: of many, that of the slots that they will get, so that they need not be moved
/// at once to a second table, while the first keeps its memory; of few, as they come. `place` gives positions, m.
pub(crate) fn first_order<V: Space>(grains: &[GrainRow], place: impl Fn(&GrainRow) -> V) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).zip(grains).map(|(row, _)| row).collect();
    if grains.len() >= WORTHWHILE {
        let largest = grains.iter().map(|grain| grain.radius).fold(0.0, f64::max);
        let places = Order::of(grains.iter().map(&place), 2.0 * largest);
        order.sort_by_cached_key(|&row| {
            let grain = &grains[row as usize];
            (places.place(place(grain)), grain.id)
        });
    }
    order
}

/// Keeps rows in the order of slots.
pub struct RowsPlugin;

impl Plugin for RowsPlugin {
    fn build(&self, app: &mut App) {
        let due = crate::columns::has_renumbered;
        app.add_systems(Step, sort_rows.in_set(Phase::Spawn).after(Renumbering).run_if(due));
    }
}
