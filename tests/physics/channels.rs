//! Checks the dissipation that the tangential channel accumulates per contact against the total of the energy balance.
//!
//! Two spheres, or one sphere and a wall, collide without normal damping and without sliding. All dissipation is then
//! due to the tangential dashpot. The slip speed u falls as u' = -kappa u with kappa = 7 c/(2 m_eff), by the factor 1 -
//! kappa dt per step.
//!
//! The total counts c u_h u dt in a step. Here u_h is the slip speed half a step earlier, and u = u_h (1 - kappa dt/2).
//! The channel counts c u_h^2 dt. With sum u_h^2 = (u_0^2 - u_1^2)/(kappa dt (2 - kappa dt)), the two differ by c dt
//! (u_0^2 - u_1^2)/(2 (2 - kappa dt)) in velocity Verlet. Centred contacts evaluate the speed at the end of the step;
//! there the difference is of second order.

use glam::DVec3;
use siloflow::energy::{Channels, EnergyFlows};

use crate::{motion, simulation, sphere};

const M: f64 = 2.0;
const K: f64 = 1e6;
const C: f64 = 60.0;
/// Large, so that normals hardly turn during a contact: by `SLIP` t_c/R = 2e-3.
const R: f64 = 1.0;
const SLIP: f64 = 0.7;

/// Returns the total and the channel's dissipation, J, and the slip speed after the contact, m/s. `phase` is the share
/// of a step at which the contact begins.
fn collide(wall: bool, integrator: &str, dt: f64, phase: f64) -> (f64, f64, f64) {
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), integrator: {integrator}, step: Fixed({dt:e}), until: 1.0, \
         contact: Linear(k: {K:e}, damping: B(0.0), tangential: Dashpot(damping: B({C:e}), friction: 1.0e6)), walls: [{}]",
        if wall { "HalfPlane(point: (0.0, 0.0, 0.0), normal: (1.0, 0.0, 0.0))" } else { "" }
    );
    let gap = 1.0 * dt * (1.0 + phase);
    let moving = sphere(1, DVec3::new(R + gap, 0.0, 0.0), DVec3::new(-1.0, SLIP, 0.0), R, M);
    let resting = sphere(2, DVec3::new(-R, 0.0, 0.0), DVec3::ZERO, R, M);
    let mut simulation = simulation(&keys, if wall { vec![moving] } else { vec![moving, resting] });
    simulation.run_steps((6e-3 / dt) as u64);
    let now = motion(&mut simulation);
    assert!(now[0].velocity.x > if wall { 0.9 } else { -0.1 }, "the contact has not ended");
    let (other_v, other_w) = if wall { (0.0, 0.0) } else { (now[1].velocity.y, now[1].spin.z) };
    let slip = now[0].velocity.y - other_v - R * (now[0].spin.z + other_w);
    let world = simulation.world();
    (world.resource::<EnergyFlows>().dissipated, world.resource::<Channels>().tangential, slip.abs())
}

#[test]
fn tangential_channel_differs_from_total_by_the_first_order_term_of_verlet() {
    for wall in [false, true] {
        let reduced_mass = if wall { M } else { 0.5 * M };
        let kappa = 3.5 * C / reduced_mass;
        for (dt, phase) in [(2e-5, 0.1), (2e-5, 0.6), (1e-5, 0.3)] {
            let (total, channel, after) = collide(wall, "Verlet", dt, phase);
            let expected = C * dt * (SLIP * SLIP - after * after) / (2.0 * (2.0 - kappa * dt));
            assert!(total > 0.02, "too little slip: {total} J");
            let share = (channel - total) / expected;
            // The turning of the normal contributes 2e-3 at most, both to the total and to the channel.
            assert!((share - 1.0).abs() < 1e-2, "wall {wall}, dt {dt}, phase {phase}: {share}");
        }
    }
}

#[test]
fn with_centred_contacts_channel_and_total_differ_by_second_order() {
    for wall in [false, true] {
        let [coarse, fine] = [4e-5, 1e-5].map(|dt| {
            let errors = [0.05, 0.25, 0.45, 0.65, 0.85].map(|phase| {
                let (total, channel, _) = collide(wall, "Centred", dt, phase);
                channel / total - 1.0
            });
            crate::rms(&errors)
        });
        let order = (coarse / fine).log2() / 2.0;
        assert!(order > 1.8, "wall {wall}: {coarse:e}, {fine:e}, order {order}");
    }
}
