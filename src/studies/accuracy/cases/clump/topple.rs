//! A pair of discs (a dumbbell) that stands on one disc, leans, and topples: the lower disc is the pivot, and rolls on a rough floor.
//!
//! On a hard floor without slip, with the axis at the angle a to the vertical and the centre b from that of the lower disc, the energy integral is
//! m g b (cos a0 - cos a) = w²/2 (I + m (R² + b² + 2 R b cos a)): the centre is at the distance of the last bracket from the point of contact, about which
//! the body turns. The contact of the case is soft, so its answer is the integrated one.

use glam::DVec2;

use super::super::super::case::{Case, Measure};
use super::super::super::reference::closed::duration;
use super::super::super::reference::{Floor, Friction, Law, System};
use super::body::{Body, Motion};

const E: f64 = 0.5;
const M: f64 = 0.5;
const R: f64 = 0.03;
/// Half of the distance of the two centres, m.
const HALF: f64 = 0.025;
const G: f64 = 9.81;
/// Angle of the axis to the vertical at the start, rad.
const LEAN: f64 = 0.6;

fn pair() -> Body {
    Body::row(M, R, 2, 2.0 * HALF)
}

/// The pair just above a floor of this stiffness (N/m), and the duration of a contact, s.
fn leaning(k: f64) -> (System, f64) {
    let axis = DVec2::from_angle(std::f64::consts::FRAC_PI_2 - LEAN);
    let contact_duration = duration(k, E, false, 1.0 / pair().mobility(-axis * HALF - DVec2::Y * R, DVec2::Y));
    // The pair falls for half a contact duration, so that it presses on the floor at once without bouncing far.
    let drop = 0.5 * G * (0.5 * contact_duration).powi(2);
    let motion = Motion { centre: DVec2::Y * (R + HALF * axis.y + drop), axis, v: DVec2::ZERO };
    let friction = Some(Friction { k: 2.0 / 7.0 * k, share: 0.5, mu: 1.0, rolling: None });
    let system = System {
        clumps: vec![pair().clump(0, 0.0)],
        gravity: DVec2::NEG_Y * G,
        law: Law::Linear { k, e: E, attracts: false, friction },
        discs: pair().discs(&motion),
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)],
    };
    (system, contact_duration)
}

pub(super) fn case() -> Case {
    let (system, contact_duration) = leaning(1.0e5);
    Case {
        end: 15.0 * contact_duration,
        measure: Measure::Velocity(0.2),
        ..Case::integrated("clump-topple", "pair of discs that topples over the lower one", system, contact_duration)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::super::reference::path::Path;
    use super::*;

    #[test]
    fn on_a_hard_floor_the_pair_follows_the_energy_integral() {
        let end = case().end;
        let mut last = f64::INFINITY;
        for k in [1.0e5, 1.0e6, 1.0e7] {
            let (system, contact_duration) = leaning(k);
            let state = Path::new(&system, contact_duration / 100.0).sample(&[end]).remove(0);
            let lean = (state.x[2] - state.x[1]).normalize();
            let inertia = pair().gyration() + R * R + HALF * HALF + 2.0 * R * HALF * lean.y;
            let expected = -(2.0 * G * HALF * (LEAN.cos() - lean.y) / inertia).sqrt();
            // Without slip the lower disc rolls: its centre moves by R times the spin.
            let slip = state.v[1].x + R * state.w[1];
            let error = (state.w[0] / expected - 1.0).abs();
            assert!(error < 0.5 * last && slip.abs() < 0.02, "{k:e}: {} {expected} {slip}", state.w[0]);
            last = error;
        }
        assert!(last < 1e-3, "{last}");
    }
}
