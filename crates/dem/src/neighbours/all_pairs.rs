//! Brute-force search: at most N (N - 1)/2 distances per step; pairs of fixed particles are skipped. It is the
//! reference that the other searches must equal.

use crate::neighbours::list::PairList;
use crate::space::Space;
use crate::store::ParticleStore;

/// Lists every pair that may touch.
pub(super) fn find<V: Space>(store: &ParticleStore<V>, list: &mut PairList) {
    list.clear();
    for j in 0..store.len() {
        for (partner, i) in (0u32..).zip(0..j.min(store.free_end)) {
            if store.may_touch(i, j) {
                list.push(partner);
            }
        }
        list.end_row();
    }
}
