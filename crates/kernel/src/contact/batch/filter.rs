//! Filter of candidates: fills a batch with the pairs that touch, and loads their bodies.
//!
//! Branches on overlap are mispredicted often, so there is none: each candidate is written, and the batch grows only if
//! it counts. With centred contacts ([`centred`](crate::contact::centred)) gaps that may close in half a step count too. Usually these
//! are all gaps below a margin: no pair of the store closes a wider one. Where a fast particle makes these many, the filter
//! chooses the gaps that the pair itself can close, which costs more for each candidate.
//!
//! Of the law only [`LawRequirements`] matter here, so the loops are compiled for each space and not for each law.

use crate::contact::LawRequirements;
use crate::contact::batch::bodies::Approach;
use crate::contact::batch::{Batch, CLOSED_IN_HALF_STEPS};
use crate::contact::lanes::LANES;
use crate::instructions::Instructions;
use crate::neighbours::list::Candidate;
use crate::periodic::{Metric, Open};
use crate::space::Space;
use crate::store::{ParticleStore, Prediction};

impl<V: Space> Batch<V> {
    /// Adds candidates that count until the batch is full, and loads their bodies. If it `chooses`, the velocities of a pair
    /// decide whether its gap counts. Returns the candidates that are left.
    pub fn select<'c, L: LawRequirements>(
        &mut self,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        chooses: bool,
        instructions: Instructions,
    ) -> &'c [Candidate] {
        match (L::INDIVIDUAL_BODIES, chooses) {
            (false, false) => self.select_in_sides::<false, false>(store, candidates, instructions),
            (false, true) => self.select_in_sides::<false, true>(store, candidates, instructions),
            (true, false) => self.select_in_sides::<true, false>(store, candidates, instructions),
            (true, true) => self.select_in_sides::<true, true>(store, candidates, instructions),
        }
    }

    fn select_in_sides<'c, const INDIVIDUAL: bool, const CHOOSES: bool>(
        &mut self,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        instructions: Instructions,
    ) -> &'c [Candidate] {
        match store.periodic {
            None => self.select_by::<INDIVIDUAL, CHOOSES>(Open, store, candidates, instructions),
            Some(periodic) => self.select_by::<INDIVIDUAL, CHOOSES>(periodic, store, candidates, instructions),
        }
    }

    /// Selects with separations measured by `metric`. `INDIVIDUAL` is [`LawRequirements::INDIVIDUAL_BODIES`].
    fn select_by<'c, const INDIVIDUAL: bool, const CHOOSES: bool>(
        &mut self,
        metric: impl Metric<V>,
        store: &ParticleStore<V>,
        candidates: &'c [Candidate],
        instructions: Instructions,
    ) -> &'c [Candidate] {
        let bodies = &store.body[..];
        let Prediction { lookahead, margin, range, .. } = store.prediction;
        instructions.run_narrow(
            #[inline(always)]
            || {
                // Copies: what lies behind a reference would be read anew after every store.
                let (metric, half, margin, range) = (metric, lookahead, margin, range);
                let (mut end, mut left) = (self.len, candidates.iter());
                while end < LANES
                    && let Some(&candidate) = left.next()
                {
                    let pair = candidate.both().map(|entry| &bodies[entry]);
                    self.pairs[end] = candidate;
                    let Approach { squared, reach, along } = self.bodies.take::<INDIVIDUAL>(end, &metric, pair);
                    let farthest = if CHOOSES {
                        // The squared distance at a gap g is reach^2 + g (reach + distance), and `along` is distance times speed.
                        (reach + range) * (reach + range) + 2.0 * CLOSED_IN_HALF_STEPS * half * along.abs()
                    } else {
                        (reach + range + margin) * (reach + range + margin)
                    };
                    // Written so that a NaN does not touch: the finite-value check reports it at the end of the step.
                    end += usize::from(squared < farthest);
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
    use crate::space::{Plane, Solid};
    use crate::store::Body;

    struct Plain;
    struct WithMemory;

    impl LawRequirements for Plain {
        const RADII: bool = false;
    }
    impl LawRequirements for WithMemory {
        const SPRING: bool = true;
    }

    /// Half a step, s, and the largest gap that any pair closes in it, m.
    const HALF: f64 = 1e-3;
    const MARGIN: f64 = 4e-3;

    /// Selects among the pairs of body 0 and each other body, 1 cm in radius each. `others` has the gap to each (m) and the speed
    /// with which the gap closes (m/s).
    fn selected<V: Space, L: LawRequirements>(others: &[[f64; 2]], half: f64, chooses: bool) -> Vec<usize> {
        let mut store = ParticleStore::<V>::default();
        (store.prediction.lookahead, store.prediction.margin) = (half, if half > 0.0 { MARGIN } else { 0.0 });
        let axis = V::narrow(Solid::new(0.6, 0.8, 0.0));
        let body = |[distance, speed]: [f64; 2]| Body {
            position: axis * distance,
            velocity: axis * -speed,
            radius: 0.01,
            inverse_mass: 1.0,
            middle: V::Inside::default(),
        };
        store.body.push(body([0.0, 0.0]));
        store.body.extend(others.iter().map(|&[gap, speed]| body([0.02 + gap, speed])));
        let candidates: Vec<_> = (1..=others.len()).map(|j| Candidate::new(0, j.try_into().unwrap())).collect();
        let all = Instructions::all().into_iter().map(|instructions| {
            let (mut batch, mut left, mut found) = (Batch::<V>::default(), &candidates[..], Vec::new());
            while !left.is_empty() {
                left = batch.select::<L>(&store, left, chooses, instructions);
                assert!(batch.len == LANES || left.is_empty());
                found.extend(batch.pairs[..batch.len].iter().map(|pair| pair.second()));
                batch.len = 0;
            }
            found
        });
        let all: Vec<_> = all.collect();
        assert!(all.iter().all(|found| *found == all[0]));
        all.into_iter().next().unwrap()
    }

    /// The gaps count that a pair closes within 1.25 half steps, at any sign of the speed; a NaN counts nowhere.
    const OTHERS: [[f64; 2]; 8] = [
        [-1e-3, 0.0],
        [1e-3, 0.9],
        [1e-3, 0.7],
        [1e-3, -0.9],
        [3.9e-3, 0.0],
        [4.1e-3, 1.0],
        [f64::NAN, 0.0],
        [-1e-6, 2.0],
    ];

    fn check<V: Space, L: LawRequirements>() {
        for chooses in [false, true] {
            assert_eq!(selected::<V, L>(&OTHERS, 0.0, chooses), [1, 8]);
        }
        assert_eq!(selected::<V, L>(&OTHERS, HALF, false), [1, 2, 3, 4, 5, 8]);
        assert_eq!(selected::<V, L>(&OTHERS, HALF, true), [1, 2, 4, 8]);
        // More than a batch.
        let many: Vec<_> = OTHERS.iter().copied().cycle().take(8 * 40).collect();
        let expected: Vec<_> = (0..40).flat_map(|round| [1, 2, 4, 8].map(|j| 8 * round + j)).collect();
        assert_eq!(selected::<V, L>(&many, HALF, true), expected);
    }

    #[test]
    fn gaps_count_if_they_may_close_in_half_a_step() {
        check::<Plane, Plain>();
        check::<Solid, Plain>();
        check::<Plane, WithMemory>();
        check::<Solid, WithMemory>();
    }
}
