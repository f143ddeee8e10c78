//! Prefetch: in large packings, the next slice of the store is read in order before the pass needs it.
//!
//! The pass first needs a particle as the partner of a particle in the slice before. Partners come in an order that the
//! processor cannot predict, so each first access would stall on memory. Where slots are sorted by beams
//! ([`SpatialOrder`](crate::store::SpatialOrder)), a slice stays in the cache until it is needed. The numbers read here
//! affect no result.

use std::hint::black_box;
use std::ops::Range;

use crate::contact::force_accumulation::touch;
use crate::contact::force_pass::worker::Worker;
use crate::contact::law::LawRequirements;
use crate::space::Space;

impl<V: Space, C: LawRequirements> Worker<'_, V, C> {
    /// Prefetches data of the partners of rows before `end`, starting at slot `start`. Returns the slot at which the
    /// next prefetch starts. Does nothing if the spatial order has no beams, because the data are then close by.
    pub(super) fn prefetch(&self, start: usize, end: usize) -> usize {
        let Some(ahead) = self.view.order.ahead() else { return start };
        let next = start..(end + ahead).clamp(start, self.view.len());
        black_box(self.read(next.clone()));
        next.end
    }

    fn read(&self, entries: Range<usize>) -> u64 {
        let bodies = touch(&self.view.body[entries.clone()], |body| body.radius);
        let rotations = self.view.rotation.get(entries.clone()).unwrap_or_default();
        bodies ^ touch(rotations, |rotation| rotation.inverse_inertia) ^ self.sums.touch(entries)
    }
}
