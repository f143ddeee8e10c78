//! Velocities of single contacts in the middle of the step and at its end, from the gains in the store.

use crate::contact::pair::{Gathered, Pair};
use crate::neighbours::list::Candidate;
use crate::space::{Linear, Space};
use crate::store::ParticleStore;
use crate::walls::surface_wall::SurfaceWall;

impl<V: Space> ParticleStore<V> {
    /// Turns a contact of two particles with predicted velocities into one with the velocities in the middle of the step
    /// and their prediction.
    pub(in crate::contact) fn predict_pair(&self, contact: Candidate, pair: &mut Pair<V>) {
        let [i, j] = contact.both();
        // Differences of the two, so that they change their sign exactly if i and j are exchanged.
        pair.relative_velocity = self.middle_velocity(i) - self.middle_velocity(j);
        pair.ahead.velocity = self.gain(i) - self.gain(j);
        self.describe(i, 0, pair);
        self.describe(j, 1, pair);
    }

    /// Like [`Self::predict_pair`], for a contact with a wall surface.
    pub(in crate::contact) fn predict_with_wall(&self, i: usize, wall: &SurfaceWall<V>, pair: &mut Pair<V>) {
        pair.relative_velocity -= self.body[i].velocity - self.middle_velocity(i);
        pair.ahead.velocity = self.gain(i);
        if let Some(gained) = wall.gained_at(|| self.contact_point(i, pair)) {
            pair.relative_velocity += gained;
            pair.ahead.velocity -= gained;
        }
        self.describe(i, 0, pair);
    }

    /// Returns the velocities of two particles in the middle of the step.
    #[inline(always)]
    pub(in crate::contact) fn gathered(&self, contact: Candidate) -> Gathered<V> {
        let [i, j] = contact.both();
        Gathered {
            relative_velocity: self.middle_velocity(i) - self.middle_velocity(j),
            spins: [self.middle_spin(i), self.middle_spin(j)],
        }
    }

    /// Like [`Self::gathered`], for a contact of particle `i` with a wall surface.
    #[inline(always)]
    pub(in crate::contact) fn gathered_with_wall(
        &self,
        i: usize,
        wall: &SurfaceWall<V>,
        pair: &Pair<V>,
    ) -> Gathered<V> {
        let ahead = self.body[i].velocity - self.middle_velocity(i);
        let mut relative_velocity = pair.relative_velocity - ahead;
        if let Some(gained) = wall.gained_at(|| self.contact_point(i, pair)) {
            relative_velocity += gained;
        }
        Gathered { relative_velocity, spins: [self.middle_spin(i), V::Spin::ZERO] }
    }

    /// The point of a wall (m) at which particle `i` touches it.
    fn contact_point(&self, i: usize, pair: &Pair<V>) -> V {
        let body = &self.body[i];
        body.position - pair.normal * (body.radius - pair.overlap)
    }

    /// Velocity gain of particle `i` in half a step by the forces at its beginning, m/s.
    fn gain(&self, i: usize) -> V {
        // Predicted velocities contain a share of it.
        (self.body[i].velocity - self.middle_velocity(i)) * (1.0 / self.prediction.share)
    }

    /// Sets the numbers of particle `i` at one side of a contact.
    fn describe(&self, i: usize, side: usize, pair: &mut Pair<V>) {
        if self.is_fixed(i) {
            return;
        }
        pair.ahead.inverse_masses[side] = self.inverse_mass_along(i, pair.normal);
        pair.ahead.lone[side] = f64::from(self.prediction.lone[i]);
        if let Some(rotation) = self.rotation.get(i) {
            let middle = self.prediction.middle_spin[i];
            pair.ahead.spins[side] = (rotation.spin - middle) * (1.0 / self.prediction.spin_share);
            pair.ahead.inverse_inertias[side] = rotation.inverse_inertia;
            pair.spins[side] = middle;
        }
    }
}
