//! Brute-force search: at most N (N - 1)/2 distances per step; pairs of fixed particles are skipped. It is the
//! reference that the other searches must equal.

use crate::neighbours::list::PairList;
use crate::space::Space;
use crate::store::ParticleStore;

/// Lists every pair that may touch.
pub(super) fn find<V: Space>(store: &ParticleStore<V>, list: &mut PairList) {
    list.clear();
    for i in 0..store.len() {
        if !store.is_fixed(i) {
            for (j, row) in (0u32..).zip(0..store.len()).skip(i + 1) {
                if store.may_touch(i, row) {
                    list.push(j);
                }
            }
        }
        list.end_row();
    }
}
