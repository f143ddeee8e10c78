//! Species pairs: the same law with other parameters for each pair of species.
//!
//! With n species, the parameters of species a and b are stored at a n + b and again at b n + a. Larger species
//! numbers use the last entry. The kind of law is the same for all pairs and compiled in; only parameters are looked
//! up.

use crate::contact::law::{Bounce, LawComputation, LawRequirements, PairLaw};
use crate::contact::memory::{Memory, MemoryVariable};
use crate::contact::pair::Pair;
use crate::contact::pair_force::PairForce;
use crate::particle::Species;
use crate::space::Space;

/// The laws of all species pairs, all of one kind.
#[derive(Clone, Debug)]
pub struct PairTable<L> {
    species: usize,
    laws: Vec<L>,
}

impl<L> PairTable<L> {
    /// Creates the table of `species` species, at least one. `of` returns the law for species a and b.
    #[must_use]
    pub fn new(species: usize, of: impl Fn(u8, u8) -> L) -> Self {
        let species = species.clamp(1, 256);
        let kinds = || (0..=u8::MAX).take(species);
        let laws = kinds().flat_map(|a| kinds().map(move |b| (a.min(b), a.max(b)))).map(|(a, b)| of(a, b));
        Self { species, laws: laws.collect() }
    }

    #[inline(always)]
    fn of(&self, species: [Species; 2]) -> &L {
        let last = self.species - 1;
        let [a, b] = species.map(|species| usize::from(species.0).min(last));
        &self.laws[a * self.species + b]
    }

    /// Returns the largest value of `figure` over all entries.
    fn largest(&self, figure: impl Fn(&L) -> f64) -> f64 {
        self.laws.iter().map(figure).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<L: LawRequirements> LawRequirements for PairTable<L> {
    const SPIN: bool = L::SPIN;
    const ROLLING: bool = L::ROLLING;
    const SPECIES: bool = true;
    const RADII: bool = L::RADII;
    const MEMORY: &'static [MemoryVariable] = L::MEMORY;
    const PULLS: bool = L::PULLS;
    const REACHES: bool = L::REACHES;
}

impl<V: Space, L: PairLaw<V> + LawRequirements> PairLaw<V> for PairTable<L> {
    #[inline(always)]
    fn force(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        self.of(pair.species).force(pair, memory)
    }

    #[inline(always)]
    fn centred(&self, pair: &Pair<V>, memory: &mut Memory) -> PairForce<V> {
        self.of(pair.species).centred(pair, memory)
    }

    fn depends_on_species(&self) -> bool {
        self.species > 1
    }

    #[inline]
    fn between<C: LawComputation<V>>(&self, species: [Species; 2], computation: C) -> C::Output {
        computation.run(self.of(species))
    }

    fn overlap_without_events(&self) -> f64 {
        self.largest(PairLaw::overlap_without_events)
    }

    fn elastic_energy(&self, pair: &Pair<V>, memory: &Memory) -> f64 {
        self.of(pair.species).elastic_energy(pair, memory)
    }

    fn on_contact_end(&self, pair: &Pair<V>, memory: &Memory) -> [f64; 2] {
        self.of(pair.species).on_contact_end(pair, memory)
    }

    #[inline(always)]
    fn range(&self, pair: &Pair<V>) -> f64 {
        self.of(pair.species).range(pair)
    }

    fn largest_range(&self, reduced_radius: f64) -> f64 {
        self.largest(|law| law.largest_range(reduced_radius))
    }

    fn lost_at_break(&self, pair: &Pair<V>) -> f64 {
        self.of(pair.species).lost_at_break(pair)
    }

    #[inline(always)]
    fn pull(&self, pair: &Pair<V>) -> f64 {
        self.of(pair.species).pull(pair)
    }

    fn needs_mass_root(&self) -> bool {
        self.laws.iter().any(PairLaw::needs_mass_root)
    }

    fn friction(&self, pair: &Pair<V>) -> f64 {
        self.of(pair.species).friction(pair)
    }

    // Estimates take the value that restricts the time step most. Restitution is that of species 0 with itself, because
    // no value is worst.

    fn stiffness(&self, bounce: &Bounce) -> f64 {
        self.largest(|law| law.stiffness(bounce))
    }

    fn damping(&self, bounce: &Bounce) -> f64 {
        self.largest(|law| law.damping(bounce))
    }

    fn deepest(&self, bounce: &Bounce) -> f64 {
        self.largest(|law| law.deepest(bounce))
    }

    fn contact_duration(&self, bounce: &Bounce) -> f64 {
        self.laws.iter().map(|law| law.contact_duration(bounce)).fold(f64::INFINITY, f64::min)
    }

    fn restitution(&self, bounce: &Bounce) -> f64 {
        self.laws[0].restitution(bounce)
    }

    fn modes(&self, bounce: &Bounce) -> [[f64; 2]; 4] {
        let larger = |a: [[f64; 2]; 4], b: [[f64; 2]; 4]| {
            std::array::from_fn(|mode| std::array::from_fn(|figure| f64::max(a[mode][figure], b[mode][figure])))
        };
        self.laws.iter().map(|law| law.modes(bounce)).fold([[f64::NEG_INFINITY; 2]; 4], larger)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::assignment::Assignment;
    use crate::contact::pair::tests::pair;

    #[test]
    fn law_does_not_depend_on_the_order_of_species() {
        let stiffness = |a: u8, b: u8| 1.0 + f64::from(a) + 10.0 * f64::from(b);
        let table =
            PairTable::new(3, |a, b| Assignment::new(stiffness(a, b).try_into().unwrap(), 0.0.try_into().unwrap()));
        let energy = |a: u8, b: u8| {
            let pair = Pair { species: [Species(a), Species(b)], ..pair() };
            table.elastic_energy(&pair, &Memory::default()) / (0.5 * pair.overlap * pair.overlap)
        };
        for (a, b, k) in [(0, 0, 1.0), (0, 2, 21.0), (2, 0, 21.0), (1, 2, 22.0), (2, 2, 23.0), (7, 0, 21.0)] {
            assert!((energy(a, b) - k).abs() < 1e-9, "{a} {b}: {}", energy(a, b));
        }
    }
}
