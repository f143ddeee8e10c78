//! The order of rows in the ECS tables: that of slots, so that passes over components and columns go along both.
//!
//! The ECS keeps rows in the order in which entities came. When slots are dealt out anew and more than a tenth of the rows
//! would be read out of order, and every [`TIDY_EVERY`] steps if any would, every grain is moved to another archetype and so to the end of its table, slot by slot: a
//! marker without data, [`Sorted`], is added to all, or taken away again. Nothing that is computed hangs on the order of
//! rows.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{DENSE, Renumbering, Slot, TIDY_EVERY, has_renumbered, is_time_to_tidy};
use crate::particle::Fixed;
use crate::step::{Clock, Phase, Step};

/// On the grains of every second sorting.
#[derive(Component, Clone, Copy, Debug)]
struct Sorted;

/// Below this number it is not worth the trouble.
const WORTHWHILE: usize = 512;

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
    let tolerated = if world.resource::<Clock>().steps.is_multiple_of(TIDY_EVERY) { 0 } else { all / 10 };
    if all < WORTHWHILE || astray <= tolerated {
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

/// Keeps rows in the order of slots.
pub struct RowsPlugin;

impl Plugin for RowsPlugin {
    fn build(&self, app: &mut App) {
        let due = has_renumbered.or_eager(is_time_to_tidy);
        app.add_systems(Step, sort_rows.in_set(Phase::Spawn).after(Renumbering).run_if(due));
    }
}
