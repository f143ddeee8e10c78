//! A single grain under gravity.

use crate::{grain, simulation, state};
use siloflow::prelude::*;

const G: f64 = 9.81;
const T: f64 = 1.0;
const V0: Vector = Vector::new(3.0, 2.0);

/// Returns the position of the grain at time T.
fn position_at_end(integrator: &str, steps: u32) -> Vector {
    let keys = format!(
        "gravity: (0.0, -{G}), contact: Linear(k: 1.0e5, damping: B(0.0)), integrator: {integrator}, \
         step: Fixed({:?}), until: {T}, watchdog: None",
        T / f64::from(steps)
    );
    let mut simulation = simulation(&keys, vec![grain(1, Vector::ZERO, V0, 0.04, 0.16)]);
    assert_eq!(simulation.run(), End::TimeReached);
    state(&mut simulation)[0].0
}

fn parabola() -> Vector {
    V0 * T - 0.5 * G * T * T * Vector::Y
}

#[test]
fn verlet_matches_the_parabola_to_round_off() {
    for steps in [10, 100, 1000] {
        let error = position_at_end("Verlet", steps).distance(parabola());
        // Each step rounds x and v, both below 8 in SI units here. An error of v acts until T, so n eps |x| + n eps |v|
        // T.
        let bound = 2.0 * f64::from(steps) * f64::EPSILON * 8.0;
        assert!(error < bound, "{steps} steps: {error:e} m, bound {bound:e} m");
    }
}

#[test]
fn explicit_euler_misses_the_parabola_by_g_t_dt_over_2() {
    for steps in [10, 100, 1000] {
        let error = position_at_end("ExplicitEuler", steps) - parabola();
        // x_n - x(T) = g T dt/2 is a closed form. It holds exactly but for the round-off derived above.
        let expected = 0.5 * G * T * T / f64::from(steps);
        let bound = 2.0 * f64::from(steps) * f64::EPSILON * 8.0;
        assert!((error.y - expected).abs() < bound && error.x.abs() < bound, "{steps} steps: {error}, not {expected}");
    }
}
