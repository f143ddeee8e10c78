//! The motion of spheres with their bodies, and the sums of their loads.
//!
//! * *Scatter* ([`ParticleStore::scatter_bodies`]), after the drift: a sphere at b in the body is at X + R b and moves with V + w x R b. In the
//!   middle of a step it moves with its displacement over dt, so that springs follow the positions.
//! * *Gather* ([`ParticleStore::gather_bodies`]), after the contacts: F = sum F_a, T = sum (T_a + R b_a x F_a), in the shape's order, so that the
//!   sums do not depend on the order of rows.
//!
//! A body wraps at a periodic side by its centre. Its spheres wrap one by one; arms come from the orientation, not from positions.

use crate::space::{Linear, Rotor, Space};
use crate::store::bodies::{BodyColumns, BodySlot};
use crate::store::longest_move::LongestMove;
use crate::store::prediction::swept_radius;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};

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
            self.place_spheres(body, &mut LongestMove::default());
        }
    }

    /// Sets the places of all spheres from the centres of their bodies.
    pub(super) fn renew_arms(&mut self) {
        for body in self.bodies.all() {
            let rotor = self.bodies.rotor[body.index()];
            for number in 0..self.bodies.rows_of(body).len() {
                let sphere = self.bodies.rows_of(body)[number] as usize;
                let arm = rotor.turn(self.bodies.shape_of(body).spheres[number].at * self.bodies.scale[body.index()]);
                self.bodies.arm[sphere - self.bodies.first_sphere] = arm;
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
            let arm = rotor.turn(self.bodies.shape_of(body).spheres[number].at * self.bodies.scale[body.index()]);
            self.bodies.arm[sphere - self.bodies.first_sphere] = arm;
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

    /// Moves the spheres of free bodies after a drift of `dt`, s.
    pub(crate) fn scatter_bodies(&mut self, dt: f64) {
        let predicts = self.predicts();
        let per_time = 1.0 / dt;
        let mut longest = LongestMove::default();
        for b in 0..self.bodies.free {
            let centre = self.body[b];
            let middle = self.middle_velocity(b);
            let spin = self.rotation[b].spin;
            let middle_spin = self.middle_spin(b);
            let Self { bodies, body, rotation, prediction, periodic, .. } = self;
            let BodyColumns { shapes, shape, scale, rotor, starts, rows, first_sphere, arm, .. } = bodies;
            let rows = &rows[starts[b] as usize..starts[b + 1] as usize];
            for (&row, sphere) in rows.iter().zip(&shapes[shape[b].index()].spheres) {
                let row = row as usize;
                let turned = rotor[b].turn(sphere.at * scale[b]);
                let before = std::mem::replace(&mut arm[row - *first_sphere], turned);
                let moved = middle * dt + (turned - before);
                let squared = longest.raise(moved);
                let sphere = &mut body[row];
                sphere.position = centre.position + turned;
                if let Some(periodic) = periodic {
                    periodic.wrap(&mut sphere.position);
                }
                rotation[row].spin = spin;
                // In the middle of the step.
                let velocity = moved * per_time;
                if predicts {
                    sphere.velocity = centre.velocity + turned.turned_by(spin);
                    V::set_middle(velocity, &mut sphere.middle, &mut prediction.middle[row]);
                    prediction.middle_spin[row] = middle_spin;
                    if let Some(swept) = prediction.swept.get_mut(row) {
                        *swept = swept_radius(sphere.radius, squared.sqrt(), prediction.range);
                    }
                } else {
                    sphere.velocity = velocity;
                }
            }
        }
        let longest = longest.length();
        // The drift has counted the moves of all centres. The longest move of all particles counts; NaN stays.
        let beyond = longest - self.bodies.drifted;
        self.travel += if beyond <= 0.0 { 0.0 } else { beyond };
        if predicts {
            self.widen_margin(longest);
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
    pub(crate) fn gather_bodies(&mut self) {
        if self.tracks_energy {
            self.gather::<TOTAL_AND_DISSIPATIVE>();
        } else {
            self.gather::<TOTAL>();
        }
    }

    fn gather<const NUMBERS: usize>(&mut self) {
        for body in self.bodies.all() {
            let carrier = self.row_of_body(body);
            let Self { bodies, loads, .. } = self;
            let rows = bodies.rows_of(body);
            let forces = loads.force.entries_mut::<NUMBERS>();
            let torques = loads.torque.entries_mut::<NUMBERS>();
            let mut force = forces[carrier];
            let mut torque = [V::Spin::ZERO; NUMBERS];
            for &row in rows {
                let row = row as usize;
                let arm = bodies.arm(row);
                for number in 0..NUMBERS {
                    force[number] += forces[row][number];
                    torque[number] += torques[row][number] + arm.cross(forces[row][number]);
                }
            }
            forces[carrier] = force;
            torques[carrier] = torque;
            if !loads.rolling_drag.is_empty() {
                // All of it is in the body then, so that no power counts twice.
                let drag = &mut loads.rolling_drag;
                drag[carrier] = rows.iter().map(|&row| std::mem::take(&mut drag[row as usize])).sum();
            }
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

/// Number of components of the principal moments.
#[expect(clippy::cast_precision_loss, reason = "one or three")]
fn number_of<V: Space>() -> f64 {
    V::Principal::COUNT as f64
}
