//! Walls that move: a driven oscillator, the invariance of contacts in a box that moves at constant velocity, a turning plate
//! against a plate with a spin of its own, a table against a steady motion, and the energy balance.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::{Motion, grain, motion, simulation, sphere};
use siloflow::dem::survey::touching::Touching;
use siloflow::dem::survey::{Partner, Survey};
use siloflow::dem::walls::shapes::half_plane::HalfPlane;
use siloflow::dem::walls::surface::Surface;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::prelude::*;

const FRICTION: &str = "tangential: Spring(k: 2857.0, damping: OfNormal(0.5), friction: 0.4)";

/// A grain that lies on an oscillating floor. With u the height over the place of rest and w the place of the floor,
/// u'' = -w0^2 (u - w), u(0) = u'(0) = 0.
fn on_a_vibrating_floor(dt: f64) -> (Simulation, f64, f64) {
    let m = 0.05f64;
    let k = 1.0e4f64;
    let amplitude = 1.0e-5;
    let frequency = 20.0;
    let radius = 0.01;
    let keys = format!(
        "gravity: (0.0, -9.81), contact: Linear(k: {k:?}, damping: B(0.0)), step: Fixed({dt:?}), until: 10.0, integrator: Verlet,
         walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"floor\")],
         motions: [(walls: \"floor\", translate: Oscillate(amplitude: (0.0, {amplitude:?}), frequency: {frequency:?}))]"
    );
    let rest = radius - m * 9.81 / k;
    let mut run = simulation(&keys, vec![grain(1, Vector::new(0.1, rest), Vector::ZERO, radius, m)]);
    let time = 0.1;
    run.run_steps((time / dt).round() as u64);
    let own = (k / m).sqrt();
    let pulse = TAU * frequency;
    let exact =
        amplitude * own / (own * own - pulse * pulse) * (own * (pulse * time).sin() - pulse * (own * time).sin());
    let height = motion(&mut run)[0].position.y - rest;
    (run, height - exact, exact)
}

#[test]
fn a_vibrating_floor_drives_a_grain_as_the_driven_oscillator() {
    let [coarse, fine] = [4.0e-5, 2.0e-5].map(on_a_vibrating_floor);
    // The phase error of Verlet is (w0 dt)^3/24 a step: w0^3 t dt^2/24 = 0.015 at the coarse step; the amplitude is 1e-5 m.
    assert!(coarse.1.abs() < 2.0e-7 && coarse.2.abs() > 1.0e-6, "{} of {}", coarse.1, coarse.2);
    let order = (coarse.1 / fine.1).log2();
    assert!((order - 2.0).abs() < 0.1, "order {order}");
}

/// A disc that sticks to a plate, which oscillates along itself. With s the distance by which the disc has slid, w the velocity of the plate and
/// m' = m/3, which counts the rotation: m' s'' = -k s - c s' - m' w', s(0) = 0, s'(0) = -w(0), and m v' = -k s - c s' for the velocity of the disc.
/// Returns the error of v, and v.
fn on_a_sliding_plate(c: f64, dt: f64) -> (f64, f64) {
    let (m, k, radius, deep) = (0.5f64, 2.0e4f64, 0.1f64, 1.0e-3f64);
    let (amplitude, frequency, time) = (1.0e-5f64, 40.0f64, 0.02f64);
    let keys = format!(
        "gravity: (0.0, -{:?}), step: Fixed({dt:?}), until: 1.0, integrator: Centred,
         contact: Linear(k: 1.0e5, damping: B(20.0), tangential: Spring(k: {k:?}, damping: B({c:?}), friction: 1.0e3)),
         walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"plate\")],
         motions: [(walls: \"plate\", translate: Oscillate(amplitude: ({amplitude:?}, 0.0), frequency: {frequency:?}))]",
        deep * 1.0e5 / m
    );
    let mut run = simulation(&keys, vec![grain(1, Vector::new(0.0, radius - deep), Vector::ZERO, radius, m)]);
    run.run_steps((time / dt).round() as u64);
    let pulse = TAU * frequency;
    let plate = amplitude * pulse;
    let slope = |[s, slides, _]: [f64; 3], t: f64| {
        let force = -k * s - c * slides;
        [slides, 3.0 * force / m + plate * pulse * (pulse * t).sin(), force / m]
    };
    let steps = 20_000u32;
    let h = time / f64::from(steps);
    let mut state = [0.0, -plate, 0.0];
    // The classical Runge-Kutta scheme.
    for t in (0..steps).map(|step| f64::from(step) * h) {
        let ahead = |by: [f64; 3], share: f64| std::array::from_fn(|i| state[i] + share * h * by[i]);
        let first = slope(state, t);
        let second = slope(ahead(first, 0.5), t + 0.5 * h);
        let third = slope(ahead(second, 0.5), t + 0.5 * h);
        let last = slope(ahead(third, 1.0), t + h);
        state = std::array::from_fn(|i| state[i] + h * (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i]) / 6.0);
    }
    (motion(&mut run)[0].velocity.x - state[2], state[2])
}

#[test]
fn a_plate_that_oscillates_along_itself_drags_a_disc_along() {
    for c in [0.0, 20.0] {
        let [(coarse, exact), (fine, _)] = [1.0e-4, 5.0e-5].map(|dt| on_a_sliding_plate(c, dt));
        let order = (coarse / fine).abs().log2();
        // The disc swings with 350 rad/s: (w dt)^2 is 1.2e-3.
        assert!(coarse.abs() < 5.0e-3 * exact.abs(), "c = {c}: {coarse} of {exact}");
        assert!((order - 2.0).abs() < 0.15, "c = {c}: {coarse}, order {order}");
    }
}

#[test]
fn the_work_of_a_vibrating_floor_is_the_energy_of_the_grain() {
    let [coarse, fine] = [4.0e-5, 2.0e-5].map(|dt| {
        let (run, ..) = on_a_vibrating_floor(dt);
        let totals = totals::of_world(run.world());
        let flows = *run.world().resource::<EnergyFlows>();
        assert!(flows.wall_work.abs() > 1.0e-8, "{flows:?}");
        (totals.energy() - flows.expected()).abs()
    });
    // Trapezoidal rule: T W^2 dt^2/12 of the power, with W <= w0 + w = 573/s; the power is at most m g A w = 6e-4 W.
    assert!(coarse < 0.1 * 573.0f64.powi(2) * 1.6e-9 / 12.0 * 6.2e-4 * 4.0, "{coarse}");
    assert!((coarse / fine).log2() > 1.7, "{coarse} {fine}");
}

/// Places and velocities of two grains on a wall that moves, after half a second.
fn on(wall: &str, motions: &str, drift: Vector) -> Vec<Motion> {
    let keys = format!(
        "gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.6), {FRICTION}), step: Fixed(2.0e-5), until: 10.0,
         walls: [{wall}], motions: [{motions}]"
    );
    let grains = [(1, 0.0102), (2, 0.0301)];
    let grains = grains.map(|(id, height)| grain(id, Vector::new(0.1, height), drift, 0.01, 0.05));
    let mut run = simulation(&keys, grains.to_vec());
    run.run_steps(25_000);
    motion(&mut run)
}

#[test]
fn motions_of_one_wall_add_up() {
    let gate = "Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"gate\")";
    let both = on(
        gate,
        "(walls: \"gate\", translate: Oscillate(amplitude: (0.0, 1.0e-3), frequency: 5.0), rotate: (about: (0.0, 0.0), by: Steady(0.1)))",
        Vector::ZERO,
    );
    let apart = on(
        gate,
        "(walls: \"gate\", translate: Oscillate(amplitude: (0.0, 1.0e-3), frequency: 5.0)), \
         (walls: \"gate\", rotate: (about: (0.0, 0.0), by: Steady(0.1)))",
        Vector::ZERO,
    );
    assert_eq!(format!("{both:?}"), format!("{apart:?}"));
    let other =
        on(gate, "(walls: \"gate\", translate: Oscillate(amplitude: (0.0, 1.0e-3), frequency: 5.0))", Vector::ZERO);
    assert!(other[0].position.distance(both[0].position) > 1e-3, "the rotation matters");
}

/// A belt that is lifted at a constant velocity is a belt at rest as seen from a frame that moves with it.
#[test]
fn a_belt_may_be_lifted() {
    let belt = "HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0), velocity: (0.3, 0.0), name: \"belt\")";
    let lift = Vector::new(0.0, 0.2);
    let lifted = on(belt, "(walls: \"belt\", translate: Steady((0.0, 0.2)))", lift);
    let at_rest = on(belt, "", Vector::ZERO);
    for (lifted, at_rest) in lifted.iter().zip(&at_rest) {
        // Both discs, of a radius of 1 cm, have rolled apart and roll on the belt.
        let slip = at_rest.velocity.x + 0.01 * at_rest.spin.z - 0.3;
        assert!(slip.abs() < 1e-3, "{at_rest:?}");
        // 25,000 steps round places of 0.1 m at 1e-17 m each, and two discs that roll off each other amplify differences little.
        let off = lifted.position - at_rest.position - lift.extend(0.0) * 0.5;
        assert!(off.length() < 1e-11, "{off} {lifted:?} {at_rest:?}");
    }
}

fn crowd() -> Vec<GrainRow> {
    let place = |n: u32| {
        let [i, j, k] = [n % 3, (n / 3) % 3, n / 9].map(f64::from);
        DVec3::new(0.022 * i - 0.021, 0.022 * j - 0.022, 0.022 * k - 0.020)
    };
    let velocity =
        |n: u32| DVec3::new((f64::from(n) * 1.7).sin(), (f64::from(n) * 2.3).cos(), (f64::from(n) * 0.9).sin());
    (0..27).map(|n| sphere(n + 1, place(n), velocity(n), 0.01, 0.01)).collect()
}

/// A closed box of panels round the origin, with these further keys.
fn boxed(more: &str, grains: Vec<GrainRow>, steps: u64) -> Vec<Motion> {
    let panel = |corner: &str, along: &str, across: &str| {
        format!("Panel(corner: {corner}, along: {along}, across: {across}, name: \"box\")")
    };
    let x = "(0.08, 0.0, 0.0)";
    let y = "(0.0, 0.08, 0.0)";
    let z = "(0.0, 0.0, 0.08)";
    let low = "(-0.04, -0.04, -0.04)";
    let walls = [
        panel(low, x, y),
        panel(low, y, z),
        panel(low, x, z),
        panel("(-0.04, -0.04, 0.04)", x, y),
        panel("(0.04, -0.04, -0.04)", y, z),
        panel("(-0.04, 0.04, -0.04)", x, z),
    ];
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), contact: Linear(k: 1.0e4, damping: Restitution(0.8), {FRICTION}),
         step: Fixed(2.0e-5), until: 10.0, walls: [{}], {more}",
        walls.join(", ")
    );
    let mut run = simulation(&keys, grains);
    run.run_steps(steps);
    assert_eq!(run.world().resource::<Ledger>().lost(), 0);
    motion(&mut run)
}

#[test]
fn a_box_at_constant_velocity_is_a_box_at_rest() {
    let drift = DVec3::new(0.3, -1.1, 0.7);
    let moved = crowd().into_iter().map(|row| GrainRow { velocity: row.velocity + drift, ..row }).collect();
    let motions = "motions: [(walls: \"box\", translate: Steady((0.3, -1.1, 0.7)))]";
    let steps = 2000;
    let still = boxed("motions: []", crowd(), steps);
    let moving = boxed(motions, moved, steps);
    let time = 2.0e-5 * steps as f64;
    for (a, b) in still.iter().zip(&moving) {
        // Rounding of positions of 0.1 m over 2000 steps, 2000 eps 0.1 m = 4e-14 m, times the growth of a difference in up to
        // 8 collisions, each by about 2 l/R = 6.
        let tolerance = 4.0e-14 * 6f64.powi(8);
        assert!((a.position - (b.position - drift * time)).length() < tolerance, "{a:?} {b:?}");
        assert!((a.spin - b.spin).length() < tolerance * 1.0e4, "{a:?} {b:?}");
    }
    let moves = crowd().iter().zip(&still).map(|(row, a)| (row.position - a.position).length()).fold(0.0, f64::max);
    assert!(moves > 0.02, "the grains collide: {moves}");
}

#[test]
fn a_straight_table_is_a_steady_motion() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("way.csv");
    std::fs::write(&file, "time_s,x_m,y_m,z_m\n0,0,0,0\n0.013,0.0039,0,0.0013\n1,0.3,0,0.1\n").unwrap();
    let table = format!("motions: [(walls: \"box\", translate: Table(file: {file:?}))]");
    let steady = "motions: [(walls: \"box\", translate: Steady((0.3, 0.0, 0.1)))]";
    let a = boxed(&table, crowd(), 1000);
    let b = boxed(steady, crowd(), 1000);
    // As above; half the time, half the collisions.
    let apart = a.iter().zip(&b).map(|(a, b)| (a.position - b.position).length()).fold(0.0, f64::max);
    assert!(apart < 2.0e-14 * 6f64.powi(6), "{apart}");
}

#[test]
fn a_turning_plate_drags_as_a_plate_with_a_spin() {
    let run = |plate: &str, more: &str| {
        let keys = format!(
            "space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5), {FRICTION}),
             step: Fixed(2.0e-5), until: 10.0,
             walls: [Annulus(centre: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.2, name: \"plate\"{plate})], {more}"
        );
        let mut run = simulation(&keys, vec![sphere(1, DVec3::new(0.05, 0.02, 0.0102), DVec3::ZERO, 0.01, 0.01)]);
        run.run_steps(5000);
        let walls = run.world().resource::<Surfaces<DVec3>>();
        let torque = walls.loads[0].torque;
        (motion(&mut run)[0], torque)
    };
    let (spun, torque) = run(", spin: 4.0", "motions: []");
    let turn =
        "motions: [(walls: \"plate\", rotate: (about: (0.0, 0.0, 0.0), axis: (0.0, 0.0, 2.0), by: Steady(4.0)))]";
    let (turned, other) = run("", turn);
    // The height of the plate is exact in both; turned axes differ by eps, times 5000 steps.
    assert!((spun.position - turned.position).length() < 1.0e-12, "{spun:?} {turned:?}");
    assert!((spun.spin - turned.spin).length() < 1.0e-9 && spun.velocity.length() > 0.05, "{spun:?} {turned:?}");
    assert!((torque - other).length() < 1.0e-10 && torque.z.abs() > 0.0, "{torque} {other}");
}

#[test]
fn a_grain_that_a_wall_passes_without_touching_is_lost() {
    let keys = "gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed(1.0e-2), until: 1.0, on_loss: Continue,
         walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"wall\")],
         motions: [(walls: \"wall\", translate: Steady((0.0, 10.0)))]";
    // 0.1 m a step: from 0.04 m below the grain to 0.06 m above it.
    let mut run = simulation(keys, vec![grain(1, Vector::new(0.0, 0.14), Vector::ZERO, 0.01, 0.01)]);
    run.run_steps(5);
    let ledger = run.world().resource::<Ledger>();
    assert_eq!((ledger.lost(), ledger.lost[0].way.as_str()), (1, "through a moving wall"));
    assert_eq!(ledger.lost[0].step, 2);
}

#[test]
fn a_half_plane_that_rocks_moves_a_grain_as_a_segment_and_a_panel_do() {
    let run = |space: &str, wall: &str, axis: &str| {
        let keys = format!(
            "{space} contact: Linear(k: 1.0e4, damping: Restitution(0.5), {FRICTION}), step: Fixed(2.0e-5), until: 10.0, walls: [{wall}],
             motions: [(walls: \"floor\", rotate: (about: {axis} by: Oscillate(amplitude: 0.3, frequency: 2.0)))]"
        );
        let mut run = simulation(&keys, vec![sphere(1, DVec3::new(0.05, 0.0, 0.0), DVec3::ZERO, 0.01, 0.01)]);
        run.run_steps(20_000);
        (motion(&mut run)[0], run.world().resource::<EnergyFlows>().wall_work)
    };
    // The turned normal and end points round differently, by eps of 1 m, and the motion of one grain on a wall is stable, so this difference
    // enters 20,000 steps at most.
    let assert_equal = |(a, work): (Motion, f64), (b, other): (Motion, f64)| {
        assert!((a.position - b.position).length() < 1.0e-11, "{a:?} {b:?}");
        assert!((work - other).abs() < 1.0e-9 * work.abs() && work.abs() > 1.0e-3, "{work} {other}");
    };
    let planar = "gravity: (0.0, -9.81),";
    let about = "(-0.2, -0.01),";
    let half = run(planar, "HalfPlane(point: (0.0, -0.0101), normal: (0.0, 1.0), name: \"floor\")", about);
    let segment = run(planar, "Segment(from: (-1.0, -0.0101), to: (1.0, -0.0101), name: \"floor\")", about);
    assert_equal(half, segment);
    let solid = "space: Solid, gravity: (0.0, 0.0, -9.81),";
    let about = "(-0.2, 0.0, -0.01), axis: (0.0, -1.0, 0.0),";
    let half = run(solid, "HalfPlane(point: (0.0, 0.0, -0.0101), normal: (0.0, 0.0, 1.0), name: \"floor\")", about);
    let corner = "corner: (-1.0, -1.0, -0.0101), along: (2.0, 0.0, 0.0), across: (0.0, 2.0, 0.0)";
    let panel = run(solid, &format!("Panel({corner}, name: \"floor\")"), about);
    assert_equal(half, panel);
}

#[test]
fn a_grain_on_a_turning_half_plane_is_found_however_far_from_the_axis() {
    // The half-plane turns by 0.01 rad about a point 10 m away, and lifts a floating grain that was a metre above it when the run began.
    let keys = "gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(0.0)), step: Fixed(1.0e-4), until: 10.0, watchdog: (energy: None),
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0), name: \"floor\")],
         motions: [(walls: \"floor\", rotate: (about: (0.0, 0.0), by: Steady(0.1)))]";
    let mut run = simulation(keys, vec![grain(1, Vector::new(10.0, 1.0), Vector::ZERO, 0.01, 0.01)]);
    // The surface reaches the grain at the height 0.99 m/cos: tan(0.1 t) 10 m = 0.99 m.
    let touches = ((0.99 / (0.1f64).cos() / 10.0).atan() / 0.1 / 1.0e-4) as u64;
    run.run_steps(touches - 100);
    assert_eq!(motion(&mut run)[0].velocity, DVec3::ZERO);
    run.run_steps(touches + 500);
    // An elastic impact doubles the velocity of the surface, omega r = 1 m/s along its normal.
    let velocity = motion(&mut run)[0].velocity;
    assert!((velocity.length() - 2.0).abs() < 0.02 && velocity.y > 1.9, "{velocity}");
}

#[test]
fn a_disc_that_moves_hits_a_grain_as_a_disc_at_rest_hits_a_moving_grain() {
    for law in ["Linear(k: 1.0e4, damping: Restitution(0.5))", "Hertz(restitution: 0.5)"] {
        let run = |wall: &str, motions: &str, velocity: f64, steps: u64| {
            let keys = format!(
                "space: Solid, gravity: (0.0, 0.0, 0.0), contact: {law}, materials: [(young: 1.0e6, poisson: 0.3)], step: Fixed(1.0e-5),
                 until: 10.0, walls: [Sphere(centre: (0.0, 0.0, 0.0), radius: 0.03{wall})], motions: [{motions}]"
            );
            let row = sphere(1, DVec3::new(0.0, 0.001, 0.042), DVec3::new(0.0, 0.0, velocity), 0.01, 0.01);
            let mut run = simulation(&keys, vec![row]);
            run.run_steps(steps);
            motion(&mut run)[0]
        };
        let steps = 1000;
        let drift = DVec3::Z * 0.5;
        let fixed = run("", "", -0.5, steps);
        let at_rest = run(", name: \"rod\"", "", -0.5, steps);
        let moving = run(", name: \"rod\"", "(walls: \"rod\", translate: Steady((0.0, 0.0, 0.5)))", 0.0, steps);
        // One impact: rounding of positions of 0.05 m, which the contact of some 200 steps amplifies by at most 200.
        assert!((fixed.position - at_rest.position).length() < 1.0e-14, "{law}: {fixed:?} {at_rest:?}");
        assert!((fixed.velocity - at_rest.velocity).length() < 1.0e-11, "{law}: {fixed:?} {at_rest:?}");
        assert!((fixed.velocity + drift - moving.velocity).length() < 1.0e-11, "{law}: {fixed:?} {moving:?}");
        assert!(fixed.velocity.z > 0.1 && fixed.velocity.y > 0.0, "{law}: {fixed:?}");
    }
}

#[test]
fn a_survey_finds_contacts_with_walls_that_the_last_force_pass_did_not_list() {
    // Contacts of a survey come from the list of the force pass where it is valid; those of `touching_walls` from all walls.
    let count = |world: &World| {
        let survey = Survey::<DVec3>::of_world(world);
        let mut found = Vec::new();
        survey.contacts(|i, partner, _, _| {
            if let Partner::Wall(wall) = partner {
                found.push((i, wall));
            }
        });
        let partner = |touching: Touching<'_, DVec3>| match touching.partner() {
            Partner::Wall(wall) => Some((touching.row(), wall)),
            Partner::Particle(_) => None,
        };
        assert_eq!(found, survey.touching_walls().filter_map(partner).collect::<Vec<_>>());
        found.len()
    };
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.8), {FRICTION}), step: Fixed(2.0e-5),
         until: 10.0, walls: [HalfPlane(point: (0.0, 0.0, -0.031), normal: (0.0, 0.0, 1.0), name: \"floor\"),
         Panel(corner: (-0.031, -1.0, -1.0), along: (0.0, 2.0, 0.0), across: (0.0, 0.0, 2.0))],
         motions: [(walls: \"floor\", translate: Steady((0.0, 0.0, 0.3)))]"
    );
    let mut run = simulation(&keys, crowd());
    let mut most = 0;
    for row in 1..=200 {
        run.run_steps(row * 7);
        most = most.max(count(run.world()));
    }
    assert!(most >= 5, "{most} contacts at once");
    let grains = run.world().resource::<Ledger>().inside();
    let mut walls = run.world_mut().resource_mut::<Surfaces<DVec3>>();
    walls.all[0].surface = Surface::HalfPlane(HalfPlane { point: DVec3::Z, normal: DVec3::Z });
    assert!(count(run.world()) >= grains as usize, "all grains are behind the half-plane");
}
