//! A column of grains at rest: each contact carries the weight of all grains above it.

use crate::{grain, simulation, state};
use siloflow::prelude::*;

#[test]
fn overlaps_in_a_column_at_rest_match_the_weight_above() {
    const N: u32 = 12;
    let k = 1.0e5;
    let m = 0.16;
    let radius = 0.04;
    let g = 9.81;
    let speed = 1.0e-8;
    let keys = format!(
        "gravity: (0.0, -{g}), contact: Linear(k: {k:?}, damping: Restitution(0.3), attraction: Forbidden), \
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], step: Fixed(1.0e-4), \
         rest: (speed: {speed:?}, energy: 1.0, hold: 0.2, stop: true), until: 60.0"
    );
    let grains = (0..N).map(|i| grain(i + 1, Vector::new(0.0, radius * f64::from(2 * i + 1)), Vector::ZERO, radius, m));
    let mut simulation = simulation(&keys, grains.collect());
    assert_eq!(simulation.run(), End::AtRest);
    let heights: Vec<_> = state(&mut simulation).into_iter().map(|(x, _)| x.y).collect();
    // A grain that still moves at speed v in the column's lowest mode w1 is at most v/w1 away from its rest position.
    // The distance of two neighbours is off by at most twice that. w1 = 2 sqrt(k/m) sin(pi/(2 (2n + 1))) for a chain
    // fixed at one end.
    let n = f64::from(N);
    let w1 = 2.0 * (k / m).sqrt() * (std::f64::consts::PI / (2.0 * (2.0 * n + 1.0))).sin();
    let tolerance = 2.0 * speed * (g * radius).sqrt() / w1;
    let mut below = -radius;
    for (i, y) in heights.into_iter().enumerate() {
        let overlap = 2.0 * radius - (y - below);
        let expected = (n - i as f64) * m * g / k;
        assert!((overlap - expected).abs() < tolerance, "contact {i}: {overlap:e} m, not {expected:e} m");
        below = y;
    }
}
