//! The distance at which two particles touch, or may touch within the time by which velocities are predicted.

use crate::space::Space;
use crate::store::ParticleStore;

impl<V: Space> ParticleStore<V> {
    /// Returns whether the contact law must test this pair.
    pub(super) fn may_touch(&self, i: usize, j: usize) -> bool {
        // The filter of the force pass sums in the same order for laws without memory, so that both agree to the last bit. For laws
        // with memory it takes fewer pairs.
        let reach = self.body[i].radius + self.body[j].radius + (self.prediction.margin + self.prediction.range);
        self.separation(self.body[i].position, self.body[j].position).length_squared() < reach * reach
            && self.can_touch(i, j)
    }
}

/// Returns the largest distance at which two particles of `store` touch, at least one of them free, m.
///
/// A grain searches the adjacent cells, so a pair is found for certain only if its centres are at most one cell side
/// apart. The side must therefore not be smaller than this distance. For grains alone it is twice the largest radius.
pub(super) fn contact_range<V: Space>(store: &ParticleStore<V>) -> f64 {
    let largest = |fixed: bool| {
        let of_kind = store.contact_rows().filter(|&i| store.is_fixed(i) == fixed);
        of_kind.map(|i| store.body[i].radius).fold(0.0, f64::max)
    };
    let free = largest(false);
    free + free.max(largest(true))
}
