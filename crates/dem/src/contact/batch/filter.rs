//! Filter of candidates: fills a batch with the pairs that touch, and loads their bodies.
//!
//! Branches on overlap are mispredicted often, so there is none: each candidate is written, and the batch grows only if
//! it counts. With centred contacts ([`centred`](crate::contact::centred)) gaps that may close in half a step count too. A gap takes few
//! instructions with a law without memory, so these laws get all gaps below a margin that no pair of the store exceeds. Laws with
//! memory get the gaps below the sum of the distances that both particles move in half a step.
//!
//! Of the law only its requirements matter here, so the loops are compiled for each space and not for each law.

use crate::contact::batch::Batch;
use crate::contact::batch::bodies::Approach;
use crate::contact::needs::{BodyNumbers, Needs};
use crate::instruction_set::InstructionSet;
use crate::lanes::LANES;
use crate::neighbours::list::Candidate;
use crate::periodic::{Metric, Open};
use crate::space::Space;
use crate::store::{ParticleStore, Prediction};

impl<V: Space> Batch<V> {
    /// Adds candidates that count until the batch is full, and loads their bodies. Returns the candidates that are left.
    pub fn select<'c>(
        &mut self,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        needs: Needs,
        instructions: InstructionSet,
    ) -> &'c [Candidate] {
        match (needs.bodies != BodyNumbers::Sums, needs.memory.is_some() && store.predicts()) {
            (false, false) => self.select_in_sides::<false, false>(store, candidates, instructions),
            (false, true) => self.select_in_sides::<false, true>(store, candidates, instructions),
            (true, false) => self.select_in_sides::<true, false>(store, candidates, instructions),
            (true, true) => self.select_in_sides::<true, true>(store, candidates, instructions),
        }
    }

    fn select_in_sides<'c, const INDIVIDUAL: bool, const SWEPT: bool>(
        &mut self,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        instructions: InstructionSet,
    ) -> &'c [Candidate] {
        match store.periodic {
            None => self.select_by::<INDIVIDUAL, SWEPT>(Open, store, candidates, instructions),
            Some(periodic) => self.select_by::<INDIVIDUAL, SWEPT>(periodic, store, candidates, instructions),
        }
    }

    /// Selects with separations measured by `metric`. Numbers of each body are loaded if `INDIVIDUAL` is set, else sums.
    #[expect(clippy::redundant_locals, reason = "the closure copies captured variables")]
    fn select_by<'c, const INDIVIDUAL: bool, const SWEPT: bool>(
        &mut self,
        metric: impl Metric<V>,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        instructions: InstructionSet,
    ) -> &'c [Candidate] {
        let Prediction { swept, margin, range, .. } = &store.prediction;
        let bodies = &store.body[..];
        let swept = &swept[..];
        let beyond = margin + range;
        instructions.run_narrow(
            #[inline(always)]
            || {
                // Copies: what lies behind a reference would be read anew after every store.
                let metric = metric;
                let bodies = bodies;
                let beyond = beyond;
                // Both slices have one length, so that an index that was checked for one needs no check for the other.
                let swept = if SWEPT { &swept[..bodies.len()] } else { &[] };
                let mut end = self.len;
                let mut left = candidates.iter();
                while end < LANES
                    && let Some(&candidate) = left.next()
                {
                    let [i, j] = candidate.slots();
                    self.pairs[end] = candidate;
                    let Approach { squared, reach } =
                        self.bodies.take::<INDIVIDUAL>(end, &metric, [&bodies[i], &bodies[j]]);
                    let farthest = if SWEPT { swept[i] + swept[j] } else { reach + beyond };
                    // Written so that a NaN does not touch: the finite-value check reports it at the end of the step.
                    end += usize::from(squared < farthest * farthest);
                }
                self.len = end;
                left.as_slice()
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::memory::{MemoryLayout, MemoryVariable, Parity};
    use crate::contact::needs::TorqueClass;
    use crate::space::{Plane, Solid};
    use crate::store::Body;

    /// A law without memory that needs sums, and one with memory that needs the numbers of each body.
    const PLAIN: Needs =
        Needs { torques: TorqueClass::None, memory: None, bodies: BodyNumbers::Sums, species: false, reaches: false };
    const WITH_MEMORY: Needs = Needs {
        memory: Some(MemoryLayout::new::<Plane>(&[MemoryVariable::vector("spring", Parity::Odd)], false)),
        bodies: BodyNumbers::EachWithRadii,
        ..PLAIN
    };

    /// Selects among the pairs of body 0 and each other body, 1 cm in radius each. `others` has the gap to each and its own margin, m.
    /// Body 0 has a margin of 1 mm, and the margin of all pairs is 2 mm. Without `centred` there are no margins.
    fn selected<V: Space>(others: &[[f64; 2]], needs: Needs, centred: bool) -> Vec<usize> {
        let mut store = ParticleStore::<V>::default();
        let axis = V::narrow(Solid::new(0.6, 0.8, 0.0));
        let at = |distance: f64| Body {
            position: axis * distance,
            velocity: V::ZERO,
            radius: 0.01,
            inverse_mass: 1.0,
            middle: V::MiddleInBody::default(),
        };
        store.body.push(at(0.0));
        store.body.extend(others.iter().map(|&[gap, _]| at(0.02 + gap)));
        if centred {
            (store.prediction.velocities_ahead, store.prediction.margin) = (1e-3, 2e-3);
            store.prediction.swept = std::iter::once(1e-3)
                .chain(others.iter().map(|&[_, margin]| margin))
                .map(|margin| 0.01 + margin)
                .collect();
        }
        let candidates: Vec<_> = (1..=others.len()).map(|j| Candidate::of_slots(0, j.try_into().unwrap())).collect();
        let all = InstructionSet::all().into_iter().map(|instructions| {
            let mut batch = Batch::<V>::default();
            let mut left = &candidates[..];
            let mut found = Vec::new();
            while !left.is_empty() {
                left = batch.select(&store, left, needs, instructions);
                assert!(batch.len == LANES || left.is_empty());
                found.extend(batch.pairs[..batch.len].iter().map(|pair| pair.row()));
                batch.len = 0;
            }
            found
        });
        let all: Vec<_> = all.collect();
        assert!(all.iter().all(|found| *found == all[0]));
        all.into_iter().next().unwrap()
    }

    /// A NaN position counts nowhere.
    const OTHERS: [[f64; 2]; 7] =
        [[-1e-3, 0.0], [0.9e-3, 0.0], [1.1e-3, 0.0], [1.9e-3, 1e-3], [2.1e-3, 1e-3], [f64::NAN, 1.0], [3e-3, 3e-3]];

    fn check<V: Space>(needs: Needs, expected: &[usize]) {
        assert_eq!(selected::<V>(&OTHERS, needs, false), [1]);
        assert_eq!(selected::<V>(&OTHERS, needs, true), expected);
        // More than a batch.
        let many: Vec<_> = OTHERS.iter().copied().cycle().take(7 * 40).collect();
        let expected: Vec<_> = (0..40).flat_map(|round| expected.iter().map(move |j| 7 * round + j)).collect();
        assert_eq!(selected::<V>(&many, needs, true), expected);
    }

    #[test]
    fn gaps_count_that_any_pair_closes_or_with_memory_those_that_the_pair_closes() {
        check::<Plane>(PLAIN, &[1, 2, 3, 4]);
        check::<Solid>(PLAIN, &[1, 2, 3, 4]);
        check::<Plane>(WITH_MEMORY, &[1, 2, 4, 7]);
        check::<Solid>(WITH_MEMORY, &[1, 2, 4, 7]);
    }
}
