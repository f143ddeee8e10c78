//! A cross of five equal discs spins freely, and hits a rough floor with one arm.
//!
//! By its symmetry the cross has one moment of inertia in the plane, like a disc; the closed form gives it. It turns one way or the other. Clockwise
//! the arm comes down faster than the centre. Its contact slips backwards at touch, and there the normal force, off the centre, turns the cross so
//! fast that the contact sticks in the same instant.

use glam::DVec2;

use super::super::super::case::Case;
use super::super::super::reference::closed::duration;
use super::super::super::reference::{Floor, Friction, Law, System};
use super::body::{Body, Motion};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const M: f64 = 0.5;
const R: f64 = 0.03;
const ARM: f64 = 0.045;
/// Spin before the impact, rad/s.
const SPIN: f64 = 20.0;

pub(super) fn cases() -> Vec<Case> {
    vec![
        case("clump-cross-slip", "spinning cross on a floor, slips at touch", SPIN),
        case("clump-cross-stick", "spinning cross on a floor, sticks at touch", -SPIN),
    ]
}

fn cross() -> Body {
    Body::cross(M, R, ARM)
}

/// The direction of the arm that hits the floor, at touch.
fn down() -> DVec2 {
    DVec2::from_angle(-1.1)
}

fn case(name: &'static str, title: &'static str, spin: f64) -> Case {
    let arm = down() * ARM - DVec2::Y * R;
    let contact_duration = duration(K, E, false, 1.0 / cross().mobility(arm, DVec2::Y));
    let flight = 2.0 * contact_duration;
    let v = DVec2::new(0.2, -1.0);
    let motion = Motion {
        centre: DVec2::Y * (R - ARM * down().y) - v * flight,
        // The first disc is at the other end of the axis.
        axis: -DVec2::from_angle(-spin * flight).rotate(down()),
        v,
    };
    let friction = Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu: 0.3, rolling: None });
    let system = System {
        clumps: vec![cross().clump(0, spin)],
        gravity: DVec2::ZERO,
        law: Law::Linear { k: K, e: E, attracts: false, friction },
        discs: cross().discs(&motion),
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)],
    };
    Case { end: 5.0 * contact_duration, ..Case::integrated(name, title, system, contact_duration) }
}

#[cfg(test)]
mod tests {
    use super::super::super::super::reference::path::Path;
    use super::*;

    #[test]
    fn the_cross_spins_freely_and_then_obeys_the_balances_of_an_impact() {
        for (case, spin) in cases().into_iter().zip([SPIN, -SPIN]) {
            let system = &case.systems[0];
            let times = [0.99 * 2.0 * case.contact_duration, case.end];
            let states = Path::new(system, case.contact_duration / 1000.0).sample(&times);
            assert!((states[0].w[0] - spin).abs() < 1e-12, "{}", states[0].w[0]);
            assert!((states[0].v[0] - system.discs[0].v).length() < 1e-12, "{}", states[0].v[0]);
            let impulse = (states[1].v[0] - states[0].v[0]) * M;
            let turned = states[1].w[0] - spin;
            // I dw is the sum of r x J over the impact, in which the cross turns by less than spin t_c.
            let arms =
                [-1.0, 1.0].map(|end| DVec2::from_angle(end * SPIN * case.contact_duration).rotate(down()) * ARM);
            let ends = arms.map(|arm| (arm - DVec2::Y * R).perp_dot(impulse) / (M * cross().gyration()));
            let [least, most] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            assert!(impulse.y > 0.1 && (least..most).contains(&turned), "{impulse} {turned} {ends:?}");
        }
    }
}
