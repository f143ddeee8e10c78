//! Comparison with another program: ten clumps of three spheres in LAMMPS 29Sep2021, `fix rigid/small` with the mass, the centre and the
//! inertia of the union, `pair_style gran/hooke/history`, three steps. `tests/data/clumps.in` has the parameters.
//!
//! Between impacts both programs turn a body with an error of second order, by different schemes: LAMMPS with Richardson's iteration of the quaternion,
//! siloflow with a symplectic splitting. In contacts LAMMPS lets a sphere move with w(t+dt/2) x r(t+dt), siloflow with its displacement over
//! dt; the two differ by O(dt). So the difference falls as dt^2 before the first contact and as dt after it.

use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::dem::space::Solid as DVec3;
use siloflow::dem::store::ParticleStore;
use siloflow::prelude::*;

/// Returns the largest distance (m) of a sphere from LAMMPS's at each time (ms), with steps of `dt`.
fn distances(dt: &str) -> BTreeMap<u64, f64> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let settings = [("step", format!("Fixed({dt})")), ("grains", "(file: \"clumps_initial.csv\")".to_owned())];
    let settings = settings.map(|(key, value)| (key.to_owned(), value));
    let loaded = load::load(&data.join("clumps.ron"), &settings).unwrap();
    let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
    let step: f64 = dt.parse().unwrap();
    let mut largest = BTreeMap::new();
    for line in fs::read_to_string(data.join("clumps_frames.csv")).unwrap().lines().skip(1) {
        let cells: Vec<_> = line.split(',').collect();
        if cells[0] != dt {
            continue;
        }
        let numbers: Vec<f64> = cells[1..].iter().map(|cell| cell.parse().unwrap()).collect();
        simulation.run_steps((numbers[0] / step).round() as u64);
        let store = simulation.world().resource::<ParticleStore<Solid>>();
        let rows = store.by_id();
        let row =
            rows.into_iter().filter(|&row| f64::from(store.id[row].number()) == numbers[1]).nth(numbers[2] as usize);
        let distance = store.body[row.unwrap()].position.distance(DVec3::new(numbers[3], numbers[4], numbers[5]));
        let at = largest.entry((numbers[0] * 1e3).round() as u64).or_insert(0.0_f64);
        *at = at.max(distance);
    }
    largest
}

#[test]
fn ten_clumps_differ_from_lammps_by_the_order_of_both_schemes() {
    let [coarse, middle, fine] = ["4e-6", "2e-6", "1e-6"].map(distances);
    // The start is the same, and so are the shapes.
    assert!(fine[&0] < 1e-14, "{fine:?}");
    // No contact before 2 ms.
    for (one, other) in [(&coarse, &middle), (&middle, &fine)] {
        assert!((one[&2] / other[&2] - 4.0).abs() < 0.2, "{one:?} {other:?}");
    }
    assert!(coarse[&2] < 1e-10, "{coarse:?}");
    // After the first contacts the differences halve.
    for time in [4, 6, 8] {
        assert!(
            fine[&time] < 0.7 * middle[&time] && middle[&time] < 0.7 * coarse[&time],
            "{coarse:?} {middle:?} {fine:?}"
        );
        assert!(fine[&time] < 1e-7, "{time} ms: {fine:?}");
    }
}
