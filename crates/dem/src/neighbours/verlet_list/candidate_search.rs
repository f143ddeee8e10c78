//! Search for all pairs that belong on a Verlet list, by hashed cells.
//!
//! A particle is slow if its allowance is at most the skin. A cell is wide enough that two slow particles that belong on the list are in adjacent
//! cells. A slow particle visits half of them: two particles in different cells are found from one of the two, those in one cell from the higher
//! slot. In a periodic box of fewer than three cells it visits all, and each pair is found from its higher slot. A fast particle searches more
//! cells, and finds all its pairs with slow ones. If most particles are fast, all of them count as slow and cells are wider; the result is the
//! same. Threads divide the rows among them.
//!
//! Most particles of adjacent cells are too far away, and no processor predicts which. So the distances to the particles of a row of cells are
//! tested one after the other without a branch, with positions in the order of cells. All other conditions are tested for those that are near.

use crate::neighbours::cells::{Cells, MAX_REACH};
use crate::neighbours::range::contact_range;
use crate::neighbours::verlet_list::anchors::{Anchors, Ball, may_be_listed};
use crate::neighbours::verlet_list::found_pairs::FoundPairs;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;

/// Particles whose distances are tested without a branch.
const CHUNK: usize = 16;

/// One search.
pub(super) struct CandidateSearch<'a, V: Space> {
    anchors: &'a Anchors<V>,
    store: &'a ParticleStore<V>,
    /// Largest distance at which two particles touch, m.
    range: f64,
    /// Largest allowance, m.
    widest: f64,
    /// Largest allowance of a slow particle, m.
    slow: f64,
    cells: Cells<V>,
    /// The balls of all particles, in the order of the entries of `cells`.
    balls: Vec<Ball<V>>,
    /// Whether slow particles visit half of the cells around them.
    halves: bool,
}

impl<'a, V: Space> CandidateSearch<'a, V> {
    /// Prepares a search among the particles of `store`. Their anchors must be set.
    pub(super) fn new(anchors: &'a Anchors<V>, store: &'a ParticleStore<V>) -> Self {
        let widest = anchors.all.iter().map(|anchor| anchor.allowance).fold(0.0, f64::max);
        let cells = Cells::new(f64::MIN_POSITIVE, store.periodic);
        let range = contact_range(store);
        let balls = Vec::new();
        let mut search = Self { anchors, store, range, widest, slow: anchors.skin, cells, balls, halves: false };
        if search.all_are_slow() {
            search.slow = widest;
        }
        search.cells = Cells::new(search.side().max(f64::MIN_POSITIVE), store.periodic);
        search.cells.fill(store.body.iter().map(|body| body.position));
        let balls = search.cells.entries().iter().map(|&j| anchors.ball(store, j as usize));
        search.balls = balls.collect();
        search.halves = search.cells.can_be_halved();
        search
    }

    /// Returns the cell side, m. Two slow particles that belong on the list are in adjacent cells.
    #[inline]
    fn side(&self) -> f64 {
        self.range + 2.0 * self.slow
    }

    #[inline]
    fn is_fast(&self, i: usize) -> bool {
        self.anchors.all[i].allowance > self.slow
    }

    /// Returns the search radius of particle `i` in cells.
    #[inline]
    fn reach(&self, i: usize) -> f64 {
        if self.is_fast(i) {
            ((self.range + self.anchors.all[i].allowance + self.widest) / self.side()).ceil()
        } else {
            1.0
        }
    }

    /// Returns whether a search costs less if all particles count as slow.
    ///
    /// The cost of one particle's search is proportional to the number of particles in the cells it visits, so to their
    /// volume. A slow particle skips higher slots.
    fn all_are_slow(&self) -> bool {
        let volume = |across: f64| (0..V::COMPONENTS).map(|_| across).product::<f64>();
        let cost_if_all_slow = volume(3.0 * (self.range + 2.0 * self.widest));
        let saved = (0..self.store.len()).map(|i| {
            let visited = volume((2.0 * self.reach(i) + 1.0) * self.side());
            if self.is_fast(i) { 2.0 * visited - cost_if_all_slow } else { visited - cost_if_all_slow }
        });
        // False if the sum is NaN.
        saved.sum::<f64>() > 0.0
    }

    /// Returns all pairs, each once, in one part per job. `expected` is an estimate of their number.
    pub(super) fn pairs(&self, expected: usize, threads: &Threads) -> Vec<FoundPairs> {
        FoundPairs::search(self.store.len(), expected, threads, |i, partners| self.find_partners(i, partners))
    }

    /// Adds the partners of particle `i` to `partners`.
    #[inline]
    fn find_partners(&self, i: u32, partners: &mut Vec<u32>) {
        let row = i as usize;
        let fast = self.is_fast(row);
        let halves = self.halves && !fast;
        // A pair of equal speed class is found once, a mixed pair by its fast member.
        let is_own = |j: u32| {
            if fast == self.is_fast(j as usize) {
                j < i || (halves && !self.cells.share_cell(row, j as usize))
            } else {
                fast
            }
        };
        let accepts = |j: u32| is_own(j) && may_be_listed(self.store, row, j as usize);
        let reach = self.reach(row);
        // For a large search radius, testing all particles costs no more.
        if reach > f64::from(MAX_REACH) {
            let near = |j: &u32| self.anchors.are_near(self.store, row, *j as usize);
            partners.extend((0u32..).take(self.store.len()).filter(|&j| is_own(j)).filter(near));
            return;
        }
        let ball = self.anchors.ball(self.store, row);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most eight")]
        let reach = reach as u8;
        self.cells.entries_around(row, reach, halves, |entries| {
            let balls = self.balls[entries.places.clone()].chunks(CHUNK);
            let slots = self.cells.entries()[entries.places.clone()].chunks(CHUNK);
            for (balls, slots) in balls.zip(slots) {
                let mut near = [0; CHUNK];
                let mut count = 0;
                for (other, &j) in balls.iter().zip(slots) {
                    // The next one overwrites it unless it is near.
                    near[count] = j;
                    count += usize::from(ball.meets(other, self.store));
                }
                partners.extend(near[..count].iter().filter(|&&j| self.cells.have(&entries, j) && accepts(j)));
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use proptest::prelude::*;

    use super::*;
    use crate::neighbours::list::{Candidate, PairList};
    use crate::neighbours::verlet_list::VerletList;
    use crate::particle::GrainId;
    use crate::periodic::{Periodic, PeriodicSides};
    use crate::space::Solid;
    use crate::store::Body;

    const SKIN: f64 = 0.1;
    const DT: f64 = 1e-3;

    /// Makes spheres at positions (x, y, z) in m with a speed in m/s. The last five are fixed. A periodic box is so long along x and y, m, and
    /// positions in it are multiples of that length.
    fn store(particles: &[(f64, f64, f64, f64)], box_length: Option<f64>) -> ParticleStore<Solid> {
        let stretch = box_length.unwrap_or(1.0);
        let body = |&(x, y, z, speed): &(f64, f64, f64, f64)| Body {
            position: Solid::new(stretch * x, stretch * y, z),
            velocity: Solid::new(0.0, speed, 0.0),
            radius: 0.05 + 0.02 * x,
            inverse_mass: 1.0,
            middle: (),
        };
        let side = Some((0.0, stretch));
        let sides = PeriodicSides { x: side, y: side, z: None };
        ParticleStore {
            id: (0u32..).zip(particles).filter_map(|(number, _)| GrainId::grain(number)).collect(),
            body: particles.iter().map(body).collect(),
            free_end: particles.len() - 5,
            periodic: box_length.and_then(|_| Periodic::new(&sides)),
            ..ParticleStore::default()
        }
    }

    fn check(store: &ParticleStore<Solid>, threads: usize) {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let mut verlet = VerletList::new(SKIN);
        let mut list = PairList::default();
        verlet.renew(store, &mut list, DT, &threads);
        let pairs = (0u32..).take(store.len()).flat_map(|j| (0..j).map(move |i| Candidate::of_slots(i, j)));
        let mut near: Vec<_> =
            pairs.filter(|pair| verlet.anchors.are_near(store, pair.partner(), pair.row())).collect();
        near.sort_unstable();
        assert_eq!(list.pairs(), near);
    }

    proptest! {
        /// Some spheres rest; others are so fast that they search many cells, or all particles. A periodic box is one to some cells wide.
        #[test]
        fn all_near_pairs_are_found(
            particles in prop::collection::vec((0.0..1.0, 0.0..1.0, 0.0..1.0, prop_oneof![Just(0.0), 0.0..10.0, 0.0..100.0]), 30),
            box_length in prop::option::of(0.3..3.0),
        ) {
            check(&store(&particles, box_length), 1);
        }
    }

    /// Makes a lattice of 2744 spheres; the first `how_many` fly at `speed` (m/s).
    fn flying(speed: f64, how_many: usize) -> ParticleStore<Solid> {
        let place = |number: u32| 0.07 * f64::from(number);
        let place = |number: u32| (place(number % 14), place(number / 14 % 14), place(number / 196));
        let particles = (0..2744).zip(0..).map(|(number, count)| {
            let (x, y, z) = place(number);
            (x, y, z, if count < how_many { speed } else { 0.0 })
        });
        store(&particles.collect::<Vec<_>>(), None)
    }

    #[test]
    fn cells_are_wider_if_most_fly_and_no_pair_is_missed() {
        let speed = 4.0 * SKIN / (25.0 * DT);
        for (count, wide) in [(0, false), (3, false), (2739, true)] {
            let store = flying(speed, count);
            let mut verlet = VerletList::new(SKIN);
            verlet.renew(&store, &mut PairList::default(), DT, &Threads::one());
            assert_eq!(CandidateSearch::new(&verlet.anchors, &store).slow > SKIN, wide, "{count}");
            for threads in [1, 2] {
                check(&store, threads);
            }
        }
    }
}
