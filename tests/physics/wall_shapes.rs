//! Walls of revolution against another program and closed forms; edges and seams where walls meet; turning walls.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;

use crate::{motion, simulation, sphere};

const FRICTION: &str = "Linear(k: 1.0e5, damping: PerMass(4000.0), attraction: Allowed, tangential: \
     Spring(k: 28571.428571428572, damping: PerMass(1500.0), friction: 0.5), lever: Radius)";

#[test]
fn bounces_in_a_cylinder_in_a_cone_and_in_a_sphere_agree_with_lammps_within_a_nanometre() {
    // `tests/data/round-walls.in`: `fix wall/gran/region` on cylinder, cone and sphere.
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let frames = std::fs::read_to_string(data.join("round_walls_frames.csv")).unwrap();
    let mut compared = 0;
    for (shape, wall) in [
        ("cylinder", "Cylinder(from: (0.001, -0.002, -0.1), to: (0.001, -0.002, 0.1), radius: 0.03)"),
        ("cone", "Cone(from: (0.001, -0.002, 0.04), to: (0.001, -0.002, -0.04), radii: (0.06, 0.02))"),
        ("sphere", "SphericalZone(centre: (0.001, -0.002, 0.0), radius: 0.045)"),
    ] {
        let keys = format!(
            "(space: Solid, gravity: (0.0, 0.0, 0.0), contact: {FRICTION}, walls: [{wall}], integrator: Verlet, \
             step: Fixed(2.0e-6), grains: (file: \"round_walls_initial.csv\"), on_loss: Continue, until: 0.03)"
        );
        let loaded = load::from_text("r.ron", "r", &data, keys, &[]).unwrap();
        let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
        for line in frames.lines().filter(|line| line.starts_with(shape)) {
            let row: Vec<f64> = line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
            let time = row[0];
            let id = row[1] as usize;
            let x = Solid::new(row[2], row[3], row[4]);
            simulation.run_steps((time / 2.0e-6).round() as u64);
            let ours = motion(&mut simulation)[id - 1];
            // The scheme is the same. Positions of 0.05 m round at 7e-18 m, and few collisions amplify it.
            let apart = ours.position.distance(x);
            assert!(apart < 1e-9, "{shape}, t = {time} s, grain {id}: {apart:e} m apart");
            compared += 1;
        }
    }
    assert_eq!(compared, 210);
}

/// Returns by how much the angle of an orbit in a hollow sphere that turns exceeds the exact one, relative to it, after a turn with steps
/// of `x` rad, and by how much the overlap exceeds the exact one, relative to it.
fn excess_of_an_orbit(integrator: &str, friction: f64, x: f64) -> [f64; 2] {
    let sphere_radius = 0.05;
    let r = 0.01;
    let mass = 0.0105;
    let k = 1.0e3;
    let depth = 2.6e-4;
    // The contact force turns the centre: k depth = m v^2/orbit.
    let orbit: f64 = sphere_radius - r + depth;
    let speed = (k * depth * orbit / mass).sqrt();
    let axis = Solid::new(0.48, 0.6, 0.64);
    let out = axis.any_orthonormal_vector();
    let ahead = axis.cross(axis.any_orthonormal_vector());
    let dt = x * orbit / speed;
    let turning = 30.0;
    let contact = format!(
        "Linear(k: {k:?}, damping: PerMass(0.0), tangential: Spring(k: {:?}, damping: PerMass(0.0), friction: {friction:?}), lever: Radius)",
        k / 3.5
    );
    let wall = format!(
        "SphericalZone(centre: (0.1, -0.2, 0.3), radius: {sphere_radius:?}, axis: (0.48, 0.6, 0.64), heights: (-0.03, 0.04), spin: {turning:?})"
    );
    let keys = format!("{}, integrator: {integrator}", keys(&wall, &contact, dt, "(0.0, 0.0, 0.0)"));
    let centre = Solid::new(0.1, -0.2, 0.3);
    let mut grain = sphere(1, centre + out * orbit, ahead * speed, r, mass);
    // Grain and wall have one velocity where they touch.
    grain.spin = axis * ((turning * sphere_radius - speed) / r);
    let mut run = simulation(&keys, vec![grain]);
    let steps = (TAU / x).round();
    run.run_steps(steps as u64);
    let place = motion(&mut run)[0].position - centre;
    // The orbit stays in its plane, to the rounding of one place for each step.
    assert!(place.dot(axis).abs() < steps * f64::EPSILON * centre.length());
    let angle = place.dot(ahead).atan2(place.dot(out));
    let exact = steps * x;
    [(angle - (exact - TAU)) / exact, (place.length() - orbit) / depth]
}

#[test]
fn a_sphere_orbits_in_a_hollow_sphere_that_turns() {
    // The leapfrog keeps the angular momentum: the step of the angle has the sine x, and so is x (1 + x^2/6). The overlap at rest is
    // larger by the share x^2/4, about which it oscillates, and changes the angle by less than a part of depth/orbit.
    for x in [0.04, 0.02, 0.01] {
        let [angle, overlap] = excess_of_an_orbit("Verlet", 0.0, x);
        assert!((angle / (x * x / 6.0) - 1.0).abs() < 0.05, "{x}: {angle:e}");
        assert!((-0.01..0.51).contains(&(overlap / (x * x))), "{x}: {overlap:e}");
    }
    // With friction, velocities of the half step, which are not along the wall, change the speed by up to x^2/8.
    for (integrator, friction) in [("Centred", 0.0), ("Verlet", 0.5), ("Centred", 0.5)] {
        let x = 0.01;
        let [coarse, fine] = [x, 0.5 * x].map(|x| excess_of_an_orbit(integrator, friction, x)[0]);
        assert!(coarse.abs() < x * x * (1.0 / 6.0 + 1.0 / 8.0), "{integrator}, friction {friction}: {coarse:e}");
        assert!((3.8..4.2).contains(&(coarse / fine)), "{integrator}, friction {friction}: {coarse:e}, {fine:e}");
    }
}

/// Keys of a scene without gravity and with these walls.
fn keys(walls: &str, contact: &str, dt: f64, gravity: &str) -> String {
    format!(
        "space: Solid, gravity: {gravity}, contact: {contact}, walls: [{walls}], step: Fixed({dt:?}), until: 1.0e3, \
         on_loss: Continue, watchdog: (energy: None), series: (interval: 1.0e6)"
    )
}

const SQUARE: &str = "[(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]";

const SLOT: &str = "Rectangle(centre: (0.0, 0.0, 0.0), along: (0.06, 0.03, 0.0), across: (-0.1, 0.2, 0.0))";

const WEIGHT: &str = "(0.0, 0.0, -9.81)";

#[test]
fn a_sphere_rolls_over_seams_as_over_one_panel() {
    // Two and four panels in one plane, in both orders, a ring inside a larger one, the triangles of a polygon, and one panel.
    let panel = |x: f64, y: f64, along: f64, across: f64| {
        format!("Panel(corner: ({x:?}, {y:?}, 0.0), along: ({along:?}, 0.0, 0.0), across: (0.0, {across:?}, 0.0))")
    };
    let ring = |inner: f64, outer: f64| {
        format!("Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), inner: {inner:?}, outer: {outer:?})")
    };
    let whole = panel(-1.0, -1.0, 2.0, 2.0);
    let floors = [
        vec![panel(-1.0, -1.0, 1.0, 2.0), panel(0.0, -1.0, 1.0, 2.0)],
        vec![panel(0.0, -1.0, 1.0, 2.0), panel(-1.0, -1.0, 1.0, 2.0)],
        vec![
            panel(0.0, 0.0, 1.0, 1.0),
            panel(-1.0, 0.0, 1.0, 1.0),
            panel(0.0, -1.0, 1.0, 1.0),
            panel(-1.0, -1.0, 1.0, 1.0),
        ],
        vec![ring(0.05, 1.0), ring(0.0, 0.05)],
        vec![
            panel(-1.0, -1.0, 2.0, 2.0)
                .replace("Panel(", "Panel(hole: Circle(centre: (0.0, 0.0, 0.0), radius: 0.05), "),
            panel(-1.0, -1.0, 2.0, 2.0)
                .replace("Panel(", "Panel(patch: Circle(centre: (0.0, 0.0, 0.0), radius: 0.05), "),
        ],
        vec![
            ring(0.0, 1.0).replace("Annulus(", &format!("Annulus(patch: {SLOT}, ")),
            ring(0.0, 1.0).replace("Annulus(", &format!("Annulus(hole: {SLOT}, ")),
        ],
        vec![format!("Polygon(points: {SQUARE})")],
        vec![format!("Polygon(points: {SQUARE}, hole: [(0.3, 0.3, 0.0), (0.5, 0.3, 0.0), (0.4, 0.5, 0.0)])")],
    ];
    let run = |walls: &str, integrator: &str| {
        let keys = keys(walls, FRICTION, 2e-5, WEIGHT);
        let grain = sphere(1, Solid::new(-0.06, -0.021, 0.00999), Solid::new(0.9, 0.17, 0.0), 0.01, 0.01);
        let mut simulation = simulation(&format!("{keys}, integrator: {integrator}"), vec![grain]);
        (1..=10)
            .map(|row| {
                simulation.run_steps(1000 * row);
                motion(&mut simulation)[0]
            })
            .collect::<Vec<_>>()
    };
    for integrator in ["Verlet", "Centred"] {
        let expected = run(&whole, integrator);
        assert!(expected[9].position.x > 0.05 && expected[9].spin.y > 50.0, "it has rolled over the seams");
        for floor in &floors {
            for (ours, one) in run(&floor.join(", "), integrator).iter().zip(&expected) {
                // The memory of the tangential spring moves with the grain, so only the rounding of the nearest point
                // differs: some 1e-17 m in each of 10,000 steps, in a stable motion.
                let apart = ours.position.distance(one.position);
                assert!(apart < 1e-12, "{integrator}, {floor:?}: {apart:e} m");
                assert!((ours.spin - one.spin).length() < 1e-8, "{integrator}, {floor:?}");
            }
        }
    }
}

/// Returns the energy, J.
fn energy(simulation: &mut Simulation) -> f64 {
    totals::of_world(simulation.world_mut()).energy()
}

#[test]
fn a_sphere_slides_over_ridges_without_a_change_of_energy() {
    // A ridge of two panels at 100 degrees, a rod on a plate's rim, the upper rim of a cone, and the rims of slots in a plate and
    // in a cone, without friction and damping: the energy of a grain is that of its distance from the union of the walls,
    // which has no jump.
    let contact = "Linear(k: 1.0e4, damping: B(0.0))";
    let left = "Panel(corner: (-0.1, -1.0, -0.03), along: (0.1, 0.0, 0.03), across: (0.0, 2.0, 0.0))";
    let right = "Panel(corner: (0.1, -1.0, -0.05), along: (-0.1, 0.0, 0.05), across: (0.0, 2.0, 0.0))";
    // A grain starts at the overlap of its weight, and slides slowly towards the edge.
    let upwards = Solid::new(-0.03, 0.0, 0.1).normalize();
    let to_the_ridge = (Solid::new(-0.02, 0.0, -0.006) + upwards * 0.00999, Solid::new(0.8, 0.0, 0.24));
    let to_the_rim = (Solid::new(0.22, 0.0, 0.00999), Solid::new(-0.4, 0.0, 0.0));
    let inwards = Solid::new(-1.0, 0.0, 1.0).normalize();
    let down_the_cone = (Solid::new(0.22, 0.03, -0.0777) + inwards * 0.00999, Solid::new(-0.3, 0.0, -0.3));
    let slot = "hole: Rectangle(centre: (0.0, 0.0, 0.0), along: (0.4, 0.0, 0.0), across: (0.0, 0.3, 0.0))";
    let ridges = [
        (format!("{left}, {right}"), to_the_ridge),
        (format!("{right}, {left}"), to_the_ridge),
        (format!("{right}, {left}, Segment(from: (0.0, -1.0, 0.0), to: (0.0, 1.0, 0.0))"), to_the_ridge),
        (
            "Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), inner: 0.2, outer: 0.4), \
             Cone(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, -0.1), radii: (0.2, 0.1))"
                .to_owned(),
            to_the_rim,
        ),
        (format!("Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.4, {slot})"), to_the_rim),
        (format!("Cone(from: (0.0, 0.0, -0.3), to: (0.0, 0.0, 0.1), radii: (0.0, 0.4), {slot})"), down_the_cone),
    ];
    for (walls, (start, speed)) in ridges {
        let change = |dt: f64| {
            let keys = keys(&walls, contact, dt, WEIGHT);
            let mut simulation =
                simulation(&format!("{keys}, integrator: Verlet"), vec![sphere(1, start, speed, 0.01, 0.01)]);
            simulation.run_steps(0);
            let before = energy(&mut simulation);
            let mut worst = 0.0f64;
            for row in 1..=100 {
                simulation.run_steps((1e-3 * f64::from(row) / dt).round() as u64);
                worst = worst.max((energy(&mut simulation) - before).abs() / 5e-3);
            }
            worst
        };
        // Verlet is of second order as long as the contact lasts, also over the jump of the curvature at an edge.
        let [coarse, fine] = [2e-5, 5e-6].map(change);
        assert!(fine < 2e-4, "{walls}: {fine:e}");
        assert!(fine < 0.5 * coarse, "{walls}: {coarse:e}, {fine:e}");
    }
}

#[test]
fn a_conical_pendulum_stays_on_its_circle() {
    // A frictionless grain circles in a cone of slope 45 degrees at constant height: v^2 = g r, with r the distance of
    // its centre from the axis and the contact force m g sqrt(2).
    let (gravity, radius, mass, stiffness): (f64, f64, f64, f64) = (9.81, 0.01, 0.01, 1e4);
    let overlap = mass * gravity * 2f64.sqrt() / stiffness;
    let r = 0.1;
    // The surface is z = r, so the centre is sqrt(2) (R - overlap) above it.
    let z = r + 2f64.sqrt() * (radius - overlap);
    let v = (gravity * r).sqrt();
    let keys = keys(
        "Cone(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 0.3), radii: (0.0, 0.3))",
        "Linear(k: 1.0e4, damping: B(0.0))",
        1e-5,
        WEIGHT,
    );
    let mut simulation = simulation(
        &format!("{keys}, integrator: Verlet"),
        vec![sphere(1, Solid::new(r, 0.0, z), Solid::new(0.0, v, 0.0), radius, mass)],
    );
    let turn = 2.0 * std::f64::consts::PI * r / v;
    let steps = (3.0 * turn / 1e-5) as u64;
    simulation.run_steps(steps);
    let x = motion(&mut simulation)[0].position;
    let angle = v / r * steps as f64 * 1e-5;
    let expected = Solid::new(r * angle.cos(), r * angle.sin(), z);
    // Verlet turns a circular motion by (w dt)^2/24 too much in each radian, and the radius stays: far below 1e-6 m. The
    // scheme excites an oscillation of the contact of at most the way in a step, v dt (v dt/2r) = 5e-9 m.
    assert!(x.distance(expected) < 1e-7, "{:e} m", x.distance(expected));
}

#[test]
fn a_turning_drum_does_the_work_of_its_torque() {
    // Forty frictional spheres in a drum with end plates that turns twice a second.
    let spin = 12.0;
    let walls = format!(
        "Cylinder(from: (0.0, -0.02, 0.0), to: (0.0, 0.02, 0.0), radius: 0.05, spin: {spin:?}), \
         Annulus(centre: (0.0, -0.02, 0.0), normal: (0.0, 1.0, 0.0), outer: 0.05, spin: {spin:?}), \
         Annulus(centre: (0.0, 0.02, 0.0), normal: (0.0, 1.0, 0.0), outer: 0.05, spin: {spin:?})"
    );
    let contact = "Linear(k: 1.0e4, damping: Restitution(0.5), tangential: Spring(k: 2857.0, damping: OfNormal(0.5), friction: 0.5))";
    let grains = (0..40u32)
        .map(|i| {
            let [x, y, z] = [i % 4, (i / 4) % 2, i / 8].map(f64::from);
            sphere(
                i + 1,
                Solid::new(0.011 * x - 0.017, 0.012 * y - 0.006, 0.011 * z - 0.03),
                Solid::ZERO,
                0.005,
                1.3e-3,
            )
        })
        .collect();
    let mut simulation = simulation(&keys(&walls, contact, 1e-5, WEIGHT), grains);
    let mut work = 0.0;
    // The work of the torques on the walls, summed here from the loads of every step by the trapezium rule.
    let mut last = 0.0;
    let mut first = true;
    for step in 0..=40_000 {
        simulation.run_steps(step);
        let torque: f64 = simulation.world().resource::<Surfaces<Solid>>().loads.iter().map(|load| load.torque.y).sum();
        let power = -torque * spin;
        if !first {
            work += 0.5e-5 * (last + power);
        }
        (last, first) = (power, false);
    }
    let totals = totals::of_world(simulation.world_mut());
    let flows = *simulation.world().resource::<EnergyFlows>();
    assert!(work > 0.02, "the drum drives the grains: {work} J");
    // All of the same sum but the first step.
    assert!((flows.wall_work - work).abs() < 1e-3 * work, "{} J, {work} J", flows.wall_work);
    // The work of the drum is dissipated, or stored in the grains. The balance of the scheme is of second order; with a step of a
    // hundredth of a contact it closes to a thousandth.
    let error = totals.energy() - flows.expected();
    assert!(error.abs() < 3e-3 * work, "{error:e} J of {work} J");
}

/// The triangles of a surface of revolution about z through the points (r, z), with `around` facets, as an OBJ file.
fn revolved(line: &[(f64, f64)], around: usize) -> String {
    let mut text = String::new();
    for (r, z) in line {
        for turn in 0..around {
            let angle = 2.0 * std::f64::consts::PI * turn as f64 / around as f64;
            let _ = writeln!(text, "v {:?} {:?} {z:?}", r * angle.cos(), r * angle.sin());
        }
    }
    for ring in 0..line.len() - 1 {
        for turn in 0..around {
            let [a, b] = [turn, (turn + 1) % around].map(|turn| ring * around + turn + 1);
            let _ = writeln!(text, "f {a} {b} {}\nf {b} {} {}", a + around, b + around, a + around);
        }
    }
    text
}

/// A simulation of grains in the walls, which may name the mesh `mesh.obj` of this text.
fn in_mesh(mesh: &str, walls: &str, more: &str, grains: &[(f64, f64, f64)]) -> Simulation {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("mesh.obj"), mesh).unwrap();
    let mut rows = "id,radius,mass,x,y,z,vx,vy,vz\n".to_owned();
    for (number, (x, y, z)) in (1..).zip(grains) {
        let _ = writeln!(rows, "{number},0.005,1.3e-3,{x:?},{y:?},{z:?},0.0,0.0,0.0");
    }
    std::fs::write(directory.path().join("grains.csv"), rows).unwrap();
    let keys = format!(
        "(space: Solid, gravity: {WEIGHT}, contact: Linear(k: 1.0e4, damping: Restitution(0.5), tangential: \
         Spring(k: 2857.0, damping: OfNormal(0.5), friction: 0.4)), walls: [{walls}], step: Fixed(2.0e-5), {more}, \
         grains: (file: \"grains.csv\"), until: 1.0e3)"
    );
    let loaded = load::from_text("m.ron", "m", directory.path(), keys, &[]).unwrap();
    Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap()
}

const MESH: &str = "Mesh(file: \"mesh.obj\", unit: Metre)";

#[test]
fn a_grain_rests_in_a_cone_of_triangles_as_in_the_cone() {
    let cone = "Cone(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 0.1), radii: (0.0, 0.1))";
    let around = 512;
    let mesh = revolved(&(0..=8).map(|n| 0.002 + 0.1 * f64::from(n) / 8.0).map(|r| (r, r)).collect::<Vec<_>>(), around);
    let grains: Vec<_> = (0..60u32)
        .map(|n| (f64::from(n) * 2.4, 0.03 + 0.0009 * f64::from(n)))
        .map(|(angle, r)| (r * angle.cos(), r * angle.sin(), r + 2f64.sqrt() * 0.00505))
        .collect();
    // The first impact: the force of the sloping wall on each grain, before grains touch each other.
    let [mut smooth, mut facets] = [cone, MESH].map(|wall| in_mesh(&mesh, wall, "integrator: Verlet", &grains));
    for simulation in [&mut smooth, &mut facets] {
        simulation.run_steps(400);
    }
    let pairs: Vec<_> = motion(&mut smooth).into_iter().zip(motion(&mut facets)).collect();
    let falling = -9.81 * 400.0 * 2e-5;
    assert!(pairs.iter().all(|(one, _)| one.velocity.z > 0.9 * falling), "every grain has touched the wall");
    // Facets lie up to r (1 - cos(pi/512)) = 1.9e-5 r inside the cone, 1.6e-6 m, so a grain touches up to 1.6e-6/0.078 =
    // 2e-5 s earlier. In that time gravity changes its velocity by 2e-4 m/s, and a normal turns by pi/512 of the velocity.
    for (one, other) in &pairs {
        let apart = one.velocity.distance(other.velocity);
        assert!(apart < 2.0 * (2e-4 + std::f64::consts::PI / 512.0 * 0.08), "{apart:e} m/s");
    }
}

#[test]
fn a_closed_mesh_loses_no_grain_and_closes_the_energy_balance() {
    // A box with a bottom like a cone, of 32 facets, coarse enough for seams to matter, and a lid.
    let profile = [(1e-4, 0.0), (0.05, 0.05), (0.05, 0.12), (1e-4, 0.12)];
    let mesh = revolved(&profile, 32);
    let grains: Vec<_> = (0..150u32)
        .map(|n| [n % 5, (n / 5) % 5, n / 25].map(f64::from))
        .map(|[x, y, z]| (0.0105 * (x - 2.0), 0.0105 * (y - 2.0) + 1e-3 * z, 0.04 + 0.0105 * (z + 1.0)))
        .collect();
    let mut simulation = in_mesh(&mesh, MESH, "watchdog: (energy: None), on_loss: Stop", &grains);
    for row in 1..=20 {
        simulation.run_steps(row * 500);
        let flows = *simulation.world().resource::<EnergyFlows>();
        let error = totals::of_world(simulation.world_mut()).energy() - flows.expected();
        // Energy of the fall: 150 grains x 1.3e-3 kg x 9.81 m/s2 x some 3 cm = 0.06 J. The balance is of second order.
        assert!(error.abs() < 3e-4, "step {}: {error:e} J", row * 500);
    }
    let ledger = simulation.world().resource::<Ledger>();
    assert_eq!((ledger.inside(), ledger.lost()), (150, 0));
}
