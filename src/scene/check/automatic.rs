//! The step, and if the scene names none the scheme, that `step: Auto(error: ...)` chooses.
//!
//! **The promise.** The error of an impact is the error of a grain's velocity after it, |v - v_exact| and |R w - R w_exact| added in
//! quadrature, divided by the speed at which the bodies meet. It depends on the phase of the step at which the contact begins. `Auto` keeps the root mean square
//! over all phases within the requested error, for the shortest contact of the scene at its fastest impact. An impact at the worst phase
//! may have a larger error, up to 2.5 times the request in those tests.
//!
//! **The estimate.** With n steps in the contact, the rms error is at most first/n + second/n^2. If the tangential or the rolling spring
//! swings faster than the normal one, n counts steps in the accordingly shorter time.
//!
//! | contacts | `Verlet`, `SymplecticEuler`: first | `Centred`: first | second |
//! |---|---|---|---|
//! | without friction | min(0.46, 1 - e) | 0 | 0.75 |
//! | linear with friction | 1.1 | 0 | 2.0 |
//! | Hertz with friction | 0.8 | 0 | 1.1 |
//!
//! The factors bound errors that were measured in impacts of a disc on a floor, with n from 5 to 400: `tests/physics/automatic.rs` holds
//! them to it, with e from 0.2 to 0.95 and mu from 0.1 to 1, and with contacts that stick throughout (mu = 1000). They are not derived. Not covered are contacts that stick throughout although attraction is
//! allowed: the cap passes zero while the spring is loaded, and the scheme has to find that moment.
//!
//! **The step** is the shortest of three, rounded down to two digits: by this estimate; 0.8 of the stability limit of a dense bed
//! ([`crate::scene::check::crowd`]); and the fastest grain moves a tenth of the smallest radius.
//!
//! **The scheme** is the one of `Centred` and `Verlet` that simulates a second in less time. A step of `Centred` counts 1.2 times as
//! much as one of `Verlet`, the middle of the costs measured in beds (1.06 to 1.4).
//!
//! Adhesion is not covered either, but a bounce with it is longer than the contact that the estimate takes.
//!
//! The error is that of one impact, not of a run: in a run chaos separates the paths of many grains at any step. Forces that a behaviour
//! adds, and contacts of several grains at once, are not considered.

use crate::scene::check::quantities::Estimates;
use siloflow_dem::contact::Contact;
use siloflow_dem::integrate::Integrator;
use siloflow_dem::math;

/// Time of a step of `Centred` over that of a step of `Verlet`.
const COST_OF_CENTRED: f64 = 1.2;

/// An automatic step.
#[derive(Clone, Debug, PartialEq)]
pub struct Automatic {
    /// The step, s.
    pub dt: f64,
    /// The criterion that decided, and the scheme.
    pub reason: String,
}

/// The automatic step for this rms error of impacts. The step of `estimates` is not used.
#[must_use]
pub fn automatic(estimates: &Estimates, error: f64) -> Automatic {
    let steps = steps_for(estimates, error);
    let shortest = estimates.shortest_swing;
    let by_error = (
        shortest / steps,
        format!(
            "{steps:.1} steps in a contact of {shortest:.3e} s keep the rms error of an impact within {error:e} of its speed"
        ),
    );
    let by_stability = (0.8 * estimates.bed_limit, "0.8 of the stability limit of a dense bed".to_owned());
    let by_way = (
        0.1 * estimates.radius / estimates.impact_speed,
        format!("at {:.2} m/s a grain moves a tenth of the smallest radius", estimates.impact_speed),
    );
    let shorter = |a: (f64, String), b: (f64, String)| if b.0 < a.0 { b } else { a };
    let (dt, reason) = shorter(shorter(by_error, by_stability), by_way);
    Automatic { dt: rounded_down(dt), reason: format!("{reason}, with `{:?}`", estimates.scheme) }
}

/// Returns whichever of `Centred` and `Verlet` reaches this rms error at the lower cost. `of` estimates the scene with a scheme.
#[must_use]
pub fn cheaper(of: impl Fn(Integrator) -> Option<Estimates>, error: f64) -> Integrator {
    let step = |scheme| of(scheme).map_or(0.0, |estimates| automatic(&estimates, error).dt);
    if step(Integrator::Verlet) * COST_OF_CENTRED > step(Integrator::Centred) {
        Integrator::Verlet
    } else {
        Integrator::Centred
    }
}

/// The expected rms error of an impact at the step of `estimates`. `None` for `ExplicitEuler`, of which nothing is known, and if no two
/// bodies can meet.
#[must_use]
pub fn expected_error(estimates: &Estimates) -> Option<f64> {
    let (first, second) = factors(estimates);
    let steps = estimates.shortest_swing / estimates.dt;
    let is_known = estimates.scheme != Integrator::ExplicitEuler && steps.is_finite();
    is_known.then(|| first / steps + second / (steps * steps))
}

/// Steps in the shortest contact that the error needs.
fn steps_for(estimates: &Estimates, error: f64) -> f64 {
    let (first, second) = factors(estimates);
    // The root of first/n + second/n^2 = error.
    (first + f64::sqrt(first * first + 4.0 * second * error)) / (2.0 * error)
}

/// The factors of 1/n and 1/n^2 in the error.
fn factors(estimates: &Estimates) -> (f64, f64) {
    let (lagged, second) = match estimates.contact {
        Contact::Linear { tangential: Some(_), .. } => (1.1, 2.0),
        Contact::Hertz { tangential: Some(_), .. } => (0.8, 1.1),
        _ => ((1.0 - estimates.lowest_restitution).min(0.46), 0.75),
    };
    (if estimates.scheme == Integrator::Centred { 0.0 } else { lagged }, second)
}

/// Rounds down to two digits.
fn rounded_down(x: f64) -> f64 {
    let unit = math::pow(10.0, math::log10(x).floor() - 1.0);
    // Without this, 4.7e-5 would be rounded to 4.6e-5.
    (x / unit + 1e-9).floor() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_not_longer() {
        for (x, round) in [(4.7e-5, 4.7e-5), (4.79e-5, 4.7e-5), (1.0e-3, 1.0e-3), (9.99, 9.9)] {
            assert!((rounded_down(x) / round - 1.0).abs() < 1e-12, "{x}: {}", rounded_down(x));
        }
    }

    /// The scheme of a scene of discs with these keys.
    fn scheme(keys: &str) -> Integrator {
        let text = format!(
            "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: ArealSquare(100.0), \
             fill: [(low: (0.0, 0.0), high: (1.0, 1.0), spacing: 0.1, radius: Fixed(0.04))], \
             walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], until: 1.0, pictures: None, {keys})"
        );
        crate::scene::load::from_text("test.ron", "test", std::path::Path::new(""), text, &[]).unwrap().scene.integrator
    }

    #[test]
    fn an_automatic_step_has_the_error_that_was_asked_for() {
        let text = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: ArealSquare(100.0), \
             fill: [(low: (0.0, 0.0), high: (1.0, 1.0), spacing: 0.1, radius: Fixed(0.04))], integrator: Verlet, \
             walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], until: 1.0, pictures: None, step: Auto(error: 1.0e-2))";
        let load =
            |text: &str| crate::scene::load::from_text("t.ron", "t", std::path::Path::new(""), text.to_owned(), &[]);
        let error = |text: &str| expected_error(&Estimates::of(&load(text).unwrap()).unwrap());
        // The step is rounded down to two digits, so that its error is up to a tenth less.
        assert!((0.9e-2..=1.0e-2).contains(&error(text).unwrap()), "{:?}", error(text));
        let centred = text.replace("Verlet", "Centred");
        assert!((0.8e-2..=1.0e-2).contains(&error(&centred).unwrap()), "{:?}", error(&centred));
        let explicit = text.replace("Verlet", "ExplicitEuler").replace("Auto(error: 1.0e-2)", "Fixed(1.0e-5)");
        assert_eq!(error(&explicit), None);
    }

    #[test]
    fn a_scene_without_a_scheme_gets_the_cheaper_one() {
        // With an error of a tenth stability decides, and a bed with drag is stable for longer steps of `Verlet`.
        assert_eq!(scheme("step: Auto(error: 0.1)"), Integrator::Verlet);
        assert_eq!(scheme("step: Auto(error: 1.0e-3)"), Integrator::Centred);
        assert_eq!(scheme("step: Auto(error: 0.1), integrator: Centred"), Integrator::Centred);
        assert_eq!(scheme("step: Auto(error: 1.0e-3), integrator: Verlet"), Integrator::Verlet);
        assert_eq!(scheme("step: Fixed(1.0e-4)"), Integrator::Centred);
    }
}
