//! One oblique contact of two spinning grains, force by force: its torques at either lever, its friction in its plane.

use std::f64::consts::PI;

use glam::DVec3;

use crate::momentum::{K, STEPS, hertz, inertia, keys, linear, momenta};
use crate::{motion, simulation, sphere};
use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;
use siloflow::space::{Plane, Solid};
use siloflow::store::ParticleStore;

/// Places of two grains and the force on the first.
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

/// Two grains on their way to graze each other, the first with a spin.
fn grazing(solid: bool) -> Vec<GrainRow> {
    let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    let mut grains = vec![
        sphere(1, flat * DVec3::new(0.3, 0.1, 0.2), DVec3::ZERO, 0.04, 0.16),
        sphere(2, flat * DVec3::new(0.35, 0.14, 0.23), flat * DVec3::new(-1.0, -0.2, -0.4), 0.03, 0.09),
    ];
    grains[0].spin = DVec3::new(3.0, -4.0, 12.0) * if solid { DVec3::ONE } else { DVec3::Z };
    grains
}

/// Lets two grains graze each other and compares, in each step, the change of L with what leaked until then, and
/// without rolling resistance the spin of the first with what friction did at its lever.
fn graze(solid: bool, lever: &str, law: fn(&str) -> String) {
    let (contact, leaks, rolls) = (law(lever), lever == "Radius", law(lever).contains("rolling"));
    let (dt, grains) = (2.0e-5, grazing(solid));
    let reach = grains[0].radius + grains[1].radius;
    let mut simulation = simulation(&keys(solid, &contact, dt), grains.clone());
    // Every step rounds m v x and I w in both kicks, and m v x in the drift, of both grains: by half an ulp of what was
    // 0.09 kg x 1.1 m/s x 0.6 m together at first.
    let tolerance = |steps: u64| 4.0 * steps as f64 * f64::EPSILON * 0.09 * 1.1 * 0.6;
    let (mut leak, mut turned, mut last, mut touched) = (DVec3::ZERO, DVec3::ZERO, [DVec3::ZERO; 2], 0);
    let (mut start, mut spin) = (DVec3::ZERO, DVec3::ZERO);
    for step in 0..STEPS {
        simulation.run_steps(step);
        let state = motion(&mut simulation);
        let (angular, own) = (momenta(solid, &grains, &state).1, inertia(solid, &grains[0]) * state[0].spin);
        let (apart, force) = pair(&simulation, solid);
        // n x F is n x F_t: the normal force drops out.
        let (overlap, friction) = (reach - apart.length(), apart.normalize().cross(force));
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
    assert!(touched > 100 && last[1] == DVec3::ZERO, "{contact}, solid {solid}: met for {touched} steps");
    assert!(!leaks || leak.length() > 1e5 * tolerance(STEPS), "{contact}, solid {solid}: {leak} kg m^2/s");
}

#[test]
fn with_the_lever_radius_a_contact_leaks_its_overlap_times_its_friction_and_nothing_else() {
    for solid in [true, false] {
        graze(solid, "Radius", linear);
        graze(solid, "Radius", hertz);
    }
}

#[test]
fn with_the_lever_contact_point_a_contact_leaks_nothing() {
    for solid in [true, false] {
        graze(solid, "ContactPoint", linear);
        graze(solid, "ContactPoint", hertz);
    }
}

#[test]
fn friction_has_no_part_along_the_normal_however_it_turns() {
    for solid in [true, false] {
        let (dt, grains) = (2.0e-5, grazing(solid));
        let (m, reach) = ([grains[0].mass, grains[1].mass], grains[0].radius + grains[1].radius);
        let keys = format!("{}, integrator: Verlet", keys(solid, &linear("Radius"), dt));
        let mut simulation = simulation(&keys, grains);
        // c = 2 zeta sqrt(k m_eff), and e = 1/2 is exp(-pi zeta/sqrt(1 - zeta^2)).
        let ln = 2.0f64.ln();
        let c = 2.0 * ln / ln.hypot(PI) * (K * m[0] * m[1] / (m[0] + m[1])).sqrt();
        let (mut turned, mut first) = (0.0f64, None);
        for step in 0..STEPS {
            simulation.run_steps(step);
            let state = motion(&mut simulation);
            let (apart, force) = pair(&simulation, solid);
            if force == DVec3::ZERO || step == 0 {
                continue;
            }
            // The velocity that the drag saw is half a kick old.
            let half = state[0].velocity - state[1].velocity - 0.5 * dt * force * (1.0 / m[0] + 1.0 / m[1]);
            let n = apart.normalize();
            let expected = K * (reach - apart.length()) - c * half.dot(n);
            // Places of 0.5 m and speeds of 2 m/s, rounded a few times.
            let tolerance = 8.0 * f64::EPSILON * (K * 0.5 + c * 2.0);
            let error = (force.dot(n) - expected).abs();
            assert!(error < tolerance, "solid {solid}, step {step}: {error:e} N along the normal");
            turned = turned.max(n.angle_between(*first.get_or_insert(n)));
        }
        assert!(turned > 0.02, "solid {solid}: the normal turned by {turned} only");
    }
}
