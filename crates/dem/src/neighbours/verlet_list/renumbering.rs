//! Updates a Verlet list without a search when a few particles enter, leave or use up their allowances. While a silo
//! fills or discharges, this is a frequent reason to change the list.
//!
//! After a renumbering, pairs are mapped to the new slots. Pairs of particles that left, or that changed their identity
//! ([`ParticleStore::same_before`]), are dropped. All other particles keep their allowances. Each newcomer gets a new
//! allowance and is tested against all particles. Each particle that used up its allowance is treated likewise.

use std::ops::Range;

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::ROWS_PER_THREAD;
use crate::neighbours::list::{Candidate, PairList};
use crate::neighbours::verlet_list::VerletList;
use crate::neighbours::verlet_list::anchors::Anchor;
use crate::space::Space;
use crate::store::{ParticleStore, Slot};
use crate::threads::Threads;

/// Fewest pairs of a thread.
const PAIRS_PER_THREAD: usize = 8 * ROWS_PER_THREAD;

/// Largest number of particles that are updated singly. In `silo1` a search takes as many instructions as some hundred
/// tests of one particle against all others, and it renews all allowances.
const MAX_UPDATES: usize = 16;

impl<V: Space> VerletList<V> {
    /// Maps `list` to the slots just assigned in `store`; `dt` is the time step, s. Returns false, and changes nothing,
    /// if there are too many newcomers.
    pub(in crate::neighbours) fn apply_renumbering(
        &mut self,
        store: &ParticleStore<V>,
        list: &mut PairList,
        dt: f64,
        threads: &Threads,
    ) -> bool {
        let former: Vec<_> = (0..store.len()).map(|i| store.same_before(i)).collect();
        let entries = || (0u32..).zip(&former);
        let known = |former: &Slot| self.anchors.all.get(former.index());
        let newcomers: Vec<_> = entries().filter(|(_, former)| known(former).is_none()).map(|(i, _)| i).collect();
        if newcomers.len() > MAX_UPDATES {
            return false;
        }
        let mut places = vec![None; self.anchors.all.len()];
        for (i, former) in entries() {
            if let Some(place) = places.get_mut(former.index()) {
                *place = Some(i);
            }
        }
        let moved = |pair: &Candidate| match pair.slots().map(|former| places[former]) {
            [Some(i), Some(j)] => Some(Candidate::of_slots(i, j)),
            _ => None,
        };
        let kept = chosen_pairs(list.pairs(), threads, moved);
        let anchors = former.iter().zip(&store.body);
        let anchors =
            anchors.map(|(former, body)| known(former).copied().unwrap_or(Anchor::of(body, self.anchors.skin, dt)));
        self.anchors.all = anchors.collect();
        self.add_pairs_of(store, list, kept, &newcomers, threads);
        true
    }

    /// Renews the pairs of the particles in `exhausted`, unless there are too many; `dt` is the time step, s. Returns
    /// whether it did.
    pub(in crate::neighbours) fn renew_particles(
        &mut self,
        store: &ParticleStore<V>,
        list: &mut PairList,
        exhausted: &[u32],
        dt: f64,
        threads: &Threads,
    ) -> bool {
        if exhausted.len() > MAX_UPDATES {
            return false;
        }
        let mut is_exhausted = vec![false; store.len()];
        for i in exhausted.iter().map(|&i| i as usize) {
            is_exhausted[i] = true;
            self.anchors.all[i] = Anchor::of(&store.body[i], self.anchors.skin, dt);
        }
        let of_others = |pair: &Candidate| (!pair.slots().iter().any(|&i| is_exhausted[i])).then_some(*pair);
        let others = chosen_pairs(list.pairs(), threads, of_others);
        self.add_pairs_of(store, list, others, exhausted, threads);
        true
    }

    /// Makes `pairs` and the pairs of `newcomers` the list. The anchors of newcomers must be set.
    fn add_pairs_of(
        &mut self,
        store: &ParticleStore<V>,
        list: &mut PairList,
        mut pairs: Vec<Vec<Candidate>>,
        newcomers: &[u32],
        threads: &Threads,
    ) {
        let anchors = &self.anchors;
        let partners = |(position, &new): (usize, &u32), rows: Range<usize>| {
            let near = rows.filter(|&j| anchors.are_near(store, new as usize, j)).filter_map(|j| u32::try_from(j).ok());
            let near = near.filter(|j| !newcomers[..=position].contains(j));
            near.map(|j| Candidate::of_slots(new, j)).collect::<Vec<_>>()
        };
        let added = threads.share_rows(0..store.len(), ROWS_PER_THREAD, |rows| {
            newcomers.iter().enumerate().flat_map(|newcomer| partners(newcomer, rows.clone())).collect::<Vec<_>>()
        });
        pairs.extend(added);
        list.replace(&pairs);
        self.trigger = DisplacementTrigger::default();
    }
}

/// Returns the results of `choose` for all pairs, in their order, in parts.
fn chosen_pairs(
    pairs: &[Candidate],
    threads: &Threads,
    choose: impl Fn(&Candidate) -> Option<Candidate> + Sync,
) -> Vec<Vec<Candidate>> {
    threads.share_rows(0..pairs.len(), PAIRS_PER_THREAD, |part| {
        let mut chosen = Vec::with_capacity(part.len());
        chosen.extend(pairs[part].iter().filter_map(&choose));
        chosen
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::GrainId;
    use crate::space::Plane;
    use crate::store::Body;
    use proptest::prelude::*;

    const SKIN: f64 = 0.1;

    /// Makes discs at `places` (m), the last `fixed` of them fixed, with the previous slots `former`.
    fn store(places: &[(f64, f64)], fixed: usize, former: Vec<Slot>) -> ParticleStore {
        let body = |&(x, y): &(f64, f64)| {
            let radius = 0.05 + 0.02 * x;
            Body {
                position: Plane::new(x, y),
                velocity: Plane::new(y, 0.1),
                radius,
                inverse_mass: 1.0,
                middle: Plane::ZERO,
            }
        };
        let id = (0u32..).zip(places).filter_map(|(number, _)| GrainId::grain(number)).collect();
        let body = places.iter().map(body).collect();
        ParticleStore { id, body, former, free_end: places.len() - fixed, ..ParticleStore::default() }
    }

    proptest! {
        /// Of 30 discs, the last five of them fixed, some leave, the others change slots, and new ones enter.
        #[test]
        fn no_near_pair_is_missed_after_renumbering(
            places in prop::collection::vec((0.0..1.0, 0.0..1.0), 30),
            leaving in prop::collection::vec(0u32..30, 0..6),
            coming in prop::collection::vec((0.0..1.0, 0.0..1.0), 0..4),
            turn in 0usize..20,
        ) {
            let before = store(&places, 5, vec![Slot::default(); 30]);
            let mut verlet = VerletList::new(SKIN);
            let mut list = PairList::default();
            verlet.renew(&before, &mut list, 1e-3, &Threads::one());
            let stays = |former: &u32| !leaving.contains(former);
            let mut former: Vec<_> = (0u32..25).filter(stays).map(Slot::new).collect();
            former.extend(coming.iter().map(|_| Slot::default()));
            let turn = turn.min(former.len());
            former.rotate_left(turn);
            let free = former.len();
            former.extend((25u32..30).filter(stays).map(Slot::new));
            let mut newcomers = coming.iter().copied();
            let place = |former: &Slot| places.get(former.index()).copied().or_else(|| newcomers.next());
            let places: Vec<_> = former.iter().map_while(place).collect();
            let fixed = places.len() - free;
            let after = store(&places, fixed, former);
            prop_assert!(verlet.apply_renumbering(&after, &mut list, 1e-3, &Threads::one()));
            prop_assert!(verlet.exhausted(&after, &Threads::one()).is_empty());
            let mut whole = PairList::default();
            VerletList::new(SKIN).renew(&after, &mut whole, 1e-3, &Threads::one());
            // No disc has moved, so the list must equal the result of a search.
            prop_assert_eq!(list.pairs(), whole.pairs());
        }
    }

    proptest! {
        /// Some discs move beyond their allowances, the others about half as far as they may.
        #[test]
        fn no_pair_is_missed_by_exhausted_particles(
            places in prop::collection::vec((0.0..1.0, 0.0..1.0), 30),
            far in prop::collection::vec((0usize..30, -0.3..0.3, -0.3..0.3), 0..8),
            ways in prop::collection::vec(0.0..std::f64::consts::TAU, 30),
        ) {
            let before = store(&places, 5, vec![Slot::default(); 30]);
            let mut verlet = VerletList::new(SKIN);
            let mut list = PairList::default();
            verlet.renew(&before, &mut list, 1e-3, &Threads::one());
            let mut after = before;
            for (body, way) in after.body.iter_mut().zip(ways) {
                body.position += 0.24 * SKIN * Plane::from_angle(way);
            }
            for (i, x, y) in far {
                after.body[i].position += Plane::new(x, y);
            }
            let exhausted = verlet.exhausted(&after, &Threads::one());
            prop_assert!(exhausted.is_empty() || verlet.renew_particles(&after, &mut list, &exhausted, 1e-3, &Threads::one()));
            prop_assert!(verlet.exhausted(&after, &Threads::one()).is_empty());
            prop_assert!(list.pairs().is_sorted_by(|one, next| one < next));
            for j in 0..30 {
                for i in 0..j.min(25) {
                    let pair = Candidate::of_slots(i, j);
                    prop_assert!(!after.may_touch(i as usize, j as usize) || list.pairs().contains(&pair), "{:?}", pair);
                }
            }
        }
    }

    #[test]
    fn too_many_newcomers_need_a_search() {
        let places: Vec<_> = (0..20).map(|number| (0.1 * f64::from(number), 0.0)).collect();
        let mut verlet = VerletList::new(SKIN);
        let mut list = PairList::default();
        let few = store(&places[..MAX_UPDATES], 0, vec![Slot::default(); MAX_UPDATES]);
        let many = store(&places, 0, vec![Slot::default(); 20]);
        assert!(verlet.apply_renumbering(&few, &mut list, 1e-3, &Threads::one()) && !list.pairs().is_empty());
        assert!(!verlet.apply_renumbering(&many, &mut list, 1e-3, &Threads::one()));
        assert!(!verlet.renew_particles(&many, &mut list, &(0..17).collect::<Vec<_>>(), 1e-3, &Threads::one()));
    }
}
