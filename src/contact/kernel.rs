//! The contact pass: the sums of all contact forces, between particles and with flat walls.
//!
//! Each pair is evaluated once, walked i < j with both ascending, and added to both: a particle receives its partners in
//! ascending order of slots. Three things happen by turns: candidates are filtered by distance, without a branch, into a
//! batch; when it is full, the law answers for all its lanes at once; the answers are added one by one, in order. What a
//! law does not demand ([`LawRequirements`]) is not compiled.
//!
//! Threads sum a range of rows each, and evaluate for themselves what rows of others do to theirs ([`PairList`]): the order
//! of every sum, and so its bits, do not depend on their number. Memories are written in pages of [`BLOCK`] rows, and a batch
//! ends with its block, so that neither do the books. What contacts with rows of others remember is copied before anyone writes:
//! at the end of the pass before, by whoever has just written it.
//!
//! Contacts with walls are summed block by block too (`walls`), after all contacts between particles of the block: a particle's sum takes
//! walls last, in the scene's order. What a wall gets is summed block by block, so that no bit of it depends on the number of threads.

mod prefetch;
mod thread_scratch;
mod walls;
mod worker;

pub(super) use self::prefetch::touch;
use self::thread_scratch::{HaloImport, exchange_halos, export_halo};
pub use self::thread_scratch::{ScratchPerThread, ThreadScratch};
use self::worker::Worker;
use crate::contact::force_accumulation::{AccumulatorSlice, ForceAccumulation};
use crate::contact::history::History;
use crate::contact::{LawRequirements, PairLaw};
use crate::instructions::Instructions;
use crate::neighbours::list::{BLOCK, Candidate, PairList};
use crate::space::{Linear, Space};
use crate::store::ParticleStore;
use crate::threads::Threads;
use crate::walls::surfaces::FlatWall;

/// What a pass needs besides the columns.
pub struct Pass<'a, V: Space, L> {
    /// The contact law.
    pub law: &'a L,
    /// Candidates.
    pub list: &'a PairList,
    /// The flat walls.
    pub walls: &'a [FlatWall<V>],
    /// Particles and walls that may touch, ascending.
    pub near: &'a [Candidate],
    /// By how much memories advance, s.
    pub dt: f64,
    /// m/s^2.
    pub gravity: V,
    /// What lanes are computed with.
    pub instructions: Instructions,
}

impl<V: Space, L: PairLaw<V> + LawRequirements> Pass<'_, V, L> {
    /// Sets the loads of `store` to the sums of weight and all contact forces. `deepest` is the largest overlap so
    /// far over the smaller radius of its pair; gives that with these. `scratches` are kept for the next pass, and hold what walls get; `goes_on`
    /// tells whether nobody has changed what contacts remember since the last one with them.
    pub fn sum(
        &self,
        store: &mut ParticleStore<V>,
        history: &mut History<V>,
        threads: &Threads,
        (scratches, goes_on): (&mut Vec<ThreadScratch<V>>, bool),
        deepest: f64,
    ) -> f64 {
        let mut loads = std::mem::take(&mut store.loads);
        if L::ROLLING && store.tracks_energy {
            loads.rolling_drag.resize(store.len(), V::Spin::ZERO);
        }
        let tasks = self.list.tasks();
        scratches.resize_with(tasks.len(), ThreadScratch::default);
        let (mut pages, mut wall_pages) = history.pages(store);
        let has_borders = L::MEMORY && tasks.len() > 1;
        if has_borders {
            exchange_halos::<V, L>(scratches, self.list, pages, goes_on);
        }
        let view = &*store;
        let (left, places): (Vec<_>, Vec<_>) = scratches
            .iter_mut()
            .map(|ThreadScratch { batch, left, leaving, rows, spare, on_walls }| {
                (&*left, (batch, leaving, rows, spare, on_walls))
            })
            .unzip();
        let halo = HaloImport::new(tasks, &left);
        // What is left for the tasks to come.
        let (mut rest, mut near) = (AccumulatorSlice::all(&mut loads), self.near);
        let mut workers = Vec::with_capacity(tasks.len());
        for (task, (batch, leaving, rows, spare, on_walls)) in tasks.iter().zip(places) {
            let count = task.rows.len();
            let sums = ForceAccumulation::new(task.rows.clone(), rest.cut_off(count));
            let blocks = count.div_ceil(BLOCK);
            let pages = pages.split_off_mut(..blocks).unwrap_or_default();
            let wall_pages = wall_pages.split_off_mut(..blocks).unwrap_or_default();
            let own = near.partition_point(|contact| contact.first() < task.rows.end);
            let near = near.split_off(..own).unwrap_or_default();
            let halo = halo.clone();
            on_walls.clear();
            let worker = Worker { pass: self, view, task, halo, sums, batch, largest: deepest, near, on_walls };
            workers.push(move || {
                let largest = worker.sum(pages, wall_pages, spare);
                if has_borders {
                    export_halo::<V, L>(&task.rows, self.list, pages, leaving);
                    *rows = task.rows.clone();
                }
                largest
            });
        }
        let largest = threads.share(workers).into_iter().fold(deepest, f64::max);
        store.loads = loads;
        largest
    }
}
