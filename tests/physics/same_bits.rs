//! What must not change a bit: an empty third dimension, threads, neighbour searches. All with friction's memory.

use glam::DVec3;

use crate::symmetry::{HERTZ, LINEAR, R, end, throw};
use crate::{motion, simulation_on, sphere};
use siloflow::contact::history::{History, HistoryBlock};
use siloflow::divergence::where_they_part;
use siloflow::grains::file::GrainRow;
use siloflow::output::state_hash;
use siloflow::prelude::*;
use siloflow::store::ParticleStore;
use siloflow::walls::surfaces::Surfaces;

/// Grains of two sizes that fall on a floor, between walls or in a periodic box: `side` a row.
fn fall(solid: bool, side: u32, layers: u32) -> Vec<GrainRow> {
    let place = |i: u32| {
        let (along, up) = (i % side, i / side);
        let [x, y, z] = if solid { [along, up % side, up / side] } else { [along, up, 0] };
        0.085 * (DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5)
    };
    let grain = |i: u32| {
        let jitter = throw("fall", i);
        let radius = if i.is_multiple_of(3) { 0.03 } else { R };
        let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
        let velocity = flat * throw("fall.velocity", i);
        let mut grain =
            sphere(i + 1, place(i) * flat + 0.002 * flat * jitter, velocity, radius, 100.0 * radius * radius);
        grain.spin = 10.0 * if solid { throw("fall.spin", i) } else { DVec3::Z * jitter.z };
        grain
    };
    (0..layers * if solid { side * side } else { side }).map(grain).collect()
}

/// The box around [`fall`], with a floor across the axis `up` and sides across the axes before it: walls or periodic.
fn walled(solid: bool, up: usize, periodic: bool, width: f64) -> String {
    let vector = |axis: usize, length: f64| {
        let mut v = [0.0; 3];
        v[axis] = length;
        if solid { format!("({:?}, {:?}, {:?})", v[0], v[1], v[2]) } else { format!("({:?}, {:?})", v[0], v[1]) }
    };
    let plane = |axis: usize, at: f64, normal: f64| {
        format!("HalfPlane(point: {}, normal: {})", vector(axis, at), vector(axis, normal))
    };
    let (mut walls, mut sides) = (vec![plane(up, 0.0, 1.0)], Vec::new());
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
fn a_solid_run_in_a_plane_is_the_plane_s_run_to_the_last_bit() {
    for (contact, periodic) in [(LINEAR, false), (HERTZ, false), (LINEAR, true), (HERTZ, true)] {
        let rest = format!(
            "contact: {contact}, materials: [(young: 1.0e6, poisson: 0.3)], inertia: Disc, step: Fixed(2.0e-4), until: 9.0"
        );
        let grains = fall(false, 6, 4);
        let [flat, deep] =
            [false, true].map(|solid| end(&format!("{}, {rest}", walled(solid, 1, periodic, 0.51)), &grains));
        for (i, (a, b)) in flat.iter().zip(&deep).enumerate() {
            // Equal as numbers: only zeros may differ in sign.
            assert_eq!((a.position, a.velocity, a.spin), (b.position, b.velocity, b.spin), "{contact}, grain {i}");
        }
        assert!(flat.iter().all(|now| now.position.y < 0.3), "nothing has fallen");
    }
}

/// Hashes on the way, and the last state.
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
fn threads_and_searches_change_no_bit_of_a_frictional_plane() {
    assert_same(false, &fall(false, 8, 5), 0.68);
}

#[test]
fn threads_and_searches_change_no_bit_of_frictional_spheres() {
    assert_same(true, &fall(true, 5, 2), 0.425);
}

/// What can be seen of many spheres between walls on so many threads, whose contacts forget all after 150 steps, and after 200 if
/// `twice`: hashes of the state, and what they do to the walls.
fn forgetful(threads: usize, twice: bool) -> Vec<(u64, Vec<DVec3>)> {
    let keys = format!(
        "{}, contact: {LINEAR}, neighbours: VerletList(skin: 0.01), step: Fixed(2.0e-4), until: 9.0",
        walled(true, 2, false, 12.0 * 0.085)
    );
    let mut simulation = simulation_on(threads, &keys, fall(true, 12, 23));
    let mut seen = Vec::new();
    for (steps, forgets) in [(150, true), (200, twice), (250, false)] {
        simulation.run_steps(steps);
        let on_walls = simulation.world().resource::<Surfaces<Solid>>().0.iter().map(|wall| wall.load.force).collect();
        seen.push((state_hash::of_world(simulation.world_mut()), on_walls));
        simulation.world_mut().resource_scope(|world, mut history: Mut<History<Solid>>| {
            if forgets {
                history.pages(world.resource::<ParticleStore<Solid>>()).0.iter_mut().for_each(HistoryBlock::clear);
            }
        });
    }
    seen
}

#[test]
fn borders_between_threads_leave_no_trace_even_if_memories_are_changed() {
    // Four blocks of rows, and 1200 places near a wall, so that there are borders of shares.
    let reference = forgetful(1, true);
    let other = forgetful(1, false);
    assert!(reference[1] == other[1] && reference[2].0 != other[2].0, "nothing hangs on memories");
    assert!(reference[2].1.iter().all(|force| *force != DVec3::ZERO), "a wall is not touched");
    for threads in [2, 3, 4] {
        assert_eq!(forgetful(threads, true), reference, "{threads} threads");
    }
}
