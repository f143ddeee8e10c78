//! Anchors of a Verlet list: where particles were when their partners were listed, and how far they may move from there.

use crate::space::Space;
use crate::store::{Body, ParticleStore};

/// Number of steps at present speed that an allowance covers.
pub(super) const HORIZON: f64 = 25.0;

/// Position of a particle when its partners were listed (m), and how far it may move from there (m).
#[derive(Clone, Copy)]
pub(super) struct Anchor<V> {
    pub(super) position: V,
    pub(super) allowance: f64,
}

impl<V: Space> Anchor<V> {
    /// Returns the anchor of a particle at its present state; `skin` in m, `dt` is the time step, s.
    pub(super) fn of(body: &Body<V>, skin: f64, dt: f64) -> Self {
        Self { position: body.position, allowance: 0.5 * skin + HORIZON * dt * body.velocity.length() }
    }
}

/// A ball around an anchor. Two particles belong on the list if their balls meet.
#[derive(Clone, Copy)]
pub(super) struct Ball<V> {
    /// Centre, m.
    centre: V,
    /// Radius of the particle plus its allowance, m.
    radius: f64,
}

impl<V: Space> Ball<V> {
    /// Whether two balls in the space of `store` meet.
    #[inline(always)]
    pub(super) fn meets(&self, other: &Self, store: &ParticleStore<V>) -> bool {
        let reach = self.radius + other.radius;
        store.separation(self.centre, other.centre).length_squared() < reach * reach
    }
}

/// Whether a pair may be on a list, wherever the two are: not two fixed particles, or two spheres of one body.
#[inline]
pub(super) fn may_be_listed<V: Space>(store: &ParticleStore<V>, i: usize, j: usize) -> bool {
    !(store.is_fixed(i) && store.is_fixed(j)) && store.can_touch(i, j)
}

/// The anchors of all particles.
pub(super) struct Anchors<V: Space> {
    /// Skin, m.
    pub(super) skin: f64,
    /// The anchor of each particle, by slot.
    pub(super) all: Vec<Anchor<V>>,
}

impl<V: Space> Anchors<V> {
    /// Sets the anchors of all particles at their present state; `dt` is the time step, s.
    pub(super) fn set_all(&mut self, store: &ParticleStore<V>, dt: f64) {
        self.all.clear();
        self.all.extend(store.body.iter().map(|body| Anchor::of(body, self.skin, dt)));
    }

    /// Returns whether a pair belongs on the list.
    #[inline]
    pub(super) fn are_near(&self, store: &ParticleStore<V>, i: usize, j: usize) -> bool {
        self.ball(store, i).meets(&self.ball(store, j), store) && may_be_listed(store, i, j)
    }

    /// Returns the ball in which the surface of particle `i` stays until it has used up its allowance.
    #[inline]
    pub(super) fn ball(&self, store: &ParticleStore<V>, i: usize) -> Ball<V> {
        let Anchor { position, allowance } = self.all[i];
        Ball { centre: position, radius: store.body[i].radius + allowance }
    }
}
