//! The search for all pairs that belong on a Verlet list, through hashed cells.
//!
//! Cells are wide enough for two slow particles, which look at the cells next to theirs, the one of higher slot for both; a fast
//! particle looks farther, for all its pairs with slow ones. As slow counts who may move no farther than the skin; or, where
//! most fly, everybody: then cells are wider. What is found is the same. Threads share the rows.

use std::ops::Range;

use crate::neighbours::cells::{Cells, MOST_CELLS};
use crate::neighbours::contact_range;
use crate::neighbours::list::Candidate;
use crate::neighbours::verlet_list::VerletList;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;

/// How many particles a thread takes at a time.
const SHARE: u32 = 1024;

/// A search.
pub(super) struct CandidateSearch<'a, V: Space> {
    verlet: &'a VerletList<V>,
    store: &'a ParticleStore<V>,
    /// The largest distance at which two touch, m.
    range: f64,
    /// The largest allowance, m.
    widest: f64,
    /// The largest of those that count as slow, m.
    slow: f64,
    cells: Cells<V>,
}

impl<'a, V: Space> CandidateSearch<'a, V> {
    /// Among the particles of `store`, whose anchors are cast.
    pub(super) fn new(verlet: &'a VerletList<V>, store: &'a ParticleStore<V>) -> Self {
        let widest = verlet.made_at.iter().map(|anchor| anchor.allowance).fold(0.0, f64::max);
        let cells = Cells::new(f64::MIN_POSITIVE, store.periodic);
        let mut sweep = Self { verlet, store, range: contact_range(store), widest, slow: verlet.skin, cells };
        if sweep.all_are_slow() {
            sweep.slow = widest;
        }
        sweep.cells = Cells::new(sweep.side().max(f64::MIN_POSITIVE), store.periodic);
        sweep.cells.fill(store.body.iter().map(|body| body.position));
        sweep
    }

    /// The side of cells in which two slow ones that are near are at most one apart, m.
    #[inline]
    fn side(&self) -> f64 {
        self.range + 2.0 * self.slow
    }

    #[inline]
    fn is_fast(&self, i: usize) -> bool {
        self.verlet.made_at[i].allowance > self.slow
    }

    /// How many cells far particle `i` looks.
    #[inline]
    fn reach(&self, i: usize) -> f64 {
        if self.is_fast(i) {
            ((self.range + self.verlet.made_at[i].allowance + self.widest) / self.side()).ceil()
        } else {
            1.0
        }
    }

    /// Whether it costs less if everybody counts as slow. A look around takes as long as there are particles in the cells that are
    /// seen, so as their volume; what lies above in slots, a slow one passes over.
    fn all_are_slow(&self) -> bool {
        let volume = |across: f64| (0..V::COMPONENTS).map(|_| across).product::<f64>();
        let instead = volume(3.0 * (self.range + 2.0 * self.widest));
        let saved = (0..self.store.len()).map(|i| {
            let seen = volume((2.0 * self.reach(i) + 1.0) * self.side());
            if self.is_fast(i) { 2.0 * seen - instead } else { seen - instead }
        });
        // Of a NaN this is not true.
        saved.sum::<f64>() > 0.0
    }

    /// All pairs, each once, in parts; about so many.
    pub(super) fn pairs(&self, expected: usize, threads: &Threads) -> Vec<Vec<Candidate>> {
        let particles = u32::try_from(self.store.len()).expect("fewer than 2^32 particles");
        let shares =
            (0..particles).step_by(SHARE as usize).map(|first| first..particles.min(first.saturating_add(SHARE)));
        let of_each = expected.div_ceil(self.store.len().max(1));
        threads.share(shares.map(|rows| move || self.pairs_of(rows, of_each)))
    }

    /// Those that particles of `rows` find, about so many each.
    #[inline]
    fn pairs_of(&self, rows: Range<u32>, of_each: usize) -> Vec<Candidate> {
        let mut pairs = Vec::with_capacity(of_each * rows.len());
        for i in rows {
            let row = i as usize;
            let fast = self.is_fast(row);
            let mut consider = |j: u32| {
                // A pair of one speed class is taken by its upper member, a mixed one by the fast member.
                let mine = if fast == self.is_fast(j as usize) { j < i } else { fast };
                if mine && self.verlet.are_near(self.store, row, j as usize) {
                    pairs.push(Candidate::new(i.min(j), i.max(j)));
                }
            };
            // Beyond a few cells around it, asking everybody is not dearer.
            match (fast, self.reach(row)) {
                (false, _) => self.cells.around(row, 1, |j| j < i, consider),
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most eight")]
                (true, n) if n <= f64::from(MOST_CELLS) => self.cells.around(row, n as u8, |_| true, consider),
                (true, _) => (0u32..).take(self.store.len()).for_each(&mut consider),
            }
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use proptest::prelude::*;

    use super::*;
    use crate::neighbours::list::PairList;
    use crate::particle::GrainId;
    use crate::periodic::{Periodic, PeriodicSides};
    use crate::space::Solid;
    use crate::store::Body;

    const SKIN: f64 = 0.1;
    const DT: f64 = 1e-3;

    /// Spheres at these places (m), the last five fixed, with these speeds (m/s).
    fn store(particles: &[(f64, f64, f64, f64)], is_periodic: bool) -> ParticleStore<Solid> {
        let body = |&(x, y, z, speed): &(f64, f64, f64, f64)| Body {
            position: Solid::new(x, y, z),
            velocity: Solid::new(0.0, speed, 0.0),
            radius: 0.05 + 0.02 * x,
            inverse_mass: 1.0,
        };
        let sides = PeriodicSides { x: Some((0.0, 1.0)), ..PeriodicSides::default() };
        ParticleStore {
            id: (0u32..).zip(particles).filter_map(|(number, _)| GrainId::grain(number)).collect(),
            body: particles.iter().map(body).collect(),
            movable_end: particles.len() - 5,
            periodic: Periodic::new(&sides).filter(|_| is_periodic),
            ..ParticleStore::default()
        }
    }

    fn check(store: &ParticleStore<Solid>, threads: usize) {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
        verlet.renew(store, &mut list, DT, &threads);
        let pairs = (0u32..).take(store.len()).flat_map(|j| (0..j).map(move |i| Candidate::new(i, j)));
        let mut near: Vec<_> = pairs.filter(|pair| verlet.are_near(store, pair.first(), pair.second())).collect();
        near.sort_unstable();
        assert_eq!(list.pairs(), near);
    }

    proptest! {
        /// Some at rest and some so fast that they look cells far, or at everybody.
        #[test]
        fn all_who_are_near_are_found(
            particles in prop::collection::vec((0.0..1.0, 0.0..1.0, 0.0..1.0, prop_oneof![Just(0.0), 0.0..10.0, 0.0..100.0]), 30),
            is_periodic in any::<bool>(),
        ) {
            check(&store(&particles, is_periodic), 1);
        }
    }

    /// A lattice of spheres that fly at this speed (m/s), but for those that are fixed.
    fn flying(speed: f64, how_many: usize) -> ParticleStore<Solid> {
        let place = |number: u32| 0.07 * f64::from(number);
        let place = |number: u32| (place(number % 14), place(number / 14 % 14), place(number / 196));
        let particles = (0..2744).zip(0..).map(|(number, count)| {
            let (x, y, z) = place(number);
            (x, y, z, if count < how_many { speed } else { 0.0 })
        });
        store(&particles.collect::<Vec<_>>(), false)
    }

    #[test]
    fn cells_are_wider_where_most_fly_and_nobody_is_missed() {
        let speed = 4.0 * SKIN / (25.0 * DT);
        for (count, wide) in [(0, false), (3, false), (2739, true)] {
            let store = flying(speed, count);
            let mut verlet = VerletList::new(SKIN);
            verlet.renew(&store, &mut PairList::default(), DT, &Threads::one());
            assert_eq!(CandidateSearch::new(&verlet, &store).slow > SKIN, wide, "{count}");
            for threads in [1, 2] {
                check(&store, threads);
            }
        }
    }
}
