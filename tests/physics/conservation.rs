//! Conserved quantities of closed systems.

use std::f64::consts::PI;

use crate::{grain, simulation, state};
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::random::Stream;

/// Returns `side` x `side` discs of two sizes on a lattice of spacing `spacing`, with random velocities of mean zero.
fn cloud(side: u32, spacing: f64, speed: f64) -> Vec<GrainRow> {
    let random = Stream::new(5, "cloud");
    (0..side * side)
        .map(|i| {
            let [u, w, size] = random.uniform(u64::from(i));
            let radius = if size < 0.5 { 0.03 } else { 0.04 };
            let place = Vector::new(f64::from(i % side) + 0.5, f64::from(i / side) + 0.5) * spacing;
            let velocity = Vector::new(2.0 * u - 1.0, 2.0 * w - 1.0) * speed;
            grain(i + 1, place, velocity, radius, 100.0 * radius * radius)
        })
        .collect()
}

#[test]
fn momentum_of_an_isolated_cloud_is_conserved_to_round_off() {
    // An implosion: all grains fly to the middle, collide, and fly apart. One law allows attraction, the other does
    // not.
    for law in ["Assignment(k: 1.0e4, b: 5.0)", "Linear(k: 1.0e4, damping: Restitution(0.5))"] {
        let mut grains = cloud(10, 0.085, 0.5);
        let middle = Vector::splat(0.425);
        for grain in &mut grains {
            grain.velocity += 3.0 * (middle.extend(0.0) - grain.position);
        }
        let masses: Vec<_> = grains.iter().map(|grain| grain.mass).collect();
        let momentum =
            |rows: &[(Vector, Vector)]| -> Vector { rows.iter().zip(&masses).map(|((_, v), m)| *m * *v).sum() };
        let keys = format!("gravity: (0.0, 0.0), contact: {law}, step: Fixed(2.0e-4), until: 1.0");
        let mut simulation = simulation(&keys, grains);
        simulation.run_steps(0);
        let before = momentum(&state(&mut simulation));
        simulation.run();
        let change = (momentum(&state(&mut simulation)) - before).length();
        // Pair forces cancel exactly. Each half-kick of each grain rounds m v and the sum of its forces by half an ulp,
        // with random sign. There are 5000 steps of two kicks for 100 grains, each with m v below 0.16 kg x 3 m/s. The
        // errors add up as the square root of their number.
        let bound = (5000.0 * 2.0 * 100.0f64).sqrt() * 0.16 * 3.0 * f64::EPSILON;
        assert!(change < bound, "{law}: {change:e} kg m/s, bound {bound:e}");
        assert!(simulation.world().resource::<EnergyFlows>().dissipated > 0.1, "nothing collided");
    }
}

#[test]
fn energy_of_an_undamped_gas_is_conserved() {
    // 100 discs at a packing fraction of 0.6 between four walls, 1e5 steps at t_c/50.
    let (k, m): (f64, f64) = (1.0e5, 0.09);
    let dt = PI * (0.5 * m / k).sqrt() / (50.0 + PI / 100.0);
    let grains = cloud(10, 0.0809, 1.0);
    let area: f64 = grains.iter().map(|grain| PI * grain.radius.powi(2)).sum();
    let side = 0.809;
    assert!((area / (side * side) - 0.6).abs() < 0.03, "packing fraction {}", area / (side * side));
    let wall = |x: f64, y: f64, nx: f64, ny: f64| format!("HalfPlane(point: ({x:?}, {y:?}), normal: ({nx:?}, {ny:?}))");
    let walls =
        [wall(0.0, 0.0, 1.0, 0.0), wall(0.0, 0.0, 0.0, 1.0), wall(side, side, -1.0, 0.0), wall(side, side, 0.0, -1.0)];
    let keys = format!(
        "gravity: (0.0, 0.0), contact: Linear(k: {k:?}, damping: B(0.0), attraction: Allowed), walls: [{}], \
         step: Fixed({dt:?}), until: 1.0e6, series: (interval: 1.0e6)",
        walls.join(", ")
    );
    let mut simulation = simulation(&keys, grains);
    simulation.run_steps(0);
    let before = totals::of_world(simulation.world_mut()).energy();
    simulation.run_steps(100_000);
    let drift = totals::of_world(simulation.world_mut()).energy() / before - 1.0;
    // Verlet conserves a modified energy while a contact lasts. Each opening or closing of a contact changes the energy
    // by about k (v dt)^2/12, with random sign: (w0 dt)^2/6 = (pi/50)^2/6 = 6.6e-4 of the energy of that pair. 2000 t_c
    // at this density are about 1e3 collisions per grain, so about 1e5 such changes in total. On the energy of 100
    // grains that is 6.6e-4 sqrt(1e5)/100 = 2e-3.
    assert!(drift.abs() < 2e-3, "{drift:e}");
}
