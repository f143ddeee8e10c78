//! Compares siloflow with the naive simulator, in units of the difference that round-off explains.

use glam::DVec3;
use siloflow::dem::space::Linear;
use siloflow::prelude::*;
use siloflow_oracle::simulator::Simulator;
use siloflow_oracle::vector::V;

/// Numbers of steps after which the two are compared.
pub const SAMPLE_STEPS: [u64; 5] = [0, 1, 2, 10, 40];

/// One sample: id, then position, velocity, spin, force and torque, for each grain.
pub type Sample = Vec<(u32, [V; 5])>;

/// Returns the difference that round-off explains after `steps` steps, for each of the five vectors.
///
/// Positions of up to 1 m are rounded to eps once per step, and differences of position persist. A contact reacts to a
/// difference with its spring, 2e4 N/m, or 5e4 N/m for Hertz's law, and with its dashpot. The damping rises from 0 to c
/// u while the overlap changes by u dt, which acts like a stiffness c/dt = 4e4 N/m. The sum is at most 1e5 N/m.
///
/// Differences of speed are differences of position times the highest frequency, sqrt(1e5 N/m over the smallest mass).
/// Spins are speeds over radii. The estimate holds because a run of about one contact duration does not amplify
/// differences. The largest difference found is a quarter of this bound.
fn round_off_bound(steps: u64) -> [f64; 5] {
    let place = (steps + 1) as f64 * f64::EPSILON;
    let stiffness = 1.0e5;
    // Mass of the lightest grain, kg, and the extremes of the radii, m.
    let (mass, shortest, longest): (f64, f64, f64) = (0.1, 0.036, 0.044);
    let speed = place * (stiffness / mass).sqrt();
    [place, speed, speed / shortest, place * stiffness, place * stiffness * longest]
}

/// Returns the largest difference at each sample, in units of [`round_off_bound`]; infinite if the sets of grains differ.
pub fn differences(simulator: &Simulator, seen: &[Sample]) -> Vec<f64> {
    let mut simulator = simulator.clone();
    simulator.start();
    let mut steps = 0;
    let mut at_sample = |sample: u64, seen: &Sample| {
        while steps < sample {
            simulator.step();
            steps += 1;
        }
        largest_difference(&simulator, seen, round_off_bound(steps))
    };
    SAMPLE_STEPS.into_iter().zip(seen).map(|(sample, seen)| at_sample(sample, seen)).collect()
}

/// Returns the largest current difference in the given units; infinite if the sets of grains differ.
fn largest_difference(simulator: &Simulator, seen: &Sample, units: [f64; 5]) -> f64 {
    let numbered = (1..).zip(simulator.bodies.iter().filter(|body| !body.is_sphere_of_clump()));
    let own: Vec<_> = numbered.filter(|(_, body)| !body.is_fixed && !body.is_gone).collect();
    if !own.iter().map(|(id, _)| *id).eq(seen.iter().map(|(id, _)| *id)) {
        return f64::INFINITY;
    }
    let mut largest = 0.0;
    for ((_, body), (_, seen)) in own.into_iter().zip(seen) {
        let place = simulator.shortest(body.position - seen[0]);
        let others = [body.velocity - seen[1], body.spin - seen[2], body.force - seen[3], body.torque - seen[4]];
        for (difference, unit) in [place].into_iter().chain(others).zip(units) {
            let share = difference.length() / unit;
            // A NaN compares as larger.
            largest = if share <= largest { largest } else { share };
        }
    }
    largest
}

/// Runs siloflow and returns all samples.
pub fn seen(simulation: &mut Simulation) -> Vec<Sample> {
    let sample = |steps| {
        if steps == 0 {
            simulation.step();
        } else {
            simulation.run_steps(steps);
        }
        match Dimension::of_world(simulation.world()) {
            Dimension::Plane => sample::<Plane>(simulation.world_mut()),
            Dimension::Solid => sample::<Solid>(simulation.world_mut()),
        }
    };
    SAMPLE_STEPS.map(sample).to_vec()
}

type Row<'a, V> = (
    (&'a GrainId, &'a Position<V>, &'a Velocity<V>, &'a Force<V>),
    Option<(&'a Spin<<V as Space>::Spin>, &'a Torque<<V as Space>::Spin>)>,
);

/// Returns the sample of all grains, sorted by id.
fn sample<S: Space>(world: &mut World) -> Sample {
    let mut query = world.query_filtered::<Row<S>, With<Grain>>();
    let row = |((id, x, v, force), turning): ((&GrainId, &Position<S>, &Velocity<S>, &Force<S>), Option<_>)| {
        let (spin, torque) = turning
            .map_or((DVec3::ZERO, DVec3::ZERO), |(w, t): (&Spin<S::Spin>, &Torque<S::Spin>)| {
                (w.0.spread(), t.0.spread())
            });
        (id.number(), [x.0.spread(), v.0.spread(), spin, force.0.spread(), torque].map(|v| V(v.to_array())))
    };
    let mut rows: Sample = query.iter(world).map(row).collect();
    rows.sort_unstable_by_key(|row| row.0);
    rows
}
