//! Fetching ahead: where a pass walks along large slices of a packing, the next one is read in order before it is needed.
//!
//! A grain is first met as the partner of one in the slice before. Partners come in no order that a processor foresees, so each
//! such meeting would wait for memory, and where slots go by beams ([`SpatialOrder`](crate::store::Order)) a slice stays at hand until it is needed.
//! Nothing depends on what is read.

use std::hint::black_box;
use std::ops::Range;

use crate::contact::kernel::worker::Worker;
use crate::contact::{LawRequirements, PairLaw};
use crate::space::Space;

/// Reads a number of each entry.
pub(in crate::contact) fn touch<T>(entries: &[T], number: impl Fn(&T) -> f64) -> u64 {
    entries.iter().fold(0, |all, entry| all ^ number(entry).to_bits())
}

impl<V: Space, L: PairLaw<V> + LawRequirements> Worker<'_, V, L> {
    /// Reads what rows before `end` may ask of their partners, from entry `at_hand` on: gives where to go on. Does nothing where all is near
    /// anyway.
    pub(super) fn fetch(&self, at_hand: usize, end: usize) -> usize {
        let Some(ahead) = self.view.order.ahead() else { return at_hand };
        let next = at_hand..(end + ahead).clamp(at_hand, self.view.len());
        black_box(self.read(next.clone()));
        next.end
    }

    fn read(&self, entries: Range<usize>) -> u64 {
        let bodies = touch(&self.view.body[entries.clone()], |body| body.radius);
        let rotations = self.view.rotation.get(entries.clone()).unwrap_or_default();
        bodies ^ touch(rotations, |rotation| rotation.inverse_inertia) ^ self.sums.touch(entries)
    }
}
