//! Reading ahead of a walk among entries that lie far apart: each would wait for memory by itself, together they wait once.
//!
//! For entries that lie side by side `contact/kernel/fetch.rs` does with less: one number of each.

use std::hint::black_box;

use crate::columns::Columns;
use crate::contact::sums::Sums;
use crate::space::{Linear, Space};

/// How many entries to read at once: a few hundred lines, which the first cache holds until they are asked for.
pub(super) const AT_ONCE: usize = 32;

/// Reads both ends of what contacts ask of each of these entries and add to it. Nothing depends on what is read.
pub(super) fn fetch<V: Space>(columns: &Columns<V>, sums: &Sums<V>, entries: impl Iterator<Item = usize>) {
    let read = |[one, other]: [f64; 2]| one.to_bits() ^ other.to_bits();
    black_box(entries.fold(0, |all, i| {
        let body = &columns.body[i];
        let rotation = columns.rotation.get(i).map_or(0, |of| read([of.spin.component(0), of.inverse_inertia]));
        let [force, torque] = sums.ends(i);
        all ^ read([body.position.axis(0), body.inverse_mass]) ^ rotation ^ read(force) ^ read(torque)
    }));
}
