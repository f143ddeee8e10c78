//! A sphere on a rigid plane with other laws of the tangential spring than siloflow's: differential equations, integrated with fixed steps.
//!
//! With k = 4/3 E* sqrt(R), k_t = 8 G* sqrt(R delta), c_t and the normal damping as in [`siloflow_dem::contact::hertz`], friction changes the velocity of the
//! contact point v_s = v_t + R w. The laws differ in how the force of the spring follows k_t, which grows with the overlap and shrinks again:
//!
//! | law | force of the spring |
//! |---|---|
//! | siloflow | changes by k_t dS while k_t grows, and shrinks in proportion to k_t while k_t shrinks |
//! | `Present` | k_t S with the present k_t. A spring that is stretched gains energy while k_t grows |
//! | `Incremental` | changes by k_t dS at all times. A spring that is stretched gains energy while k_t shrinks |
//!
//! The error of the integration is below 1e-3 of the incoming velocity (tested).

use std::f64::consts::PI;

/// How the force of the tangential spring follows its stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spring {
    /// As in siloflow.
    Kept,
    /// k_t S.
    Present,
    /// The sum of k_t dS.
    Incremental,
}

/// A sphere on a plane a thousand times as stiff, SI.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    pub young: f64,
    pub poisson: f64,
    pub density: f64,
    pub radius: f64,
    pub restitution: f64,
    pub friction: f64,
    /// Share of Mindlin's k_t that the spring has.
    pub share: f64,
    pub spring: Spring,
}

/// Velocities after the impact: along the normal, along the plane (m/s), and the spin (rad/s), with v_s = v_t + R w.
#[derive(Clone, Copy, Debug)]
pub struct After {
    pub normal: f64,
    pub tangential: f64,
    pub spin: f64,
}

/// Steps in the duration of an elastic contact.
const STEPS: f64 = 4000.0;

impl Impact {
    /// Returns the motion after an impact at these velocities, m/s.
    pub fn after(&self, v_n: f64, v_t: f64) -> After {
        let r = self.radius;
        let nu = self.poisson;
        let modulus = self.young / (1.0 - nu * nu) / 1.001;
        let shear = self.share * self.young / (2.0 * (1.0 + nu) * (2.0 - nu)) / 1.001;
        let mass = 4.0 / 3.0 * PI * self.density * r.powi(3);
        let k = 4.0 / 3.0 * modulus * r.sqrt();
        let log = self.restitution.ln();
        let z = (5.0f64 / 6.0).sqrt() * -log / PI.hypot(log);
        let deepest = (1.25 * mass * v_n * v_n / k).powf(0.4);
        let h = 2.943_275 * deepest / v_n / STEPS;
        let mut overlap = 0.0f64;
        let mut rate = v_n;
        let mut along = v_t;
        let mut spin = 0.0;
        // The force of the spring, or its displacement.
        let mut force = 0.0f64;
        let mut stretch = 0.0f64;
        loop {
            overlap += 0.5 * h * rate;
            let root = overlap.max(0.0).sqrt();
            let normal = k * root.powi(3) + 2.0 * z * (1.5 * k * root * mass).sqrt() * rate;
            let k_t = 8.0 * shear * r.sqrt() * root;
            let c_t = 2.0 * z * (k_t * mass).sqrt();
            let slip = along + r * spin;
            let cap = self.friction * normal.abs();
            let spring = if self.spring == Spring::Present {
                stretch += slip * h;
                -k_t * stretch
            } else {
                if self.spring == Spring::Kept && rate < 0.0 {
                    // The overlap of the step before.
                    force *= root / (overlap - rate * h).max(f64::MIN_POSITIVE).sqrt();
                }
                force - k_t * slip * h
            };
            let friction = (spring - c_t * slip).clamp(-cap, cap);
            force = friction + c_t * slip;
            if self.spring == Spring::Present && k_t > 0.0 {
                stretch = -force / k_t;
            }
            rate -= h * normal / mass;
            along += h * friction / mass;
            spin += 2.5 * h * friction / (mass * r);
            overlap += 0.5 * h * rate;
            if overlap <= 0.0 && rate < 0.0 {
                return After { normal: -rate, tangential: along, spin };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Impact = Impact {
        young: 2.08e11,
        poisson: 0.3,
        density: 7850.0,
        radius: 1e-5,
        restitution: 1.0,
        friction: 0.3,
        share: 1.0,
        spring: Spring::Kept,
    };

    #[test]
    fn gross_sliding_is_the_closed_form_for_every_law() {
        for spring in [Spring::Kept, Spring::Present, Spring::Incremental] {
            let after = Impact { spring, ..STEEL }.after(5.0, 10.0 * 1.5);
            // v_t falls by mu (1 + e) v_n, and R w = -2.5 of that.
            assert!((after.normal - 5.0).abs() < 5e-3, "{after:?}");
            assert!((after.tangential - 12.0).abs() < 1.5e-2 && (1e-5 * after.spin + 7.5).abs() < 4e-2, "{after:?}");
        }
    }

    #[test]
    fn the_law_of_siloflow_gives_what_siloflow_gives() {
        // Recoil v_s/(mu v_n) of siloflow, as `docs/explanation/validation.md` has it, in two digits.
        for (ratio, recoil) in [(1.01, 0.42), (2.0, -0.19), (2.99, -0.98), (4.0, -1.40), (5.0, -1.44)] {
            let after = STEEL.after(5.0, ratio * 1.5);
            let found = (after.tangential + 1e-5 * after.spin) / 1.5;
            assert!((found - recoil).abs() < 0.01, "{ratio}: {found}");
        }
    }
}
