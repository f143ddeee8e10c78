//! Rigid bodies of several spheres.
//!
//! * Places: a sphere at b among the principal axes e_1, e_2, e_3 is at X + sum b_k e_k. With w = sum (e_k . L)/I_k e_k it moves with V + w x (x - X).
//! * Kick: V += h F/m, L += h T, with F = sum F_a and T = sum (T_a + (x_a - X) x F_a).
//! * Drift: X += dt V, and a free rotation for dt. It is a splitting of the energy sum M_k^2/(2 I_k), M_k = e_k . L, about the axis k whose
//!   neighbour p has the most similar 1/I: half a turn about e_p by (1/I_p - 1/I_k) M_p dt, a turn about e_q by (1/I_q - 1/I_k) M_q dt, the other half about
//!   e_p, and at last a turn about L by |L|/I_k dt.
//! * In the middle of a step a sphere moves with its displacement over dt and turns with the mean of w before and after the rotation. The velocities at
//!   the end that the centred scheme predicts are those of V + beta h F/m and L + beta h T.
//! * An impulse along n at a sphere changes the speed of its place along n by 1/m + (r x n) . I^-1 (r x n).

use crate::simulator::{Body, Part};
use crate::vector::V;

/// A body of several spheres.
#[derive(Clone, Debug)]
pub struct Clump {
    /// The number of its centre among the bodies.
    pub centre: usize,
    /// L, kg m^2/s.
    pub momentum: V,
    /// e_1, e_2, e_3.
    pub axes: [V; 3],
    /// 1/I_1, 1/I_2, 1/I_3, 1/(kg m^2). In the plane all three are those of the axis z.
    pub inverse_inertias: [f64; 3],
    /// The number of each sphere among the bodies, and its place among the principal axes, m.
    pub spheres: Vec<(usize, V)>,
}

/// How far ahead velocities are predicted: the shares of the gains of half a step in velocities and in spins.
pub type Shares = Option<[f64; 2]>;

impl Clump {
    /// Returns I^-1 of a vector.
    pub fn turning(&self, vector: V) -> V {
        self.axes
            .iter()
            .zip(self.inverse_inertias)
            .fold(V::default(), |sum, (axis, a)| sum + *axis * (axis.dot(vector) * a))
    }

    /// Returns w, rad/s.
    pub fn spin(&self) -> V {
        self.turning(self.momentum)
    }

    /// Returns 1/m + (r x n) . I^-1 (r x n), 1/kg.
    pub fn mobility(&self, mass: f64, arm: V, normal: V) -> f64 {
        let turn = arm.cross(normal);
        1.0 / mass + turn.dot(self.turning(turn))
    }

    fn place(&self, b: V) -> V {
        self.axes.iter().zip(b.0).fold(V::default(), |sum, (axis, along)| sum + *axis * along)
    }

    /// Places the spheres by the present motion.
    pub fn place_spheres(&self, bodies: &mut [Body]) {
        let centre = bodies[self.centre];
        for &(number, b) in &self.spheres {
            let arm = self.place(b);
            let sphere = &mut bodies[number];
            sphere.arm = arm;
            sphere.position = centre.position + arm;
            sphere.spin = self.spin();
            sphere.velocity = centre.velocity + sphere.spin.cross(arm);
        }
    }

    /// Turns the body freely for `dt` and moves its spheres. The centre has been moved.
    pub fn drift(&mut self, bodies: &mut [Body], dt: f64, shares: Shares) {
        let before = self.spin();
        let former: Vec<V> = self.spheres.iter().map(|(_, b)| self.place(*b)).collect();
        self.turn_freely(dt);
        let middle = (before + self.spin()) * 0.5;
        let centre = bodies[self.centre];
        let half = 0.5 * dt;
        let [share, spin_share] = shares.unwrap_or([1.0; 2]);
        let end = centre.velocity + centre.force * (share * half / centre.mass);
        let end_spin = self.turning(self.momentum + centre.torque * (spin_share * half));
        for (&(number, b), former) in self.spheres.iter().zip(former) {
            let arm = self.place(b);
            let sphere = &mut bodies[number];
            sphere.arm = arm;
            sphere.position = centre.position + arm;
            sphere.velocity = centre.velocity + (arm - former) * (1.0 / dt);
            sphere.spin = middle;
            let gained = end + end_spin.cross(arm) - sphere.velocity;
            sphere.part = Part::Sphere {
                of: self.centre,
                gains: [gained * (1.0 / share), (end_spin - middle) * (1.0 / spin_share)],
            };
        }
    }

    /// Adds the loads of the spheres to the centre, and gives every sphere the contacts of the body.
    pub fn gather(&self, bodies: &mut [Body]) {
        let mut contacts = 0;
        for &(number, _) in &self.spheres {
            let Body { force, torque, arm, contacts: own, .. } = bodies[number];
            bodies[self.centre].force += force;
            bodies[self.centre].torque += torque + arm.cross(force);
            contacts += own;
        }
        for number in self.spheres.iter().map(|(number, _)| *number).chain([self.centre]) {
            bodies[number].contacts = contacts;
        }
    }

    /// Turns all axes about `axis` by `angle`, rad (Rodrigues' formula).
    fn turn(&mut self, axis: V, angle: f64) {
        let (sine, cosine) = angle.sin_cos();
        let turned = |e: V| e * cosine + axis.cross(e) * sine + axis * (axis.dot(e) * (1.0 - cosine));
        self.axes = self.axes.map(turned);
    }

    fn turn_freely(&mut self, dt: f64) {
        let a = self.inverse_inertias;
        let similar = |k: usize| (a[k] - a[(k + 1) % 3]).abs();
        let k = (0..3).min_by(|&i, &j| similar(i).total_cmp(&similar(j))).unwrap();
        let [p, q] = [(k + 1) % 3, (k + 2) % 3];
        for (axis, time) in [(p, 0.5 * dt), (q, dt), (p, 0.5 * dt)] {
            let angle = (a[axis] - a[k]) * self.axes[axis].dot(self.momentum) * time;
            self.turn(self.axes[axis], angle);
        }
        let size = self.momentum.length();
        if size > 0.0 {
            self.turn(self.momentum * (1.0 / size), size * a[k] * dt);
        }
    }
}
