//! Walking along columns and the rows of a table together.

use std::ops::Range;

use crate::columns::Slot;

/// Calls `each` with what two columns hold for each of these slots, and with the state of its row; who has no place yet is
/// passed over. Where slots follow one upon another, as in a table whose rows were sorted, columns are walked along:
/// gives the entries. Elsewhere each entry is looked up.
#[inline(always)]
pub(crate) fn along<A, B, S>(
    slots: &[Slot],
    (read, written): (&[A], &mut [B]),
    states: impl Iterator<Item = S>,
    mut each: impl FnMut(&A, &mut B, S),
) -> Option<Range<usize>> {
    let run = run_of(slots).filter(|run| run.end <= read.len().min(written.len()));
    if let Some(run) = run.clone() {
        for ((a, b), state) in read[run.clone()].iter().zip(&mut written[run]).zip(states) {
            each(a, b, state);
        }
    } else {
        for (slot, state) in slots.iter().zip(states) {
            if let (Some(a), Some(b)) = (read.get(slot.index()), written.get_mut(slot.index())) {
                each(a, b, state);
            }
        }
    }
    run
}

/// The same with one column.
#[inline(always)]
pub(crate) fn along_one<B, S>(
    slots: &[Slot],
    written: &mut [B],
    states: impl Iterator<Item = S>,
    mut each: impl FnMut(&mut B, S),
) -> Option<Range<usize>> {
    let nothing = vec![(); written.len()];
    along(slots, (&nothing, written), states, |(), b, state| each(b, state))
}

/// The entries of these slots, if they follow one upon another.
#[inline(always)]
fn run_of(slots: &[Slot]) -> Option<Range<usize>> {
    let (first, last) = (slots.first()?.index(), slots.last()?.index());
    let run = first..first + slots.len();
    // What is not sorted is mostly seen at its ends. The rest without a branch, several at a time.
    (last + 1 == run.end && slots.iter().zip(first..).fold(true, |all, (slot, place)| all & (slot.index() == place)))
        .then_some(run)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_find_their_entries_in_whatever_order_they_are() {
        let column = [10, 11, 12, 13, 14];
        for slots in [vec![1, 2, 3], vec![3, 2, 1], vec![1, 1, 3], vec![2, u32::MAX, 0], vec![3, 4, 5], vec![]] {
            let slots: Vec<_> = slots.into_iter().map(Slot::at).collect();
            let (mut written, mut seen) = ([0; 5], Vec::new());
            let run = along(&slots, (&column, &mut written), 0.., |a, b, row: usize| {
                *b += a;
                seen.push((row, *a));
            });
            assert_eq!(run, (slots == [1, 2, 3].map(Slot::at)).then_some(1..4));
            let expected = (0..).zip(&slots).filter_map(|(row, slot)| Some((row, *column.get(slot.index())?)));
            assert_eq!(seen, expected.collect::<Vec<_>>());
            for (place, sum) in written.iter().enumerate() {
                assert_eq!(*sum, slots.iter().filter(|slot| slot.index() == place).count() * column[place]);
            }
        }
    }
}
