//! A Verlet list keeps up with a few particles that came, left or have used up their allowances, while the many others
//! stay where they are: in filling and discharging that happens far more often than anything else.
//!
//! When slots are dealt out anew, pairs go over to the new ones; those of particles that left, or that are no longer what they
//! were ([`ParticleStore::same_before`]), go. The others' allowances go on as they were. Everybody is asked about each newcomer, who is
//! given an allowance from here on; and so about each that has gone far.

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::list::{Candidate, PairList};
use crate::neighbours::verlet_list::{Anchor, VerletList};
use crate::space::Space;
use crate::store::{ParticleStore, Slot};

/// About more at once nobody is asked: in `silo1` a search takes as many instructions as some hundred of these questions to each
/// particle, and then the list is good for all.
const FEW: usize = 16;

impl<V: Space> VerletList<V> {
    /// Brings `list` to the slots that have just been dealt out in `store`; `dt` is the time step, s. Tells whether it did.
    pub(in crate::neighbours) fn follow(&mut self, store: &ParticleStore<V>, list: &mut PairList, dt: f64) -> bool {
        let former: Vec<_> = (0..store.len()).map(|i| store.same_before(i)).collect();
        let entries = || (0u32..).zip(&former);
        let known = |former: &Slot| self.made_at.get(former.index());
        let newcomers: Vec<_> = entries().filter(|(_, former)| known(former).is_none()).map(|(i, _)| i).collect();
        if newcomers.len() > FEW {
            return false;
        }
        let mut places = vec![None; self.made_at.len()];
        for (i, former) in entries() {
            if let Some(place) = places.get_mut(former.index()) {
                *place = Some(i);
            }
        }
        let followed = list.pairs().iter().filter_map(|pair| match pair.both().map(|former| places[former]) {
            [Some(i), Some(j)] => Some(Candidate::new(i.min(j), i.max(j))),
            _ => None,
        });
        let followed = followed.collect();
        let anchors = former.iter().zip(&store.body);
        let anchors = anchors.map(|(former, body)| known(former).copied().unwrap_or(Anchor::of(body, self.skin, dt)));
        self.made_at = anchors.collect();
        self.admit(store, list, followed, &newcomers);
        true
    }

    /// Brings `list` up to date for those who have gone far, if they are few; `dt` is the time step, s. Tells whether it did.
    pub(in crate::neighbours) fn catch_up(
        &mut self,
        store: &ParticleStore<V>,
        list: &mut PairList,
        far: &[u32],
        dt: f64,
    ) -> bool {
        if far.len() > FEW {
            return false;
        }
        let mut is_far = vec![false; store.len()];
        for i in far.iter().map(|&i| i as usize) {
            is_far[i] = true;
            self.made_at[i] = Anchor::of(&store.body[i], self.skin, dt);
        }
        let others = list.pairs().iter().filter(|pair| !pair.both().iter().any(|&i| is_far[i]));
        let others = others.copied().collect();
        self.admit(store, list, others, far);
        true
    }

    /// Adds to `pairs` those of newcomers, whose anchors are cast, and makes them the list.
    fn admit(&mut self, store: &ParticleStore<V>, list: &mut PairList, mut pairs: Vec<Candidate>, newcomers: &[u32]) {
        for (met, &new) in newcomers.iter().enumerate() {
            let near = (0u32..).take(store.len()).filter(|&j| self.are_near(store, new as usize, j as usize));
            let near = near.filter(|j| !newcomers[..=met].contains(j));
            pairs.extend(near.map(|j| Candidate::new(new.min(j), new.max(j))));
        }
        list.take(&[pairs], store.len());
        self.trigger = DisplacementTrigger::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::GrainId;
    use crate::space::Plane;
    use crate::store::Body;
    use crate::threads::Threads;
    use proptest::prelude::*;

    const SKIN: f64 = 0.1;

    /// Of discs at these places (m), the last ones of them fixed, which had those slots.
    fn store(places: &[(f64, f64)], fixed: usize, former: Vec<Slot>) -> ParticleStore {
        let body = |&(x, y): &(f64, f64)| {
            let radius = 0.05 + 0.02 * x;
            Body { position: Plane::new(x, y), velocity: Plane::new(y, 0.1), radius, inverse_mass: 1.0 }
        };
        let id = (0u32..).zip(places).filter_map(|(number, _)| GrainId::grain(number)).collect();
        let body = places.iter().map(body).collect();
        ParticleStore { id, body, former, movable_end: places.len() - fixed, ..ParticleStore::default() }
    }

    proptest! {
        /// Of 30 discs, the last five of them fixed, some leave, the others change places and some come.
        #[test]
        fn nobody_near_is_missed(
            places in prop::collection::vec((0.0..1.0, 0.0..1.0), 30),
            leaving in prop::collection::vec(0u32..30, 0..6),
            coming in prop::collection::vec((0.0..1.0, 0.0..1.0), 0..4),
            turn in 0usize..20,
        ) {
            let before = store(&places, 5, vec![Slot::default(); 30]);
            let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
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
            prop_assert!(verlet.follow(&after, &mut list, 1e-3));
            prop_assert!(verlet.gone_far(&after).is_empty());
            let mut whole = PairList::default();
            VerletList::new(SKIN).renew(&after, &mut whole, 1e-3, &Threads::one());
            // Nobody has moved: so the list is what a search would find.
            prop_assert_eq!(list.pairs(), whole.pairs());
        }
    }

    proptest! {
        /// Some go beyond their allowances, the others half as far as they may.
        #[test]
        fn nobody_is_missed_by_those_who_went_far(
            places in prop::collection::vec((0.0..1.0, 0.0..1.0), 30),
            far in prop::collection::vec((0usize..30, -0.3..0.3, -0.3..0.3), 0..8),
            ways in prop::collection::vec(0.0..std::f64::consts::TAU, 30),
        ) {
            let before = store(&places, 5, vec![Slot::default(); 30]);
            let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
            verlet.renew(&before, &mut list, 1e-3, &Threads::one());
            let mut after = before;
            for (body, way) in after.body.iter_mut().zip(ways) {
                body.position += 0.24 * SKIN * Plane::from_angle(way);
            }
            for (i, x, y) in far {
                after.body[i].position += Plane::new(x, y);
            }
            let gone_far = verlet.gone_far(&after);
            prop_assert!(gone_far.is_empty() || verlet.catch_up(&after, &mut list, &gone_far, 1e-3));
            prop_assert!(verlet.gone_far(&after).is_empty());
            prop_assert!(list.pairs().is_sorted_by(|one, next| one < next));
            for j in 0..30 {
                for i in 0..j.min(25) {
                    let pair = Candidate::new(i, j);
                    prop_assert!(!after.may_touch(i as usize, j as usize) || list.pairs().contains(&pair), "{:?}", pair);
                }
            }
        }
    }

    #[test]
    fn it_does_not_follow_a_crowd() {
        let places: Vec<_> = (0..20).map(|number| (0.1 * f64::from(number), 0.0)).collect();
        let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
        let (few, many) =
            (store(&places[..FEW], 0, vec![Slot::default(); FEW]), store(&places, 0, vec![Slot::default(); 20]));
        assert!(verlet.follow(&few, &mut list, 1e-3) && !list.pairs().is_empty());
        assert!(!verlet.follow(&many, &mut list, 1e-3));
        assert!(!verlet.catch_up(&many, &mut list, &(0..17).collect::<Vec<_>>(), 1e-3));
    }
}
