//! Search for all pairs that belong on a Verlet list, with one grid of cells per size class.
//!
//! A grid whose cells are as wide as the largest pair holds thousands of small grains per cell if sizes differ widely. Here the
//! range of a particle is its radius plus its allowance, s_i = R_i + a_i, and a pair belongs on the list if its centres are closer than
//! s_i + s_j. Class c holds the ranges in (2^-(c+1), 2^-c] times the widest, and its own grid, with cells as wide as twice its widest
//! range, L_c = 2 max s. A particle searches the adjacent cells in its own class and in each wider class. That finds all pairs, because
//! s_i + s_j <= 2 max(s_i, s_j) <= L_c of the wider member. A wide class has few members, so a small grain meets few candidates
//! (hierarchical grids: Ogarko and Luding 2012, Comput. Phys. Commun. 183, 931). Fast particles need no special treatment, because their
//! allowances are wide.
//!
//! The list is the same as that of [`super::candidate_search`]. Limit: the narrowest class holds all ranges below 2^-15 of the widest.

use crate::neighbours::cells::Cells;
use crate::neighbours::range::contact_range;
use crate::neighbours::verlet_list::anchors::Anchors;
use crate::neighbours::verlet_list::found_pairs::FoundPairs;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;

/// Most size classes.
const MOST_CLASSES: usize = 16;

/// Members of a class up to which testing all of them costs less than searching cells.
const FEW: usize = 16;

/// By this share, cells are wider than the widest pair of their class, so that no pair is missed by round-off.
const ROUNDING: f64 = 1e-9;

/// Classes cost less than one grid if its cells hold more particles than a dense packing of equal grains by this factor. Measured:
/// docs/developers/speed-notebook.md.
const WORTHWHILE: f64 = 8.0;

/// Returns whether the sizes of a scene call for classes.
///
/// In a dense bed the number of candidates in a cell of the single grid is proportional to the volume of the cell over the mean volume of a
/// particle, each with the skin. With equal grains the ratio is 1.
pub(super) fn are_worthwhile<V: Space>(store: &ParticleStore<V>, skin: f64) -> bool {
    let volume = |across: f64| (0..V::COMPONENTS).map(|_| across).product::<f64>();
    let sum: f64 = store.body.iter().map(|body| volume(body.radius + 0.5 * skin)).sum();
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^32 particles")]
    let particles = store.len() as f64;
    particles * volume(0.5 * (contact_range(store) + skin)) > WORTHWHILE * sum
}

/// The particles of one class.
struct Class<V: Space> {
    cells: Cells<V>,
    /// Slots, ascending; the cells hold their indices.
    members: Vec<u32>,
}

/// One search.
pub(super) struct SizeClasses<'a, V: Space> {
    anchors: &'a Anchors<V>,
    store: &'a ParticleStore<V>,
    /// The classes that have members, from the widest to the narrowest.
    classes: Vec<Class<V>>,
    /// For each slot: the index of its class in `classes`.
    class_of: Vec<u8>,
}

impl<'a, V: Space> SizeClasses<'a, V> {
    /// Prepares a search among the particles of `store`. Their anchors must be set.
    pub(super) fn new(anchors: &'a Anchors<V>, store: &'a ParticleStore<V>) -> Self {
        let ranges = || store.body.iter().zip(&anchors.all).map(|(body, anchor)| body.radius + anchor.allowance);
        let widest = ranges().fold(0.0, f64::max);
        let mut class_of: Vec<u8> = ranges().map(|range| class_number(range, widest)).collect();
        let mut members = vec![Vec::new(); MOST_CLASSES];
        let mut widths = [f64::MIN_POSITIVE; MOST_CLASSES];
        for ((slot, &class), range) in (0u32..).zip(&class_of).zip(ranges()) {
            members[usize::from(class)].push(slot);
            widths[usize::from(class)] = widths[usize::from(class)].max(range);
        }
        let mut index = [0u8; MOST_CLASSES];
        let mut classes = Vec::new();
        for ((members, width), place) in members.into_iter().zip(widths).zip(&mut index) {
            *place = u8::try_from(classes.len()).expect("at most 16 classes");
            if !members.is_empty() {
                let mut cells = Cells::new(2.0 * width * (1.0 + ROUNDING), store.periodic);
                cells.fill(members.iter().map(|&slot| store.body[slot as usize].position));
                classes.push(Class { cells, members });
            }
        }
        for class in &mut class_of {
            *class = index[usize::from(*class)];
        }
        Self { anchors, store, classes, class_of }
    }

    /// Returns all pairs, each once, in one part per job. `expected` is an estimate of their number.
    pub(super) fn pairs(&self, expected: usize, threads: &Threads) -> Vec<FoundPairs> {
        FoundPairs::search(self.store.len(), expected, threads, |i, partners| self.find_partners(i, partners))
    }

    /// Adds the partners of particle `i` to `partners`.
    fn find_partners(&self, i: u32, partners: &mut Vec<u32>) {
        let row = i as usize;
        let own = usize::from(self.class_of[row]);
        for (number, class) in self.classes[..=own].iter().enumerate() {
            let members = &class.members;
            // A pair of one class is found by its higher slot, a pair of two classes by its narrower member.
            let wants = |k: u32| number < own || members[k as usize] < i;
            let mut consider = |k: u32| {
                let j = members[k as usize];
                if self.anchors.are_near(self.store, row, j as usize) {
                    partners.push(j);
                }
            };
            if members.len() <= FEW {
                (0u32..).take(members.len()).filter(|&k| wants(k)).for_each(&mut consider);
            } else {
                class.cells.around_place(self.store.body[row].position, wants, consider);
            }
        }
    }
}

/// Returns the number of the class of a range. A range that is not a number belongs to the widest class.
fn class_number(range: f64, widest: f64) -> u8 {
    let mut class = 0;
    let mut bound = 0.5 * widest;
    while range <= bound && usize::from(class) + 1 < MOST_CLASSES {
        class += 1;
        bound *= 0.5;
    }
    class
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
    use crate::space::{Plane, Solid};
    use crate::store::Body;

    const SKIN: f64 = 0.01;
    const DT: f64 = 1e-3;

    /// Makes particles at positions (m) with a radius (m) and a speed (m/s). The last `fixed` are fixed.
    fn store<V: Space>(particles: &[(V, f64, f64)], fixed: usize, is_periodic: bool) -> ParticleStore<V> {
        let body = |&(position, radius, speed): &(V, f64, f64)| Body {
            position,
            velocity: V::from_components(|axis| if axis == 0 { speed } else { 0.0 }),
            radius,
            inverse_mass: 1.0,
            middle: V::MiddleInBody::default(),
        };
        let sides = PeriodicSides { x: Some((0.0, 2.0)), ..PeriodicSides::default() };
        ParticleStore {
            id: (0u32..).zip(particles).filter_map(|(number, _)| GrainId::grain(number)).collect(),
            body: particles.iter().map(body).collect(),
            free_end: particles.len() - fixed,
            periodic: Periodic::new(&sides).filter(|_| is_periodic),
            ..ParticleStore::default()
        }
    }

    /// Checks that the classes find the pairs that a comparison of all particles finds, each once.
    fn check<V: Space>(store: &ParticleStore<V>, threads: usize) -> usize {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let mut verlet = VerletList::new(SKIN);
        verlet.renew(store, &mut PairList::default(), DT, &threads);
        let parts = SizeClasses::new(&verlet.anchors, store).pairs(0, &threads);
        let mut found: Vec<_> = parts.iter().flat_map(FoundPairs::pairs).collect();
        found.sort_unstable();
        let pairs = (0u32..).take(store.len()).flat_map(|j| (0..j).map(move |i| Candidate::of_slots(i, j)));
        let mut near: Vec<_> =
            pairs.filter(|pair| verlet.anchors.are_near(store, pair.partner(), pair.row())).collect();
        near.sort_unstable();
        assert_eq!(found, near);
        SizeClasses::new(&verlet.anchors, store).classes.len()
    }

    proptest! {
        /// Radii from 0.003 m to 0.3 m, many of them small; some particles fly.
        #[test]
        fn all_near_pairs_are_found(
            particles in prop::collection::vec(
                ((0.0..2.0, 0.0..2.0, 0.0..2.0), 0.0..1.0, prop_oneof![3 => Just(0.0), 1 => 0.0..30.0]), 6..120),
            fixed in 0usize..6,
            is_periodic in any::<bool>(),
        ) {
            let sized: Vec<_> = particles
                .into_iter()
                .map(|((x, y, z), u, speed)| (Solid::new(x, y, z), 0.003 * 100f64.powf(u * u * u), speed))
                .collect();
            check(&store(&sized, fixed, is_periodic), 1);
            let planar: Vec<(Plane, f64, f64)> = sized.iter().map(|&(x, r, v)| (x.truncate(), r, v)).collect();
            check(&store(&planar, fixed, is_periodic), 1);
        }
    }

    /// A lattice of small spheres around `large` ones of 20 times their radius.
    fn bed(large: u32) -> ParticleStore<Solid> {
        let place = |number: u32| 0.021 * f64::from(number);
        let small = (0..4096u32).map(|n| Solid::new(place(n % 16), place(n / 16 % 16), place(n / 256)));
        let mut all: Vec<_> = small.map(|x| (x, 0.01, 0.0)).collect();
        all.extend((0..large).map(|n| (Solid::new(0.168, 0.168, -0.2 - 0.4 * f64::from(n)), 0.2, 0.0)));
        store(&all, 0, false)
    }

    #[test]
    fn few_large_grains_among_many_small_ones_call_for_classes() {
        for (large, worthwhile) in [(0, false), (1, true), (20, true)] {
            let store = bed(large);
            assert_eq!(are_worthwhile(&store, SKIN), worthwhile, "{large}");
            for threads in [1, 3] {
                assert_eq!(check(&store, threads), 1 + usize::from(large > 0));
            }
        }
        // Nothing to search.
        assert!(!are_worthwhile(&store::<Solid>(&[], 0, false), SKIN));
        assert_eq!(check(&store::<Solid>(&[], 0, false), 1), 0);
    }

    #[test]
    fn classes_halve_the_range() {
        for (range, class) in
            [(1.0, 0), (0.51, 0), (0.5, 1), (0.26, 1), (0.25, 2), (1e-9, 15), (0.0, 15), (f64::NAN, 0)]
        {
            assert_eq!(class_number(range, 1.0), class, "{range}");
        }
    }
}
