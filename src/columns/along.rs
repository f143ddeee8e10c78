//! Walking along columns and the rows of a table together, on all threads.
//!
//! Where slots follow one upon another, as in a table whose rows were sorted, columns are walked along, [`STRIDE`] rows at a
//! time. What is summed on the way is summed over each stride by itself, so that the number of threads leaves no trace.
//! Elsewhere each entry is looked up.

use std::ops::Range;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use rayon::prelude::*;

use crate::columns::Slot;
use crate::instructions::Instructions;
use crate::threads::Threads;

/// How many rows a thread takes at a time.
pub(crate) const STRIDE: usize = 1024;

/// From how many strides on threads share them: with ten, waking a second thread takes longer than it saves, with a hundred not.
const WORTHWHILE: usize = 64;

/// Rows of a table, component by component.
pub(crate) trait Rows: Default + Send {
    /// One of them.
    type Row;

    /// The first ones and the others.
    fn cut(self, first: usize) -> (Self, Self);

    /// One by one.
    fn each(self) -> impl Iterator<Item = Self::Row>;
}

impl<'a, T: Sync> Rows for &'a [T] {
    type Row = &'a T;

    fn cut(self, first: usize) -> (Self, Self) {
        self.split_at(first)
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = Self::Row> {
        self.iter()
    }
}

impl<'a, T: Send> Rows for &'a mut [T] {
    type Row = &'a mut T;

    fn cut(self, first: usize) -> (Self, Self) {
        self.split_at_mut(first)
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = Self::Row> {
        self.iter_mut()
    }
}

impl<A: Rows, B: Rows> Rows for (A, B) {
    type Row = (A::Row, B::Row);

    fn cut(self, first: usize) -> (Self, Self) {
        let ((a, others_of_a), (b, others_of_b)) = (self.0.cut(first), self.1.cut(first));
        ((a, b), (others_of_a, others_of_b))
    }

    #[inline(always)]
    fn each(self) -> impl Iterator<Item = Self::Row> {
        self.0.each().zip(self.1.each())
    }
}

/// Who walks.
#[derive(SystemParam)]
pub(crate) struct Walkers<'w> {
    threads: Res<'w, Threads>,
    instructions: Res<'w, Instructions>,
}

impl Walkers<'_> {
    /// Calls `each` with what two columns hold for each of these slots, with its row, and with what it sums up; who has no
    /// place yet is passed over. Gives the sums of the strides in order, and the entries if they follow one upon another.
    pub(crate) fn along<A: Sync, B: Send, R: Rows, T: Default + Send>(
        &self,
        slots: &[Slot],
        (read, written): (&[A], &mut [B]),
        mut rows: R,
        each: impl Fn(&A, &mut B, R::Row, &mut T) + Sync,
    ) -> (Vec<T>, Option<Range<usize>>) {
        let instructions = *self.instructions;
        let run = instructions.run_narrow(
            #[inline(always)]
            || run_of(slots),
        );
        let Some(run) = run.filter(|run| run.end <= read.len().min(written.len())) else {
            let mut sum = T::default();
            for (slot, row) in slots.iter().zip(rows.each()) {
                if let (Some(a), Some(b)) = (read.get(slot.index()), written.get_mut(slot.index())) {
                    each(a, b, row, &mut sum);
                }
            }
            return (vec![sum], None);
        };
        let columns = read[run.clone()].chunks(STRIDE).zip(written[run.clone()].chunks_mut(STRIDE));
        let strides = columns.map(|(a, b)| {
            let (first, others) = std::mem::take(&mut rows).cut(a.len());
            rows = others;
            (a, b, first)
        });
        let stride = |(a, b, rows): (&[A], &mut [B], R)| {
            instructions.run_narrow(
                #[inline(always)]
                || {
                    let mut sum = T::default();
                    for ((a, b), row) in a.iter().zip(b).zip(rows.each()) {
                        each(a, b, row, &mut sum);
                    }
                    sum
                },
            )
        };
        let sums = match self.threads.pool().filter(|_| slots.len() >= WORTHWHILE * STRIDE) {
            None => strides.map(stride).collect(),
            Some(pool) => {
                let strides: Vec<_> = strides.collect();
                pool.install(|| strides.into_par_iter().map(stride).collect())
            }
        };
        (sums, Some(run))
    }

    /// The same with one column.
    pub(crate) fn along_one<B: Send, R: Rows, T: Default + Send>(
        &self,
        slots: &[Slot],
        written: &mut [B],
        rows: R,
        each: impl Fn(&mut B, R::Row, &mut T) + Sync,
    ) -> Vec<T> {
        let nothing = vec![(); written.len()];
        let columns = (&nothing[..], written);
        let (sums, _) = self.along(
            slots,
            columns,
            rows,
            #[inline(always)]
            |(), b, row, sum| each(b, row, sum),
        );
        sums
    }
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
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use std::num::NonZeroUsize;

    use bevy_ecs::system::SystemState;

    use super::*;

    /// Walks on so many threads.
    fn with<T>(threads: usize, walk: impl FnOnce(Walkers<'_>) -> T) -> T {
        let mut world = World::new();
        world.insert_resource(Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap());
        world.init_resource::<Instructions>();
        walk(SystemState::<Walkers>::new(&mut world).get(&world).unwrap())
    }

    #[test]
    fn rows_find_their_entries_in_whatever_order_they_are() {
        let column = [10, 11, 12, 13, 14];
        for slots in [vec![1, 2, 3], vec![3, 2, 1], vec![1, 1, 3], vec![2, u32::MAX, 0], vec![3, 4, 5], vec![]] {
            let slots: Vec<_> = slots.into_iter().map(Slot::at).collect();
            let (mut written, mut seen) = ([0; 5], vec![0; slots.len()]);
            let (sums, run) = with(1, |walkers| {
                walkers.along(&slots, (&column, &mut written), &mut seen[..], |a, b, row, sum: &mut usize| {
                    *b += a;
                    *row = *a;
                    *sum += a;
                })
            });
            assert_eq!(run, (slots == [1, 2, 3].map(Slot::at)).then_some(1..4));
            assert_eq!(sums, [seen.iter().sum::<usize>()]);
            let expected = slots.iter().map(|slot| column.get(slot.index()).copied().unwrap_or(0));
            assert_eq!(seen, expected.collect::<Vec<_>>());
            for (place, sum) in written.iter().enumerate() {
                assert_eq!(*sum, slots.iter().filter(|slot| slot.index() == place).count() * column[place]);
            }
        }
    }

    #[test]
    fn sums_are_those_of_strides_on_any_number_of_threads() {
        let count = u32::try_from(WORTHWHILE * STRIDE + 100).unwrap();
        let slots: Vec<_> = (0..count).map(Slot::at).collect();
        let column: Vec<_> = (0..count).map(|number| 1.0 / f64::from(number + 1)).collect();
        let by_strides: Vec<f64> = column.chunks(STRIDE).map(|stride| stride.iter().sum()).collect();
        for threads in [1, 2, 3] {
            let mut written = vec![0.0; column.len()];
            let (sums, run) = with(threads, |walkers| {
                walkers.along(&slots, (&column, &mut written), &slots[..], |a, b, row, sum: &mut f64| {
                    *b = a * f64::from(u32::try_from(row.index()).unwrap());
                    *sum += a;
                })
            });
            assert_eq!((sums, run), (by_strides.clone(), Some(0..column.len())));
            assert!(written.iter().zip(0u32..).all(|(b, row)| *b == 1.0 / f64::from(row + 1) * f64::from(row)));
        }
    }
}
