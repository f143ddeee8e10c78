//! The force pass: sums the contact forces between particles and with wall surfaces.
//!
//! Each pair (i, j) with i < j is evaluated once, in ascending order of j, then of i, and added to both particles. So
//! each particle receives the forces of its partners in ascending order of slots. The pass alternates between three
//! stages:
//!
//! 1. Filter candidates by distance into a batch, without branches.
//! 2. When the batch is full, evaluate the law in all lanes at once.
//! 3. Add the forces one by one, in order.
//!
//! The lanes are compiled for each law, the other loops for three classes of laws (module `needs`).
//!
//! Each thread evaluates the pairs of a range of rows, and sums the forces on the particles of these rows. The force of a pair on a particle in
//! an earlier row goes to the thread of that row (`exchange`). This thread adds it after its own pairs, which is its place in the order of slots.
//! So the order of every sum, and every bit of it, does not depend on the number of threads. Memories are stored in history blocks of [`BLOCK`]
//! rows. A batch never spans two blocks, so the energy balance does not depend on the number of threads either.
//!
//! Contacts with walls are summed block by block (`walls`), after all contacts between particles. So the sum of a particle takes walls last, in
//! the scene's order. The load on a wall is also summed block by block, so that no bit of it depends on the number of threads.

mod contact_end;
mod exchange;
mod input;
mod thread_scratch;
mod walls;
mod worker;

use self::exchange::{Exchange, Post};
pub use self::input::ForcePass;
pub use self::thread_scratch::{ScratchPerThread, ThreadScratch};
use self::worker::{OwnHistories, OwnOutput, Worker};
use crate::contact::force_accumulation::{AccumulatorSlice, ForceAccumulation};
use crate::contact::history::History;
use crate::contact::law::LawRequirements;
use crate::contact::needs::{FrictionTorques, NoTorques, RollingTorques, TorqueClass};
use crate::neighbours::list::{BLOCK, Task};
use crate::space::{Linear, Space};
use crate::store::ParticleStore;
use crate::threads::Threads;

impl<V: Space> ForcePass<'_, V> {
    /// Sets the loads of `store` to the sums of weight and all contact forces.
    ///
    /// `deepest` is the largest overlap so far divided by the smaller radius of its pair. Returns the same ratio after
    /// this pass. After the pass `scratches` hold the loads on walls.
    pub fn sum(
        &self,
        store: &mut ParticleStore<V>,
        history: &mut History,
        threads: &Threads,
        scratches: &mut Vec<ThreadScratch<V>>,
        deepest: f64,
    ) -> f64 {
        match self.needs.torques {
            TorqueClass::None => self.sum_as::<NoTorques>(store, history, threads, scratches, deepest),
            TorqueClass::Friction => self.sum_as::<FrictionTorques>(store, history, threads, scratches, deepest),
            TorqueClass::Rolling => self.sum_as::<RollingTorques>(store, history, threads, scratches, deepest),
        }
    }

    /// As [`Self::sum`], compiled for the class `C`.
    fn sum_as<C: LawRequirements>(
        &self,
        store: &mut ParticleStore<V>,
        history: &mut History,
        threads: &Threads,
        scratches: &mut Vec<ThreadScratch<V>>,
        deepest: f64,
    ) -> f64 {
        let mut loads = std::mem::take(&mut store.loads);
        loads.contacts.resize(if self.counts { store.len() } else { 0 }, 0);
        if C::ROLLING && store.tracks_energy {
            loads.rolling_drag.resize(store.len(), V::Spin::ZERO);
        }
        let tasks = self.list.tasks();
        scratches.resize_with(tasks.len(), ThreadScratch::default);
        let (mut pair_histories, mut wall_histories) = history.blocks_mut(store);
        let view = &*store;
        let posts: Vec<_> = tasks.iter().map(|_| Post::new()).collect();
        // The parts not yet assigned to a task.
        let mut rest = AccumulatorSlice::all(&mut loads);
        let mut near = self.near;
        let mut workers = Vec::with_capacity(tasks.len());
        for (own, (Task { rows, .. }, scratch)) in tasks.iter().zip(&mut *scratches).enumerate() {
            let ThreadScratch { batch, outgoing, of_walls, spare, on_walls } = scratch;
            let blocks = rows.len().div_ceil(BLOCK);
            let pairs = pair_histories.split_off_mut(..blocks).unwrap_or_default();
            let walls = wall_histories.split_off_mut(..blocks).unwrap_or_default();
            let histories = OwnHistories { pairs, walls, spare };
            let sums = ForceAccumulation::new(rows.clone(), rest.split_front(rows.len()));
            let output = OwnOutput { sums, batch, outgoing, of_walls, on_walls };
            let near = near.split_off(..near.partition_point(|contact| contact.row() < rows.end)).unwrap_or_default();
            let exchange = Exchange { threads, tasks, posts: &posts, own };
            let worker = Worker::<V, C>::new(self, view, near, output, deepest);
            workers.push(move || worker.sum(histories, &exchange));
        }
        debug_assert!(tasks.len() <= threads.count(), "a task waits for later ones, so each needs a thread");
        let largest = threads.share(workers).into_iter().fold(deepest, f64::max);
        for (scratch, post) in scratches.iter_mut().zip(posts) {
            scratch.outgoing = post.into_inner().unwrap_or_default();
        }
        store.loads = loads;
        store.gather_bodies(threads);
        if self.counts {
            store.share_contact_counts();
            store.store_lone(self.starts);
        }
        largest
    }
}
