//! The instruction set for the lanes of the force pass: the baseline of the processor family, or AVX2 or AVX-512 if
//! found at run time.
//!
//! One source is compiled for each set, so all sets do the same operations in the same order. Additions,
//! multiplications, divisions and roots follow IEEE 754 and are never fused. The results are equal to the last bit;
//! `tests/program/searches.rs` runs every set.
//!
//! A run uses the widest set of its processor. The environment variable [`VARIABLE`], `SILOFLOW_INSTRUCTIONS`, forces
//! `baseline`, `avx2` or `avx512` instead. Another word, or a set that the processor lacks, is an error of the run. An
//! empty variable counts as not set.

use std::env;

use bevy_ecs::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Avx2, Avx512, Level, Simd};

use siloflow_text::fault::Fault;

/// The environment variable that forces an instruction set by its [`InstructionSet::name`].
pub const VARIABLE: &str = "SILOFLOW_INSTRUCTIONS";

/// Names of all sets, including those that a processor may lack.
const NAMES: [&str; 3] = ["baseline", "avx2", "avx512"];

/// An instruction set.
#[derive(Resource, Clone, Copy, Debug)]
pub enum InstructionSet {
    /// The instructions that the program was compiled for.
    Baseline,
    /// AVX2, four lanes at a time.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    /// AVX-512, eight lanes at a time.
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Default for InstructionSet {
    /// The widest set of this machine.
    fn default() -> Self {
        Self::all().pop().unwrap_or(Self::Baseline)
    }
}

impl InstructionSet {
    /// All sets of this machine, the widest last.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let baseline = std::iter::once(Self::Baseline);
        #[cfg(target_arch = "x86_64")]
        let baseline = {
            let level = Level::new();
            let wider = [level.as_avx2().map(Self::Avx2), level.as_avx512().map(Self::Avx512)];
            baseline.chain(wider.into_iter().flatten())
        };
        baseline.collect()
    }

    /// The word for this set in [`VARIABLE`].
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

    /// Returns the set that [`VARIABLE`] names, or the widest if the variable is not set.
    ///
    /// # Errors
    /// As [`InstructionSet::named`].
    pub fn of_environment() -> Result<Self, Fault> {
        match env::var_os(VARIABLE).filter(|value| !value.is_empty()) {
            None => Ok(Self::default()),
            Some(value) => Self::named(&value.to_string_lossy()),
        }
    }

    /// Returns the set with this name.
    ///
    /// # Errors
    /// If no set has this name, or this machine lacks it.
    pub fn named(name: &str) -> Result<Self, Fault> {
        let all = Self::all();
        all.iter().copied().find(|instructions| instructions.name() == name).ok_or_else(|| {
            let expected = NAMES.join(", ");
            let why = if NAMES.contains(&name) {
                "this processor lacks this instruction set"
            } else {
                "there is no such instruction set"
            };
            let here: Vec<_> = all.iter().map(|instructions| instructions.name()).collect();
            Fault::new("call::instructions", format!("{VARIABLE} is `{name}`: {why}; expected one of {expected}"))
                .help(format!("this processor has {}; without {VARIABLE} the widest set is used", here.join(", ")))
        })
    }

    /// Runs `work` with this instruction set: all code inlined into `work` is compiled for it.
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

    /// Like [`InstructionSet::run`], with AVX2 at most. It suits code that handles one or two vectors at a time, where
    /// wider registers would have to be assembled from several vectors.
    #[inline]
    pub fn run_narrow<R>(self, work: impl FnOnce() -> R) -> R {
        // `work` is not compiled for AVX-512.
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = match self {
            Self::Baseline => None,
            Self::Avx2(avx2) => Some(avx2),
            Self::Avx512(avx512) => avx512.level().as_avx2(),
        } {
            return avx2.vectorize(work);
        }
        work()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_is_found_by_its_name() {
        for instructions in InstructionSet::all() {
            assert_eq!(InstructionSet::named(instructions.name()).unwrap().name(), instructions.name());
        }
    }

    #[test]
    fn an_unknown_name_is_a_fault() {
        for name in ["", "AVX2", "sse2", "avx2 "] {
            let fault = InstructionSet::named(name).unwrap_err();
            assert_eq!(fault.code(), "call::instructions");
            let message = fault.to_string();
            assert!(message.contains(VARIABLE) && message.contains(&format!("`{name}`")), "{message}");
            assert!(NAMES.iter().all(|known| message.contains(known)), "{message}");
        }
    }
}
