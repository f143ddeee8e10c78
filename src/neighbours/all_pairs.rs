//! Every pair: N(N-1)/2 distances a step. The reference that the other searches must equal.

use crate::columns::Columns;
use crate::neighbours::list::PairList;
use crate::space::Space;

/// Lists who may touch.
pub(super) fn find<V: Space>(columns: &Columns<V>, list: &mut PairList) {
    list.clear();
    for i in 0..columns.len() {
        if i < columns.movable_end {
            for (j, row) in (0u32..).zip(0..columns.len()).skip(i + 1) {
                if columns.may_touch(i, row) {
                    list.push(j);
                }
            }
        }
        list.end_row();
    }
}
