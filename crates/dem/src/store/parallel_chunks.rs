//! Passes over columns on all threads, in chunks of [`CHUNK`] entries.
//!
//! Each chunk has its own partial sum. The sums therefore do not depend on the number of threads.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::instruction_set::InstructionSet;
use crate::threads::Threads;

/// Entries per chunk.
pub const CHUNK: usize = 128;

/// The smallest number of chunks that is shared among threads. With fewer chunks, sharing saves too little: 2000 particles take 10 us, and
/// handing out takes 1 to 2 us.
const MIN_SHARED_CHUNKS: usize = 16;

/// System parameter of a chunked pass: the threads and the instruction set.
#[derive(SystemParam)]
pub(crate) struct ChunkedPass<'w> {
    threads: Res<'w, Threads>,
    instructions: Res<'w, InstructionSet>,
}

/// Columns of equal length: a slice that a pass writes, one that it reads, or a pair of columns.
pub(crate) trait Columns: Sized + Send {
    /// The entries of one particle.
    type Entries;

    /// Returns consecutive parts of `size` entries; the last may be shorter.
    fn parts(self, size: usize) -> impl Iterator<Item = Self>;

    /// Returns the entries particle by particle.
    fn entries(self) -> impl Iterator<Item = Self::Entries>;
}

impl<'a, T: Send> Columns for &'a mut [T] {
    type Entries = &'a mut T;

    #[inline(always)]
    fn parts(self, size: usize) -> impl Iterator<Item = Self> {
        self.chunks_mut(size)
    }

    #[inline(always)]
    fn entries(self) -> impl Iterator<Item = &'a mut T> {
        self.iter_mut()
    }
}

impl<'a, T: Sync> Columns for &'a [T] {
    type Entries = &'a T;

    #[inline(always)]
    fn parts(self, size: usize) -> impl Iterator<Item = Self> {
        self.chunks(size)
    }

    #[inline(always)]
    fn entries(self) -> impl Iterator<Item = &'a T> {
        self.iter()
    }
}

impl<A: Columns, B: Columns> Columns for (A, B) {
    type Entries = (A::Entries, B::Entries);

    #[inline(always)]
    fn parts(self, size: usize) -> impl Iterator<Item = Self> {
        self.0.parts(size).zip(self.1.parts(size))
    }

    #[inline(always)]
    fn entries(self) -> impl Iterator<Item = Self::Entries> {
        self.0.entries().zip(self.1.entries())
    }
}

impl ChunkedPass<'_> {
    /// Calls `each` with the entries of the read and the written columns and the partial sum of the chunk. Returns the partial
    /// sums, in the order of chunks. A column that is not needed may hold `()`, which takes no memory.
    #[expect(clippy::redundant_locals, reason = "the inner closure copies what it captures")]
    pub(crate) fn in_chunks<A: Sync, C: Columns, T: Default + Send>(
        &self,
        read: &[A],
        written: C,
        each: impl Fn(&A, C::Entries, &mut T) + Copy + Sync,
    ) -> Vec<T> {
        let instructions = *self.instructions;
        self.by_chunks(read, written, |read, written| {
            instructions.run_narrow(
                #[inline(always)]
                || {
                    // A copy: what lies behind a reference would be read anew after every store.
                    let each = each;
                    let mut sum = T::default();
                    for (one, entries) in read.iter().zip(written.entries()) {
                        each(one, entries, &mut sum);
                    }
                    sum
                },
            )
        })
    }

    /// Calls `each` with whole chunks of the read and the written columns. Returns its results, in the order of chunks.
    pub(crate) fn by_chunks<A: Sync, C: Columns, T: Send>(
        &self,
        read: &[A],
        written: C,
        each: impl Fn(&[A], C) -> T + Sync,
    ) -> Vec<T> {
        let in_chunks = |read: &[A], written: C| -> Vec<T> {
            read.chunks(CHUNK).zip(written.parts(CHUNK)).map(|(read, written)| each(read, written)).collect()
        };
        let chunks = read.len().div_ceil(CHUNK);
        let threads = self.threads.count();
        if threads == 1 || chunks < MIN_SHARED_CHUNKS {
            return in_chunks(read, written);
        }
        let share = chunks.div_ceil(threads) * CHUNK;
        let shares = read.chunks(share).zip(written.parts(share));
        let shares = shares.map(|(read, written)| || in_chunks(read, written));
        self.threads.share(shares).into_iter().flatten().collect()
    }

    /// The instruction set.
    pub(crate) fn instructions(&self) -> InstructionSet {
        *self.instructions
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
        world.init_resource::<InstructionSet>();
        pass(SystemState::<ChunkedPass>::new(&mut world).get(&world).unwrap())
    }

    #[test]
    fn sums_are_chunk_sums_on_any_number_of_threads() {
        let count = u32::try_from(MIN_SHARED_CHUNKS * CHUNK + 100).unwrap();
        let column: Vec<_> = (0..count).map(|number| 1.0 / f64::from(number + 1)).collect();
        let by_chunks: Vec<f64> = column.chunks(CHUNK).map(|chunk| chunk.iter().sum()).collect();
        for threads in [1, 2, 3] {
            let mut written = vec![1.0; column.len()];
            let mut also = vec![1.0; column.len()];
            let sums = with_threads(threads, |chunked| {
                chunked.in_chunks(&column, (&mut written[..], &mut also[..]), |a, (b, c), sum: &mut f64| {
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
