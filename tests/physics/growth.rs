//! `Centred` makes no motion of a held grain grow, whatever dashpots its contacts have: by the eigenvalues of the scheme's linear
//! recurrence, and in simulations of siloflow.
//!
//! A sphere of mass 1 and radius 1 moves and turns between 1, 2, 6 or 12 fixed surfaces. q has its displacement and its rotation times
//! sqrt(2/5); in these coordinates all masses are 1. A contact has springs and dashpots along rows of a matrix: its normal n; its tangents e,
//! with the rotation at the surface; rolling and twisting, with the rotation alone. The scheme, with the step as the unit of time, is
//!
//! V' = V + a, q' = q + V', v_p = V' + R a, a' = -(K_n q' + C v_p) - sum of k s' over the other springs,
//!
//! R = beta/2 with one beta for displacements and one for rotations. A spring has s' = (its row of q'), or, if all springs have c >= k dt,
//! s' = s + (its row of v_p' + v_p)/2. With every spring along q', nothing grows below the largest eigenvalue
//! of K + 2 G C G = 4, G^2 = 1 + 2 R, which is the condition of `scene::check::crowd`. Springs along v_p do not count in K.

use siloflow::dem::space::Solid;
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::scene::check::Estimates;
use siloflow::scene::load;

use crate::matrix::{Matrix, largest_eigenvalue, spectral_radius};
use crate::{simulation, sphere};

/// Displacements and rotations.
const FREEDOMS: usize = 6;
const INERTIA: f64 = 0.4;

/// Stiffness and drag coefficient along the normal, along tangents, in rolling and in twisting.
type Law = [[f64; 2]; 4];

/// Directions of the contacts of a sphere: of one, two opposite ones, six along the axes, twelve of the densest packing.
fn directions(count: usize) -> Vec<Solid> {
    let axes = [Solid::Z, -Solid::Z, Solid::X, -Solid::X, Solid::Y, -Solid::Y];
    if count <= 6 {
        return axes[..count].to_vec();
    }
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let planes = [(Solid::X, Solid::Y), (Solid::X, Solid::Z), (Solid::Y, Solid::Z)];
    planes.iter().flat_map(|&(a, b)| signs.map(|(s, t)| (a * s + b * t).normalize())).collect()
}

/// Rows of the contacts, each with its place in the law.
fn rows(count: usize) -> Vec<(usize, [f64; FREEDOMS])> {
    let row = |displacement: Solid, rotation: Solid| {
        let [a, b] = [displacement, rotation * (1.0 / INERTIA.sqrt())].map(|vector| vector.to_array());
        [a[0], a[1], a[2], b[0], b[1], b[2]]
    };
    let of = |normal: Solid| {
        let one = normal.any_orthonormal_vector();
        let tangents = [one, normal.cross(one)];
        // The surface moves with v - w x n, of which the part along e is v.e - w.(n x e).
        let sliding = tangents.map(|e| (1, row(e, -normal.cross(e))));
        let rolling = tangents.map(|e| (2, row(Solid::ZERO, normal.cross(e))));
        let others = [(0, row(normal, Solid::ZERO)), (3, row(Solid::ZERO, normal))];
        sliding.into_iter().chain(rolling).chain(others)
    };
    directions(count).into_iter().flat_map(of).collect()
}

/// beta of displacements and of rotations, from the damping rates of one contact.
fn shares(law: &Law) -> [f64; 2] {
    let turning = [law[1][1] * (1.0 + 1.0 / INERTIA), law[2][1] / INERTIA, law[3][1] / INERTIA];
    [law[0][1], turning.into_iter().fold(0.0, f64::max)].map(|c| ((1.0 - 0.5 * c) / (1.0 + 0.5 * c)).max(0.01))
}

/// Whether springs follow the positions: one of them has c < k dt.
fn follow_positions(law: &Law) -> bool {
    law[1..].iter().any(|&[k, c]| c < k)
}

/// Returns the largest eigenvalue of K + 2 G C G, with only those springs in K that follow the positions.
fn load(count: usize, law: &Law) -> f64 {
    let shares = shares(law);
    let mut sum = Matrix::zero(FREEDOMS, FREEDOMS);
    for (part, row) in rows(count) {
        let [k, c] = law[part];
        let k = if part == 0 || follow_positions(law) { k } else { 0.0 };
        for i in 0..FREEDOMS {
            for j in 0..FREEDOMS {
                let g = ((1.0 + shares[i / 3]) * (1.0 + shares[j / 3])).sqrt();
                sum[[i, j]] += row[i] * row[j] * (k + 2.0 * g * c);
            }
        }
    }
    largest_eigenvalue(&sum)
}

/// Returns the growth of the fastest growing motion in a step.
fn growth(count: usize, law: &Law) -> f64 {
    let rows = rows(count);
    let shares = shares(law);
    // A law without resistance to rolling or twisting has no such springs.
    let rows: Vec<_> = rows.into_iter().filter(|&(part, _)| law[part] != [0.0; 2]).collect();
    let gathering = if follow_positions(law) { 0 } else { rows.iter().filter(|row| row.0 > 0).count() };
    // The state q, V, a, v_p and the springs that follow predicted velocities. Each number is a row over the former state.
    let size = 4 * FREEDOMS + gathering;
    let unit = |place: usize| (0..size).map(|n| f64::from(u8::from(n == place))).collect::<Vec<f64>>();
    let plus = |a: &[f64], b: &[f64], by: f64| a.iter().zip(b).map(|(a, b)| a + by * b).collect::<Vec<f64>>();
    let [places, velocities, gains, predictions] =
        [0, 1, 2, 3].map(|part| (0..FREEDOMS).map(|i| unit(part * FREEDOMS + i)).collect::<Vec<_>>());
    let velocity: Vec<_> = (0..FREEDOMS).map(|i| plus(&velocities[i], &gains[i], 1.0)).collect();
    let place: Vec<_> = (0..FREEDOMS).map(|i| plus(&places[i], &velocity[i], 1.0)).collect();
    let predicted: Vec<_> = (0..FREEDOMS).map(|i| plus(&velocity[i], &gains[i], 0.5 * shares[i / 3])).collect();
    let along = |row: &[f64; FREEDOMS], of: &[Vec<f64>]| {
        (0..FREEDOMS).fold(vec![0.0; size], |sum, i| plus(&sum, &of[i], row[i]))
    };
    let mut accelerations = vec![vec![0.0; size]; FREEDOMS];
    let mut springs = Vec::new();
    for (part, row) in &rows {
        let [k, c] = law[*part];
        let now = along(row, &predicted);
        let stretch = if *part == 0 || follow_positions(law) {
            along(row, &place)
        } else {
            let spring = unit(4 * FREEDOMS + springs.len());
            springs.push(plus(&plus(&spring, &now, 0.5), &along(row, &predictions), 0.5));
            springs[springs.len() - 1].clone()
        };
        let force = plus(&now.iter().map(|x| c * x).collect::<Vec<_>>(), &stretch, k);
        for i in 0..FREEDOMS {
            accelerations[i] = plus(&accelerations[i], &force, -row[i]);
        }
    }
    let state = [place, velocity, accelerations, predicted, springs].concat();
    spectral_radius(&Matrix::from_rows(&state))
}

/// Damping ratios of a sweep. The steps of the test give (w dt)^2.
const RATIOS: [f64; 4] = [0.0, 0.01, 0.2, 1.5];

/// All laws of the sweep, with a normal stiffness of 1. The other parts have stiffnesses and dashpots in proportion to these.
fn laws() -> impl Iterator<Item = Law> {
    let part = |k: f64, zeta: f64| [k, 2.0 * zeta * k.sqrt()];
    let all = RATIOS.into_iter().map(move |zeta| part(1.0, zeta));
    let tangents = [0.02f64, 0.3, 2.0].into_iter().flat_map(|share| RATIOS.map(|zeta| (share, zeta)));
    let rest = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2)];
    all.flat_map(move |normal| tangents.clone().map(move |(share, zeta)| (normal, part(share * normal[0], zeta))))
        .flat_map(move |(normal, tangent)| {
            rest.map(|(share, zeta)| {
                [normal, tangent, part(share * normal[0], zeta), part(0.5 * share * normal[0], zeta)]
            })
        })
}

/// Returns the law with another step, `by` times as long.
fn with_step(law: &Law, by: f64) -> Law {
    law.map(|[k, c]| [k * by * by, c * by])
}

/// Returns the longest stable step in units of that of the law, by the condition.
fn longest(count: usize, law: &Law) -> f64 {
    let mut low = 0.0;
    let mut high = 1e4;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if load(count, &with_step(law, middle)) < 4.0 { low = middle } else { high = middle }
    }
    low
}

#[test]
fn nothing_grows_below_the_limit_with_any_number_of_contacts_and_any_dashpots() {
    for count in [1, 2, 6, 12] {
        for law in laws() {
            let limit = longest(count, &law);
            for share in [0.01, 0.2, 0.6, 0.99] {
                let growth = growth(count, &with_step(&law, share * limit));
                // A motion without force moves at a constant velocity: the norm of 2^24 steps is of the order of 2^24.
                assert!(growth < 1.0 + 4e-6, "{count} contacts, {law:?}, {share} of the limit: {growth}");
            }
            let growth = growth(count, &with_step(&law, 1.02 * limit));
            assert!(growth > 1.0 + 1e-5, "{count} contacts, {law:?}, beyond the limit: {growth}");
        }
    }
}

/// Mass, radius and stiffness of the sphere in simulations, kg, m, N/m: half a period of its normal contact takes pi seconds.
const M: f64 = 1.0;
const R: f64 = 0.5;
const K: f64 = 1.0;
/// How deep the surfaces press the sphere, m.
const PRESSED: f64 = 1e-3;

/// A sphere between half-spaces in siloflow, with a law in units of the step `dt` (s).
struct Held {
    keys: String,
    sphere: GrainRow,
}

impl Held {
    fn new(count: usize, scheme: &str, law: &Law, dt: f64) -> Self {
        // Rolling and twisting act with the arm R of their torque, as friction does.
        let [[k, c], [kt, ct], [kr, cr], [kw, cw]] = law.map(|[k, c]| [K * k, K * c]);
        let walls = directions(count).into_iter().map(|normal| {
            let point = normal * (PRESSED - R);
            let text = |v: Solid| format!("({:?}, {:?}, {:?})", v.x, v.y, v.z);
            format!("HalfPlane(point: {}, normal: {})", text(point), text(normal))
        });
        let keys = format!(
            "space: Solid, gravity: (0.0, 0.0, 0.0), integrator: {scheme}, step: Fixed({dt:?}), until: 1.0e9, watchdog: None, \
             contact: Linear(k: {k:?}, damping: B({c:?}), attraction: Allowed, \
             tangential: Spring(k: {kt:?}, damping: B({ct:?}), friction: 1.0e3), \
             rolling: (k: {kr:?}, damping: B({cr:?}), friction: 1.0e3), twisting: (k: {kw:?}, damping: B({cw:?}), friction: 1.0e3)), \
             walls: [{}]",
            walls.collect::<Vec<_>>().join(", ")
        );
        let mut sphere = sphere(1, Solid::ZERO, Solid::new(1e-7, -2e-7, 1.5e-7), R, M);
        sphere.spin = Solid::new(-3e-7, 2e-7, 4e-7);
        Self { keys, sphere }
    }

    fn simulation(&self) -> siloflow::prelude::Simulation {
        simulation(&self.keys, vec![self.sphere])
    }

    fn estimates(&self) -> Estimates {
        let text = format!("({}, pictures: None)", self.keys);
        let mut loaded = load::from_text("test.ron", "test", std::path::Path::new(""), text, &[]).unwrap();
        loaded.grains = vec![self.sphere];
        Estimates::of(&loaded).unwrap()
    }

    /// Energy of motion at the start, J.
    fn energy(&self) -> f64 {
        let GrainRow { velocity, spin, .. } = self.sphere;
        0.5 * M * velocity.length_squared() + 0.5 * INERTIA * M * R * R * spin.length_squared()
    }

    /// Returns the largest energy, less that of the pressed surfaces, of steps 20 to 200 and of the last 180 of `steps`, J.
    fn energies(&self, count: usize, steps: u64) -> [f64; 2] {
        let mut simulation = self.simulation();
        let mut most = |from: u64| {
            let energy = |step| {
                simulation.run_steps(step);
                // Velocities alone do not show a motion that changes its sign in each step: they are zero at its ends.
                totals::of_world(simulation.world()).energy() - 0.5 * K * count as f64 * PRESSED * PRESSED
            };
            (from..from + 180).map(energy).fold(0.0, |most: f64, energy| most.max(energy.abs()))
        };
        [20, steps - 180].map(&mut most)
    }
}

/// Laws of simulations in units of the step: no dashpots; normal ones; weak ones along tangents too; enough of them for springs that follow
/// predicted velocities.
fn held_laws() -> [Law; 4] {
    let k = 1.0;
    let kt = 2.0 / 7.0;
    let kr = 0.1;
    let kw = 0.05;
    [
        [[k, 0.0], [kt, 0.0], [kr, 0.0], [kw, 0.0]],
        [[k, 0.43], [kt, 0.0], [kr, 0.0], [kw, 0.0]],
        [[k, 0.9], [kt, 0.02], [kr, 0.0], [kw, 0.01]],
        [[k, 0.2], [kt, 1.0], [kr, 0.4], [kw, 0.2]],
    ]
}

#[test]
fn a_held_sphere_of_siloflow_grows_beyond_the_limit_and_not_below() {
    for count in [2, 6, 12] {
        for law in held_laws() {
            let limit = longest(count, &law);
            let held = |share: f64| {
                let dt = share * limit;
                (Held::new(count, "Centred", &law, dt), with_step(&law, dt))
            };
            let (below, _) = held(0.97);
            let stated = below.estimates().bed_limit;
            assert!(stated < 1.0001 * limit, "{count} contacts, {law:?}: {stated} s stated, the limit is {limit} s");
            let [early, late] = below.energies(count, 20_000);
            assert!(late < 1.5 * early, "{count} contacts, {law:?}: {early:e} J, then {late:e} J");
            let (above, scaled) = held(1.02);
            // The energy grows by the square of the eigenvalue in each step, from the rounding of a motion that may be absent at the start.
            let steps = 200 + (20.0 / growth(count, &scaled).ln()) as u64;
            let late = above.energies(count, steps + 180)[1];
            assert!(late > 1e3 * above.energy(), "{count} contacts, {law:?}, beyond: {late:e} J");
        }
    }
}

/// A swing between two plates loses nothing where its springs have no dashpots, and the energy balance closes.
#[test]
fn a_swing_without_tangential_dashpots_keeps_its_energy() {
    let law = held_laws()[1];
    // 2 k_t (1 + 5/2)/m = 2: the frequency of the swing, with 2 pi/(sqrt(2) dt) = 89 steps in a period.
    let held = Held::new(2, "Centred", &law, 0.05);
    let mut simulation = held.simulation();
    simulation.run_steps(20);
    let energy = |simulation: &siloflow::prelude::Simulation| totals::of_world(simulation.world()).energy();
    let pressed = K * PRESSED * PRESSED;
    // The motion along the normal has died away after 2000 steps: its energy falls as exp(-2 c t/m).
    simulation.run_steps(2000);
    let flows = |simulation: &siloflow::prelude::Simulation| simulation.world().resource::<EnergyFlows>().dissipated;
    let early = energy(&simulation) - pressed;
    let lost = flows(&simulation);
    simulation.run_steps(200_000);
    let late = energy(&simulation) - pressed;
    let dissipated = flows(&simulation) - lost;
    // Velocity Verlet keeps a neighbour of the energy, which differs from it by (w dt)^2/8 of it at most.
    let bound = 0.25 * 2.0 * 0.05f64.powi(2) * early;
    assert!((late - early).abs() < bound, "{early:e} J, then {late:e} J");
    // 2e5 steps, each with a rounding of the pressed energy.
    assert!(dissipated.abs() < bound, "{dissipated:e} J dissipated of {early:e} J");
}
