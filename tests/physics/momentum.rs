//! Friction and rolling resistance conserve momentum. With the lever `ContactPoint` they conserve angular momentum too.
//!
//! Derivation: with half-kicks and x(t+dt) = x + dt v_h, sum m x(t+dt) x v_h = sum m x(t) x v_h because v_h x v_h = 0.
//! The angular momentum L = sum (m x x v + I w) therefore changes in a step by dt/2 times the sum of the torques,
//! orbital and on spins, at t and at t + dt. Each torque uses the positions at which its forces were evaluated. This
//! holds for any dt.
//!
//! A contact contributes x_ij x F - (l_i + l_j) n x F_t = (|x_ij| - l_i - l_j) n x F_t. That is zero with
//! `ContactPoint`, where the levers add up to the distance, and -delta n x F_t with `Radius`. Rolling torques are
//! opposite and cancel.

use glam::DVec3;

use crate::{Motion, motion, simulation, sphere};
use siloflow::grains::file::GrainRow;
use siloflow::random::Stream;

pub const STEPS: u64 = 5000;
pub const K: f64 = 1.0e4;

pub fn keys(solid: bool, contact: &str, dt: f64) -> String {
    let (space, gravity) = if solid { ("Solid", "(0.0, 0.0, 0.0)") } else { ("Plane", "(0.0, 0.0)") };
    format!(
        "space: {space}, gravity: {gravity}, contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], \
         step: Fixed({dt:?}), until: {:?}",
        STEPS as f64 * dt
    )
}

pub fn linear(lever: &str) -> String {
    format!(
        "Linear(k: {K:?}, damping: Restitution(0.5), attraction: Allowed, lever: {lever}, \
         tangential: Spring(k: 2.9e3, damping: PerMass(20.0), friction: 0.5), \
         rolling: (k: 1.0e3, damping: PerMass(20.0), friction: 0.1))"
    )
}

pub fn hertz(lever: &str) -> String {
    format!("Hertz(restitution: 0.5, attraction: Allowed, tangential: Mindlin(friction: 0.5), lever: {lever})")
}

/// Returns the linear law with twisting resistance, in solid space.
fn twisting(lever: &str) -> String {
    format!(
        "{}, twisting: (k: 1.0e3, damping: PerMass(20.0), friction: 0.1))",
        linear(lever).trim_end_matches(')').to_owned() + ")"
    )
}

/// Returns a law with adhesion, rolling resistance of constant torque and chosen tangential damping.
fn adhesive(lever: &str) -> String {
    format!(
        "Hertz(restitution: 0.5, attraction: Allowed, tangential: Mindlin(friction: 0.5, damping: OfNormal(0.7)), \
         rolling: (kind: Torque, friction: 0.1), adhesion: Dmt(0.5), lever: {lever})"
    )
}

pub fn inertia(solid: bool, grain: &GrainRow) -> f64 {
    (if solid { 0.4 } else { 0.5 }) * grain.mass * grain.radius * grain.radius
}

/// Returns momentum and angular momentum about the origin.
pub fn momenta(solid: bool, grains: &[GrainRow], state: &[Motion]) -> (DVec3, DVec3) {
    let momentum = grains.iter().zip(state).map(|(grain, now)| grain.mass * now.velocity).sum();
    let angular = |(grain, now): (&GrainRow, &Motion)| {
        grain.mass * now.position.cross(now.velocity) + inertia(solid, grain) * now.spin
    };
    (momentum, grains.iter().zip(state).map(angular).sum())
}

/// Returns 100 grains of two sizes that fly to their common centre, with additional random velocities and spins.
fn cloud(solid: bool) -> Vec<GrainRow> {
    let (wide, high) = if solid { (5, 5) } else { (10, 10) };
    let place = |x: u32, y: u32, z: u32| 0.085 * DVec3::new(f64::from(x), f64::from(y), f64::from(z));
    let middle = 0.5 * place(wide - 1, high - 1, if solid { 3 } else { 0 });
    let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    let grain = |i: u32| {
        let random = |name| DVec3::from(Stream::new(5, name).uniform(u64::from(i)).map(|u: f64| 2.0 * u - 1.0));
        let radius = if random("size").x < 0.0 { 0.03 } else { 0.04 };
        let at = place(i % wide, i / wide % high, i / wide / high);
        let velocity = flat * (0.5 * random("velocity") + 3.0 * (middle - at));
        let mut grain = sphere(i + 1, at, velocity, radius, 100.0 * radius * radius);
        grain.spin = 20.0 * random("spin") * if solid { DVec3::ONE } else { DVec3::Z };
        grain
    };
    (0..100).map(grain).collect()
}

/// Returns the changes of momentum and angular momentum in an implosion, each with the bound of its round-off.
fn changes(solid: bool, contact: &str) -> [(f64, f64); 2] {
    let grains = cloud(solid);
    let mut simulation = simulation(&keys(solid, contact, 2.0e-4), grains.clone());
    simulation.run_steps(0);
    let before = momenta(solid, &grains, &motion(&mut simulation));
    simulation.run();
    let state = motion(&mut simulation);
    let after = momenta(solid, &grains, &state);
    // Pair forces cancel exactly. Each half-kick of each grain rounds m v by half an ulp, and so does the sum of its
    // forces, with random sign. L has the same error times the arm x, and an error of the drift. A position is a
    // multiple of its ulp and a flight adds the same dt v in each step, so the drift has the same error in each step:
    // at most half an ulp, with a sign that is random per grain only.
    let speed = grains.iter().map(|grain| grain.velocity.length()).fold(0.0, f64::max);
    let arm = state.iter().map(|now| now.position.length()).fold(0.0, f64::max);
    let steps = STEPS as f64;
    let half_ulp = 0.5 * f64::EPSILON * 0.16 * speed;
    let kicks = (100.0 * 4.0 * steps).sqrt() * half_ulp;
    let drifts = 100.0f64.sqrt() * steps * half_ulp;
    [((after.0 - before.0).length(), kicks), ((after.1 - before.1).length(), (kicks + drifts) * arm)]
}

#[test]
fn imploding_frictional_cloud_conserves_momentum_and_angular_momentum_to_round_off() {
    let laws =
        [(true, linear as fn(&str) -> String), (false, linear), (true, adhesive), (false, adhesive), (true, twisting)];
    for (solid, law) in laws {
        let [(change, bound), (turned, angular_bound)] = changes(solid, &law("ContactPoint"));
        assert!(change < bound, "solid {solid}: {change:e} kg m/s, bound {bound:e}");
        assert!(turned < angular_bound, "solid {solid}: {turned:e} kg m^2/s, bound {angular_bound:e}");
        let [(change, bound), (turned, angular_bound)] = changes(solid, &law("Radius"));
        assert!(change < bound, "solid {solid}, Radius: {change:e} kg m/s, bound {bound:e}");
        // This change is no round-off: friction did act, and the bound above distinguishes the levers.
        assert!(turned > 1e6 * angular_bound, "solid {solid}, Radius: {turned:e} kg m^2/s");
    }
}
