//! Rigid bodies of several spheres: the free top, conserved quantities, orders of convergence, and the limit of one sphere.

use std::num::NonZeroUsize;
use std::path::Path;

use glam::{DQuat, DVec3};
use siloflow::dem::bodies::Orientation;
use siloflow::dem::space::{Linear, Rotor, Space};
use siloflow::dem::store::ParticleStore;
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::grains::shaped::{Posture, Shapes};
use siloflow::measure::totals;
use siloflow::output::state_hash;
use siloflow::prelude::*;
use siloflow::random::Stream;

use crate::{Motion, motion, sphere};

/// Shapes of solid space: an irregular cluster, a straight rod, and a single sphere.
const SOLID_SHAPES: &str = "{
    \"bean\": Spheres([(at: (0.0, 0.0, 0.0), radius: 0.04), (at: (0.05, 0.01, 0.0), radius: 0.03), (at: (0.02, 0.03, 0.02), radius: 0.025)]),
    \"ball\": Spheres([(at: (0.3, 0.0, 0.0), radius: 0.04)]),
    \"rod\": Capsule(length: 0.2, diameter: 0.06, spheres: 4),
}";

/// The same in the plane.
const PLANE_SHAPES: &str = "{
    \"bean\": Discs([(at: (0.0, 0.0), radius: 0.04), (at: (0.05, 0.01), radius: 0.03), (at: (0.02, 0.03), radius: 0.025)]),
    \"ball\": Discs([(at: (0.3, 0.0), radius: 0.04)]),
    \"rod\": Capsule(length: 0.2, diameter: 0.06, discs: 4),
}";

const DAMPED: &str = "Linear(k: 1.0e4, damping: Restitution(0.6), tangential: Spring(k: 8.0e3, damping: B(2.0), friction: 0.4), lever: ContactPoint)";

/// Returns a simulation of the scene with these keys, with the grains that `grains` makes of its shapes.
fn simulation(keys: &str, threads: usize, grains: impl FnOnce(&Shapes) -> Vec<GrainRow>) -> Simulation {
    let text = format!("({keys}, pictures: None)");
    let loaded = load::from_text("test.ron", "test", Path::new(""), text, &[]);
    let mut loaded = loaded.unwrap_or_else(|fault| panic!("{fault}\n{keys}"));
    loaded.grains = grains(&loaded.shapes);
    Simulation::with_plugins(&loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap(), |_| {}).unwrap()
}

/// A grain of a shape at scale one, of 1000 kg/m^3 (kg/m^2), with its principal axes turned by `rotor`.
fn shaped(shapes: &Shapes, name: &str, id: u32, position: DVec3, rotor: DQuat) -> GrainRow {
    let shape = shapes.named(name).unwrap();
    let facts = shapes.facts_of(shape).unwrap();
    let radius = facts.equivalent_radius;
    let is_solid = !shapes.rigid::<Solid>().is_empty();
    let size = if is_solid {
        4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
    } else {
        std::f64::consts::PI * radius.powi(2)
    };
    let posture = Some(Posture { shape, rotor, reach: facts.reach });
    GrainRow { posture, ..sphere(id, position, DVec3::ZERO, radius, 1000.0 * size) }
}

/// Total momentum and angular momentum about the origin.
fn momenta<V: Space>(simulation: &Simulation) -> (DVec3, DVec3) {
    let store = simulation.world().resource::<ParticleStore<V>>();
    let mut sums = (DVec3::ZERO, DVec3::ZERO);
    for i in store.integrated_rows() {
        let momentum = store.body[i].velocity.spread() * store.mass[i];
        let own = match store.body_of_row(i) {
            Some(body) => store.bodies.momentum[body.index()].spread(),
            None => store.spin(i).spread() / store.rotation[i].inverse_inertia,
        };
        sums.0 += momentum;
        sums.1 += store.body[i].position.spread().cross(momentum) + own;
    }
    sums
}

/// Jacobi's sn, cn and dn of u with the parameter m, by the arithmetic-geometric mean (Abramowitz and Stegun 16.4).
fn jacobi(u: f64, m: f64) -> [f64; 3] {
    let mut means = vec![[1.0, (1.0 - m).sqrt(), m.sqrt()]];
    while means[means.len() - 1][2].abs() > 1e-16 {
        let [a, b, _] = means[means.len() - 1];
        means.push([0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b)]);
    }
    let last = means.len() - 1;
    let mut phi = (1_u64 << last) as f64 * means[last][0] * u;
    let mut before = phi;
    for [a, _, c] in means[1..].iter().rev() {
        before = phi;
        phi = 0.5 * (phi + (c / a * phi.sin()).asin());
    }
    let dn = if last == 0 { 1.0 } else { phi.cos() / (before - phi).cos() };
    [phi.sin(), phi.cos(), dn]
}

/// The largest error of the spin in the body's axes over the spin, of a free top in a time of about six turns, with steps of `dt`.
fn top_error(scheme: &str, dt: f64) -> f64 {
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), contact: {DAMPED}, shapes: {SOLID_SHAPES}, integrator: {scheme}, \
         step: Fixed({dt:?}), until: 100.0"
    );
    let start = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.4);
    let gyration_of = |shapes: &Shapes| shapes.rigid::<Solid>()[shapes.named("bean").unwrap().index()].gyration;
    let mut gyration = DVec3::ZERO;
    let mut top = simulation(&keys, 1, |shapes| {
        gyration = gyration_of(shapes);
        let mut grain = shaped(shapes, "bean", 1, DVec3::ZERO, start);
        // Sorted moments I1 < I2 < I3: mostly about the largest, with the energy on the side of I3.
        grain.spin = start * spin_at_start(gyration);
        vec![grain]
    });
    let spin = spin_at_start(gyration);
    let order = ascending(gyration);
    let [i1, i2, i3] = order.map(|axis| gyration[axis]);
    let [w1, _, w3] = order.map(|axis| spin[axis]);
    let energy = i1 * w1 * w1 + i3 * w3 * w3;
    let square = (i1 * w1).powi(2) + (i3 * w3).powi(2);
    assert!(square > energy * i2, "the other case of the formula");
    let rate = ((i3 - i2) * (square - energy * i1) / (i1 * i2 * i3)).sqrt();
    let parameter = (i2 - i1) * (energy * i3 - square) / ((i3 - i2) * (square - energy * i1));
    let amplitude = ((energy * i3 - square) / (i2 * (i3 - i2))).sqrt();
    // The handedness of the axes in ascending order.
    let hand = (unit(order[0]).cross(unit(order[1]))).dot(unit(order[2]));
    let mut largest = 0.0_f64;
    let steps = (6.0 * std::f64::consts::TAU / spin.length() / dt).round() as u64;
    for step in 1..=steps {
        top.run_steps(step);
        let time = step as f64 * dt;
        let [sn, cn, dn] = jacobi(rate * time, parameter);
        let mut exact = DVec3::ZERO;
        exact[order[0]] = w1 * cn;
        exact[order[1]] = hand * amplitude * sn * (w1 * w3).signum();
        exact[order[2]] = w3 * dn;
        let (rotor, own) = rotor_and_spin(&mut top);
        largest = largest.max((rotor.inverse() * own - exact).length() / spin.length());
    }
    largest
}

fn unit(axis: usize) -> DVec3 {
    [DVec3::X, DVec3::Y, DVec3::Z][axis]
}

fn ascending(v: DVec3) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| v[a].total_cmp(&v[b]));
    order
}

/// The spin of the top at its start, in its principal axes, rad/s.
fn spin_at_start(gyration: DVec3) -> DVec3 {
    let order = ascending(gyration);
    let mut spin = DVec3::ZERO;
    spin[order[0]] = 1.0;
    spin[order[2]] = 5.0;
    spin
}

fn rotor_and_spin(simulation: &mut Simulation) -> (DQuat, DVec3) {
    let world = simulation.world_mut();
    let mut query = world.query::<(&Orientation<Solid>, &Spin<DVec3>)>();
    let (rotor, spin) = query.single(world).unwrap();
    (rotor.0, spin.0)
}

#[test]
fn a_free_top_follows_jacobis_functions_to_second_order() {
    for scheme in ["Verlet", "Centred"] {
        // 126 and 251 steps a turn.
        let [coarse, fine] = [0.01, 0.005].map(|dt| top_error(scheme, dt));
        assert!((coarse / fine - 4.0).abs() < 0.2, "{scheme}: {coarse:e} {fine:e}");
        assert!(coarse < 1e-2, "{scheme}: {coarse:e}");
    }
}

#[test]
fn a_cross_of_six_spheres_spins_like_a_sphere() {
    let (arm, radius) = (0.1, 0.08);
    let sphere = |axis: usize, side: f64| {
        let DVec3 { x, y, z } = unit(axis) * side * arm;
        format!("(at: ({x:?}, {y:?}, {z:?}), radius: {radius:?})")
    };
    let spheres: Vec<_> = (0..6).map(|number| sphere(number / 2, if number % 2 == 0 { 1.0 } else { -1.0 })).collect();
    let dt = 0.01;
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), contact: {DAMPED}, shapes: {{\"cross\": Spheres([{}])}}, \
         step: Fixed({dt:?}), until: 100.0",
        spheres.join(", ")
    );
    let start = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.4);
    // About no axis of symmetry.
    let spin = DVec3::new(1.0, 2.0, -3.0);
    let mut top =
        simulation(&keys, 1, |shapes| vec![GrainRow { spin, ..shaped(shapes, "cross", 1, DVec3::ZERO, start) }]);
    let turns = 6.0;
    let steps = (turns * std::f64::consts::TAU / spin.length() / dt).round();
    top.run_steps(steps as u64);
    let (rotor, after) = rotor_and_spin(&mut top);
    // Moments are exact to 1e-6, so the spin turns about the momentum by no more than that share of the turns.
    let angle = spin.length() * steps * dt;
    assert!((after - spin).length() < 1e-6 * angle * spin.length(), "{after}");
    // The step is exact for a body with equal moments.
    let exact = DQuat::from_axis_angle(spin.normalize(), angle) * start;
    let apart = rotor.angle_between(exact);
    assert!(apart < 1e-6 * angle, "{apart}");
}

#[test]
fn the_energy_of_a_free_top_does_not_drift_in_a_hundred_thousand_turns() {
    // 100 steps a turn. The energy of a symplectic scheme oscillates about a shifted value.
    let (inverse, momentum) = (DVec3::new(1.0, 0.55, 0.4), DVec3::new(0.4, 0.3, 2.0));
    let turns = 100_000;
    let dt = std::f64::consts::TAU / (0.4 * momentum.length()) / 100.0;
    let mut rotor = DQuat::IDENTITY;
    let hundredth = turns / 100 * 100;
    let mut sums = [0.0; 2];
    for step in 0..turns * 100 {
        let own = Rotor::<Solid>::own(rotor, momentum);
        rotor = Rotor::<Solid>::freely_turned(rotor, own, inverse, dt).rotor;
        let place = if step < hundredth {
            0
        } else if step >= turns * 100 - hundredth {
            1
        } else {
            continue;
        };
        sums[place] += 0.5 * momentum.dot(Rotor::<Solid>::spin(rotor, momentum, inverse));
    }
    assert!((sums[1] / sums[0] - 1.0).abs() < 1e-7, "{:e}", sums[1] / sums[0] - 1.0);
}

/// Grains that fly together in the middle: shapes and a few spheres.
fn implosion(shapes: &Shapes, is_solid: bool) -> Vec<GrainRow> {
    let random = Stream::new(7, "implosion");
    let flat = if is_solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    let grain = |i: u32| {
        let numbers = random.uniform::<6>(u64::from(i));
        let shift = DVec3::new(numbers[0], numbers[1], numbers[2]);
        let turns = [numbers[3], numbers[4], numbers[5]];
        let cell = DVec3::new(f64::from(i % 3) - 1.0, f64::from(i / 3 % 3) - 1.0, f64::from(i / 9) - 0.5) * flat;
        let position = cell * 0.24 + 0.01 * flat * shift;
        let rotor = if is_solid { Rotor::<Solid>::from_uniform(turns) } else { DQuat::from_rotation_z(6.0 * turns[0]) };
        let mut grain = match i % 3 {
            0 => shaped(shapes, "bean", i + 1, position, rotor),
            1 => shaped(shapes, "rod", i + 1, position, rotor),
            _ => sphere(i + 1, position, DVec3::ZERO, 0.05, 2.0),
        };
        grain.velocity = -4.0 * position + 0.2 * flat * DVec3::from(turns);
        grain.spin = if is_solid { shift * 3.0 } else { DVec3::Z * shift.x * 3.0 };
        grain
    };
    (0..if is_solid { 18 } else { 9 }).map(grain).collect()
}

fn implosion_keys(is_solid: bool, contact: &str, dt: f64) -> String {
    let (space, gravity, shapes) =
        if is_solid { ("Solid", "(0.0, 0.0, 0.0)", SOLID_SHAPES) } else { ("Plane", "(0.0, 0.0)", PLANE_SHAPES) };
    format!("space: {space}, gravity: {gravity}, contact: {contact}, shapes: {shapes}, step: Fixed({dt:?}), until: 0.4")
}

#[test]
fn colliding_bodies_conserve_momentum_and_angular_momentum_to_round_off() {
    for contact in [DAMPED, "Linear(k: 1.0e4, damping: Restitution(0.6))"] {
        for is_solid in [false, true] {
            let keys = implosion_keys(is_solid, contact, 1e-4);
            let mut simulation = simulation(&keys, 1, |shapes| implosion(shapes, is_solid));
            simulation.run_steps(0);
            let of = if is_solid { momenta::<Solid> } else { momenta::<Plane> };
            let (p, l) = of(&simulation);
            simulation.run();
            let (after_p, after_l) = of(&simulation);
            // 4000 steps round 18 momenta of about 10 kg m/s, with random signs.
            let bound = (4000.0 * 2.0 * 18.0_f64).sqrt() * 10.0 * f64::EPSILON;
            assert!((after_p - p).length() < bound, "{contact}: {:e}", (after_p - p).length());
            assert!((after_l - l).length() < bound, "{contact}: {:e}", (after_l - l).length());
            assert!(simulation.world().resource::<EnergyFlows>().dissipated > 0.1, "nothing collided");
        }
    }
}

#[test]
fn the_energy_balance_of_colliding_bodies_closes_to_second_order() {
    let error = |is_solid: bool, dt: f64| {
        let keys = implosion_keys(is_solid, DAMPED, dt);
        let mut simulation = simulation(&keys, 1, |shapes| implosion(shapes, is_solid));
        simulation.run();
        let world = simulation.world();
        let flows = world.resource::<EnergyFlows>();
        assert!(flows.dissipated > 0.1 * flows.released, "hardly anything collided");
        (totals::of_world(world).energy() - flows.expected()).abs() / flows.released
    };
    for is_solid in [false, true] {
        let [coarse, fine] = [2e-4, 5e-5].map(|dt| error(is_solid, dt));
        // A quarter of the step: a sixteenth, or less where errors of several contacts cancel.
        assert!(coarse < 5e-3 && fine < coarse / 8.0 + 1e-6, "{coarse:e} {fine:e}");
    }
}

#[test]
fn a_shape_of_one_sphere_moves_like_a_sphere() {
    for is_solid in [false, true] {
        let (space, gravity, shapes, up) = if is_solid {
            ("Solid", "(0.0, 0.0, -9.81)", SOLID_SHAPES, DVec3::Z)
        } else {
            ("Plane", "(0.0, -9.81)", PLANE_SHAPES, DVec3::Y)
        };
        let floor = if is_solid {
            "point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0)"
        } else {
            "point: (0.0, 0.0), normal: (0.0, 1.0)"
        };
        let keys = format!(
            "space: {space}, gravity: {gravity}, contact: {DAMPED}, shapes: {shapes}, step: Fixed(1.0e-4), until: 0.5, \
             walls: [HalfPlane({floor})]"
        );
        let run = |as_shape: bool| {
            let mut simulation = simulation(&keys, 1, |shapes| {
                let make = |id: u32, position: DVec3| {
                    let shaped = shaped(shapes, "ball", id, position, DQuat::IDENTITY);
                    let plain = GrainRow { radius: 0.04, posture: None, ..shaped };
                    if as_shape { shaped } else { plain }
                };
                let mut one = make(1, up * 0.2);
                one.velocity = DVec3::X;
                one.spin = if is_solid { DVec3::new(3.0, 5.0, -2.0) } else { DVec3::Z * 4.0 };
                vec![one, make(2, up * 0.1 + DVec3::X * 0.03)]
            });
            simulation.run();
            motion(&mut simulation)
        };
        let [shaped, plain] = [true, false].map(run);
        for (a, b) in shaped.iter().zip(&plain) {
            let differences = [a.position - b.position, (a.velocity - b.velocity) * 0.01, (a.spin - b.spin) * 1e-3];
            // Round-off of 1e-16, amplified in a few collisions; moments of inertia agree to 1e-10.
            assert!(differences.iter().all(|difference| difference.length() < 1e-9), "{a:?} {b:?}");
        }
        assert!(plain[0].velocity != DVec3::X);
    }
}

/// A rod of the plane that falls on a floor at an angle: its motion after the impact, with steps of `dt`.
fn rod_after_impact(scheme: &str, contact: &str, dt: f64) -> Motion {
    let keys = format!(
        "gravity: (0.0, 0.0), contact: {contact}, shapes: {PLANE_SHAPES}, integrator: {scheme}, step: Fixed({dt:?}), until: 0.5, \
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))]"
    );
    let mut rod = simulation(&keys, 1, |shapes| {
        let mut rod = shaped(shapes, "rod", 1, DVec3::new(0.0, 0.0803, 0.0), DQuat::from_rotation_z(0.6));
        rod.velocity = DVec3::new(0.3, -1.0, 0.0);
        vec![rod]
    });
    rod.run();
    motion(&mut rod)[0]
}

#[test]
fn the_damped_impact_of_a_rod_at_its_end_is_of_second_order() {
    let distance = |a: Motion, b: Motion| {
        ((a.velocity - b.velocity).length_squared() + (0.1 * (a.spin - b.spin)).length_squared()).sqrt()
    };
    // Steps incommensurate with the contact; errors are root mean squares over phases.
    let rms = |scheme: &str, dt: f64| {
        let phases = [1.0, 1.013, 1.029, 1.041, 1.057, 1.071];
        let exact = rod_after_impact(scheme, DAMPED, 2e-6);
        let errors = phases.map(|phase| distance(rod_after_impact(scheme, DAMPED, dt * phase), exact).powi(2));
        (errors.iter().sum::<f64>() / phases.len() as f64).sqrt()
    };
    let [coarse, fine] = [2e-4, 5e-5].map(|dt| rms("Centred", dt));
    let order = (coarse / fine).log2() / 2.0;
    assert!(order > 1.7, "{order}: {coarse:e} {fine:e}");
    let first = rms("Verlet", 5e-5);
    assert!(fine < 0.5 * first, "{fine:e} {first:e}");
}

/// Four spheres without symmetry, of which three are arms.
const STAR: &str = "{\"star\": Spheres([
    (at: (0.0, 0.0, 0.0), radius: 0.03), (at: (0.045, 0.0, 0.0), radius: 0.02), (at: (0.0, 0.045, 0.0), radius: 0.025), (at: (0.0, 0.0, 0.045), radius: 0.022),
])}";

/// A star that spins and hits a floor with one arm: momentum and angular momentum after impact number `impact`, with steps of `dt`. Unlike the spin,
/// they do not depend on the moment at which the run ends.
fn star_after_impact(scheme: &str, impact: usize, dt: f64) -> (DVec3, DVec3) {
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), contact: {DAMPED}, shapes: {STAR}, integrator: {scheme}, step: Fixed({dt:?}), until: 0.06, \
         walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))]"
    );
    let random = Stream::new(7, "impacts");
    let [turn, velocity, spin] = [0, 1, 2].map(|part| {
        let numbers = random.uniform::<3>(3 * impact as u64 + part);
        DVec3::from_array(numbers.map(|number| 2.0 * number - 1.0))
    });
    let mut star = simulation(&keys, 1, |shapes| {
        let arm = shapes.rigid::<Solid>()[0].spheres[1 + impact % 3];
        let down = DQuat::from_rotation_arc(arm.at.normalize(), -DVec3::Z);
        let reach = arm.at.length() + arm.radius;
        let tilt = DQuat::from_scaled_axis(0.15 * turn);
        let mut star = shaped(shapes, "star", 1, DVec3::Z * (reach + 0.01), tilt * down);
        star.velocity = DVec3::new(0.6 * velocity.x, 0.6 * velocity.y, -1.0);
        star.spin = 15.0 * spin;
        vec![star]
    });
    star.run();
    momenta::<Solid>(&star)
}

#[test]
fn damped_impacts_with_slip_that_turns_are_of_second_order() {
    const IMPACTS: usize = 6;
    // Root mean squares over impacts and phases of the step.
    let rms = |scheme: &str, dt: f64| {
        let phases = [1.0, 1.013, 1.029, 1.041];
        let errors = (0..IMPACTS).flat_map(|impact| {
            let exact = star_after_impact(scheme, impact, 2e-6);
            phases.map(|phase| {
                let after = star_after_impact(scheme, impact, dt * phase);
                (after.0 - exact.0).length_squared() + ((after.1 - exact.1) / 0.04).length_squared()
            })
        });
        (errors.sum::<f64>() / (IMPACTS * phases.len()) as f64).sqrt()
    };
    let [coarse, fine] = [2e-4, 5e-5].map(|dt| rms("Centred", dt));
    let order = (coarse / fine).log2() / 2.0;
    assert!(order > 1.7, "{order}: {coarse:e} {fine:e}");
    let first = rms("Verlet", 5e-5);
    assert!(fine < 0.1 * first, "{fine:e} {first:e}");
}

#[test]
fn bodies_have_the_same_bits_on_any_number_of_threads_and_with_any_search() {
    let keys = |search: &str| format!("{}, neighbours: {search}", implosion_keys(true, DAMPED, 1e-4));
    let hash = |search: &str, threads: usize| {
        let mut simulation = simulation(&keys(search), threads, |shapes| implosion(shapes, true));
        simulation.run();
        state_hash::of_world(simulation.world_mut())
    };
    let first = hash("VerletList(skin: 0.01)", 1);
    for (search, threads) in [("AllPairs", 1), ("Cells(size: 0.12)", 1), ("VerletList(skin: 0.02)", 3)] {
        assert_eq!(hash(search, threads), first, "{search}, {threads} threads");
    }
}

#[test]
fn a_body_crosses_a_periodic_side_as_if_there_were_none() {
    let run = |sides: &str| {
        let keys = format!(
            "gravity: (0.0, 0.0), {sides} contact: {DAMPED}, shapes: {PLANE_SHAPES}, step: Fixed(1.0e-4), until: 0.6"
        );
        let mut simulation = simulation(&keys, 1, |shapes| {
            let mut rod = shaped(shapes, "rod", 1, DVec3::new(0.9, 0.5, 0.0), DQuat::from_rotation_z(0.3));
            rod.velocity = DVec3::new(0.5, 0.0, 0.0);
            rod.spin = DVec3::Z * 2.0;
            let mut bean = shaped(shapes, "bean", 2, DVec3::new(1.15, 0.55, 0.0), DQuat::IDENTITY);
            bean.velocity = DVec3::new(-0.2, 0.0, 0.0);
            vec![rod, bean]
        });
        simulation.run();
        motion(&mut simulation)
    };
    let [open, periodic] = [run(""), run("periodic: (x: (0.0, 1.0)),")];
    for (a, b) in open.iter().zip(&periodic) {
        let apart = (a.position - b.position).length();
        // Positions differ by a side, and rounding differs with them.
        assert!((apart - apart.round()).abs() < 1e-9 && (a.velocity - b.velocity).length() < 1e-8, "{a:?} {b:?}");
    }
    assert!(open[1].spin.length() > 0.1, "they met");
}
