//! The time step: how long it may be, and how long `step: Auto(error: ...)` makes it.
//!
//! One contact, w0 = sqrt(k/m), beta = c/(2 m), is stable for
//!
//! | scheme | dt below |
//! |---|---|
//! | `Verlet`, `SymplecticEuler`: drag half a step or a whole one old | 2/(sqrt(w0^2 + beta^2) + beta) |
//! | `Centred` ([`crate::contact::centred`]) | min(2/w0, 1/beta) |
//! | `ExplicitEuler` | 2 beta/w0^2: nothing without drag |
//!
//! An automatic step is the shortest of three, rounded down to two digits:
//!
//! * t_c/n for the shortest contact, with n steps in it: an impact is wrong, rms over the phases of the step and in units
//!   of its speed, by at most about 1/n^2 centred, by 0.6/n with lagged drag. The factors are the worst that `siloflow
//!   accuracy` measures for impacts with e from 0.2 to 1, mu up to 0.5 (0.9 and 0.6); Hertz's contacts are below.
//! * 0.8 of the limit of a dense bed.
//! * The fastest grain moves a tenth of the smallest radius.
//!
//! Chaos makes the paths of many grains differ whatever the step: the error is that of an impact, not of a run.

use std::f64::consts::PI;

use crate::check::Estimates;
use crate::integrate::Integrator;

/// Largest stable step, s, for a stiffness k (N/m), a drag coefficient c (N s/m) and a reduced mass (kg).
#[must_use]
pub fn limit(scheme: Integrator, k: f64, c: f64, mass: f64) -> f64 {
    let (w0, beta) = ((k / mass).sqrt(), 0.5 * c / mass);
    match scheme {
        // Written so that they hold without a spring or drag too.
        Integrator::Verlet | Integrator::SymplecticEuler => 2.0 / (w0.hypot(beta) + beta),
        Integrator::Centred => 1.0 / (0.5 * w0).max(beta),
        Integrator::ExplicitEuler if k == 0.0 => 1.0 / beta,
        Integrator::ExplicitEuler => 2.0 * beta / (w0 * w0),
    }
}

/// An automatic step.
#[derive(Clone, Debug, PartialEq)]
pub struct Automatic {
    /// The step, s.
    pub dt: f64,
    /// What decided.
    pub reason: String,
}

/// The step for an error of impacts, for estimates whose step is not known yet.
#[must_use]
pub fn automatic(estimates: &Estimates, error: f64) -> Automatic {
    let centred =
        estimates.scheme == Integrator::Centred || estimates.scheme == Integrator::Verlet && estimates.is_elastic;
    let steps = if centred { error.sqrt().recip() } else { 0.6 / error };
    let shortest = estimates.contact_duration.min(PI / estimates.frequency);
    let by_error = (
        shortest / steps,
        format!("{steps:.1} steps in a contact of {shortest:.3e} s keep impacts within {error:e} of their speed"),
    );
    let by_stability = (0.8 * estimates.bed_limit, "0.8 of the stability limit of a dense bed".to_owned());
    let by_way = (
        0.1 * estimates.radius / estimates.impact_speed,
        format!("at {:.2} m/s a grain moves a tenth of the smallest radius", estimates.impact_speed),
    );
    let shorter = |a: (f64, String), b: (f64, String)| if b.0 < a.0 { b } else { a };
    let (dt, reason) = shorter(shorter(by_error, by_stability), by_way);
    Automatic { dt: rounded_down(dt), reason }
}

/// To two digits.
fn rounded_down(x: f64) -> f64 {
    let unit = 10f64.powf(x.log10().floor() - 1.0);
    // 4.7e-5 is not 46.99999 units.
    (x / unit + 1e-9).floor() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_recurrences() {
        // w0 = 1, zeta = beta: the figures of plain Verlet's closed form, and of the centred one.
        for (zeta, verlet, centred) in
            [(0.0, 2.0, 2.0), (0.5, 1.236_068, 2.0), (1.0, 0.828_427, 1.0), (2.0, 0.472_136, 0.5)]
        {
            assert!((limit(Integrator::Verlet, 1.0, 2.0 * zeta, 1.0) - verlet).abs() < 1e-6, "{zeta}");
            assert!((limit(Integrator::Centred, 1.0, 2.0 * zeta, 1.0) - centred).abs() < 1e-15, "{zeta}");
        }
        assert!((limit(Integrator::Verlet, 0.0, 2.0, 1.0) - 1.0).abs() < 1e-15, "drag alone");
        assert!(limit(Integrator::ExplicitEuler, 1.0, 0.0, 1.0) == 0.0);
    }

    #[test]
    fn steps_are_round_and_not_longer() {
        for (x, round) in [(4.7e-5, 4.7e-5), (4.79e-5, 4.7e-5), (1.0e-3, 1.0e-3), (9.99, 9.9)] {
            assert!((rounded_down(x) / round - 1.0).abs() < 1e-12, "{x}: {}", rounded_down(x));
        }
    }
}
