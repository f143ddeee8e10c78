//! Neighbour search: finds the pairs of particles that may touch.
//!
//! The scene key `neighbours` selects one of three searches. Their results are equal to the last bit.
//!
//! | search | work per step | memory |
//! |---|---|---|
//! | [`AllPairs`](Neighbours::AllPairs) | at most N (N - 1)/2 distances (reference) | the pairs that may touch |
//! | [`Cells`](Neighbours::Cells) | sorting into hashed cells, then 9 (27) cells per grain | N entries, and the pairs that may touch |
//! | [`VerletList`](Neighbours::VerletList) | the listed pairs; occasionally a search by cells | the list |

mod all_pairs;
mod candidate;
pub mod cells;
pub mod list;
mod range;
mod verlet_list;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use self::cells::Cells;
use self::list::PairList;
use self::verlet_list::VerletList;
use crate::neighbours::list::BLOCK;
use crate::outcome::{Failure, Outcome};
use crate::periodic::Periodic;
use crate::persist::PersistApp as _;
use crate::space::{Plane, Space};
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{ParticleStore, VelocitiesPredicted};
use crate::threads::Threads;
use crate::values::Positive;

/// The scene key `neighbours`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Neighbours {
    /// Tests every pair in every step.
    AllPairs,
    /// Hashed square or cubic cells, filled in every step. A grain searches its own cell and the adjacent ones.
    Cells {
        /// Side L of a cell, m: at least the largest distance at which two particles touch.
        size: Positive,
    },
    /// Like [`Cells`](Neighbours::Cells), with L given as a multiple of the largest radius.
    CellsOfRange {
        /// L over the largest radius, dimensionless: at least 2 if all particles are grains. A scene writes `rng`, the name of the soft-particle paper.
        #[serde(rename = "rng")]
        range: Positive,
    },
    /// A list of the pairs that may touch soon. It is rebuilt when a particle has moved too far.
    VerletList {
        /// Skin, m: two particles at rest are listed if the gap between their surfaces is smaller.
        skin: Positive,
    },
}

/// Fewest rows of a task. Threads that share fewer lose more time by handing out work than they save.
pub const ROWS_PER_THREAD: usize = 512;

/// A search with its state.
pub enum Method<V: Space> {
    /// Every pair.
    AllPairs,
    /// Cells, filled in every step.
    Cells(Cells<V>),
    /// A list, rebuilt after displacements.
    VerletList(VerletList<V>),
}

/// Counts how often cells were filled or the list was rebuilt.
#[derive(Resource, Default, Debug, Clone, Copy, Deserialize, Serialize)]
pub struct Rebuilds(pub u64);

/// Neighbour search of a run, with its latest result.
#[derive(Resource)]
pub struct Search<V: Space = Plane> {
    /// The search and its state.
    method: Method<V>,
    /// The latest neighbour list.
    pub list: PairList,
    /// Renumberings of the store up to the last update.
    generation: u64,
}

impl<V: Space> Search<V> {
    /// Makes the search `kind` in the periodic box `periodic`, for grains with radii up to `largest_radius` (m).
    #[must_use]
    pub fn new(kind: Neighbours, periodic: Option<Periodic<V>>, largest_radius: f64) -> Self {
        let method = match kind {
            Neighbours::AllPairs => Method::AllPairs,
            Neighbours::Cells { size } => Method::Cells(Cells::new(size.get(), periodic)),
            Neighbours::CellsOfRange { range } => Method::Cells(Cells::new(range.get() * largest_radius, periodic)),
            Neighbours::VerletList { skin } => Method::VerletList(VerletList::new(skin.get())),
        };
        Self { method, list: PairList::default(), generation: 0 }
    }

    /// Updates the list to the positions in `store` and assigns it to `threads` tasks; `dt` is the time step, s.
    /// Returns whether cells were filled or the list was rebuilt.
    ///
    /// # Errors
    /// If particles touch at a distance larger than the cell size.
    pub fn update(&mut self, store: &ParticleStore<V>, dt: f64, threads: &Threads) -> Result<bool, Failure> {
        let shares = threads.count().min(store.len() / ROWS_PER_THREAD);
        let renumbered = self.generation != store.generation;
        let mut renewed_some = false;
        let mut range_check = Ok(());
        let is_next = self.generation + 1 == store.generation;
        self.generation = store.generation;
        let rebuilt = match &mut self.method {
            Method::AllPairs => {
                all_pairs::find(store, &mut self.list);
                true
            }
            Method::Cells(cells) => {
                cells.fill(store.body.iter().map(|body| body.position));
                if renumbered {
                    range_check = cells.check_range(store);
                }
                cells.set_reach(store.prediction.margin + store.prediction.range);
                // The list is made even after an error, so that the state left by the failed step has a valid list.
                cells.find(store, &mut self.list);
                true
            }
            Method::VerletList(list) => {
                let is_whole = !renumbered || (is_next && list.apply_renumbering(store, &mut self.list, dt, threads));
                let exhausted = if is_whole { list.exhausted(store, threads) } else { Vec::new() };
                renewed_some = !exhausted.is_empty();
                let stale = !is_whole
                    || (renewed_some && !list.renew_particles(store, &mut self.list, &exhausted, dt, threads));
                if stale {
                    list.renew(store, &mut self.list, dt, threads);
                }
                stale
            }
        };
        if rebuilt || renumbered || renewed_some {
            self.list.assign_tasks(store.len(), shares, BLOCK);
        }
        range_check.map(|()| rebuilt)
    }
}

fn update_search<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    threads: Res<Threads>,
    mut search: ResMut<Search<V>>,
    mut rebuilds: ResMut<Rebuilds>,
    mut outcome: ResMut<Outcome>,
) {
    match search.update(&store, clock.dt, &threads) {
        Ok(rebuilt) => rebuilds.0 += u64::from(rebuilt),
        Err(failure) => outcome.fail(failure),
    }
}

/// The neighbour search of a scene.
pub struct NeighboursPlugin<V: Space> {
    /// The kind of search.
    pub kind: Neighbours,
    /// The periodic box of the scene.
    pub periodic: Option<Periodic<V>>,
    /// Largest radius of all grains, m.
    pub largest_radius: f64,
    /// Largest range of a contact beyond touch, m.
    pub range: f64,
}

impl<V: Space> Plugin for NeighboursPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<ParticleStore<V>>().prediction.range = self.range;
        app.insert_resource(Search::new(self.kind, self.periodic, self.largest_radius))
            .init_resource::<Rebuilds>()
            .derived::<Search<V>>()
            .persist_sound::<Rebuilds>()
            .add_systems(Step, update_search::<V>.in_set(Part::Engine(Phase::Neighbours)).after(VelocitiesPredicted));
    }
}
