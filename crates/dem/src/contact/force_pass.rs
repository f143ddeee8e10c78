//! The force pass: sums the contact forces between particles and with wall surfaces.
//!
//! Each pair (i, j) with i < j is evaluated once, in ascending order of i, then of j, and added to both particles. So
//! each particle receives the forces of its partners in ascending order of slots. The pass alternates between three
//! stages:
//!
//! 1. Filter candidates by distance into a batch, without branches.
//! 2. When the batch is full, evaluate the law in all lanes at once.
//! 3. Add the forces one by one, in order.
//!
//! The lanes are compiled for each law, the other loops for three classes of laws (module `needs`).
//!
//! Each thread sums the forces of a range of rows. A pair across a border between two ranges is evaluated by both
//! threads ([`PairList`](crate::neighbours::list::PairList)). So the order of every sum, and every bit of it, does not depend on the number of threads.
//! Memories are stored in history blocks of [`BLOCK`] rows. A batch never spans two blocks, so the energy balance does
//! not depend on the number of threads either. Memories of contacts across a border are copied at the end of a pass, by
//! the thread that has just written them. In the next pass the other thread reads the copy (halo export and import).
//!
//! Contacts with walls are summed block by block (`walls`), after all contacts between the particles of the block. So
//! the sum of a particle takes walls last, in the scene's order. The load on a wall is also summed block by block, so
//! that no bit of it depends on the number of threads.

mod contact_end;
mod input;
mod prefetch;
mod thread_scratch;
mod walls;
mod worker;

pub use self::input::ForcePass;
use self::thread_scratch::{HaloImport, exchange_halos, export_halo};
pub use self::thread_scratch::{KeptScratches, ScratchPerThread, ThreadScratch};
use self::worker::{OwnContacts, OwnOutput, Worker};
use crate::contact::force_accumulation::{AccumulatorSlice, ForceAccumulation};
use crate::contact::history::History;
use crate::contact::law::LawRequirements;
use crate::contact::needs::{FrictionTorques, NoTorques, RollingTorques, TorqueClass};
use crate::neighbours::list::BLOCK;
use crate::space::{Linear, Space};
use crate::store::ParticleStore;
use crate::threads::Threads;

impl<V: Space> ForcePass<'_, V> {
    /// Sets the loads of `store` to the sums of weight and all contact forces.
    ///
    /// `deepest` is the largest overlap so far divided by the smaller radius of its pair. Returns the same ratio after
    /// this pass. After the pass `kept` holds the loads on walls.
    pub fn sum(
        &self,
        store: &mut ParticleStore<V>,
        history: &mut History,
        threads: &Threads,
        kept: KeptScratches<'_, V>,
        deepest: f64,
    ) -> f64 {
        match self.needs.torques {
            TorqueClass::None => self.sum_as::<NoTorques>(store, history, threads, kept, deepest),
            TorqueClass::Friction => self.sum_as::<FrictionTorques>(store, history, threads, kept, deepest),
            TorqueClass::Rolling => self.sum_as::<RollingTorques>(store, history, threads, kept, deepest),
        }
    }

    /// As [`Self::sum`], compiled for the class `C`.
    fn sum_as<C: LawRequirements>(
        &self,
        store: &mut ParticleStore<V>,
        history: &mut History,
        threads: &Threads,
        kept: KeptScratches<'_, V>,
        deepest: f64,
    ) -> f64 {
        let KeptScratches { scratches, history_unchanged } = kept;
        let mut loads = std::mem::take(&mut store.loads);
        loads.contacts.resize(if self.counts { store.len() } else { 0 }, 0);
        if C::ROLLING && store.tracks_energy {
            loads.rolling_drag.resize(store.len(), V::Spin::ZERO);
        }
        let tasks = self.list.tasks();
        scratches.resize_with(tasks.len(), ThreadScratch::default);
        let (mut pair_histories, mut wall_histories) = history.blocks_mut(store);
        // The layout of the memories, if memories cross a border between two tasks.
        let over_borders = self.needs.memory.as_ref().filter(|_| tasks.len() > 1);
        if let Some(layout) = over_borders {
            exchange_halos(scratches, self.list, pair_histories, layout, history_unchanged);
        }
        let view = &*store;
        let (halo, places): (Vec<_>, Vec<_>) = scratches
            .iter_mut()
            .map(|ThreadScratch { batch, halo, next_halo, rows, spare, on_walls }| {
                (&*halo, (batch, next_halo, rows, spare, on_walls))
            })
            .unzip();
        let halo = HaloImport::new(tasks, &halo);
        // The parts not yet assigned to a task.
        let mut rest = AccumulatorSlice::all(&mut loads);
        let mut near = self.near;
        let mut workers = Vec::with_capacity(tasks.len());
        for (task, (batch, next_halo, rows, spare, on_walls)) in tasks.iter().zip(places) {
            let count = task.rows.len();
            let sums = ForceAccumulation::new(task.rows.clone(), rest.split_front(count));
            let blocks = count.div_ceil(BLOCK);
            let pair_histories = pair_histories.split_off_mut(..blocks).unwrap_or_default();
            let wall_histories = wall_histories.split_off_mut(..blocks).unwrap_or_default();
            let own = near.partition_point(|contact| contact.first() < task.rows.end);
            let near = near.split_off(..own).unwrap_or_default();
            let halo = halo.clone();
            on_walls.clear();
            let contacts = OwnContacts { task, halo, near };
            let output = OwnOutput { sums, batch, on_walls };
            let worker = Worker::<V, C>::new(self, view, contacts, output, deepest);
            workers.push(move || {
                let largest = worker.sum(pair_histories, wall_histories, spare);
                if let Some(layout) = over_borders {
                    export_halo(&task.rows, self.list, pair_histories, layout, next_halo);
                    *rows = task.rows.clone();
                }
                largest
            });
        }
        let largest = threads.share(workers).into_iter().fold(deepest, f64::max);
        store.loads = loads;
        store.gather_bodies(threads);
        if self.counts {
            store.share_contact_counts();
            store.store_lone(self.starts);
        }
        largest
    }
}
