//! Neighbour search: which particles may touch.
//!
//! The scene's `neighbours` chooses between three searches with one result, to the last bit:
//!
//! | search | work a step | memory |
//! |---|---|---|
//! | [`AllPairs`](Neighbours::AllPairs) | N^2/2 distances: the reference | N indices |
//! | [`Cells`](Neighbours::Cells) | sorting into hashed cells, then 9 cells a grain | N entries |
//! | [`VerletList`](Neighbours::VerletList) | the listed pairs; now and then a search by cells | the list |

mod all_pairs;
pub mod cells;
mod verlet_list;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use self::all_pairs::AllPairs;
use self::cells::Cells;
use self::verlet_list::VerletList;
use crate::columns::{Columns, Gathered};
use crate::outcome::{Failure, Outcome};
use crate::scene::values::Positive;
use crate::step::{Clock, Phase, Step};
use crate::threads::Threads;

/// The scene's `neighbours`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Neighbours {
    /// Every pair, every step.
    AllPairs,
    /// Hashed square cells, filled anew every step; a grain looks into its own cell and the eight around it.
    Cells {
        /// Side L of a cell, m: at least the largest distance at which two particles touch.
        size: Positive,
    },
    /// A list of the pairs that might touch soon, renewed when a particle has moved too far.
    VerletList {
        /// Skin, m: particles at rest are listed up to this distance of their surfaces.
        skin: Positive,
    },
}

/// The search and its state.
pub enum Method {
    /// Every pair.
    AllPairs(AllPairs),
    /// Cells, filled every step.
    Cells(Cells),
    /// A list, renewed on displacement.
    VerletList(VerletList),
}

/// The neighbour search of a run.
#[derive(Resource)]
pub struct Search {
    /// Which, with its state.
    pub method: Method,
    /// How often cells were filled or the list was renewed.
    pub rebuilds: u64,
    /// Whether partners below the particle are listed too, as several threads need them.
    full: bool,
    generation: u64,
}

impl Search {
    /// The search `kind`; `full` offers each pair from both sides.
    #[must_use]
    pub fn new(kind: Neighbours, full: bool) -> Self {
        let method = match kind {
            Neighbours::AllPairs => Method::AllPairs(AllPairs::new(full)),
            Neighbours::Cells { size } => Method::Cells(Cells::new(size.get(), full)),
            Neighbours::VerletList { skin } => Method::VerletList(VerletList::new(skin.get())),
        };
        Self { method, rebuilds: 0, full, generation: 0 }
    }

    /// Makes the search valid for the positions in `columns`; `dt` is the time step, s.
    ///
    /// # Errors
    /// If particles touch at more than the cell size.
    pub fn update(&mut self, columns: &Columns, dt: f64) -> Result<(), Failure> {
        let renumbered = self.generation != columns.generation;
        self.generation = columns.generation;
        let rebuilt = match &mut self.method {
            Method::AllPairs(all) => {
                all.resize(columns.len());
                false
            }
            Method::Cells(cells) => {
                // Filled first, so that what is left of a step that fails finds valid cells.
                cells.fill(columns.body.iter().map(|body| body.position));
                if renumbered {
                    cells.check_range(columns)?;
                }
                true
            }
            Method::VerletList(list) => {
                let stale = renumbered || list.is_stale(columns);
                if stale {
                    list.renew(columns, self.full, dt);
                }
                stale
            }
        };
        self.rebuilds += u64::from(rebuilt);
        Ok(())
    }
}

/// The largest distance at which two particles of `columns` touch, at least one of them movable, m.
///
/// A grain looks one cell far, so a pair is found for certain only if its centres are at most a cell's side apart:
/// the side must not be smaller than this. For grains alone that is twice the largest radius.
#[must_use]
pub fn contact_range(columns: &Columns) -> f64 {
    let largest = |fixed: bool| {
        let of_kind = (0..columns.len()).filter(|&i| columns.is_fixed(i) == fixed);
        of_kind.map(|i| columns.body[i].radius).fold(0.0, f64::max)
    };
    let movable = largest(false);
    movable + movable.max(largest(true))
}

fn update_search(clock: Res<Clock>, columns: Res<Columns>, mut search: ResMut<Search>, mut outcome: ResMut<Outcome>) {
    if let Err(failure) = search.update(&columns, clock.dt) {
        outcome.fail(failure);
    }
}

/// The neighbour search of a scene.
pub struct NeighboursPlugin(pub Neighbours);

impl Plugin for NeighboursPlugin {
    fn build(&self, app: &mut App) {
        let full = app.world().resource::<Threads>().pool().is_some();
        app.insert_resource(Search::new(self.0, full))
            .add_systems(Step, update_search.in_set(Phase::Neighbours).after(Gathered));
    }
}
