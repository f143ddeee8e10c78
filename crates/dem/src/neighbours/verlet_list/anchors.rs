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
        let one = &self.all[i];
        let other = &self.all[j];
        let reach = store.body[i].radius + store.body[j].radius + one.allowance + other.allowance;
        store.separation(one.position, other.position).length_squared() < reach * reach
            && !(store.is_fixed(i) && store.is_fixed(j))
            && store.can_touch(i, j)
    }
}
