//! Stability limits of the time step for a single contact.
//!
//! w0 = sqrt(k/m), beta = c/(2 m). A single contact, whose grains touch nothing else, is stable for
//!
//! | scheme | stable for dt below |
//! |---|---|
//! | `Verlet`, `SymplecticEuler`: the drag is half a step or a whole step old | 2/(sqrt(w0^2 + beta^2) + beta) |
//! | `Centred` ([`siloflow_dem::contact::centred`]) | min(2/w0, 1/beta) |
//! | `ExplicitEuler` | 2 beta/w0^2, never without drag; overdamped 2/(beta + sqrt(beta^2 - w0^2)) |
//!
//! [`crate::scene::check::crowd`] has the limits of several contacts.

use siloflow_dem::integrate::Integrator;
use siloflow_dem::math;

/// Largest stable step of a single contact, s, for a stiffness k (N/m), a drag coefficient c (N s/m) and a reduced mass
/// (kg).
#[must_use]
pub fn limit(scheme: Integrator, k: f64, c: f64, mass: f64) -> f64 {
    let w0 = (k / mass).sqrt();
    let beta = 0.5 * c / mass;
    match scheme {
        // This form also holds without a spring or without drag.
        Integrator::Verlet | Integrator::SymplecticEuler => 2.0 / (math::hypot(w0, beta) + beta),
        Integrator::Centred => 1.0 / (0.5 * w0).max(beta),
        Integrator::ExplicitEuler if beta < w0 => 2.0 * beta / (w0 * w0),
        Integrator::ExplicitEuler => 2.0 / (beta + (beta * beta - w0 * w0).sqrt()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_recurrences() {
        // w0 = 1, zeta = beta: the values of the closed forms of plain Verlet and of `Centred`.
        for (zeta, verlet, centred) in
            [(0.0, 2.0, 2.0), (0.5, 1.236_068, 2.0), (1.0, 0.828_427, 1.0), (2.0, 0.472_136, 0.5)]
        {
            assert!((limit(Integrator::Verlet, 1.0, 2.0 * zeta, 1.0) - verlet).abs() < 1e-6, "{zeta}");
            assert!((limit(Integrator::Centred, 1.0, 2.0 * zeta, 1.0) - centred).abs() < 1e-15, "{zeta}");
        }
        assert!((limit(Integrator::Verlet, 0.0, 2.0, 1.0) - 1.0).abs() < 1e-15, "drag alone");
        // |1 + s dt| = 1 with s = -beta +- sqrt(beta^2 - w0^2): at zeta = 2 it is 2/(2 + sqrt 3).
        for (zeta, explicit) in [(0.0, 0.0), (0.5, 1.0), (1.0, 2.0), (1.25, 1.0), (2.0, 0.535_898)] {
            assert!((limit(Integrator::ExplicitEuler, 1.0, 2.0 * zeta, 1.0) - explicit).abs() < 1e-6, "{zeta}");
        }
        assert!((limit(Integrator::ExplicitEuler, 0.0, 2.0, 1.0) - 1.0).abs() < 1e-15, "drag alone");
    }
}
