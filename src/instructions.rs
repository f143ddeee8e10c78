//! Which instructions the lanes of the force pass are computed with: those that every processor of the kind has, or
//! AVX2 or AVX-512 where they are found at run time.
//!
//! The same source is compiled for each, so they do the same operations in the same order: additions, multiplications,
//! divisions and roots as IEEE 754 has them, never fused. The bits are the same; `tests/program/searches.rs` forces each.

use bevy_ecs::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx2, Avx512, Level, Simd};

/// One of the ways to compute.
#[derive(Resource, Clone, Copy, Debug)]
pub enum Instructions {
    /// What the program was compiled for.
    Baseline,
    /// AVX2, four lanes at a time.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// AVX-512, eight lanes at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Default for Instructions {
    /// The widest.
    fn default() -> Self {
        Self::all().pop().unwrap_or(Self::Baseline)
    }
}

impl Instructions {
    /// All that this machine can do, the widest last.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(Level::new().as_avx2().map(Self::Avx2));
            all.extend(Level::new().as_avx512().map(Self::Avx512));
        }
        all
    }

    /// Runs `work` with them: all of it that is inlined is compiled for them.
    #[inline]
    pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
        match self {
            Self::Baseline => work(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(avx2) => avx2.vectorize(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(avx512) => avx512.vectorize(work),
        }
    }

    /// The same, with AVX2 at most: where a vector or two lie side by side, wider ones would have to be put together.
    #[inline]
    pub fn run_narrow<R>(self, work: impl FnOnce() -> R) -> R {
        #[cfg(target_arch = "x86_64")]
        if let Self::Avx512(avx512) = self
            && let Some(avx2) = avx512.level().as_avx2()
        {
            return avx2.vectorize(work);
        }
        self.run(work)
    }
}
