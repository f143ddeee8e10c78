//! Scenes with friction, in the plane and in solid space: their components and their behaviour.

use siloflow::dem::contact::history::History;
use siloflow::dem::store::ParticleStore;
use siloflow::dem::survey::Survey;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::energy::{Channels, EnergyFlows};
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::studies::diff::where_they_part;

use crate::{hash, load, simulation};

const QUIET: [(&str, &str); 2] = [("pictures", "None"), ("profiles", "[]")];

fn run(name: &str, settings: &[(&str, &str)]) -> Simulation {
    let settings: Vec<_> = QUIET.iter().chain(settings).copied().collect();
    let mut run = simulation(&load(name, &settings), 1);
    run.run();
    run
}

/// Returns the names of all components in a world.
fn components(world: &mut World) -> String {
    let entities: Vec<_> = world.query::<Entity>().iter(world).collect();
    let names = entities.into_iter().flat_map(|entity| {
        let infos = world.inspect_entity(entity).unwrap();
        infos.map(|(_, info)| info.name().to_string()).collect::<Vec<_>>()
    });
    names.collect::<Vec<_>>().join(" ")
}

#[test]
fn scene_without_friction_has_no_spin_torque_inertia_or_history() {
    let mut smooth = run("column.ron", &[("until", "0.01")]);
    let names = components(smooth.world_mut());
    assert!(names.contains("Position") && !["Spin", "Torque", "Inertia"].iter().any(|part| names.contains(part)));
    let store = smooth.world().resource::<ParticleStore>();
    assert!(store.rotation.is_empty() && store.loads.torque.is_empty());
    let remembered = (0..20).flat_map(|i| (i + 1..20).map(move |j| (i, j)));
    let history = smooth.world().resource::<History>();
    assert!(remembered.into_iter().all(|(i, j)| history.of_pair(i, j).is_none()));
    assert!(smooth.world().get_resource::<Channels>().is_none());

    let tangential = "Linear(k: 1.0e5, damping: Restitution(0.3), tangential: Spring(k: 1.0e5, damping: OfNormal(0.5), \
                      friction: 0.5))";
    let mut rough = run("column.ron", &[("until", "0.01"), ("contact", tangential)]);
    let names = components(rough.world_mut());
    assert!(["Spin", "Torque", "Inertia"].iter().all(|part| names.contains(part)), "{names}");
    assert!(rough.world().resource::<History>().of_pair(0, 1).is_some());
}

#[test]
fn floor_carries_the_weight_and_reports_it_with_the_right_sign() {
    let mut column = run("column.ron", &[]);
    let weight = 20.0 * 0.16 * 9.81;
    let force = column.world().resource::<Surfaces>().loads[0].force;
    // At rest to 1e-7 sqrt(g R): the remaining motion has that momentum, and w1 = 2 sqrt(k/m) sin(pi/82) = 60/s of it
    // per second.
    assert!((force + weight * Vector::Y).length() < 60.0 * 20.0 * 0.16 * 1e-7 * 0.63, "{force}");
    // The contact view agrees: the lowest grain pushes on the wall with the whole weight and on the next grain with the
    // weight of the others.
    let survey = Survey::<Plane>::of_world(column.world_mut());
    let contacts = survey.view(1e-4);
    assert_eq!(contacts.len(), 20);
    let wall = contacts.iter().find(|contact| contact.with == Touched::Wall(1)).unwrap();
    assert!((wall.normal_force - weight).abs() < 1e-5 && wall.normal == Vector::Y, "{wall:?}");
    let first = contacts[0];
    assert_eq!((first.grain.number(), first.with), (1, Touched::Particle(GrainId::grain(2).unwrap())));
    assert!((first.normal_force - 0.95 * weight).abs() < 1e-5 && !first.is_sliding && first.mobilised == 0.0);
}

#[test]
fn contact_view_reports_sliding_and_sticking() {
    for (until, slides) in [("0.05", true), ("0.2", false)] {
        let ball = run("slip-to-roll.ron", &[("until", until)]);
        let contacts = Survey::<Solid>::of_world(ball.world()).view(1e-5);
        assert_eq!(contacts.len(), 1);
        assert_eq!(contacts[0].is_sliding, slides, "{:?}", contacts[0]);
        // The view evaluates the dashpot with the velocity of half a step later: 7/2 c_t dt/(2 m) = 3e-3 of the cap.
        let full = contacts[0].mobilised > 0.99;
        assert_eq!(full, slides, "{:?}", contacts[0]);
        assert!(!slides || contacts[0].friction.x < 0.0);
    }
}

#[test]
fn small_hopper_fills_rests_opens_and_empties() {
    let mut hopper = run("silo3d.ron", &[("fill[0].count", "400"), ("until", "3.0")]);
    let world = hopper.world_mut();
    let ledger = world.resource::<Ledger>();
    assert_eq!((ledger.released, ledger.out(), ledger.lost()), (400, 400, 0));
    assert_eq!(world.query_filtered::<(), With<Grain>>().iter(world).count(), 400 - ledger_culled(world));
    let flows = *world.resource::<EnergyFlows>();
    let error = totals::of_world(world).energy() - flows.expected();
    // As for silo1: (w0 dt)^2/6 of the dissipation in contacts that open and close, w0 = sqrt(1e4/1.4e-4)/s.
    let bound = 1e4 / 1.414e-4 * 2e-5f64.powi(2) / 6.0 * flows.dissipated;
    assert!(error.abs() < bound, "balance error {error} J, bound {bound} J");
    let channels = world.resource::<Channels>();
    assert!(channels.tangential > 0.0 && channels.rolling == 0.0 && channels.tangential < flows.dissipated);
}

fn ledger_culled(world: &World) -> usize {
    world.resource::<Ledger>().culled as usize
}

#[test]
fn energy_balance_of_a_periodic_chute_includes_work_of_gravity() {
    let mut chute = run("chute3d.ron", &[("until", "0.08"), ("profiles", "[]")]);
    let world = chute.world_mut();
    assert_eq!(world.resource::<Ledger>().inside(), 1944);
    let flows = *world.resource::<EnergyFlows>();
    assert!(flows.lifted > 0.0, "no grain has crossed a periodic side");
    let totals = totals::of_world(world);
    let error = totals.energy() - flows.expected();
    // (w0 dt)^2/6 of the dissipation in contacts, with w0 = sqrt(257/5e-7)/s.
    let bound = 257.0 / 4.8e-7 * 8e-6f64.powi(2) / 6.0 * flows.dissipated;
    assert!(error.abs() < bound, "balance error {error} J, bound {bound} J of {} J", flows.dissipated);
    for x in world.query_filtered::<&Position<Solid>, With<Grain>>().iter(world) {
        assert!((0.0..0.02).contains(&x.0.x) && (0.0..0.01).contains(&x.0.y), "{}", x.0);
    }
}

#[test]
fn rough_walls_keep_their_velocity_and_their_work_is_counted() {
    let mut cell = run("couette.ron", &[("until", "0.2")]);
    let world = cell.world_mut();
    let mut fixed = world.query_filtered::<&Velocity, With<Fixed>>();
    assert!(fixed.iter(world).all(|v| v.0.x.abs() == 0.5) && fixed.iter(world).count() == 42);
    let flows = *world.resource::<EnergyFlows>();
    assert!(flows.wall_work > 0.0);
    let error = totals::of_world(world).energy() - flows.expected();
    // As above, with w0 = sqrt(1e5/0.6)/s. Moving walls of discs collide like grains.
    let bound = 1e5 / 0.59 * 5e-5f64.powi(2) / 6.0 * flows.dissipated;
    assert!(error.abs() < bound, "balance error {error} J, bound {bound} J of {} J", flows.dissipated);
}

#[test]
fn each_species_pair_has_its_own_restitution() {
    // Three head-on pairs of grains: species 0 with 0, 0 with 1, 1 with 1. Each pair has its own restitution.
    let law = |e: f64| format!("Linear(k: 1.0e5, damping: Restitution({e:?}), attraction: Allowed)");
    let keys = format!(
        "(gravity: (0.0, 0.0), contact: {}, pairs: [(species: (1, 0), contact: {}), (species: (1, 1), contact: {})], \
         step: Fixed(1.0e-6), until: 0.02, pictures: None)",
        law(0.9),
        law(0.6),
        law(0.3)
    );
    let mut loaded = siloflow::scene::load::from_text("m.ron", "m", std::path::Path::new(""), keys, &[]).unwrap();
    for (pair, species) in (0u32..).zip([[0, 0], [0, 1], [1, 1]]) {
        for (side, species) in (0u32..).zip(species) {
            let x = 0.081 * f64::from(side);
            loaded.grains.push(siloflow::grains::file::GrainRow {
                id: GrainId::grain(2 * pair + side).unwrap(),
                radius: 0.04,
                mass: 0.16,
                position: Solid::new(x, f64::from(pair), 0.0),
                velocity: Solid::new(0.5 - f64::from(side), 0.0, 0.0),
                spin: Solid::ZERO,
                posture: None,
                species: Species(species),
            });
        }
    }
    let mut run = simulation(&loaded, 1);
    run.run();
    let store = run.world_mut().resource::<ParticleStore>();
    let entries = store.by_id();
    for (pair, e) in [0.9, 0.6, 0.3].into_iter().enumerate() {
        let [first, second] = [2 * pair, 2 * pair + 1].map(|grain| store.body[entries[grain]].velocity.x);
        let parting = second - first;
        // Damping evaluated half a step late, and a jump at both ends: 3 zeta w0 dt, with zeta up to 0.36 and w0 =
        // sqrt(1e5/0.08)/s.
        assert!((parting - e).abs() < 3.0 * 0.36 * 1118.0 * 1e-6, "{pair}: {parting}, not {e}");
    }
}

#[test]
fn searches_and_threads_change_no_bit_of_a_frictional_hopper() {
    let start = |neighbours: &str, threads: usize| {
        let settings = [
            ("pictures", "None"),
            ("profiles", "[]"),
            ("fill[0].count", "350"),
            ("until", "0.3"),
            ("neighbours", neighbours),
        ];
        simulation(&load("silo3d.ron", &settings), threads)
    };
    let settle = |neighbours: &str, threads: usize| {
        let mut run = start(neighbours, threads);
        run.run();
        hash(&mut run)
    };
    let usual = "VerletList(skin: 0.0006)";
    let reference = settle(usual, 1);
    for (neighbours, threads) in
        [("VerletList(skin: 0.003)", 2), ("Cells(size: 0.006)", 1), ("CellsOfRange(rng: 2.5)", 2)]
    {
        let part = || where_they_part(start(neighbours, threads), start(usual, 1), u64::MAX);
        assert_eq!(settle(neighbours, threads), reference, "{neighbours} on {threads} threads: {}", part());
    }
}
