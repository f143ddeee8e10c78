//! The motion of spheres with their bodies, and the sums of their loads.
//!
//! * *Scatter*: a sphere at b in the body is at X + R b and moves with V + w x R b. Each drift does it for all free bodies at once
//!   (`integrate/scatter.rs`); here it is done for one body, and for the velocities alone.
//! * *Gather* ([`ParticleStore::gather_bodies`]), after the contacts: F = sum F_a, T = sum (T_a + R b_a x F_a), in the shape's order, so that the
//!   sums do not depend on the order of rows.
//!
//! A body wraps at a periodic side by its centre. Its spheres wrap one by one; arms come from the orientation, not from positions.

use crate::space::{Linear, Rotor, Space};
use crate::store::bodies::{BodyColumns, BodySlot};
use crate::store::longest_move::LongestMove;
use crate::store::parallel_chunks::CHUNK;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::threads::Threads;

impl<V: Space> ParticleStore<V> {
    /// Sets the numbers of all spheres that follow from their bodies: radius, 1/m, species, place and motion.
    pub(super) fn renew_spheres(&mut self) {
        for body in self.bodies.all() {
            let row = self.row_of_body(body);
            let b = body.index();
            let scale = self.bodies.scale[b];
            let spin = self.rotation.get(row).map_or(V::Spin::ZERO, |rotation| rotation.spin);
            let mean = self.bodies.inverse_inertia[b].sum_of_components() / number_of::<V>();
            for (number, &sphere) in self.bodies.rows_of(body).to_vec().iter().enumerate() {
                let sphere = sphere as usize;
                self.body[sphere].radius = self.bodies.shape_of(body).spheres[number].radius * scale;
                self.body[sphere].inverse_mass = self.body[row].inverse_mass;
                self.mass[sphere] = 0.0;
                self.species[sphere] = self.species[row];
                self.entity[sphere] = self.entity[row];
                if let Some(rotation) = self.rotation.get_mut(sphere) {
                    rotation.spin = spin;
                    rotation.inverse_inertia = if self.body[row].inverse_mass > 0.0 { mean } else { 0.0 };
                }
            }
            self.bodies.renew_places(body);
            self.place_spheres(body, &mut LongestMove::default());
        }
    }

    /// Sets the places of all spheres from the centres of their bodies.
    pub(super) fn renew_arms(&mut self) {
        for body in self.bodies.all() {
            self.bodies.renew_places(body);
            let rotor = self.bodies.rotor[body.index()];
            for number in 0..self.bodies.rows_of(body).len() {
                let place = self.bodies.rows_of(body)[number] as usize - self.bodies.first_sphere;
                self.bodies.arm[place] = rotor.turn(self.bodies.in_body[place]);
            }
        }
    }

    /// Places the spheres of a body by its present place and motion. Includes their moves in `longest`.
    pub(super) fn place_spheres(&mut self, body: BodySlot, longest: &mut LongestMove) {
        let row = self.row_of_body(body);
        let centre = self.body[row].position;
        let velocity = self.body[row].velocity;
        let middle = self.middle_velocity(row);
        let spin = self.spin(row);
        let middle_spin = self.middle_spin(row);
        let rotor = self.bodies.rotor[body.index()];
        for number in 0..self.bodies.rows_of(body).len() {
            let sphere = self.bodies.rows_of(body)[number] as usize;
            let place = sphere - self.bodies.first_sphere;
            let arm = rotor.turn(self.bodies.in_body[place]);
            self.bodies.arm[place] = arm;
            self.put(sphere, centre + arm, longest);
            if self.is_ahead(sphere) {
                let middle = middle + arm.turned_by(middle_spin);
                V::set_middle(middle, &mut self.body[sphere].middle, &mut self.prediction.middle[sphere]);
                if let Some(middle) = self.prediction.middle_spin.get_mut(sphere) {
                    *middle = middle_spin;
                }
            }
            self.body[sphere].velocity = velocity + arm.turned_by(spin);
            if let Some(rotation) = self.rotation.get_mut(sphere) {
                rotation.spin = spin;
            }
            let moved = 2.0 * self.prediction.velocities_ahead * self.middle_velocity(sphere).length();
            self.widen_margins(sphere, moved);
        }
    }

    /// Gives the spheres of free bodies the velocities of the step's end, after the kick.
    pub(crate) fn scatter_velocities(&mut self) {
        for b in 0..self.bodies.free {
            let velocity = self.body[b].velocity;
            let spin = self.rotation[b].spin;
            for &row in self.bodies.rows_of(BodySlot::of(b)) {
                let row = row as usize;
                self.body[row].velocity = velocity + self.bodies.arm(row).turned_by(spin);
                self.rotation[row].spin = spin;
            }
        }
    }

    /// Sets the orientation of the body in row `i`, which keeps its spin. A rotor without a direction counts as a number that is not finite.
    pub(super) fn set_orientation(&mut self, i: usize, rotor: V::Rotor, longest: &mut LongestMove) {
        let Some(body) = self.body_of_row(i) else { return };
        let Some(rotor) = rotor.normalised() else {
            self.is_suspect = true;
            return;
        };
        let b = body.index();
        let inverse_inertia = self.bodies.inverse_inertia[b];
        let middle = self.bodies.rotor[b].spin(self.bodies.momentum[b], inverse_inertia);
        self.bodies.momentum[b] = rotor.momentum(middle, inverse_inertia);
        self.bodies.rotor[b] = rotor;
        self.place_spheres(body, longest);
    }

    /// Adds the forces and torques of the spheres to those of their bodies.
    pub(crate) fn gather_bodies(&mut self, threads: &Threads) {
        if self.bodies.is_empty() {
            return;
        }
        if self.tracks_energy {
            self.gather::<TOTAL_AND_DISSIPATIVE>(threads);
        } else {
            self.gather::<TOTAL>(threads);
        }
    }

    fn gather<const NUMBERS: usize>(&mut self, threads: &Threads) {
        let fixed = self.contact_rows().end;
        let Self { bodies, loads, .. } = self;
        let first = bodies.first_sphere;
        // Spheres lie between free bodies and fixed bodies.
        let (free_forces, others) = loads.force.entries_mut::<NUMBERS>().split_at_mut(first);
        let (sphere_forces, fixed_forces) = others.split_at_mut(fixed - first);
        let (free_torques, others) = loads.torque.entries_mut::<NUMBERS>().split_at_mut(first);
        let (sphere_torques, fixed_torques) = others.split_at_mut(fixed - first);
        let spheres = SphereLoads { forces: sphere_forces, torques: sphere_torques, first };
        let bodies = &*bodies;
        let count = bodies.free;
        let size = count.div_ceil(threads.count()).max(CHUNK);
        let parts = free_forces[..count].chunks_mut(size).zip(free_torques[..count].chunks_mut(size));
        threads.share(parts.enumerate().map(|(part, (forces, torques))| {
            move || {
                for (b, (force, torque)) in (part * size..).zip(forces.iter_mut().zip(torques)) {
                    spheres.gather(bodies, b, force, torque);
                }
            }
        }));
        for (place, (force, torque)) in fixed_forces.iter_mut().zip(fixed_torques).enumerate() {
            spheres.gather(bodies, count + place, force, torque);
        }
        self.gather_rolling_drag();
    }

    /// Moves the dissipative torques of rolling from spheres to their bodies, so that no power counts twice.
    fn gather_rolling_drag(&mut self) {
        if self.loads.rolling_drag.is_empty() {
            return;
        }
        for body in self.bodies.all() {
            let carrier = self.row_of_body(body);
            let drag = &mut self.loads.rolling_drag;
            drag[carrier] = self.bodies.rows_of(body).iter().map(|&row| std::mem::take(&mut drag[row as usize])).sum();
        }
    }

    /// Gives all spheres of a body the number of contacts of the body: lone is a property of bodies.
    pub(crate) fn share_contact_counts(&mut self) {
        let contacts = &mut self.loads.contacts;
        for body in self.bodies.all() {
            let rows = self.bodies.rows_of(body);
            let sum = rows.iter().fold(0_u16, |sum, &sphere| sum.saturating_add(contacts[sphere as usize]));
            for &sphere in rows {
                contacts[sphere as usize] = sum;
            }
        }
    }
}

/// The loads of all rows that can be spheres of bodies.
#[derive(Clone, Copy)]
struct SphereLoads<'a, V: Space, const NUMBERS: usize> {
    forces: &'a [[V; NUMBERS]],
    torques: &'a [[V::Spin; NUMBERS]],
    /// The first of these rows.
    first: usize,
}

impl<V: Space, const NUMBERS: usize> SphereLoads<'_, V, NUMBERS> {
    /// Adds the loads of the spheres of body `b` to its force, and sets its torque.
    fn gather(&self, bodies: &BodyColumns<V>, b: usize, force: &mut [V; NUMBERS], torque: &mut [V::Spin; NUMBERS]) {
        *torque = [V::Spin::ZERO; NUMBERS];
        for &row in bodies.rows_of(BodySlot::of(b)) {
            let place = row as usize - self.first;
            let arm = bodies.arm[place];
            for number in 0..NUMBERS {
                force[number] += self.forces[place][number];
                torque[number] += self.torques[place][number] + arm.cross(self.forces[place][number]);
            }
        }
    }
}

/// Number of components of the principal moments.
#[expect(clippy::cast_precision_loss, reason = "one or three")]
fn number_of<V: Space>() -> f64 {
    V::Principal::COUNT as f64
}
