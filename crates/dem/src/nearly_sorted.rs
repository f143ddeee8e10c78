//! Sorting of rows that are nearly in order already, as slots, pairs and memories are after a renumbering: most particles keep their place
//! among their neighbours.
//!
//! A row that comes after a larger one is set aside together with it, so each row that is out of place costs two. The rows that remain are in
//! order. Those set aside are sorted and merged with them. n rows with k out of place take O(n + k log k) steps; in any other order they take as
//! long as a sort.
//!
//! The method is a simple form of drop-merge sort (Ernerfeldt 2016).

/// Replaces the content of `all` by the rows in the ascending order of their keys. Rows with equal keys may be exchanged.
pub fn sort_into<T, K: Ord>(all: &mut Vec<T>, rows: impl Iterator<Item = T>, key: impl Fn(&T) -> K) {
    all.clear();
    let mut aside = Vec::new();
    for row in rows {
        match all.pop_if(|last| key(last) > key(&row)) {
            Some(last) => aside.extend([last, row]),
            None => all.push(row),
        }
    }
    all.append(&mut aside);
    // The stable sort merges runs that are in order.
    all.sort_by_key(key);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn sorted(rows: Vec<u32>) -> Vec<u32> {
        let mut all = vec![7];
        sort_into(&mut all, rows.into_iter(), |row| *row);
        all
    }

    proptest! {
        #[test]
        fn rows_are_sorted_in_whichever_order_they_come(rows in prop::collection::vec(0u32..300, 0..200)) {
            let mut expected = rows.clone();
            expected.sort_unstable();
            prop_assert_eq!(sorted(rows), expected);
        }

        /// Some rows of an ordered sequence are moved elsewhere.
        #[test]
        fn rows_nearly_in_order_are_sorted(moves in prop::collection::vec((0usize..1000, 0usize..1000), 0..20)) {
            let mut rows: Vec<_> = (0..1000).collect();
            for (from, to) in moves {
                let row = rows.remove(from);
                rows.insert(to, row);
            }
            prop_assert_eq!(sorted(rows), (0..1000).collect::<Vec<_>>());
        }
    }
}
