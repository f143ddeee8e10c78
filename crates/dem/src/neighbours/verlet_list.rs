//! Verlet list: the pairs that may touch soon, valid until an unlisted pair could touch.
//!
//! Each particle has an allowance, the distance it may move before the list must change: half the skin, plus the
//! distance it covers in [`HORIZON`] steps at its present speed. A pair is listed if its centres are closer than
//! R_i + R_j + both allowances. With contacts beyond touch, half of their largest range is not available for motion. An unlisted pair cannot touch before one of the two has used up its allowance. So the
//! few grains that fall fast have long rows, and do not force the many grains at rest to renew theirs.
//!
//! Each row is in ascending order. A search rebuilds the list: with one grid of cells ([`candidate_search`]), or, if sizes differ
//! widely, with one grid per size class ([`size_classes`]). After small changes, [`renumbering`] updates it without a search: a few particles entered, left or used up their allowances.

mod candidate_search;
mod found_pairs;
mod renumbering;
mod size_classes;

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::list::PairList;
use crate::neighbours::verlet_list::candidate_search::CandidateSearch;
use crate::neighbours::verlet_list::found_pairs::FoundPairs;
use crate::neighbours::verlet_list::size_classes::SizeClasses;
use crate::space::Space;
use crate::store::{Body, ParticleStore};
use crate::threads::Threads;

/// A particle counts as nearly exhausted if less than this share of its allowance is left.
const NEARLY_EXHAUSTED: f64 = 0.5;

/// Number of steps at present speed that an allowance covers.
const HORIZON: f64 = 25.0;

/// State that decides when the list must be rebuilt.
pub struct VerletList<V: Space> {
    skin: f64,
    /// Anchor of each particle, by slot.
    anchors: Vec<Anchor<V>>,
    trigger: DisplacementTrigger,
}

/// Position of a particle when its partners were listed (m), and how far it may move from there (m).
#[derive(Clone, Copy)]
struct Anchor<V> {
    position: V,
    allowance: f64,
}

impl<V: Space> Anchor<V> {
    /// Returns the anchor of a particle at its present state; `skin` in m, `dt` is the time step, s.
    fn of(body: &Body<V>, skin: f64, dt: f64) -> Self {
        Self { position: body.position, allowance: 0.5 * skin + HORIZON * dt * body.velocity.length() }
    }
}

impl<V: Space> VerletList<V> {
    pub(super) fn new(skin: f64) -> Self {
        Self { skin, anchors: Vec::new(), trigger: DisplacementTrigger::default() }
    }

    /// Returns the nearly exhausted particles if any particle has used up its allowance, else none.
    pub(super) fn exhausted(&mut self, store: &ParticleStore<V>) -> Vec<u32> {
        if !self.trigger.has_fired(store.travel_meter(), store.prediction.margin) {
            return Vec::new();
        }
        let left = |(i, (body, anchor)): (usize, (&Body<V>, &Anchor<V>))| {
            // With centred contacts, pairs that touch within the look-ahead time must be listed too.
            let ahead = store.prediction.lookahead * store.middle_velocity(i).extent();
            let ahead = if store.prediction.range > 0.0 { ahead + 0.5 * store.prediction.range } else { ahead };
            anchor.allowance - ahead - store.separation(body.position, anchor.position).length()
        };
        let particles = || store.body.iter().zip(&self.anchors).enumerate();
        let least = particles().map(left).fold(f64::INFINITY, f64::min);
        self.trigger = DisplacementTrigger::for_distance(store.travel_meter(), least);
        if least > 0.0 {
            return Vec::new();
        }
        // Particles that would exhaust their allowance soon are included, so that one update serves them all.
        let nearly = |&(_, particle): &(u32, (usize, (&Body<V>, &Anchor<V>)))| {
            left(particle) < NEARLY_EXHAUSTED * particle.1.1.allowance
        };
        (0u32..).zip(particles()).filter(nearly).map(|(i, _)| i).collect()
    }

    /// Rebuilds `list` for the positions in `store`; `dt` is the time step, s.
    pub(super) fn renew(&mut self, store: &ParticleStore<V>, list: &mut PairList, dt: f64, threads: &Threads) {
        self.anchors.clear();
        self.anchors.extend(store.body.iter().map(|body| Anchor::of(body, self.skin, dt)));
        self.trigger = DisplacementTrigger::default();
        let expected = list.pairs().len();
        let pairs = if size_classes::are_worthwhile(store, self.skin) {
            SizeClasses::new(self, store).pairs(expected, threads)
        } else {
            CandidateSearch::new(self, store).pairs(expected, threads)
        };
        list.fill(pairs.iter().flat_map(FoundPairs::pairs), store.len());
    }

    /// Returns whether a pair belongs on the list.
    #[inline]
    fn are_near(&self, store: &ParticleStore<V>, i: usize, j: usize) -> bool {
        let one = &self.anchors[i];
        let other = &self.anchors[j];
        let reach = store.body[i].radius + store.body[j].radius + one.allowance + other.allowance;
        store.separation(one.position, other.position).length_squared() < reach * reach
            && !(store.is_fixed(i) && store.is_fixed(j))
    }
}
