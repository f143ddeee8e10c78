//! A pair of discs (a dumbbell) set down on a slope with its axis along it: it slides on both discs.
//!
//! On a slope of the angle t the pair accelerates by g (sin t - mu cos t). Friction pulls at the radius R below the axis, so that statics of discs
//! at the distances +-b from the centre shifts the load N of the front disc and that of the one behind: their difference is mu R/b times their sum.

use glam::DVec2;

use super::super::super::case::{Case, Measure};
use super::super::super::reference::closed::duration;
use super::super::super::reference::{Floor, Friction, Law, System};
use super::body::{Body, Motion};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const M: f64 = 0.5;
const R: f64 = 0.03;
/// Half of the distance of the two centres, m.
const HALF: f64 = 0.025;
const MU: f64 = 0.3;
const G: f64 = 9.81;
/// Angle of the slope, rad.
const SLOPE: f64 = 0.5;
/// Velocity down the slope at the start, m/s.
const SPEED: f64 = 0.1;

fn gravity() -> DVec2 {
    DVec2::new(SLOPE.sin(), -SLOPE.cos()) * G
}

pub(super) fn case() -> Case {
    let pair = Body::row(M, R, 2, 2.0 * HALF);
    let contact_duration = duration(K, E, false, 1.0 / pair.mobility(DVec2::new(HALF, R), DVec2::Y));
    // The pair falls for half a contact duration, so that it presses on the slope at once without bouncing far.
    let drop = -0.5 * gravity().y * (0.5 * contact_duration).powi(2);
    let motion = Motion { centre: DVec2::Y * (R + drop), axis: DVec2::X, v: DVec2::X * SPEED };
    let friction = Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu: MU, rolling: None });
    let system = System {
        clumps: vec![pair.clump(0, 0.0)],
        gravity: gravity(),
        law: Law::Linear { k: K, e: E, attracts: false, friction },
        discs: pair.discs(&motion),
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)],
    };
    Case {
        end: 6.0 * contact_duration,
        measure: Measure::Velocity(SPEED),
        ..Case::integrated("clump-slide", "pair of discs that slides down a slope", system, contact_duration)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::super::reference::path::Path;
    use super::*;

    #[test]
    fn the_pair_comes_to_slide_with_the_acceleration_and_the_loads_of_statics() {
        let case = case();
        let times = [60.0, 80.0].map(|durations| durations * case.contact_duration);
        let [early, late] = &Path::new(&case.systems[0], case.contact_duration / 200.0).sample(&times)[..] else {
            panic!("two states")
        };
        let a = (late.v[0] - early.v[0]) / (times[1] - times[0]);
        let expected = G * (SLOPE.sin() - MU * SLOPE.cos());
        assert!((a.x / expected - 1.0).abs() < 1e-9 && a.y.abs() < 1e-9 && late.w[0].abs() < 1e-9, "{a} {expected}");
        // The springs carry the weight; the overlap of the front disc is greater.
        let [behind, front] = [1, 2].map(|disc| K * (R - late.x[disc].y));
        let weight = M * G * SLOPE.cos();
        assert!(((front + behind) / weight - 1.0).abs() < 1e-9, "{front} {behind} {weight}");
        // The axis leans forward by about 1e-4 rad, so the arms differ from b by its square only, and the lever of friction is R.
        let shift = (front - behind) / weight;
        assert!((shift - MU * R / HALF).abs() < 1e-4, "{shift}");
    }
}
