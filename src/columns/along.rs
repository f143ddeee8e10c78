//! Walking along two columns, on all threads.
//!
//! [`STRIDE`] entries at a time. What is summed on the way is summed over each stride by itself, so that the number of threads
//! leaves no trace.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::instructions::Instructions;
use crate::threads::Threads;

/// How many entries a thread takes at a time.
pub(crate) const STRIDE: usize = 1024;

/// From how many strides on threads share them: with fewer there is little to save.
const WORTHWHILE: usize = 8;

/// Who walks.
#[derive(SystemParam)]
pub(crate) struct Walkers<'w> {
    threads: Res<'w, Threads>,
    instructions: Res<'w, Instructions>,
}

impl Walkers<'_> {
    /// Calls `each` with the entries of both columns, and with what it sums up. Gives the sums of the strides, in order.
    pub(crate) fn along<A: Sync, B: Send, T: Default + Send>(
        &self,
        read: &[A],
        written: &mut [B],
        each: impl Fn(&A, &mut B, &mut T) + Sync,
    ) -> Vec<T> {
        let instructions = *self.instructions;
        let stride = |(read, written): (&[A], &mut [B])| {
            instructions.run_narrow(
                #[inline(always)]
                || {
                    let mut sum = T::default();
                    for (a, b) in read.iter().zip(written) {
                        each(a, b, &mut sum);
                    }
                    sum
                },
            )
        };
        let along = |read: &[A], written: &mut [B]| -> Vec<T> {
            read.chunks(STRIDE).zip(written.chunks_mut(STRIDE)).map(stride).collect()
        };
        let (strides, threads) = (written.len().div_ceil(STRIDE), self.threads.count());
        if threads == 1 || strides < WORTHWHILE {
            return along(read, written);
        }
        let share = strides.div_ceil(threads) * STRIDE;
        let shares = read.chunks(share).zip(written.chunks_mut(share));
        self.threads.share(shares.map(|(read, written)| || along(read, written))).into_iter().flatten().collect()
    }
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
    fn sums_are_those_of_strides_on_any_number_of_threads() {
        let count = u32::try_from(WORTHWHILE * STRIDE + 100).unwrap();
        let column: Vec<_> = (0..count).map(|number| 1.0 / f64::from(number + 1)).collect();
        let by_strides: Vec<f64> = column.chunks(STRIDE).map(|stride| stride.iter().sum()).collect();
        for threads in [1, 2, 3] {
            let mut written = vec![1.0; column.len()];
            let sums = with(threads, |walkers| {
                walkers.along(&column, &mut written, |a, b, sum: &mut f64| {
                    *b += a;
                    *sum += a;
                })
            });
            assert_eq!(sums, by_strides);
            assert!(written.iter().zip(&column).all(|(b, a)| *b == 1.0 + a));
        }
    }
}
