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
//! In a crowd ([`in_crowd`]) the motion that first becomes unstable changes its sign in each step. If contacts take part in
//! it with weights W, and m is its mass, the limit is
//!
//! * sum W (k dt^2 + 2 c dt) = 4 m with lagged drag, which for one contact is the limit above;
//! * sum W (k dt^2 + 4 c dt/(1 + b)) = 4 m centred, with b = c dt/(2 m_c) and the reduced mass m_c of that contact alone. The
//!   drag at the end of the step is implicit in the contact's own force, and lags for all others. With the second difference
//!   s_(n+1) = x_(n+1) - 2 x_n + x_(n-1) the motion is s_(n+2) = -(K dt^2/m) x_(n+1) - (C dt/m) (x_(n+1) - x_n +
//!   (1 - b)/(1 + b) s_(n+1)/2), and x_n = (-1)^n gives the limit. The other two roots stay within the unit
//!   circle up to that step (Jury's conditions).
//!
//! So in a crowd with b < 1 `Centred` needs shorter steps than `Verlet`, down to half where drag decides. For a single
//! contact it allows longer steps, because it then includes the change of the spring force.
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

/// Contribution of contacts of one kind to a motion.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Weight of a contact, times the number of contacts.
    pub weight: f64,
    /// k, N/m.
    pub k: f64,
    /// c, N s/m.
    pub c: f64,
    /// Mobility of the contact: acceleration per unit of its own force, 1/kg.
    pub mobility: f64,
}

/// Largest stable step, s, of a motion with this mass (kg) in which these contacts take part.
#[must_use]
pub fn in_crowd(scheme: Integrator, pulls: &[Pull], mass: f64) -> f64 {
    if scheme == Integrator::ExplicitEuler {
        let [k, c] = [|pull: &Pull| pull.k, |pull: &Pull| pull.c]
            .map(|figure| pulls.iter().map(|pull| pull.weight * figure(pull)).sum::<f64>());
        return limit(scheme, k, c, mass);
    }
    let is_centred = scheme == Integrator::Centred;
    let load = |dt: f64| -> f64 {
        let of_one = |&Pull { weight, k, c, mobility }: &Pull| {
            let drag = if is_centred { 4.0 / (1.0 + 0.5 * mobility * c * dt) } else { 2.0 };
            weight * dt * (k * dt + drag * c)
        };
        pulls.iter().map(of_one).sum()
    };
    // Springs alone or lagged drag alone give the limit. Centred drag alone saturates at 2 W/mobility, which may stay below
    // 4 m at any step. The sum of all terms grows with the step.
    let total = |figure: fn(&Pull) -> f64| pulls.iter().map(|pull| pull.weight * figure(pull)).sum::<f64>();
    let [springs, drags] = [total(|pull| pull.k), total(|pull| pull.c)];
    let mut high = (2.0 * (mass / springs).sqrt()).min(if is_centred { f64::INFINITY } else { 2.0 * mass / drags });
    if !high.is_finite() {
        high = mass / drags;
        while high.is_finite() && load(high) < 4.0 * mass {
            high *= 2.0;
        }
    }
    if !high.is_finite() {
        return f64::INFINITY;
    }
    let mut low = 0.0;
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if load(middle) < 4.0 * mass { low = middle } else { high = middle }
    }
    high
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

    /// `n` equal contacts in a motion of mass 1, each with this k and c and a reduced mass of 1.
    fn crowd(scheme: Integrator, n: f64, k: f64, c: f64) -> f64 {
        in_crowd(scheme, &[Pull { weight: n, k, c, mobility: 1.0 }], 1.0)
    }

    #[test]
    fn in_a_crowd_the_spectral_radius_passes_one_at_the_limit() {
        // x_n = lambda^n in the recurrence: p(lambda) = lambda^3 + (a + 2 B + B r - 2) lambda^2 + (1 - 2 B - 2 B r) lambda + B r.
        let radius = |n: f64, zeta: f64, dt: f64| {
            let (spring, own) = (n * dt * dt, zeta * dt);
            let [drag, rest] = [2.0 * n * own, n * own * (1.0 - own) / (1.0 + own)];
            let factors = [spring + drag + rest - 2.0, 1.0 - drag - 2.0 * rest, rest];
            // Iterates the recurrence itself, rescaled on the way, so that no root finder has to be trusted.
            let (mut last, mut log, steps) = ([1.0, -0.7, 0.4], 0.0f64, 20_000);
            for _ in 0..steps {
                let next = -(factors[0] * last[2] + factors[1] * last[1] + factors[2] * last[0]);
                let size = [last[1], last[2], next].iter().fold(0.0f64, |size, x: &f64| size.max(x.abs()));
                last = [last[1] / size, last[2] / size, next / size];
                log += size.ln();
            }
            (log / f64::from(steps)).exp()
        };
        for n in [1.0, 2.0, 3.0, 6.0] {
            for zeta in [0.01, 0.1, 0.3, 0.5, 1.0, 3.0] {
                let limit = crowd(Integrator::Centred, n, 1.0, 2.0 * zeta);
                let [below, above] = [0.99, 1.01].map(|share| radius(n, zeta, share * limit));
                assert!(below < 1.0 && above > 1.0 + 1e-4, "{n} contacts, zeta {zeta}: {below} {above}");
                assert!(limit < crowd(Integrator::Verlet, n, 1.0, 2.0 * zeta), "{n} contacts, zeta {zeta}");
            }
        }
    }

    #[test]
    fn a_crowd_of_one_is_the_lone_contact_with_lagged_drag_and_without_drag() {
        for (k, c) in [(1.0, 0.0), (1.0, 0.4), (1.0, 6.0), (0.0, 1.0)] {
            let lone = limit(Integrator::Verlet, k, c, 1.0);
            assert!((crowd(Integrator::Verlet, 1.0, k, c) / lone - 1.0).abs() < 1e-14, "{k} {c}");
        }
        assert!((crowd(Integrator::Centred, 4.0, 1.0, 0.0) - 1.0).abs() < 1e-14);
        // 8 N beta dt = 4 (1 + beta dt).
        assert!((crowd(Integrator::Centred, 3.0, 0.0, 2.0) - 0.2).abs() < 1e-14, "drag alone");
        let nothing = crowd(Integrator::Centred, 3.0, 0.0, 0.0);
        assert!(nothing.is_infinite() && crowd(Integrator::Verlet, 3.0, 0.0, 0.0).is_infinite());
    }

    #[test]
    fn steps_are_round_and_not_longer() {
        for (x, round) in [(4.7e-5, 4.7e-5), (4.79e-5, 4.7e-5), (1.0e-3, 1.0e-3), (9.99, 9.9)] {
            assert!((rounded_down(x) / round - 1.0).abs() < 1e-12, "{x}: {}", rounded_down(x));
        }
    }
}
