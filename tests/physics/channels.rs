//! What tangential dashpots take, told contact by contact, against what the whole of the books says.
//!
//! Two spheres, or one and a wall, meet without normal damping and without sliding, so that all that is dissipated goes through
//! tangential dashpots. The slip speed u falls as u' = -kappa u, kappa = 7 c/(2 m_eff), in steps of 1 - kappa dt.
//! The whole counts c u_h u dt in a step, with u_h of half a step before and u = u_h (1 - kappa dt/2); the channel counts
//! c u_h^2 dt. With sum u_h^2 = (u_0^2 - u_1^2)/(kappa dt (2 - kappa dt)) the two differ by
//! c dt (u_0^2 - u_1^2)/(2 (2 - kappa dt)) in velocity Verlet. Centred contacts know the speed of the step's end: second order.

use glam::DVec3;
use siloflow::energy::{Channels, EnergyFlows};

use crate::{motion, simulation, sphere};

const M: f64 = 2.0;
const K: f64 = 1e6;
const C: f64 = 60.0;
/// So large that normals hardly turn while a contact lasts: by `SLIP` t_c/R, 2e-3.
const R: f64 = 1.0;
const SLIP: f64 = 0.7;

/// The whole, and the channel, J; and the slip speed afterwards, m/s. `phase` says where in a step the contact begins.
fn meet(wall: bool, integrator: &str, dt: f64, phase: f64) -> (f64, f64, f64) {
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
    assert!(now[0].velocity.x > if wall { 0.9 } else { -0.1 }, "still in touch");
    let (other_v, other_w) = if wall { (0.0, 0.0) } else { (now[1].velocity.y, now[1].spin.z) };
    let slip = now[0].velocity.y - other_v - R * (now[0].spin.z + other_w);
    let world = simulation.world();
    (world.resource::<EnergyFlows>().dissipated, world.resource::<Channels>().tangential, slip.abs())
}

#[test]
fn the_dashpots_channel_differs_from_the_whole_as_the_scheme_says() {
    for wall in [false, true] {
        let reduced_mass = if wall { M } else { 0.5 * M };
        let kappa = 3.5 * C / reduced_mass;
        for (dt, phase) in [(2e-5, 0.1), (2e-5, 0.6), (1e-5, 0.3)] {
            let (whole, channel, after) = meet(wall, "Verlet", dt, phase);
            let expected = C * dt * (SLIP * SLIP - after * after) / (2.0 * (2.0 - kappa * dt));
            assert!(whole > 0.02, "hardly any slip: {whole} J");
            let share = (channel - whole) / expected;
            // The turning of the normal: twice 2e-3 at most, in whole and channel.
            assert!((share - 1.0).abs() < 1e-2, "wall {wall}, dt {dt}, phase {phase}: {share}");
        }
    }
}

#[test]
fn centred_contacts_make_it_second_order() {
    for wall in [false, true] {
        let [coarse, fine] = [4e-5, 1e-5].map(|dt| {
            let errors = [0.05, 0.25, 0.45, 0.65, 0.85].map(|phase| {
                let (whole, channel, _) = meet(wall, "Centred", dt, phase);
                channel / whole - 1.0
            });
            crate::rms(&errors)
        });
        let order = (coarse / fine).log2() / 2.0;
        assert!(order > 1.8, "wall {wall}: {coarse:e}, {fine:e}, order {order}");
    }
}
