//! Verlet list: the pairs that may touch soon, valid until an unlisted pair could touch.
//!
//! Each particle has an allowance, the distance it may move before the list must change: half the skin, plus the
//! distance it covers in [`HORIZON`](anchors::HORIZON) steps at its present speed. A pair is listed if its centres are closer than
//! R_i + R_j + both allowances. With contacts beyond touch, half of their largest range is not available for motion. An unlisted pair cannot touch before one of the two has used up its allowance. So the
//! few grains that fall fast have long rows, and do not force the many grains at rest to renew theirs.
//!
//! Each row is in ascending order. A search rebuilds the list: with one grid of cells ([`candidate_search`]), or, if sizes differ
//! widely, with one grid per size class ([`size_classes`]). After small changes, [`renumbering`] updates it without a search: a few particles entered, left or used up their allowances.

mod anchors;
mod candidate_search;
mod found_pairs;
mod renumbering;
mod size_classes;

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::ROWS_PER_THREAD;
use crate::neighbours::list::PairList;
use crate::neighbours::verlet_list::anchors::Anchors;
use crate::neighbours::verlet_list::candidate_search::CandidateSearch;
use crate::neighbours::verlet_list::found_pairs::FoundPairs;
use crate::neighbours::verlet_list::size_classes::SizeClasses;
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;

/// A particle counts as nearly exhausted if less than this share of its allowance is left.
const NEARLY_EXHAUSTED: f64 = 0.5;

/// State that decides when the list must be rebuilt.
pub struct VerletList<V: Space> {
    anchors: Anchors<V>,
    trigger: DisplacementTrigger,
}

impl<V: Space> VerletList<V> {
    pub(super) fn new(skin: f64) -> Self {
        Self { anchors: Anchors { skin, all: Vec::new() }, trigger: DisplacementTrigger::default() }
    }

    /// Returns the nearly exhausted particles if any particle has used up its allowance, else none.
    pub(super) fn exhausted(&mut self, store: &ParticleStore<V>, threads: &Threads) -> Vec<u32> {
        if !self.trigger.has_fired(store.travel_meter(), store.prediction.margin) {
            return Vec::new();
        }
        let anchors = &self.anchors.all[..];
        let left = |i: usize| {
            let (body, anchor) = (&store.body[i], &anchors[i]);
            // With centred contacts, pairs that touch within the time by which velocities are ahead must be listed too.
            let ahead = store.prediction.velocities_ahead * store.middle_velocity(i).extent();
            let ahead = if store.prediction.range > 0.0 { ahead + 0.5 * store.prediction.range } else { ahead };
            anchor.allowance - ahead - store.separation(body.position, anchor.position).length()
        };
        let particles = store.len();
        let of_parts =
            threads.share_rows(0..particles, ROWS_PER_THREAD, |rows| rows.map(left).fold(f64::INFINITY, f64::min));
        let least = of_parts.into_iter().fold(f64::INFINITY, f64::min);
        self.trigger = DisplacementTrigger::for_distance(store.travel_meter(), least);
        if least > 0.0 {
            return Vec::new();
        }
        // Particles that would exhaust their allowance soon are included, so that one update serves them all.
        let nearly = |i: &u32| left(*i as usize) < NEARLY_EXHAUSTED * anchors[*i as usize].allowance;
        (0u32..).take(particles).filter(nearly).collect()
    }

    /// Rebuilds `list` for the positions in `store`; `dt` is the time step, s.
    pub(super) fn renew(&mut self, store: &ParticleStore<V>, list: &mut PairList, dt: f64, threads: &Threads) {
        self.anchors.set_all(store, dt);
        self.trigger = DisplacementTrigger::default();
        let expected = list.pairs().len();
        let pairs = if size_classes::are_worthwhile(store, self.anchors.skin) {
            SizeClasses::new(&self.anchors, store).pairs(expected, threads)
        } else {
            CandidateSearch::new(&self.anchors, store).pairs(expected, threads)
        };
        list.fill(pairs.iter().flat_map(FoundPairs::pairs), store.len());
    }
}
