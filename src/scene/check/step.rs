//! Stability limits of the time step, and the step that `step: Auto(error: ...)` chooses.
//!
//! w0 = sqrt(k/m), beta = c/(2 m). A single contact, whose grains touch nothing else, is stable for
//!
//! | scheme | stable for dt below |
//! |---|---|
//! | `Verlet`, `SymplecticEuler`: the drag is half a step or a whole step old | 2/(sqrt(w0^2 + beta^2) + beta) |
//! | `Centred` ([`crate::contact::centred`]) | min(2/w0, 1/beta) |
//! | `ExplicitEuler` | 2 beta/w0^2, never without drag; overdamped 2/(beta + sqrt(beta^2 - w0^2)) |
//!
//! [`crate::scene::check::crowd`] has the limits of several contacts.
//!
//! An automatic step is the shortest of three, rounded down to two digits:
//!
//! * t_c/n for the shortest contact, with n steps in it. The rms error of an impact over the phases of
//!   the step, in units of its speed, is at most about 1/n^2 (centred) or 0.6/n (lagged drag). The factors are the worst that `siloflow
//!   accuracy` measures for impacts with e from 0.2 to 1, mu up to 0.5 (0.9 and 0.6); Hertz contacts have smaller errors.
//! * 0.8 of the limit of a dense bed.
//! * The fastest grain moves a tenth of the smallest radius.
//!
//! The error is that of one impact, not of a run: in a run chaos separates the paths of many grains at any step.

use std::f64::consts::PI;

use crate::integrate::Integrator;
use crate::scene::check::Estimates;

/// Largest stable step of a single contact, s, for a stiffness k (N/m), a drag coefficient c (N s/m) and a reduced mass
/// (kg).
#[must_use]
pub fn limit(scheme: Integrator, k: f64, c: f64, mass: f64) -> f64 {
    let (w0, beta) = ((k / mass).sqrt(), 0.5 * c / mass);
    match scheme {
        // This form also holds without a spring or without drag.
        Integrator::Verlet | Integrator::SymplecticEuler => 2.0 / (w0.hypot(beta) + beta),
        Integrator::Centred => 1.0 / (0.5 * w0).max(beta),
        Integrator::ExplicitEuler if beta < w0 => 2.0 * beta / (w0 * w0),
        Integrator::ExplicitEuler => 2.0 / (beta + (beta * beta - w0 * w0).sqrt()),
    }
}

/// An automatic step.
#[derive(Clone, Debug, PartialEq)]
pub struct Automatic {
    /// The step, s.
    pub dt: f64,
    /// The criterion that decided.
    pub reason: String,
}

/// The automatic step for this error of impacts. The step of `estimates` is not used.
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

/// Rounds down to two digits.
fn rounded_down(x: f64) -> f64 {
    let unit = 10f64.powf(x.log10().floor() - 1.0);
    // Without this, 4.7e-5 would be rounded to 4.6e-5.
    (x / unit + 1e-9).floor() * unit
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

    #[test]
    fn steps_are_round_and_not_longer() {
        for (x, round) in [(4.7e-5, 4.7e-5), (4.79e-5, 4.7e-5), (1.0e-3, 1.0e-3), (9.99, 9.9)] {
            assert!((rounded_down(x) / round - 1.0).abs() < 1e-12, "{x}: {}", rounded_down(x));
        }
    }
}
