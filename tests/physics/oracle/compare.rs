//! What siloflow and the naive simulator make of a scene, and how far apart they are in units of what round-off explains.

use glam::DVec3;
use siloflow::prelude::*;
use siloflow::space::Linear;

use crate::oracle::simulator::Simulator;
use crate::oracle::vector::V;

/// After how many steps the two are compared.
pub const LOOKS: [u64; 5] = [0, 1, 2, 10, 40];

/// Id, and position, velocity, spin, force and torque, of each grain.
pub type Look = Vec<(u32, [V; 5])>;

/// What round-off explains after so many steps, of each of the five.
///
/// Places of up to 1 m are rounded to eps once a step, and differences of places in space go on from there. A contact answers to a
/// difference with its spring, 2e4 N/m or with Hertz's law 5e4, and with its dashpot: while the share of a step goes from 0 to 1 over a
/// way u dt, the drag goes from 0 to c u, which is c/dt = 4e4 N/m. Together that is 1e5 N/m at most. Differences of speeds are those of
/// places times the highest frequency, sqrt(1e5 N/m over the smallest mass), and spins are speeds over radii. Condition: a run of about
/// one contact time lets no difference grow by itself. A quarter of this is the most that was found.
fn round_off(steps: u64) -> [f64; 5] {
    let (place, stiffness) = ((steps + 1) as f64 * f64::EPSILON, 1.0e5);
    // The lightest grain, kg, and the extremes of the radii, m.
    let (mass, shortest, longest): (f64, f64, f64) = (0.1, 0.036, 0.044);
    let speed = place * (stiffness / mass).sqrt();
    [place, speed, speed / shortest, place * stiffness, place * stiffness * longest]
}

/// The largest difference at each look, in units of [`round_off`]; infinite if other grains are there.
pub fn differences(simulator: &Simulator, seen: &[Look]) -> Vec<f64> {
    let mut simulator = simulator.clone();
    simulator.start();
    let mut steps = 0;
    let mut at_look = |look: u64, seen: &Look| {
        while steps < look {
            simulator.step();
            steps += 1;
        }
        largest_difference(&simulator, seen, round_off(steps))
    };
    LOOKS.into_iter().zip(seen).map(|(look, seen)| at_look(look, seen)).collect()
}

/// The largest difference now, in these units.
fn largest_difference(simulator: &Simulator, seen: &Look, units: [f64; 5]) -> f64 {
    let numbered = (1..).zip(&simulator.bodies);
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
            // Written so that a NaN differs.
            largest = if share <= largest { largest } else { share };
        }
    }
    largest
}

/// What siloflow makes of it at each look.
pub fn seen(simulation: &mut Simulation) -> Vec<Look> {
    let look = |steps| {
        if steps == 0 {
            simulation.step();
        } else {
            simulation.run_steps(steps);
        }
        match Dimension::of_world(simulation.world()) {
            Dimension::Plane => look::<Plane>(simulation.world_mut()),
            Dimension::Solid => look::<Solid>(simulation.world_mut()),
        }
    };
    LOOKS.map(look).to_vec()
}

type Row<'a, V> = (
    (&'a GrainId, &'a Position<V>, &'a Velocity<V>, &'a Force<V>),
    Option<(&'a Spin<<V as Space>::Spin>, &'a Torque<<V as Space>::Spin>)>,
);

/// All grains by id.
fn look<S: Space>(world: &mut World) -> Look {
    let mut query = world.query_filtered::<Row<S>, With<Grain>>();
    let row = |((id, x, v, force), turning): ((&GrainId, &Position<S>, &Velocity<S>, &Force<S>), Option<_>)| {
        let (spin, torque) = turning
            .map_or((DVec3::ZERO, DVec3::ZERO), |(w, t): (&Spin<S::Spin>, &Torque<S::Spin>)| {
                (w.0.spread(), t.0.spread())
            });
        (id.number(), [x.0.spread(), v.0.spread(), spin, force.0.spread(), torque].map(|v| V(v.to_array())))
    };
    let mut rows: Look = query.iter(world).map(row).collect();
    rows.sort_unstable_by_key(|row| row.0);
    rows
}
