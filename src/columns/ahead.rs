//! Reading ahead of a walk among entries that lie far apart: each would wait for memory by itself, together they wait once.
//!
//! For entries that lie side by side `contact/kernel/fetch.rs` does with less: one number of each, and of the sums of one share.

use std::hint::black_box;

use crate::columns::Columns;
use crate::space::{Linear, Space};

/// How many entries to read at once: a few hundred lines, which the first cache holds until they are asked for.
pub(crate) const AT_ONCE: usize = 32;

impl<V: Space> Columns<V> {
    /// Reads both ends of what contacts ask of each of these entries and add to it. Nothing depends on what is read.
    pub(crate) fn fetch(&self, entries: impl Iterator<Item = usize>) {
        let read = |[one, other]: [f64; 2]| one.to_bits() ^ other.to_bits();
        black_box(entries.fold(0, |all, i| {
            let body = self.body.get(i).map_or(0, |body| read([body.position.axis(0), body.inverse_mass]));
            let rotation = self.rotation.get(i).map_or(0, |of| read([of.spin.component(0), of.inverse_inertia]));
            all ^ body ^ rotation ^ read(self.loads.force.ends(i)) ^ read(self.loads.torque.ends(i))
        }));
    }
}
