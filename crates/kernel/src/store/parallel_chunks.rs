//! Passes over three columns on all threads, in chunks of [`CHUNK`] entries.
//!
//! Each chunk has its own partial sum. The sums therefore do not depend on the number of threads.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::instructions::Instructions;
use crate::threads::Threads;

/// Entries per chunk.
pub const CHUNK: usize = 1024;

/// The smallest number of chunks that is shared among threads. With fewer chunks, sharing saves too little.
const MIN_SHARED_CHUNKS: usize = 8;

/// System parameter of a chunked pass: the threads and the instruction set.
#[derive(SystemParam)]
pub(crate) struct ChunkedPass<'w> {
    threads: Res<'w, Threads>,
    instructions: Res<'w, Instructions>,
}

impl ChunkedPass<'_> {
    /// Calls `each` with the entries of all three columns and the partial sum of the chunk. Returns the partial sums, in the
    /// order of chunks. A column that is not needed may hold `()`, which takes no memory.
    pub(crate) fn in_chunks<A: Sync, B: Send, C: Send, T: Default + Send>(
        &self,
        read: &[A],
        (written, also): (&mut [B], &mut [C]),
        each: impl Fn(&A, &mut B, &mut C, &mut T) + Sync,
    ) -> Vec<T> {
        let instructions = *self.instructions;
        let chunk = |((read, written), also): ((&[A], &mut [B]), &mut [C])| {
            instructions.run_narrow(
                #[inline(always)]
                || {
                    let mut sum = T::default();
                    for ((a, b), c) in read.iter().zip(written).zip(also) {
                        each(a, b, c, &mut sum);
                    }
                    sum
                },
            )
        };
        let in_chunks = |read: &[A], written: &mut [B], also: &mut [C]| -> Vec<T> {
            read.chunks(CHUNK).zip(written.chunks_mut(CHUNK)).zip(also.chunks_mut(CHUNK)).map(chunk).collect()
        };
        let (chunks, threads) = (written.len().div_ceil(CHUNK), self.threads.count());
        if threads == 1 || chunks < MIN_SHARED_CHUNKS {
            return in_chunks(read, written, also);
        }
        let share = chunks.div_ceil(threads) * CHUNK;
        let shares = read.chunks(share).zip(written.chunks_mut(share)).zip(also.chunks_mut(share));
        let shares = shares.map(|((read, written), also)| || in_chunks(read, written, also));
        self.threads.share(shares).into_iter().flatten().collect()
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use std::num::NonZeroUsize;

    use bevy_ecs::system::SystemState;

    use super::*;

    /// Runs `pass` with this number of threads.
    fn with_threads<T>(threads: usize, pass: impl FnOnce(ChunkedPass<'_>) -> T) -> T {
        let mut world = World::new();
        world.insert_resource(Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap());
        world.init_resource::<Instructions>();
        pass(SystemState::<ChunkedPass>::new(&mut world).get(&world).unwrap())
    }

    #[test]
    fn sums_are_chunk_sums_on_any_number_of_threads() {
        let count = u32::try_from(MIN_SHARED_CHUNKS * CHUNK + 100).unwrap();
        let column: Vec<_> = (0..count).map(|number| 1.0 / f64::from(number + 1)).collect();
        let by_chunks: Vec<f64> = column.chunks(CHUNK).map(|chunk| chunk.iter().sum()).collect();
        for threads in [1, 2, 3] {
            let (mut written, mut also) = (vec![1.0; column.len()], vec![1.0; column.len()]);
            let sums = with_threads(threads, |chunked| {
                chunked.in_chunks(&column, (&mut written, &mut also), |a, b, c, sum: &mut f64| {
                    *b += a;
                    *c -= a;
                    *sum += a;
                })
            });
            assert_eq!(sums, by_chunks);
            assert!(written.iter().zip(&column).all(|(b, a)| *b == 1.0 + a));
            assert!(also.iter().zip(&column).all(|(c, a)| *c == 1.0 - a));
        }
    }
}
