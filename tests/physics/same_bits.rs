//! Changes that must leave every bit of a result alone: an empty third dimension, threads, neighbour searches, the
//! filter of gaps. All runs have contact history of friction.

use glam::DVec3;

use crate::symmetry::{ADHESIVE, HERTZ, JKR, LINEAR, R, end, random_vector};
use crate::{motion, simulation_on, simulation_with, sphere};
use siloflow::dem::contact::history::{History, HistoryBlock};
use siloflow::dem::space::Space;
use siloflow::dem::store::ParticleStore;
use siloflow::dem::survey::Survey;
use siloflow::dem::threads::Threads;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::grains::file::GrainRow;
use siloflow::output::state_hash;
use siloflow::prelude::*;
use siloflow::studies::diff::where_they_part;

/// Returns grains of two sizes that fall on a floor, between walls or in a periodic box, `side` per row.
fn fall(solid: bool, side: u32, layers: u32) -> Vec<GrainRow> {
    let place = |i: u32| {
        let along = i % side;
        let up = i / side;
        let [x, y, z] = if solid { [along, up % side, up / side] } else { [along, up, 0] };
        0.085 * (DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5)
    };
    let grain = |i: u32| {
        let jitter = random_vector("fall", i);
        let radius = if i.is_multiple_of(3) { 0.03 } else { R };
        let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
        let velocity = flat * random_vector("fall.velocity", i);
        let mut grain =
            sphere(i + 1, place(i) * flat + 0.002 * flat * jitter, velocity, radius, 100.0 * radius * radius);
        grain.spin = 10.0 * if solid { random_vector("fall.spin", i) } else { DVec3::Z * jitter.z };
        grain
    };
    (0..layers * if solid { side * side } else { side }).map(grain).collect()
}

/// Returns the box around [`fall`]: a floor across the axis `up`, and walls or periodic sides across the axes before
/// it.
fn walled(solid: bool, up: usize, periodic: bool, width: f64) -> String {
    let vector = |axis: usize, length: f64| {
        let mut v = [0.0; 3];
        v[axis] = length;
        if solid { format!("({:?}, {:?}, {:?})", v[0], v[1], v[2]) } else { format!("({:?}, {:?})", v[0], v[1]) }
    };
    let plane = |axis: usize, at: f64, normal: f64| {
        format!("HalfPlane(point: {}, normal: {})", vector(axis, at), vector(axis, normal))
    };
    let mut walls = vec![plane(up, 0.0, 1.0)];
    let mut sides = Vec::new();
    for (axis, name) in ["x", "y"].iter().enumerate().take(up) {
        if periodic {
            sides.push(format!("{name}: (0.0, {width:?})"));
        } else {
            walls.extend([plane(axis, 0.0, 1.0), plane(axis, width, -1.0)]);
        }
    }
    let sides = if periodic { format!("periodic: ({}), ", sides.join(", ")) } else { String::new() };
    let space = if solid { "Solid" } else { "Plane" };
    let gravity = vector(up, -9.81);
    format!("space: {space}, gravity: {gravity}, {sides}walls: [{}]", walls.join(", "))
}

#[test]
fn solid_run_of_coplanar_grains_equals_the_planar_run_to_the_last_bit() {
    for (contact, periodic) in [(LINEAR, false), (HERTZ, false), (LINEAR, true), (HERTZ, true)] {
        let rest = format!(
            "contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], inertia: Disc, step: Fixed(2.0e-4), until: 9.0"
        );
        let grains = fall(false, 6, 4);
        let [flat, deep] =
            [false, true].map(|solid| end(&format!("{}, {rest}", walled(solid, 1, periodic, 0.51)), &grains));
        for (i, (a, b)) in flat.iter().zip(&deep).enumerate() {
            // Equal as numbers: only the sign of zeros may differ.
            assert_eq!((a.position, a.velocity, a.spin), (b.position, b.velocity, b.spin), "{contact}, grain {i}");
        }
        assert!(flat.iter().all(|now| now.position.y < 0.3), "grains have not fallen");
    }
}

/// Returns hashes at three times, and the last state.
fn course(threads: usize, keys: &str, grains: &[GrainRow]) -> (Vec<u64>, Vec<DVec3>) {
    let mut simulation = simulation_on(threads, keys, grains.to_vec());
    let hashes = [500, 1000, 2000].map(|steps| {
        simulation.run_steps(steps);
        state_hash::of_world(simulation.world_mut())
    });
    let state = motion(&mut simulation);
    (hashes.to_vec(), state.iter().flat_map(|now| [now.position, now.velocity, now.spin]).collect())
}

fn assert_same(solid: bool, grains: &[GrainRow], width: f64) {
    for (periodic, contact) in [(false, LINEAR), (true, LINEAR), (true, HERTZ)] {
        let keys = format!(
            "{}, contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], step: Fixed(2.0e-4), until: 9.0",
            walled(solid, if solid { 2 } else { 1 }, periodic, width)
        );
        let reference = course(1, &format!("{keys}, neighbours: AllPairs"), grains);
        assert!(reference.0[0] != reference.0[1] && reference.0[1] != reference.0[2]);
        for (threads, neighbours) in [
            (2, "AllPairs"),
            (1, "Cells(size: 0.1)"),
            (2, "Cells(size: 0.14)"),
            (1, "VerletList(skin: 0.001)"),
            (1, "VerletList(skin: 0.04)"),
            (2, "VerletList(skin: 0.01)"),
        ] {
            let found = course(threads, &format!("{keys}, neighbours: {neighbours}"), grains);
            let part = || {
                let start = |threads: usize, neighbours: &str| {
                    simulation_on(threads, &format!("{keys}, neighbours: {neighbours}"), grains.to_vec())
                };
                where_they_part(start(threads, neighbours), start(1, "AllPairs"), 2000)
            };
            let place = format!("{contact}, {neighbours} on {threads} threads, periodic {periodic}");
            assert!(found == reference, "{place}: {}", part());
        }
    }
}

#[test]
fn threads_and_searches_change_no_bit_of_frictional_discs() {
    assert_same(false, &fall(false, 8, 5), 0.68);
}

#[test]
fn threads_and_searches_change_no_bit_of_frictional_spheres() {
    assert_same(true, &fall(true, 5, 2), 0.425);
}

/// Which gaps the contact pass takes for pairs that may touch in half a step.
#[derive(Clone, Copy, PartialEq)]
enum Gaps {
    /// Those that the pair itself can close.
    OfThePair,
    /// All that the fastest pair can close.
    OfAnyPair,
    /// None.
    None,
}

/// Returns the motion of `grains` after 1500 steps.
fn with_gaps<V: Space>(keys: &str, grains: &[GrainRow], gaps: Gaps) -> Vec<[DVec3; 3]> {
    let choose = move |mut store: ResMut<ParticleStore<V>>| {
        let ParticleStore { body, prediction, .. } = &mut *store;
        let beyond = 0.5 * (prediction.margin + prediction.range);
        for (swept, body) in prediction.swept.iter_mut().zip(body) {
            // Two roundings.
            assert!(*swept <= (body.radius + beyond) * (1.0 + 2.0 * f64::EPSILON));
            match gaps {
                Gaps::OfThePair => {}
                Gaps::OfAnyPair => *swept = body.radius + beyond,
                Gaps::None => *swept = body.radius,
            }
        }
    };
    let more = |app: &mut App| {
        app.add_systems(Step, choose.in_set(Phase::Neighbours));
    };
    let mut simulation = simulation_with(1, keys, grains.to_vec(), more);
    simulation.run_steps(1500);
    motion(&mut simulation).iter().map(|now| [now.position, now.velocity, now.spin]).collect()
}

#[test]
fn gaps_that_a_pair_cannot_close_change_no_bit() {
    for solid in [false, true] {
        for contact in [LINEAR, HERTZ, ADHESIVE, JKR] {
            let (side, layers, width) = if solid { (4, 3, 0.34) } else { (8, 6, 0.68) };
            let keys = format!(
                "{}, contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], step: Fixed(2.0e-4), integrator: Centred, until: 9.0",
                walled(solid, if solid { 2 } else { 1 }, false, width)
            );
            let grains = fall(solid, side, layers);
            let run = |gaps| {
                if solid { with_gaps::<Solid>(&keys, &grains, gaps) } else { with_gaps::<Plane>(&keys, &grains, gaps) }
            };
            let own = run(Gaps::OfThePair);
            assert!(own == run(Gaps::OfAnyPair), "solid: {solid}, {contact}");
            assert!(own != run(Gaps::None), "solid: {solid}, {contact}: gaps have no effect");
        }
    }
}

/// More contacts than [`run_with_cleared_history`] has: the largest relative round-off of a sum of so many positive numbers, in units of epsilon.
const CONTACTS: f64 = 2e4;

/// Simulates many spheres between walls. Contact history is cleared after 150 steps, and again after 200 if `twice`.
/// Returns state hashes, the forces on the walls and the elastic energy of all contacts.
fn run_with_cleared_history(threads: usize, twice: bool) -> Vec<(u64, Vec<DVec3>, f64)> {
    let keys = format!(
        "{}, contact: {LINEAR}, neighbours: VerletList(skin: 0.01), step: Fixed(2.0e-4), until: 9.0",
        walled(true, 2, false, 12.0 * 0.085)
    );
    let mut simulation = simulation_on(threads, &keys, fall(true, 12, 23));
    let mut seen = Vec::new();
    for (steps, clears) in [(150, true), (200, twice), (250, false)] {
        simulation.run_steps(steps);
        let on_walls = simulation.world().resource::<Surfaces<Solid>>().loads.iter().map(|load| load.force).collect();
        let survey = Survey::<Solid>::of_world(simulation.world());
        let elastic = survey.whole_elastic_energy(simulation.world().resource::<Threads>());
        let in_one_sum = survey.elastic_energy(|_, _| true);
        // Terms are positive, and both sums have the same but for the order: four blocks and the walls.
        assert!(
            (elastic - in_one_sum).abs() <= CONTACTS * f64::EPSILON * elastic && elastic > 0.0,
            "{elastic} {in_one_sum}"
        );
        seen.push((state_hash::of_world(simulation.world_mut()), on_walls, elastic));
        simulation.world_mut().resource_scope(|world, mut history: Mut<History>| {
            if clears {
                history.blocks_mut(world.resource::<ParticleStore<Solid>>()).0.iter_mut().for_each(HistoryBlock::clear);
            }
        });
    }
    seen
}

#[test]
fn thread_count_changes_no_bit_after_contact_history_is_cleared() {
    // Four history blocks and 1200 grains near a wall, so that thread chunks have borders.
    let reference = run_with_cleared_history(1, true);
    let other = run_with_cleared_history(1, false);
    assert!(reference[1] == other[1] && reference[2].0 != other[2].0, "contact history has no effect");
    assert!(reference[2].1.iter().all(|force| *force != DVec3::ZERO), "a wall is not touched");
    for threads in [2, 3, 4] {
        assert_eq!(run_with_cleared_history(threads, true), reference, "{threads} threads");
    }
}
