//! Fields on grids against statics, closed forms and sums that a test makes itself.

use std::f64::consts::PI;

use glam::DVec3;
use siloflow::dem::survey::Survey;
use siloflow::grains::file::GrainRow;
use siloflow::measure::fields::{Field, FieldSampler, Grid};
use siloflow::prelude::*;
use siloflow::random::Stream;

use crate::{grain, motion, simulation, sphere};

/// One sample of a field, as fields by cell: solid fraction, density, velocity, temperature, kinetic stress, contact stress.
struct Sampled<V: Space> {
    grid: Grid<V>,
    means: Vec<Vec<f64>>,
}

fn sample<V: Space>(simulation: &Simulation, grid: &str, side: Option<(f64, f64)>) -> Sampled<V> {
    let field: Field = ron::from_str(&format!("({grid}, sample: 1.0)")).unwrap();
    let mut sampler = FieldSampler::<V>::new(field, Grid::new(&field.grid, field.kernel, side), 0);
    sampler.add(&Survey::of_world(simulation.world()));
    let layout = sampler.layout;
    let sums = sampler.layout.sums();
    let means = (0..sampler.grid.len()).map(|cell| {
        let means = sampler.blocks.estimate(cell * sums..(cell + 1) * sums, |sums| layout.means_of(sums));
        means.into_iter().map(|(mean, _)| mean).collect()
    });
    Sampled { means: means.collect(), grid: sampler.grid }
}

impl<V: Space> Sampled<V> {
    /// The contact stress of a cell: force along `a`, branch along `b`.
    fn contact(&self, cell: usize, a: usize, b: usize) -> f64 {
        let d = V::COMPONENTS;
        self.means[cell][3 + d + d * (d + 1) / 2 + a * d + b]
    }

    /// The sum of a quantity times the volume of its cell.
    fn integral(&self, quantity: impl Fn(usize) -> f64) -> f64 {
        (0..self.means.len()).map(|cell| quantity(cell) * self.grid.volume(cell)).sum()
    }
}

#[test]
fn a_column_of_two_grains_has_the_stress_of_its_weights() {
    let k = 1.0e5;
    let m = 0.16;
    let radius = 0.04;
    let g = 9.81;
    let keys = format!(
        "gravity: (0.0, -{g}), contact: Linear(k: {k:?}, damping: Restitution(0.3), attraction: Forbidden), \
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], step: Fixed(1.0e-4), \
         rest: (speed: 1.0e-9, energy: 1.0, hold: 0.2, stop: true), until: 60.0"
    );
    let grains = [1, 3].map(|n| grain(n, Vector::new(0.01, radius * f64::from(n)), Vector::ZERO, radius, m));
    let mut simulation = simulation(&keys, grains.to_vec());
    assert_eq!(simulation.run(), End::AtRest);
    let [first, second] = [0, 1].map(|n| motion(&mut simulation)[n].position.y);
    let low = -0.02;
    let high = 0.2;
    let rows = 44u16;
    let width = 0.1;
    let field = sample::<Plane>(
        &simulation,
        &format!("grid: XY(low: (-0.05, {low}), high: (0.05, {high}), cells: (1, {rows}))"),
        None,
    );
    let step = (high - low) / f64::from(rows);
    for row in 0..usize::from(rows) {
        let from = low + step * row as f64;
        let to = low + step * (row + 1) as f64;
        // The line of each contact in the row carries the weight above: 2 m g below the first centre, m g up to the second.
        let part = |start: f64, end: f64| (to.min(end) - from.max(start)).max(0.0);
        let expected = m * g * (2.0 * part(0.0, first) + part(first, second)) / (step * width);
        // A grain at a speed of 1e-9 sqrt(g R) has a spring force that is off by less than sqrt(k m) times it, 8e-8 N of 1.6 N.
        assert!((field.contact(row, 1, 1) - expected).abs() < 1e-6 * 2.0 * m * g / width, "row {row}");
        assert_eq!((field.contact(row, 0, 1), field.contact(row, 0, 0)), (0.0, 0.0));
    }
}

/// A bed of discs with friction, at rest on a floor, periodic along x with the side `SIDE`.
fn bed() -> (Simulation, Vec<(DVec3, f64)>) {
    let keys = format!(
        "gravity: (0.0, -9.81), periodic: (x: (0.0, {SIDE:?})), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
         contact: Linear(k: 1.0e5, damping: Restitution(0.3), tangential: Spring(k: 3.0e4, damping: OfNormal(1.0), friction: 0.5)), \
         step: Fixed(1.0e-4), rest: (speed: 1.0e-7, energy: 1.0, hold: 0.2, stop: true), until: 60.0"
    );
    let random = Stream::new(3, "bed");
    let grains = (0..80u32).map(|n| {
        let [dx, dy, size] = random.uniform::<3>(n.into());
        let place = Vector::new(0.1 * (f64::from(n % 8) + 0.4 + 0.2 * dx), 0.06 + 0.1 * (f64::from(n / 8) + 0.1 * dy));
        let radius = 0.035 + 0.01 * size;
        grain(n + 1, place, Vector::ZERO, radius, 100.0 * radius * radius)
    });
    let grains: Vec<GrainRow> = grains.collect();
    let masses: Vec<_> = grains.iter().map(|grain| grain.mass).collect();
    let mut simulation = simulation(&keys, grains);
    assert_eq!(simulation.run(), End::AtRest);
    let places = motion(&mut simulation).into_iter().map(|motion| motion.position).zip(masses).collect();
    (simulation, places)
}

const SIDE: f64 = 0.8;

#[test]
fn a_bed_at_rest_carries_the_weight_above_in_every_row_and_its_stress_has_the_divergence_of_the_weight() {
    let (simulation, grains) = bed();
    let g = 9.81;
    let weight: f64 = grains.iter().map(|(_, mass)| mass * g).sum();
    // Springs relax at rates above 1/s: forces are off by less than the mass times a speed of 1e-7 sqrt(g R) times a frequency
    // of sqrt(k/m) = 800/s: 1e-5 of a grain's weight. 80 grains: 1e-5 of the weight of the bed is a bound.
    let tolerance = 1e-5 * weight / SIDE;
    let rows = 31u16;
    let sharp = sample::<Plane>(&simulation, "grid: XY(low: (0.0, 0.0), high: (0.8, 0.93), cells: (1, 31))", None);
    for row in 0..rows {
        let from = 0.03 * f64::from(row);
        let part = |y: f64| ((y - from) / 0.03).clamp(0.0, 1.0);
        let expected = grains.iter().map(|(x, mass)| mass * g * part(x.y)).sum::<f64>() / SIDE;
        let found = sharp.contact(row.into(), 1, 1);
        assert!((found - expected).abs() < tolerance, "row {row}: {found} {expected}");
        assert!(sharp.contact(row.into(), 0, 1).abs() < tolerance, "no shear force acts along a periodic floor");
    }
    // The same with a Gaussian, on a fine grid: d(sigma_ab)/db = rho g_a at every point far from the floor. Differences of fourth order
    // are off by h^4/30 of the fifth derivative of the integral of a Gaussian. With h = w/4 it is below
    // 7/256/30 = 1e-3 of sigma/w for a single contact; rho g is 1e2 N/m^2, and sigma/w = 1e4 N/m^2 at most.
    let width = 0.04;
    let grid = format!("grid: XY(low: (0.0, 0.25), high: (0.8, 0.85), cells: (80, 60)), kernel: Gaussian({width})");
    let fine = sample::<Plane>(&simulation, &grid, None);
    let h = 0.01;
    let at = |x: usize, y: usize, a: usize, b: usize| fine.contact(y * 80 + x % 80, a, b);
    let difference = |near: [f64; 2], far: [f64; 2]| (8.0 * (near[1] - near[0]) - (far[1] - far[0])) / (12.0 * h);
    let mut largest_error = 0.0f64;
    let mut largest_weight = 0.0f64;
    for y in 2..58 {
        for x in 80..160 {
            let divergence = [0, 1].map(|a| {
                difference([at(x - 1, y, a, 0), at(x + 1, y, a, 0)], [at(x - 2, y, a, 0), at(x + 2, y, a, 0)])
                    + difference([at(x, y - 1, a, 1), at(x, y + 1, a, 1)], [at(x, y - 2, a, 1), at(x, y + 2, a, 1)])
            });
            let density = fine.means[y * 80 + x % 80][1];
            largest_weight = largest_weight.max(density * g);
            largest_error = largest_error.max(divergence[0].abs()).max((divergence[1] + density * g).abs());
        }
    }
    assert!(largest_error < 0.02 * largest_weight, "{largest_error} {largest_weight}");
    // Mean over a row: sum m g Phi((y_i - y)/w), with the normal distribution Phi; here by its own integral of densities.
    let row_stress = |y: usize| (0..80).map(|x| at(x, y, 1, 1)).sum::<f64>() / 80.0;
    let above: f64 = (0..60).map(|y| (0..80).map(|x| fine.means[y * 80 + x][1]).sum::<f64>() / 80.0 * g * h).sum();
    // Rows 10 and 49 are compared by the weight between them: midpoints 0.355 and 0.745 m.
    let between: f64 = (10..49)
        .map(|y| {
            (0..80).map(|x| 0.5 * (fine.means[y * 80 + x][1] + fine.means[(y + 1) * 80 + x][1])).sum::<f64>() / 80.0
                * g
                * h
        })
        .sum();
    let drop = row_stress(10) - row_stress(49);
    // The trapezoidal rule has an error of h^2/12 times the difference of the slopes of rho at its ends, of about rho/w.
    assert!((drop - between).abs() < h * h / 6.0 / width * largest_weight + tolerance, "{drop} {between} of {above}");
}

/// Overlapping spheres at random, periodic along y, with the contact law k delta.
fn cloud() -> (Simulation, Vec<GrainRow>) {
    let random = Stream::new(9, "cloud");
    let grains = (0..60u32).map(|n| {
        let at: [f64; 6] = random.uniform(n.into());
        let place = DVec3::new(0.8 * at[0] - 0.4, 0.5 * at[1], 0.6 * at[2]);
        let velocity = DVec3::new(at[3], at[4], at[5]);
        sphere(n + 1, place, velocity, 0.05 + 0.0005 * f64::from(n), 0.2 + 0.01 * f64::from(n))
    });
    let grains: Vec<_> = grains.collect();
    let keys = "space: Solid, gravity: (0.0, 0.0, 0.0), periodic: (y: (0.0, 0.5)), watchdog: None, \
                contact: Linear(k: 1.0e3, damping: B(0.0)), step: Fixed(1.0e-4), until: 1.0";
    let mut simulation = simulation(keys, grains.clone());
    // Step zero evaluates the forces and moves nothing.
    simulation.step();
    (simulation, grains)
}

#[test]
fn integrals_over_every_grid_are_the_sums_over_grains_and_contacts() {
    let (simulation, grains) = cloud();
    let mass = grains.iter().map(|grain| grain.mass).sum::<f64>();
    let mut virial = [0.0; 9];
    let mut contacts = 0;
    for (n, a) in grains.iter().enumerate() {
        for b in &grains[..n] {
            let mut l = a.position - b.position;
            l.y -= 0.5 * (l.y / 0.5).round();
            let overlap = a.radius + b.radius - l.length();
            if overlap > 0.0 {
                contacts += 1;
                let f = 1.0e3 * overlap * l.normalize();
                (0..9).for_each(|at| virial[at] += f[at / 3] * l[at % 3]);
            }
        }
    }
    assert!(contacts > 40, "{contacts}");
    let volume: f64 = grains.iter().map(|grain| 4.0 / 3.0 * PI * grain.radius.powi(3)).sum();
    let size = virial[0].abs();
    // Sharp cells: sums of a thousand rounded numbers. Gaussian: 2e-9 of a grain is cut off along each axis, at both ends of
    // up to three axes; the midpoint rule with w = 1.5 h is exact to 2 exp(-2 pi^2 w^2/h^2) = 1e-19. The margin is 6 w = 0.36 m.
    let side = Some((0.0, 0.5));
    for (grid, tolerance) in [
        ("grid: XYZ(low: (-0.6, 0.0, -0.1), high: (0.6, 0.5, 0.7), cells: (13, 7, 9))", 1e-13),
        ("grid: XZ(low: (-0.6, -0.1), high: (0.6, 0.7), cells: (13, 9))", 1e-13),
        ("grid: XZ(low: (-1.0, -0.52), high: (1.0, 1.12), cells: (50, 41)), kernel: Gaussian(0.06)", 2e-8),
        ("grid: XYZ(low: (-0.8, 0.0, -0.4), high: (0.8, 0.5, 1.0), cells: (32, 10, 28)), kernel: Gaussian(0.06)", 2e-8),
    ] {
        let field = sample::<Solid>(&simulation, grid, side);
        assert!((field.integral(|cell| field.means[cell][1]) / mass - 1.0).abs() < tolerance, "{grid}");
        assert!((field.integral(|cell| field.means[cell][0]) / volume - 1.0).abs() < tolerance, "{grid}");
        for (at, &expected) in virial.iter().enumerate() {
            let found = field.integral(|cell| field.contact(cell, at / 3, at % 3));
            assert!((found - expected).abs() < tolerance * size, "{grid} {at}: {found} {expected}");
        }
    }
}

#[test]
fn rings_hold_the_whole_mass_and_the_invariants_of_the_stress() {
    // Along y the box is open here, and the rings reach beyond all grains.
    let random = Stream::new(4, "rings");
    let grains = (0..50u32).map(|n| {
        let at: [f64; 6] = random.uniform(n.into());
        let [place, velocity] = [0, 3].map(|start| DVec3::from_slice(&at[start..]));
        sphere(n + 1, 0.5 * place, velocity, 0.06, 0.3)
    });
    let grains: Vec<_> = grains.collect();
    let keys = "space: Solid, gravity: (0.0, 0.0, 0.0), contact: Linear(k: 1.0e3, damping: B(0.0)), step: Fixed(1.0e-4), \
                watchdog: None, until: 1.0";
    let mut simulation = simulation(keys, grains.clone());
    simulation.step();
    let field = sample::<Solid>(
        &simulation,
        "grid: RZ(axis: (0.21, 0.3), radius: 0.6, low: -0.1, high: 0.6, cells: (7, 9))",
        None,
    );
    let mut trace = 0.0;
    let mut vertical = 0.0;
    for (n, a) in grains.iter().enumerate() {
        for b in &grains[..n] {
            let l = a.position - b.position;
            let f = 1.0e3 * (a.radius + b.radius - l.length()).max(0.0) * l.normalize();
            trace += f.dot(l);
            vertical += f.z * l.z;
        }
    }
    // Sums of a few hundred rounded numbers.
    let found = field.integral(|cell| (0..3).map(|a| field.contact(cell, a, a)).sum());
    assert!((found / trace - 1.0).abs() < 1e-13 && trace > 1.0, "{found} {trace}");
    let found = field.integral(|cell| field.contact(cell, 2, 2));
    assert!((found / vertical - 1.0).abs() < 1e-13, "{found} {vertical}");
    let mass = field.integral(|cell| field.means[cell][1]);
    assert!((mass / (50.0 * 0.3) - 1.0).abs() < 1e-13, "{mass}");
    // A rigid rotation about the axis is along the angle alone, so the radial velocity is zero: here for one grain.
    let omega = 3.0;
    let place = DVec3::new(0.3, 0.4, 0.0);
    let turning = sphere(1, place, DVec3::new(-omega * 0.4, omega * 0.3, 0.7), 0.01, 1.0);
    let mut simulation = crate::simulation(keys, vec![turning]);
    simulation.step();
    let ring = sample::<Solid>(&simulation, "grid: RZ(radius: 1.0, low: -1.0, high: 1.0, cells: (1, 1))", None);
    let expected = [0.0, 0.5 * omega, 0.7];
    assert!((0..3).all(|a| (ring.means[0][2 + a] - expected[a]).abs() < 1e-15), "{:?}", ring.means);
}

#[test]
fn a_sheared_lattice_has_its_known_stress() {
    // A square lattice of spacing d, each row shifted by e d (`shift` is e) against the row below, periodic after eight rows. Each grain
    // has half of four bonds: one (d, 0) and one (e d, d) in the area d^2. So sigma = sum of f l / d^2.
    let stiffness = 1.0e4;
    let d = 0.1;
    let radius = 0.052;
    let shift = 0.125;
    let n = 8u32;
    let more = Vector::new(0.3, -0.2);
    let drift = 5.0;
    let grains = (0..n * n).map(|at| {
        let column = at % n;
        let row = at / n;
        let x = (d * (f64::from(column) + 0.5 + shift * f64::from(row))).rem_euclid(d * f64::from(n));
        // Half of the grains have the velocity `more` more than the mean, the others less.
        let sign = if (column + row).is_multiple_of(2) { 1.0 } else { -1.0 };
        grain(at + 1, Vector::new(x, d * (f64::from(row) + 0.5)), Vector::X * drift + more * sign, radius, 2.0)
    });
    let keys = format!(
        "gravity: (0.0, 0.0), periodic: (x: (0.0, 0.8), y: (0.0, 0.8)), contact: Linear(k: {stiffness:?}, damping: B(0.0)), \
         step: Fixed(1.0e-5), until: 1.0"
    );
    let mut simulation = simulation(&keys, grains.collect());
    simulation.step();
    let length = d * (1.0 + shift * shift).sqrt();
    let density = 2.0 / (d * d);
    let flat = stiffness * (2.0 * radius - d);
    let steep = stiffness * (2.0 * radius - length) / length;
    let along = shift * steep * d * d;
    let expected = [flat * d + shift * along, along, along, steep * d * d];
    for (cells, tolerance) in [("cells: (1, 1)", 1e-12), ("cells: (16, 16)), kernel: Gaussian(0.5", 1e-6)] {
        // With a Gaussian of five spacings the lattice is smooth: its first Fourier component is exp(-2 pi^2 w^2/d^2) = 0; the
        // cut at 6 w leaves 4e-9 of each axis, and the periodic images fill the rest.
        let field =
            sample::<Plane>(&simulation, &format!("grid: XY(low: (0.0, 0.0), high: (0.8, 0.8), {cells})"), None);
        for (cell, means) in field.means.iter().enumerate() {
            for (at, &expected) in expected.iter().enumerate() {
                let found = field.contact(cell, at / 2, at % 2) * d * d;
                assert!((found - expected).abs() < tolerance * flat * d, "{cells} {at}: {found} {expected}");
            }
            let found = [means[1], means[2], means[3], means[4], means[5], means[6], means[7]];
            let exact = [
                density,
                drift,
                0.0,
                0.5 * more.length_squared(),
                density * more.x * more.x,
                density * more.x * more.y,
                density * more.y * more.y,
            ];
            // The kinetic stress is a difference of numbers (drift/0.3)^2 = 300 times larger.
            let scales = [density, drift, drift, 300.0, density * 300.0, density * 300.0, density * 300.0];
            for ((found, exact), scale) in found.into_iter().zip(exact).zip(scales) {
                assert!((found - exact).abs() < tolerance * scale, "{cells}: {found} {exact}");
            }
        }
    }
}
