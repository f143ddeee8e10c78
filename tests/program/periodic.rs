//! Periodic scenes, species pairs and doors of panels: cases that are easy to get wrong.

use std::ops::Add;
use std::path::Path;

use siloflow::dem::store::ParticleStore;
use siloflow::energy::EnergyFlows;
use siloflow::grains::file::GrainRow;
use siloflow::measure::totals;
use siloflow::prelude::*;

use crate::{hash, simulation};

/// Runs a scene to its end with the given grains (position, velocity, species) of 4 cm and 0.16 kg.
fn run(keys: &str, grains: &[(Solid, Solid, u8)], threads: usize) -> Simulation {
    let text = format!("({keys}, pictures: None)");
    let mut loaded = load::from_text("p.ron", "p", Path::new(""), text, &[]).unwrap_or_else(|fault| panic!("{fault}"));
    for (number, &(position, velocity, species)) in (1..).zip(grains) {
        let id = GrainId::grain(number).unwrap();
        let species = Species(species);
        loaded.grains.push(GrainRow {
            id,
            radius: 0.04,
            mass: 0.16,
            position,
            velocity,
            spin: Solid::ZERO,
            posture: None,
            species,
        });
    }
    let mut run = simulation(&loaded, threads);
    run.run();
    run
}

const LAW: &str = "contact: Linear(k: 1.0e5, damping: Restitution(0.5)), step: Fixed(1.0e-4)";

#[test]
fn grain_outside_the_box_is_replaced_by_its_image_inside() {
    let start = |x: f64| {
        let right = Solid::new(1.0, 0.0, 0.0);
        [
            (Solid::new(x, 0.5, 0.0), -right, 0),
            (Solid::new(0.14, 0.51, 0.0), right, 0),
            (Solid::new(0.9, 0.5, 0.0), right, 0),
        ]
    };
    let hashed = |x: f64, neighbours: &str| {
        let keys =
            format!("gravity: (0.0, 0.0), periodic: (x: (0.0, 1.0)), {LAW}, until: 0.5, neighbours: {neighbours}");
        hash(&mut run(&keys, &start(x), 1))
    };
    let reference = hashed(0.25, "AllPairs");
    for x in [1.25, -2.75] {
        for neighbours in ["AllPairs", "Cells(size: 0.1)", "VerletList(skin: 0.04)", "VerletList(skin: 0.01)"] {
            assert_eq!(hashed(x, neighbours), reference, "{neighbours} from {x} m");
        }
    }
}

#[test]
fn grain_that_wraps_around_past_an_obstacle_is_not_lost() {
    let keys = format!(
        "gravity: (0.0, 0.0), periodic: (x: (0.0, 1.0), y: (0.0, 1.0)), {LAW}, until: 3.0, \
         walls: [Segment(from: (0.3, 0.5), to: (0.7, 0.5))]"
    );
    let run = run(&keys, &[(Solid::new(0.5, 0.8, 0.0), Solid::new(0.9, 0.01, 0.0), 0)], 1);
    assert_eq!(run.world().resource::<Ledger>().inside(), 1);
}

/// A slab, periodic along x and y, with a floor with a slot on both sides of the periodic side along x. Grains fall obliquely through
/// the slot while they cross one periodic side, both sides at once, or the other one.
#[test]
fn grain_that_wraps_around_inside_a_door_panel_counts_as_out() {
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), periodic: (x: (0.0, 1.0), y: (0.0, 1.0)), {LAW}, until: 0.5, \
         walls: [Panel(corner: (0.2, 0.0, 0.0), along: (0.4, 0.0, 0.0), across: (0.0, 1.0, 0.0)), \
         Panel(corner: (0.6, 0.0, 0.0), along: (0.4, 0.0, 0.0), across: (0.0, 1.0, 0.0), door: true), \
         Panel(corner: (0.0, 0.0, 0.0), along: (0.2, 0.0, 0.0), across: (0.0, 1.0, 0.0), door: true)], \
         door: (opens: At(0.0)), cull: (below: -0.3)"
    );
    // At z = 0 each grain is at most 0.02 m before the side that it crosses, within the quarter of a radius between two
    // checks of paths.
    let falls = |x: f64, y: f64, vx: f64, vy: f64| {
        (Solid::new(x - 0.06 * vx, y - 0.06 * vy, 0.06), Solid::new(5.0 * vx, 5.0 * vy, -5.0), 0)
    };
    let grains: Vec<_> = (1..60)
        .flat_map(|n| {
            let off = 2e-4 * f64::from(n);
            [falls(1.0 - off, 0.5, 1.0, 0.0), falls(0.8, 1.0 - off, 0.0, 1.0), falls(1.0 - off, 1.0 - off, 1.0, 1.0)]
        })
        .collect();
    for grain in grains {
        let run = run(&keys, &[grain], 1);
        let ledger = run.world().resource::<Ledger>();
        assert_eq!((ledger.out(), ledger.lost()), (1, 0), "{grain:?}: {:?}", ledger.lost);
    }
}

#[test]
fn species_pairs_have_their_own_law_with_the_assignments_law_too() {
    let dissipated = |pairs: &str| {
        let keys = format!(
            "gravity: (0.0, 0.0), contact: Assignment(k: 1.0e4, b: 0.0), pairs: [{pairs}], step: Fixed(1.0e-4), until: 0.1"
        );
        let ahead = Solid::new(1.0, 0.0, 0.0);
        let run = run(&keys, &[(Solid::ZERO, ahead, 0), (Solid::new(0.1, 0.0, 0.0), -ahead, 1)], 1);
        run.world().resource::<EnergyFlows>().dissipated
    };
    assert_eq!(dissipated(""), 0.0);
    assert!(dissipated("(species: (0, 1), contact: Assignment(k: 1.0e4, b: 5.0))") > 0.01);
}

#[test]
fn removed_panel_takes_the_energy_of_its_contacts_once() {
    // A ball is pressed into the door and moved along it. The door is removed while both springs are loaded.
    let keys = "space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e3, damping: B(0.0), tangential: \
                Spring(k: 200.0, damping: B(0.0), friction: 10.0)), step: Fixed(1.0e-4), until: 0.05, \
                walls: [Panel(corner: (-1.0, -1.0, 0.0), along: (2.0, 0.0, 0.0), across: (0.0, 2.0, 0.0), door: true)], \
                door: (opens: At(0.02))";
    let mut run = run(keys, &[(Solid::new(0.0, 0.0, 0.039), Solid::new(0.1, 0.0, 0.0), 0)], 1);
    let flows = *run.world().resource::<EnergyFlows>();
    let error = totals::of_world(run.world_mut()).energy() - flows.expected();
    // In one half-step the door's force still acts after it was counted: F v dt/2 with F below 10 N and v below 0.3
    // m/s. Springs counted twice would be 4e-4 J off.
    assert!(flows.removed > 1e-3 && error.abs() < 10.0 * 0.3 * 0.5e-4, "{error:e} J of {} J", flows.removed);
}

#[test]
fn open_door_panel_does_not_block_a_release() {
    let keys = "space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), \
                mass: Sphere(2500.0), step: Fixed(1.0e-4), until: 0.3, on_loss: Continue, \
                walls: [Panel(corner: (-1.0, -1.0, 0.0), along: (2.0, 0.0, 0.0), across: (0.0, 2.0, 0.0), door: true)], \
                door: (opens: At(0.0)), spawner: (point: (0.0, 0.0, 0.01), velocity: (0.0, 0.0, -1.0), interval: 0.1, \
                count: 2, radius: Fixed(0.04), release_timeout: 0.0)";
    let mut run = run(keys, &[], 1);
    assert_eq!(run.world_mut().resource::<Ledger>().released, 2);
    assert_eq!(run.run(), End::Empty, "a grain did not fall through the open door");
}

/// A crystal with slices so large that slots are assigned beam by beam. Spheres touch and slide across the sides of the
/// beams and of the box.
#[test]
fn assigning_slots_by_beams_changes_no_bit() {
    const SIDE: u32 = 30;
    let spacing = 0.0795;
    let place = |number: u32| spacing * (0.5 + f64::from(number));
    let grains: Vec<_> = (0..SIDE.pow(3))
        .map(|number| {
            let [x, y, z] = [number % SIDE, number / SIDE % SIDE, number / SIDE.pow(2)];
            // All velocities differ in direction.
            let way = f64::from(number) * 2.4;
            let velocity = Solid::new(way.sin(), (1.7 * way).sin(), (2.3 * way).cos());
            (Solid::new(place(x), place(y), place(z)), velocity, 0)
        })
        .collect();
    let box_side = place(SIDE) - place(0);
    let results = |neighbours: &str, threads: usize| {
        let keys = format!(
            "space: Solid, gravity: (0.0, 0.0, 0.0), periodic: (x: (0.0, {box_side}), y: (0.0, {box_side})), \
             contact: Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 2.0e4, damping: B(1.0), friction: 0.5)), \
             step: Fixed(1.0e-4), until: 0.002, integrator: Verlet, neighbours: {neighbours}"
        );
        let mut run = run(&keys, &grains, threads);
        let store = run.world().resource::<ParticleStore<Solid>>();
        // Within a beam slots are ordered along x; the next beam starts again at the low end.
        let back = store.body.windows(2).filter(|two| two[1].position.x < two[0].position.x - 0.9 * box_side);
        assert_eq!(back.count(), 2, "slots are not in three beams");
        let momentum = store.body.iter().map(|body| body.velocity / body.inverse_mass).fold(Solid::ZERO, Add::add);
        let dissipated = run.world().resource::<EnergyFlows>().dissipated;
        (hash(&mut run), dissipated.to_bits(), momentum)
    };
    let reference = results("VerletList(skin: 0.004)", 1);
    let before = grains.iter().map(|&(_, velocity, _)| velocity * 0.16).fold(Solid::ZERO, Add::add);
    // Forces cancel up to rounding: each of 40 half-kicks rounds a momentum of about 0.16 kg m/s.
    let rounding = f64::from(SIDE.pow(3)) * 40.0 * 0.16 * f64::EPSILON;
    assert!(reference.2.distance(before) < rounding, "{} {before}", reference.2);
    assert!(f64::from_bits(reference.1) > 0.0);
    for (neighbours, threads) in
        [("VerletList(skin: 0.004)", 2), ("VerletList(skin: 0.004)", 3), ("Cells(size: 0.09)", 2)]
    {
        assert_eq!(results(neighbours, threads), reference, "{neighbours} on {threads} threads");
    }
}
