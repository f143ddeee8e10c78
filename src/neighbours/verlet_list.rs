//! A Verlet list: the pairs that might touch soon, kept until one that is not listed could.
//!
//! Each particle has an allowance, a way that it may move before the list is renewed: half the skin, and for a grain
//! on its way also what it does in the next [`HORIZON`] steps at its present speed. A pair is listed if it is closer
//! than R_i + R_j + both allowances; it cannot touch unlisted before one of the two has used up its own. So the few
//! grains that fall fast have long lists, and do not force the many that rest to renew theirs.
//!
//! Each particle's partners are listed in ascending order. The list is renewed by a search ([`sweep`]); with a few that come, leave
//! or go far it keeps up without ([`follow`]).

mod candidate_search;
mod renumbering;

use crate::displacement_trigger::DisplacementTrigger;
use crate::neighbours::list::PairList;
use crate::neighbours::verlet_list::candidate_search::CandidateSearch;
use crate::space::Space;
use crate::store::{Body, ParticleStore};
use crate::threads::Threads;

/// What share of an allowance is left to whoever has used up most of it.
const MOST: f64 = 0.5;

/// For how many steps ahead the list provides at present speeds.
const HORIZON: f64 = 25.0;

/// What tells when the list is to be renewed.
pub struct VerletList<V: Space> {
    skin: f64,
    made_at: Vec<Anchor<V>>,
    trigger: DisplacementTrigger,
}

/// Where a particle was when the list was made, and how far it may go.
#[derive(Clone, Copy)]
struct Anchor<V> {
    position: V,
    allowance: f64,
}

impl<V: Space> Anchor<V> {
    /// For a particle as it is now; `skin` in m, `dt` is the time step, s.
    fn of(body: &Body<V>, skin: f64, dt: f64) -> Self {
        Self { position: body.position, allowance: 0.5 * skin + HORIZON * dt * body.velocity.length() }
    }
}

impl<V: Space> VerletList<V> {
    pub(super) fn new(skin: f64) -> Self {
        Self { skin, made_at: Vec::new(), trigger: DisplacementTrigger::default() }
    }

    /// Who has used up most of its allowance, in case that somebody has used up all of it.
    pub(super) fn gone_far(&mut self, store: &ParticleStore<V>) -> Vec<u32> {
        if !self.trigger.has_fired(store.travel_meter(), store.margin) {
            return Vec::new();
        }
        let left = |(body, anchor): (&Body<V>, &Anchor<V>)| {
            // A scheme that looks ahead sees what may touch in that time.
            let ahead = store.lookahead * body.velocity.extent();
            anchor.allowance - ahead - store.separation(body.position, anchor.position).length()
        };
        let particles = || store.body.iter().zip(&self.made_at);
        let least = particles().map(left).fold(f64::INFINITY, f64::min);
        self.trigger = DisplacementTrigger::for_distance(store.travel_meter(), least);
        if least > 0.0 {
            return Vec::new();
        }
        // Those who will soon be here too are done with in one go.
        let most = |&(_, particle): &(u32, (&Body<V>, &Anchor<V>))| left(particle) < MOST * particle.1.allowance;
        (0u32..).zip(particles()).filter(most).map(|(i, _)| i).collect()
    }

    /// Makes `list` anew for the positions in `store`; `dt` is the time step, s.
    pub(super) fn renew(&mut self, store: &ParticleStore<V>, list: &mut PairList, dt: f64, threads: &Threads) {
        self.made_at.clear();
        self.made_at.extend(store.body.iter().map(|body| Anchor::of(body, self.skin, dt)));
        self.trigger = DisplacementTrigger::default();
        let pairs = CandidateSearch::new(self, store).pairs(list.pairs().len(), threads);
        list.take(&pairs, store.len());
    }

    /// Whether two belong on the list.
    #[inline]
    fn are_near(&self, store: &ParticleStore<V>, i: usize, j: usize) -> bool {
        let (one, other) = (&self.made_at[i], &self.made_at[j]);
        let reach = store.body[i].radius + store.body[j].radius + one.allowance + other.allowance;
        store.separation(one.position, other.position).length_squared() < reach * reach
            && !(store.is_fixed(i) && store.is_fixed(j))
    }
}
