//! One oblique contact of two spinning grains, step by step: its torques for both levers, and that its friction is
//! tangential.

use std::f64::consts::PI;

use glam::DVec3;

use crate::momentum::{K, STEPS, hertz, inertia, keys, linear, momenta};
use crate::{motion, simulation, sphere};
use siloflow::dem::space::{Plane, Solid};
use siloflow::dem::store::ParticleStore;
use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;

/// Returns the vector from the second to the first grain, m, and the force on the first, N.
fn pair(simulation: &Simulation, solid: bool) -> (DVec3, DVec3) {
    let world = simulation.world();
    if solid {
        let store = world.resource::<ParticleStore<Solid>>();
        let entries = store.by_id();
        let [first, second] = [0, 1].map(|grain| store.body[entries[grain]].position);
        (first - second, store.loads.force.of(entries[0]))
    } else {
        let store = world.resource::<ParticleStore<Plane>>();
        let entries = store.by_id();
        let [first, second] = [0, 1].map(|grain| store.body[entries[grain]].position);
        ((first - second).extend(0.0), store.loads.force.of(entries[0]).extend(0.0))
    }
}

/// Two grains about to graze each other; the first one spins.
fn grazing(solid: bool) -> Vec<GrainRow> {
    let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    let mut grains = vec![
        sphere(1, flat * DVec3::new(0.3, 0.1, 0.2), DVec3::ZERO, 0.04, 0.16),
        sphere(2, flat * DVec3::new(0.35, 0.14, 0.23), flat * DVec3::new(-1.0, -0.2, -0.4), 0.03, 0.09),
    ];
    grains[0].spin = DVec3::new(3.0, -4.0, 12.0) * if solid { DVec3::ONE } else { DVec3::Z };
    grains
}

/// Lets two grains graze each other. In each step it compares the change of the angular momentum L with the leak
/// accumulated so far. Without rolling resistance it also compares the spin of the first grain with the impulse of
/// friction at its lever.
fn graze(solid: bool, lever: &str, law: fn(&str) -> String) {
    let contact = law(lever);
    let leaks = lever == "Radius";
    let rolls = law(lever).contains("rolling");
    let dt = 2.0e-5;
    let grains = grazing(solid);
    let reach = grains[0].radius + grains[1].radius;
    let mut simulation = simulation(&keys(solid, &contact, dt), grains.clone());
    // Each step rounds m v x and I w in both kicks, and m v x in the drift, for both grains: by half an ulp of their
    // initial sum 0.09 kg x 1.1 m/s x 0.6 m.
    let tolerance = |steps: u64| 4.0 * steps as f64 * f64::EPSILON * 0.09 * 1.1 * 0.6;
    let mut leak = DVec3::ZERO;
    let mut turned = DVec3::ZERO;
    let mut last = [DVec3::ZERO; 2];
    let mut touched = 0;
    let mut start = DVec3::ZERO;
    let mut spin = DVec3::ZERO;
    for step in 0..STEPS {
        simulation.run_steps(step);
        let state = motion(&mut simulation);
        let angular = momenta(solid, &grains, &state).1;
        let own = inertia(solid, &grains[0]) * state[0].spin;
        let (apart, force) = pair(&simulation, solid);
        // n x F = n x F_t: the normal force drops out.
        let overlap = reach - apart.length();
        let friction = apart.normalize().cross(force);
        let arm = grains[0].radius - if leaks { 0.0 } else { overlap * grains[1].radius / reach };
        let torques = [if leaks { -overlap * friction } else { DVec3::ZERO }, -arm * friction];
        if step == 0 {
            (start, spin) = (angular, own);
        } else {
            leak += 0.5 * dt * (last[0] + torques[0]);
            turned += 0.5 * dt * (last[1] + torques[1]);
        }
        last = torques;
        touched += u64::from(force != DVec3::ZERO);
        let error = (angular - start - leak).length();
        assert!(error < tolerance(step + 1), "{contact}, solid {solid}, step {step}: {error:e} kg m^2/s");
        let error = (own - spin - turned).length();
        assert!(rolls || error < tolerance(step + 1), "{contact}, solid {solid}, step {step}: spin {error:e}");
    }
    assert!(touched > 100 && last[1] == DVec3::ZERO, "{contact}, solid {solid}: in contact for {touched} steps only");
    assert!(!leaks || leak.length() > 1e5 * tolerance(STEPS), "{contact}, solid {solid}: {leak} kg m^2/s");
}

#[test]
fn with_lever_radius_angular_momentum_changes_by_overlap_times_friction_only() {
    for solid in [true, false] {
        graze(solid, "Radius", linear);
        graze(solid, "Radius", hertz);
    }
}

#[test]
fn with_lever_contact_point_angular_momentum_is_conserved() {
    for solid in [true, false] {
        graze(solid, "ContactPoint", linear);
        graze(solid, "ContactPoint", hertz);
    }
}

#[test]
fn friction_has_no_component_along_a_turning_normal() {
    for solid in [true, false] {
        let dt = 2.0e-5;
        let grains = grazing(solid);
        let m = [grains[0].mass, grains[1].mass];
        let reach = grains[0].radius + grains[1].radius;
        let keys = format!("{}, integrator: Verlet", keys(solid, &linear("Radius"), dt));
        let mut simulation = simulation(&keys, grains);
        // c = 2 zeta sqrt(k m_eff), where e = 1/2 = exp(-pi zeta/sqrt(1 - zeta^2)).
        let ln = 2.0f64.ln();
        let c = 2.0 * ln / ln.hypot(PI) * (K * m[0] * m[1] / (m[0] + m[1])).sqrt();
        let mut turned = 0.0f64;
        let mut first = None;
        for step in 0..STEPS {
            simulation.run_steps(step);
            let state = motion(&mut simulation);
            let (apart, force) = pair(&simulation, solid);
            if force == DVec3::ZERO || step == 0 {
                continue;
            }
            // The damping force was evaluated with the velocity of half a kick earlier.
            let half = state[0].velocity - state[1].velocity - 0.5 * dt * force * (1.0 / m[0] + 1.0 / m[1]);
            let n = apart.normalize();
            let expected = K * (reach - apart.length()) - c * half.dot(n);
            // Positions of 0.5 m and speeds of 2 m/s, rounded a few times.
            let tolerance = 8.0 * f64::EPSILON * (K * 0.5 + c * 2.0);
            let error = (force.dot(n) - expected).abs();
            assert!(error < tolerance, "solid {solid}, step {step}: {error:e} N along the normal");
            turned = turned.max(n.angle_between(*first.get_or_insert(n)));
        }
        assert!(turned > 0.02, "solid {solid}: the normal turned by {turned} only");
    }
}
