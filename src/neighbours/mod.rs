//! Neighbour search: which particles may touch.
//!
//! The scene's `neighbours` chooses between three searches with one result, to the last bit:
//!
//! | search | work a step | memory |
//! |---|---|---|
//! | [`AllPairs`](Neighbours::AllPairs) | N^2/2 distances: the reference | N indices |
//! | [`Cells`](Neighbours::Cells) | sorting into hashed cells, then 9 (27) cells a grain | N entries |
//! | [`VerletList`](Neighbours::VerletList) | the listed pairs; now and then a search by cells | the list |

mod all_pairs;
mod candidate;
pub mod cells;
pub mod list;
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
use crate::space::{Plane, Space};
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{ParticleStore, VelocitiesPredicted};
use crate::threads::Threads;
use crate::values::Positive;

/// The scene's `neighbours`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Neighbours {
    /// Every pair, every step.
    AllPairs,
    /// Hashed square or cubic cells, filled anew every step; a grain looks into its own cell and those around it.
    Cells {
        /// Side L of a cell, m: at least the largest distance at which two particles touch.
        size: Positive,
    },
    /// The same, with the side given as a multiple of the largest radius.
    CellsOfRange {
        /// L over the largest radius: 2 or more, for grains alone.
        rng: Positive,
    },
    /// A list of the pairs that might touch soon, renewed when a particle has moved too far.
    VerletList {
        /// Skin, m: particles at rest are listed up to this distance of their surfaces.
        skin: Positive,
    },
}

/// The search and its state.
pub enum Method<V: Space> {
    /// Every pair.
    AllPairs,
    /// Cells, filled every step.
    Cells(Cells<V>),
    /// A list, renewed on displacement.
    VerletList(VerletList<V>),
}

/// How often cells were filled or the list was renewed.
#[derive(Resource, Default, Debug, Clone, Copy)]
pub struct Rebuilds(pub u64);

/// The neighbour search of a run.
#[derive(Resource)]
pub struct Search<V: Space = Plane> {
    /// Which, with its state.
    method: Method<V>,
    /// What it has found.
    pub list: PairList,
    generation: u64,
}

impl<V: Space> Search<V> {
    /// The search `kind` in a box with these periodic sides, for grains of at most `largest_radius` (m).
    #[must_use]
    pub fn new(kind: Neighbours, periodic: Option<Periodic<V>>, largest_radius: f64) -> Self {
        let method = match kind {
            Neighbours::AllPairs => Method::AllPairs,
            Neighbours::Cells { size } => Method::Cells(Cells::new(size.get(), periodic)),
            Neighbours::CellsOfRange { rng } => Method::Cells(Cells::new(rng.get() * largest_radius, periodic)),
            Neighbours::VerletList { skin } => Method::VerletList(VerletList::new(skin.get())),
        };
        Self { method, list: PairList::default(), generation: 0 }
    }

    /// Makes the search valid for the positions in `store`, and shares the list out among `threads`; `dt` is the time step, s.
    /// Tells whether cells were filled or the list was renewed.
    ///
    /// # Errors
    /// If particles touch at more than the cell size.
    pub fn update(&mut self, store: &ParticleStore<V>, dt: f64, threads: &Threads) -> Result<bool, Failure> {
        let renumbered = self.generation != store.generation;
        let mut caught_up = false;
        let follows = self.generation + 1 == store.generation;
        self.generation = store.generation;
        let rebuilt = match &mut self.method {
            Method::AllPairs => {
                all_pairs::find(store, &mut self.list);
                true
            }
            Method::Cells(cells) => {
                cells.fill(store.body.iter().map(|body| body.position));
                let is_right = if renumbered { cells.check_range(store) } else { Ok(()) };
                cells.look_ahead(store.margin);
                // Found in any case, so that what is left of a step that fails has a valid list.
                cells.find(store, &mut self.list);
                self.list.share_out(store.len(), threads.count(), BLOCK);
                is_right?;
                true
            }
            Method::VerletList(list) => {
                let is_whole = !renumbered || (follows && list.follow(store, &mut self.list, dt));
                let gone_far = if is_whole { list.gone_far(store) } else { Vec::new() };
                caught_up = !gone_far.is_empty();
                let stale = !is_whole || (caught_up && !list.catch_up(store, &mut self.list, &gone_far, dt));
                if stale {
                    list.renew(store, &mut self.list, dt, threads);
                }
                stale
            }
        };
        if rebuilt || renumbered || caught_up {
            self.list.share_out(store.len(), threads.count(), BLOCK);
        }
        Ok(rebuilt)
    }
}

impl<V: Space> ParticleStore<V> {
    /// Whether two are so near that the law has to look at them.
    fn may_touch(&self, i: usize, j: usize) -> bool {
        // Summed as the kernel does it, to the last bit.
        let reach = self.body[i].radius + self.body[j].radius + self.margin;
        self.separation(self.body[i].position, self.body[j].position).length_squared() < reach * reach
    }
}

/// The largest distance at which two particles of `store` touch, at least one of them movable, m.
///
/// A grain looks one cell far, so a pair is found for certain only if its centres are at most a cell's side apart:
/// the side must not be smaller than this. For grains alone that is twice the largest radius.
#[must_use]
pub fn contact_range<V: Space>(store: &ParticleStore<V>) -> f64 {
    let largest = |fixed: bool| {
        let of_kind = (0..store.len()).filter(|&i| store.is_fixed(i) == fixed);
        of_kind.map(|i| store.body[i].radius).fold(0.0, f64::max)
    };
    let movable = largest(false);
    movable + movable.max(largest(true))
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
    /// Which.
    pub kind: Neighbours,
    /// The periodic sides of the scene.
    pub periodic: Option<Periodic<V>>,
    /// Of all grains, m.
    pub largest_radius: f64,
}

impl<V: Space> Plugin for NeighboursPlugin<V> {
    fn build(&self, app: &mut App) {
        app.insert_resource(Search::new(self.kind, self.periodic, self.largest_radius))
            .init_resource::<Rebuilds>()
            .add_systems(Step, update_search::<V>.in_set(Part::Engine(Phase::Neighbours)).after(VelocitiesPredicted));
    }
}
