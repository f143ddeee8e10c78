//! Velocities of single contacts in the middle of the step and at its end, from the gains in the store.

use crate::contact::pair::{Gathered, Pair};
use crate::neighbours::list::Candidate;
use crate::space::{Linear, Rotor, Space};
use crate::store::ParticleStore;
use crate::walls::surface_wall::SurfaceWall;

impl<V: Space> ParticleStore<V> {
    /// Turns a contact of two particles with predicted velocities into one with the velocities in the middle of the step
    /// and their prediction.
    pub(in crate::contact) fn predict_pair(&self, contact: Candidate, pair: &mut Pair<V>) {
        let [i, j] = contact.slots();
        // Differences of the two, so that they change their sign exactly if i and j are exchanged.
        pair.relative_velocity = self.middle_velocity(i) - self.middle_velocity(j);
        pair.ahead.velocity = self.gain(i) - self.gain(j);
        self.describe(i, 0, pair);
        self.describe(j, 1, pair);
        let along = self.sliding_direction([i, j].map(|row| self.body[row].radius), pair);
        self.describe_body(i, 0, along, pair);
        self.describe_body(j, 1, along, pair);
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
        let along = self.sliding_direction([self.body[i].radius, 0.0], pair);
        self.describe_body(i, 0, along, pair);
    }

    /// Returns the velocities of two particles in the middle of the step.
    #[inline(always)]
    pub(in crate::contact) fn gathered(&self, contact: Candidate) -> Gathered<V> {
        let [i, j] = contact.slots();
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

    /// Returns the direction in which the surfaces of a contact slide, or zero. `levers` are the radii of the spheres, m.
    fn sliding_direction(&self, levers: [f64; 2], pair: &Pair<V>) -> V {
        if self.bodies.is_empty() {
            return V::ZERO;
        }
        let sliding = pair.sliding_velocity(levers);
        let speed = sliding.length();
        if speed > 0.0 { sliding * (1.0 / speed) } else { V::ZERO }
    }

    /// Sets what the body of sphere `i` adds to the numbers of a contact whose surfaces slide along the unit vector `along`.
    fn describe_body(&self, i: usize, side: usize, along: V, pair: &mut Pair<V>) {
        let Some(sphere) = self.bodies.sphere(i).filter(|_| !self.is_fixed(i)) else { return };
        let inverse_inertia = self.bodies.inverse_inertia[sphere.body.index()];
        let rotor = self.bodies.rotor[sphere.body.index()];
        let sign = [1.0, -1.0][side];
        let centre = self.bodies.arm(i);
        let arm = centre - pair.normal * (sign * self.body[i].radius);
        let turned_by = |momentum: V| rotor.spin(arm.cross(momentum), inverse_inertia);
        let spin = turned_by(pair.normal);
        let of_sphere =
            pair.ahead.inverse_masses[side] + self.body[i].radius.powi(2) * pair.ahead.inverse_inertias[side];
        let beside = &mut pair.ahead.beside;
        beside.velocities[side] = centre.turned_by(spin);
        beside.spins[side] = spin * sign;
        if along != V::ZERO {
            let mobility = self.body[i].inverse_mass + arm.turned_by(turned_by(along)).dot(along);
            beside.mobilities[side] = mobility - of_sphere;
        }
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
