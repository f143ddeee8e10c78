//! A sphere that hits a wall obliquely: the impact in siloflow, and the same spring, dashpot and slider as differential
//! equations, solved by Runge-Kutta.
//!
//! The friction spring is loaded by v_s = v_t + R w. With q = m R^2/I a force F_t changes v_s at the rate (1 + q)
//! F_t/m. N is the number of steps per undamped contact, never an integer.

use std::f64::consts::PI;

use siloflow::dem::space::Solid;
use siloflow::prelude::*;

use crate::{grain, motion, simulation, sphere};

pub const N: f64 = 400.0 + PI / 8.0;

/// A sphere and a wall, SI: normal spring k d^p, tangential stiffness k_t d^(p-1).
pub struct Law {
    pub keys: String,
    pub p: f64,
    pub k: f64,
    pub k_t: f64,
    /// c = 2 z sqrt(k' m), c_t = 2 z sqrt(k_t m): z = sqrt(5/6) zeta.
    pub zeta: f64,
    pub friction: f64,
    pub mass: f64,
    pub radius: f64,
}

/// Returns the law of Chung and Ooi's spheres, on a wall a thousand times as stiff.
pub fn mindlin([young, poisson, density]: [f64; 3], radius: f64, e: f64, friction: f64) -> Law {
    let keys = format!(
        "contact: Hertz(restitution: {e:?}, attraction: Allowed, tangential: Mindlin(friction: {friction:?})), \
         materials: [(young: {young:?}, poisson: {poisson:?}), (young: {:?}, poisson: {poisson:?})],",
        1000.0 * young
    );
    let modulus = young / (1.0 - poisson * poisson) / 1.001;
    let shear_modulus = young / (2.0 * (1.0 + poisson) * (2.0 - poisson)) / 1.001;
    Law {
        keys,
        p: 1.5,
        k: 4.0 / 3.0 * modulus * radius.sqrt(),
        k_t: 8.0 * shear_modulus * radius.sqrt(),
        zeta: -e.ln() / (PI * PI + e.ln().powi(2)).sqrt(),
        friction,
        mass: 4.0 / 3.0 * PI * density * radius.powi(3),
        radius,
    }
}

/// Velocities after a contact: normal and tangential velocity, and w with v_s = v_t + R w.
#[derive(Clone, Copy)]
pub struct After {
    pub normal: f64,
    pub tangential: f64,
    pub spin: f64,
}

impl Law {
    fn deepest(&self, v_n: f64) -> f64 {
        (0.5 * (self.p + 1.0) * self.mass * v_n * v_n / self.k).powf(1.0 / (self.p + 1.0))
    }

    fn duration(&self, v_n: f64) -> f64 {
        if self.p == 1.0 { PI * (self.mass / self.k).sqrt() } else { 2.943_275_184 * self.deepest(v_n) / v_n }
    }

    /// Returns w_t dt with w_t = sqrt((1 + q) k_t/m) at the deepest point, and the error of damping that is evaluated
    /// half a step late and begins and ends within a step. That error is c dt/(2 m) along the normal, (1 + q) c_t dt/(2
    /// m) across it, and the latter once more for the ends.
    pub fn steps_and_drag(&self, v_n: f64, q: f64) -> (f64, f64) {
        let k_t = self.k_t * self.deepest(v_n).powf(self.p - 1.0);
        let step = ((1.0 + q) * k_t / self.mass).sqrt() * self.duration(v_n) / N;
        (step, self.zeta * 3.68 / N + 2.0 * self.zeta * (1.0 + q).sqrt() * step)
    }

    pub fn simulate(&self, space: &str, v_n: f64, v_t: f64, phase: f64) -> After {
        let dt = self.duration(v_n) / N;
        let height = self.radius + v_n * dt * (1.0 + phase);
        let (normal, along, scene, row) = if space == "Solid" {
            // Not along an axis, so that both components of the tangent plane are used.
            let n = Solid::Z;
            let t = Solid::new(0.6, -0.8, 0.0);
            let wall = "space: Solid, gravity: (0.0, 0.0, 0.0), \
                        walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), species: 1)]";
            (n, t, wall, sphere(1, n * height, t * v_t - n * v_n, self.radius, self.mass))
        } else {
            let wall = "gravity: (0.0, 0.0), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0), species: 1)]";
            let row = grain(1, Vector::Y * height, Vector::new(v_t, -v_n), self.radius, self.mass);
            (Solid::Y, Solid::X, wall, row)
        };
        let keys = format!("{scene}, {} step: Fixed({dt:?}), until: 1.0", self.keys);
        let mut simulation = simulation(&keys, vec![row]);
        simulation.run_steps((1.2 * N) as u64);
        let after = motion(&mut simulation).remove(0);
        // The motion stays in the plane of the impact.
        let binormal = normal.cross(along);
        assert!(after.velocity.dot(binormal).abs() < N * f64::EPSILON * v_t);
        assert!((after.spin - after.spin.dot(binormal) * binormal).length() < N * f64::EPSILON * v_t / self.radius);
        let normal = after.velocity.dot(normal);
        let tangential = after.velocity.dot(along);
        After { normal, tangential, spin: -after.spin.dot(binormal) }
    }

    /// Integrates spring, dashpot and slider with fourth-order Runge-Kutta, for q of a sphere.
    pub fn integrate(&self, v_n: f64, v_t: f64) -> After {
        let h = self.duration(v_n) / 4000.0;
        // Returns normal force, k_t, c_t.
        let forces = |overlap: f64, rate: f64| {
            let overlap = overlap.max(0.0);
            let soft = overlap.powf(self.p - 1.0);
            let z = (5.0f64 / 6.0).sqrt() * self.zeta;
            let c = 2.0 * z * (self.p * self.k * soft * self.mass).sqrt();
            let k_t = self.k_t * soft;
            (self.k * soft * overlap + c * rate, k_t, 2.0 * z * (k_t * self.mass).sqrt())
        };
        // State: overlap, its rate, v_t, w, spring.
        let rates = |[overlap, rate, v_t, spin, spring]: [f64; 5]| {
            let (f_n, k_t, c_t) = forces(overlap, rate);
            let v_s = v_t + self.radius * spin;
            let cap = self.friction * f_n.abs();
            let f_t = (-k_t * spring - c_t * v_s).clamp(-cap, cap);
            // A stiffening spring keeps its force: k_t s' = k_t v_s - k_t' s.
            let kept = if rate > 0.0 && overlap > 0.0 { (self.p - 1.0) * rate / overlap * spring } else { 0.0 };
            [rate, -f_n / self.mass, f_t / self.mass, 2.5 * f_t / (self.mass * self.radius), v_s - kept]
        };
        let mut y = [0.0, v_n, v_t, 0.0, 0.0];
        loop {
            let ahead = |rates: [f64; 5], h: f64| std::array::from_fn(|i| y[i] + h * rates[i]);
            let r1 = rates(y);
            let r2 = rates(ahead(r1, 0.5 * h));
            let r3 = rates(ahead(r2, 0.5 * h));
            let r4 = rates(ahead(r3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (r1[i] + 2.0 * r2[i] + 2.0 * r3[i] + r4[i]));
            if y[0] <= 0.0 {
                return After { normal: -y[1], tangential: y[2], spin: y[3] };
            }
            let (f_n, k_t, c_t) = forces(y[0], y[1]);
            let v_s = y[2] + self.radius * y[3];
            let cap = self.friction * f_n.abs();
            let pull = -k_t * y[4] - c_t * v_s;
            if pull.abs() > cap {
                y[4] = -(cap * pull.signum() + c_t * v_s) / k_t;
            }
        }
    }
}
