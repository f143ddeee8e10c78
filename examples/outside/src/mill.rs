//! Tests of behaviours that make and unmake grains, in a scene with four behaviours.

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::energy::EnergyFlows;
use siloflow::grain_requests;
use siloflow::measure::totals;
use siloflow::output::state_hash;
use siloflow::prelude::*;

use crate::registry;
use crate::tests::simulation;

const MILL: &str = include_str!("../scenes/mill.ron");

fn loaded() -> Loaded {
    load::from_text("mill.ron", "mill", Path::new(""), MILL.to_owned(), &[]).expect("the scene is right")
}

#[test]
fn every_grain_and_its_energy_are_accounted_for() {
    let mut run = simulation("mill", MILL.to_owned());
    assert_eq!(run.run(), End::TimeReached);
    let world = run.world_mut();
    let figures = grain_requests::figures(world);
    let [broken, fed] = ["breakage", "level_feeder"].map(|reason| &figures[reason]);
    assert!(broken.removed > 3 && broken.made == 3 * broken.removed, "{broken:?}");
    // Mass and momentum are kept up to round-off of each piece.
    assert!(broken.mass_kg.abs() < 1e-12, "{broken:?}");
    assert!(broken.momentum_kg_m_per_s.iter().all(|component| component.abs() < 1e-11), "{broken:?}");
    assert!(fed.made > 3 && fed.removed == 0, "{fed:?}");
    assert!((fed.mass_kg / (f64::from(fed.made) * 100.0 * std::f64::consts::PI * 0.0016) - 1.0).abs() < 1e-12);
    let ledger = world.resource::<Ledger>();
    assert_eq!((ledger.lost(), ledger.removed), (0, broken.removed));
    let [inside, released] = [ledger.inside(), ledger.released];
    let masses: Vec<f64> = world.query_filtered::<&Mass, With<Grain>>().iter(world).map(|mass| mass.0).collect();
    assert_eq!(u32::try_from(masses.len()), Ok(inside));
    let whole = released - broken.made;
    let expected = f64::from(whole) * 100.0 * std::f64::consts::PI * 0.0016;
    assert!((masses.iter().sum::<f64>() / expected - 1.0).abs() < 1e-12);
    let flows = world.resource::<EnergyFlows>();
    let error = totals::of_world(world).energy() - flows.expected();
    assert!(error.abs() < 0.01 * flows.dissipated, "{error} J of {} J", flows.dissipated);
}

#[test]
fn a_saved_state_and_any_number_of_threads_lead_to_the_same_bits() {
    let loaded = loaded();
    let with = |threads: usize| {
        let threads = NonZeroUsize::new(threads).expect("at least one");
        Simulation::new(&loaded, &registry(), threads).expect("the behaviours fit")
    };
    let mut whole = with(1);
    whole.run();
    let expected = state_hash::of_world(whole.world_mut());
    let mut threaded = with(2);
    threaded.run();
    assert_eq!(state_hash::of_world(threaded.world_mut()), expected);
    // Saved in steps after which requests wait, and in others.
    let mut first = with(1);
    for step in [500, 1777, 2300, 2301, 2302, 20_000] {
        first.run_steps(step);
        let saved = first.save().expect("all state can be saved");
        first = Simulation::restored(&loaded, &registry(), NonZeroUsize::MIN, &saved).expect("the state fits");
    }
    first.run();
    assert_eq!(state_hash::of_world(first.world_mut()), expected);
}
