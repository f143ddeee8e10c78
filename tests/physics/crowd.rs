//! The stability limit of a dense bed: a settled bed stays calm just below the limit that `check` prints, and is agitated at up to
//! three times that step.
//!
//! `docs/measure/stability.py` measures the same in larger beds, with more laws.

use crate::{grain, motion, simulation};
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::scene::check::Estimates;

const K: f64 = 1.0e5;
const COLUMNS: u32 = 10;
const SPACING: f64 = 0.081;
/// Velocities at the start of the measurement, m/s: a thousandth of sqrt(g R).
const STIRRED: f64 = 6.0e-4;

fn keys(law: &str, scheme: &str, dt: f64) -> String {
    let width = f64::from(COLUMNS) * SPACING;
    format!(
        "gravity: (0.0, -9.81), periodic: (x: (0.0, {width:?})), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
         contact: {law}, integrator: {scheme}, step: Fixed({dt:?}), until: 1.0e9"
    )
}

/// Returns a settled bed of 150 discs of two sizes, with small random velocities.
fn settled() -> Vec<GrainRow> {
    let start = (0..15 * COLUMNS).map(|n| {
        let row = n / COLUMNS;
        let column = n % COLUMNS;
        let radius = if (7 * row + 3 * column) % 5 < 2 { 0.03 } else { 0.04 };
        let place = Vector::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * SPACING;
        let push = Vector::from_angle(f64::from(n) * 2.4) * 0.3;
        grain(n + 1, place, push, radius, 100.0 * radius * radius)
    });
    let start: Vec<_> = start.collect();
    let law = format!("Linear(k: {K:?}, damping: Restitution(0.2))");
    let mut simulation = simulation(&keys(&law, "Verlet", 1.0e-4), start.clone());
    simulation.run_steps(40_000);
    let now = motion(&mut simulation);
    let stirred = (0u32..).zip(start.iter().zip(now)).map(|(n, (row, now))| {
        let push = Vector::from_angle(f64::from(n) * 2.4) * STIRRED;
        grain(n + 1, now.position.truncate(), push, row.radius, row.mass)
    });
    stirred.collect()
}

/// Returns the stability limits of a dense bed of these grains and of a single contact, s.
fn limits(law: &str, scheme: &str, grains: &[GrainRow]) -> [f64; 2] {
    let text = format!("({}, pictures: None)", keys(law, scheme, 1.0e-6));
    let mut loaded = load::from_text("test.ron", "test", std::path::Path::new(""), text, &[]).unwrap();
    loaded.grains = grains.to_vec();
    let estimates = Estimates::of(&loaded).unwrap();
    [estimates.bed_limit, estimates.pair_limit]
}

#[test]
fn a_settled_bed_is_calm_up_to_the_limit_of_a_dense_bed() {
    let grains = settled();
    let start: f64 = grains.iter().map(|row| 0.5 * row.mass * row.velocity.length_squared()).sum();
    let friction =
        |mu: f64| format!(", tangential: Spring(k: {:?}, damping: OfNormal(0.5), friction: {mu:?})", K * 2.0 / 7.0);
    let linear = |e: f64, rest: &str| format!("Linear(k: {K:?}, damping: Restitution({e:?}){rest})");
    // The drag of the last law gives two grains of R = 0.03 m a restitution of 0.2.
    let laws = [
        linear(0.5, ""),
        linear(0.2, ""),
        linear(0.9, &friction(0.5)),
        linear(0.2, &friction(0.5)),
        format!("Assignment(k: {K:?}, b: 61.0)"),
    ];
    for law in &laws {
        for scheme in ["Verlet", "Centred"] {
            let [limit, lone] = limits(law, scheme, &grains);
            let after = |share: f64| {
                let mut simulation = simulation(&keys(law, scheme, share * limit), grains.clone());
                simulation.run_steps(4000);
                let now = totals::of_world(simulation.world());
                (now.kinetic + now.rotational) / start
            };
            // In a calm bed the energy of the start can only be dissipated, apart from what loose grains gain by falling a little.
            // The weights of the limit assume six neighbours, of which most grains of a smooth bed have four.
            let coarse = (0.95 * lone / limit).min(3.0);
            let [below, above] = [0.99, coarse].map(after);
            assert!(below < 2.0, "{law}, {scheme}: {below} at 0.99 of {limit:e} s");
            assert!(above > 100.0, "{law}, {scheme}: {above} at {coarse} of {limit:e} s");
        }
    }
}
