//! A Verlet list follows its particles to the slots that are dealt out anew when some came or left: in a discharge that
//! happens far more often than anything else that would make it stale.
//!
//! Pairs go over to the new slots; those of particles that left, or that are no longer what they were ([`Columns::former`]), go.
//! Allowances go on as they were. Everybody is asked about each newcomer, who is given an allowance from here on.

use crate::columns::{Columns, Slot};
use crate::neighbours::list::{Candidate, PairList};
use crate::neighbours::verlet_list::{Anchor, VerletList};
use crate::space::Space;
use crate::wait::Wait;

/// Of more newcomers at once a search finds the pairs sooner.
const FEW: usize = 16;

impl<V: Space> VerletList<V> {
    /// Brings `list` to the slots that have just been dealt out in `columns`; `dt` is the time step, s. Tells whether it did.
    pub(in crate::neighbours) fn follow(&mut self, columns: &Columns<V>, list: &mut PairList, dt: f64) -> bool {
        let entries = || (0u32..).zip(&columns.former);
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
        let mut pairs: Vec<_> = followed.collect();
        let anchors = columns.former.iter().zip(&columns.body);
        let anchors = anchors.map(|(former, body)| known(former).copied().unwrap_or(Anchor::of(body, self.skin, dt)));
        self.made_at = anchors.collect();
        self.wait = Wait::default();
        for (met, &new) in newcomers.iter().enumerate() {
            let near = (0u32..).take(columns.len()).filter(|&j| self.are_near(columns, new as usize, j as usize));
            let near = near.filter(|j| !newcomers[..=met].contains(j));
            pairs.extend(near.map(|j| Candidate::new(new.min(j), new.max(j))));
        }
        list.take(&pairs, columns.len());
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::Body;
    use crate::particle::GrainId;
    use crate::space::Plane;
    use proptest::prelude::*;

    const SKIN: f64 = 0.1;

    /// Of discs at these places (m), the last ones of them fixed, which had those slots.
    fn columns(places: &[(f64, f64)], fixed: usize, former: Vec<Slot>) -> Columns {
        let body = |&(x, y): &(f64, f64)| {
            let radius = 0.05 + 0.02 * x;
            Body { position: Plane::new(x, y), velocity: Plane::new(y, 0.1), radius, inverse_mass: 1.0 }
        };
        let id = (0u32..).zip(places).filter_map(|(number, _)| GrainId::grain(number)).collect();
        let body = places.iter().map(body).collect();
        Columns { id, body, former, movable_end: places.len() - fixed, ..Columns::default() }
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
            let before = columns(&places, 5, vec![Slot::default(); 30]);
            let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
            verlet.renew(&before, &mut list, 1e-3);
            let stays = |former: &u32| !leaving.contains(former);
            let mut former: Vec<_> = (0u32..25).filter(stays).map(Slot::at).collect();
            former.extend(coming.iter().map(|_| Slot::default()));
            let turn = turn.min(former.len());
            former.rotate_left(turn);
            let free = former.len();
            former.extend((25u32..30).filter(stays).map(Slot::at));
            let mut newcomers = coming.iter().copied();
            let place = |former: &Slot| places.get(former.index()).copied().or_else(|| newcomers.next());
            let places: Vec<_> = former.iter().map_while(place).collect();
            let fixed = places.len() - free;
            let after = columns(&places, fixed, former);
            prop_assert!(verlet.follow(&after, &mut list, 1e-3));
            prop_assert!(!verlet.is_stale(&after));
            let mut whole = PairList::default();
            VerletList::new(SKIN).renew(&after, &mut whole, 1e-3);
            // Nobody has moved: so the list is what a search would find.
            prop_assert_eq!(list.pairs(), whole.pairs());
        }
    }

    #[test]
    fn it_does_not_follow_a_crowd() {
        let places: Vec<_> = (0..20).map(|number| (0.1 * f64::from(number), 0.0)).collect();
        let (mut verlet, mut list) = (VerletList::new(SKIN), PairList::default());
        let (few, many) =
            (columns(&places[..FEW], 0, vec![Slot::default(); FEW]), columns(&places, 0, vec![Slot::default(); 20]));
        assert!(verlet.follow(&few, &mut list, 1e-3) && !list.pairs().is_empty());
        assert!(!verlet.follow(&many, &mut list, 1e-3));
    }
}
