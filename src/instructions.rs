//! Which instructions the lanes of the force pass are computed with: those that every processor of the kind has, or
//! AVX2 or AVX-512 where they are found at run time.
//!
//! The same source is compiled for each, so they do the same operations in the same order: additions, multiplications,
//! divisions and roots as IEEE 754 has them, never fused. The bits are the same; `tests/program/searches.rs` forces each.
//!
//! A run takes the widest instructions of its processor. The environment variable [`VARIABLE`], `SILOFLOW_INSTRUCTIONS`, forces
//! `baseline`, `avx2` or `avx512` instead. A word that is none of these is an error of the run, and so are instructions that the
//! processor lacks. An empty variable counts as none.

use std::env;

use bevy_ecs::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx2, Avx512, Level, Simd};

use crate::fault::Fault;

/// The environment variable that forces instructions by their [`Instructions::name`].
pub const VARIABLE: &str = "SILOFLOW_INSTRUCTIONS";

/// All names, of instructions that a processor may lack too.
const NAMES: [&str; 3] = ["baseline", "avx2", "avx512"];

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

    /// The word that [`VARIABLE`] has for them.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline => NAMES[0],
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => NAMES[1],
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => NAMES[2],
        }
    }

    /// Those that [`VARIABLE`] names, the widest if it is not set.
    ///
    /// # Errors
    /// As [`Instructions::named`].
    pub fn of_environment() -> Result<Self, Fault> {
        match env::var_os(VARIABLE).filter(|value| !value.is_empty()) {
            None => Ok(Self::default()),
            Some(value) => Self::named(&value.to_string_lossy()),
        }
    }

    /// Those with this name.
    ///
    /// # Errors
    /// If no instructions have this name, or this machine lacks them.
    pub fn named(name: &str) -> Result<Self, Fault> {
        let all = Self::all();
        all.iter().copied().find(|instructions| instructions.name() == name).ok_or_else(|| {
            let expected = NAMES.join(", ");
            let why = if NAMES.contains(&name) {
                "this processor lacks these instructions"
            } else {
                "there are no such instructions"
            };
            let here: Vec<_> = all.iter().map(|instructions| instructions.name()).collect();
            Fault::new("call::instructions", format!("{VARIABLE} is `{name}`: {why}; expected one of {expected}"))
                .help(format!("this processor has {}; without {VARIABLE} the widest are taken", here.join(", ")))
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_found_by_its_name() {
        for instructions in Instructions::all() {
            assert_eq!(Instructions::named(instructions.name()).unwrap().name(), instructions.name());
        }
    }

    #[test]
    fn a_name_that_this_machine_does_not_know_is_a_fault() {
        for name in ["", "AVX2", "sse2", "avx2 "] {
            let fault = Instructions::named(name).unwrap_err();
            assert_eq!(fault.code(), "call::instructions");
            let message = fault.to_string();
            assert!(message.contains(VARIABLE) && message.contains(&format!("`{name}`")), "{message}");
            assert!(NAMES.iter().all(|known| message.contains(known)), "{message}");
        }
    }
}
