//! The scenes of the repository: each one behaves as its comment states, and each bad scene causes its expected error.

use std::fs;
use std::num::NonZeroUsize;

use crate::{load, root, scene, simulation};
use siloflow::dem::contact::LargestOverlap;
use siloflow::dem::particle::Grain;
use siloflow::door::DoorState;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::rest::RestDetector;
use siloflow::scene::check;
use siloflow::scene::load as loading;
use siloflow::scene::loaded::AnyScene;

/// Asserts that a scene fills, comes to rest, opens and empties, and that its energy balance closes within the bound of
/// the scheme.
fn assert_whole_run(name: &str) {
    let loaded = load(name, &[("pictures", "None")]);
    // A grain falls 4 m on soft contacts, which `check` and the run judge by the same limit.
    let warnings: Vec<_> = check::warnings(&loaded).iter().map(|warning| warning.code).collect();
    assert_eq!(warnings, ["check::deep_impacts"]);
    let mut simulation = simulation(&loaded, 1);
    assert_eq!(simulation.run(), End::Empty, "{name}");
    assert!(simulation.world().resource::<LargestOverlap>().0 > 0.3, "{name}: a warning without a deep impact");
    let world = simulation.world_mut();
    let ledger = world.resource::<Ledger>();
    assert_eq!((ledger.released, ledger.out(), ledger.lost(), ledger.inside()), (1000, 1000, 0, 0), "{name}");
    let rest = world.resource::<RestDetector>().rest_time.expect("came to rest");
    let opened = world.resource::<DoorState>().open_time().expect("opened");
    // The last grain is released at 999 x 0.05 s.
    assert!(rest > 49.95 && opened == rest && world.resource::<Clock>().time() > opened, "{name}: {rest} {opened}");
    let flows = *world.resource::<EnergyFlows>();
    let error = totals::of_world(world).energy() - flows.expected();
    // A contact that opens at v_in and closes at v_out loses k dt^2 (v_in^2 - v_out^2)/12 from the balance and
    // dissipates m_eff (v_in^2 - v_out^2)/2. The ratio is (w0 dt)^2/6, largest for the lightest pair. Dissipation by
    // sliding and in lasting contacts is counted without that error.
    let estimates = check::Estimates::of(&loaded).unwrap();
    let w0 = (estimates.stiffness / (0.5 * estimates.mass)).sqrt();
    let bound = (w0 * estimates.dt).powi(2) / 6.0 * flows.dissipated;
    assert!(error.abs() < bound, "{name}: balance error {error} J, bound {bound} J");
    let left = world.query_filtered::<(), With<Grain>>().iter(world).count();
    assert_eq!(left + world.resource::<Ledger>().culled as usize, 1000, "{name}: a grain is missing from the world");
}

#[test]
fn silo1_fills_rests_opens_and_empties() {
    assert_whole_run("silo1.ron");
}

#[test]
fn silo1_mixture_fills_rests_opens_and_empties() {
    assert_whole_run("silo1-mixture.ron");
}

#[test]
fn silo1_polydisperse_fills_rests_opens_and_empties() {
    assert_whole_run("silo1-polydisperse.ron");
}

#[test]
fn silo1_literal_warns_of_leaks_and_reports_every_lost_grain() {
    let loaded = load("silo1-literal.ron", &[("pictures", "None")]);
    let codes: Vec<_> = check::warnings(&loaded).iter().map(|warning| warning.code).collect();
    assert!(codes.contains(&"check::soft_walls") && codes.contains(&"check::soft_bed"), "{codes:?}");
    let mut simulation = simulation(&loaded, 1);
    assert_eq!(simulation.run(), End::Empty);
    let ledger = simulation.world().resource::<Ledger>();
    assert_eq!((ledger.released, ledger.lost(), ledger.out(), ledger.inside()), (1000, 1000, 0, 0));
    let mut names: Vec<_> = ledger.lost.iter().map(|loss| loss.grain).collect();
    names.sort_unstable();
    assert!(names.into_iter().eq(1..=1000), "every grain is named once");
    assert!(ledger.lost.iter().all(|loss| loss.nearest_wall_grain.is_some() || loss.way.contains("cull")));
}

#[test]
fn grains_in_one_exact_column_block_the_release_point() {
    let loaded = load("silo1-one-column.ron", &[("pictures", "None")]);
    let mut simulation = simulation(&loaded, 1);
    let End::Failed(Failure::ReleaseBlocked { waited_s, .. }) = simulation.run() else { panic!("not blocked") };
    assert!(waited_s > 10.0);
    // No contact has pushed a grain sideways, and no grain was released into another.
    let world = simulation.world_mut();
    let mut grains = world.query_filtered::<&Position, With<Grain>>();
    assert!(grains.iter(world).all(|x| x.0.x == 0.0));
}

#[test]
fn every_scene_is_valid_and_runs_a_few_steps() {
    let mut scenes = 0;
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "ron") {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let settings = [("pictures".to_owned(), "None".to_owned())];
            let one = NonZeroUsize::MIN;
            let mut simulation = match loading::any(&path, &settings).unwrap_or_else(|fault| panic!("{name}: {fault}"))
            {
                AnyScene::Grains(loaded) => Simulation::new(&loaded, &Registry::default(), one),
                AnyScene::Lattice(loaded) => Simulation::of_lattice(&loaded, &Registry::default(), one),
            }
            .unwrap();
            assert_eq!(simulation.run_steps(3), None, "{name}");
            scenes += 1;
        }
    }
    assert!(scenes >= 7, "{scenes}");
}

#[test]
fn every_bad_scene_causes_its_expected_error() {
    let mut scenes = 0;
    for entry in fs::read_dir(root().join("scenes/bad")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "ron") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let expected = text
            .lines()
            .next()
            .unwrap()
            .strip_prefix("// expected error: ")
            .expect("a first line with the expected error");
        let (code, key) = expected.split_once(" at ").map_or((expected, None), |(code, key)| (code, Some(key)));
        let registry = Registry::default();
        let fault = loading::any(&path, &[])
            .and_then(|scene| match scene {
                AnyScene::Grains(loaded) => registry.of_scene(&loaded).map(|_| ()),
                AnyScene::Lattice(loaded) => registry.of_lattice(&loaded).map(|_| ()),
            })
            .expect_err(&path.display().to_string());
        assert_eq!((fault.code(), fault.scene_key()), (code, key), "{}: {fault}", path.display());
        assert!(fault.line_and_column().is_some(), "{}: has no line and column", path.display());
        scenes += 1;
    }
    assert!(scenes >= 30, "{scenes}");
}

#[test]
fn final_state_can_be_read_as_grains_of_a_scene() {
    let directory = tempfile::tempdir().unwrap();
    let loaded = load("silo1.ron", &[("pictures", "None"), ("spawner.count", "30")]);
    let mut first = simulation(&loaded, 1);
    first.run_steps(2000);
    let csv = siloflow::grains::file::write::<Plane>(first.world_mut());
    fs::write(directory.path().join("state.csv"), &csv).unwrap();
    fs::copy(root().join("assets/silo1.dat"), directory.path().join("silo1.dat")).unwrap();
    let text = fs::read_to_string(scene("silo1.ron")).unwrap();
    let settings = [("silo.file", "\"silo1.dat\""), ("grains", "(file: \"state.csv\")"), ("spawner.count", "0")]
        .map(|(key, value)| (key.to_owned(), value.to_owned()));
    let again = loading::from_text("again.ron", "again", directory.path(), text, &settings).unwrap();
    let mut second = simulation(&again, 1);
    second.run_steps(0);
    assert_eq!(siloflow::grains::file::write::<Plane>(second.world_mut()), csv);
    assert_eq!(second.world().resource::<Ledger>().released, 30);
}

#[test]
fn sliding_door_clears_the_orifice_and_its_work_is_counted() {
    let settings = [
        ("pictures", "None"),
        ("spawner.count", "60"),
        ("door", "(opens: At(6.0), how: Slide(0.5))"),
        ("until", "60.0"),
    ];
    let mut simulation = simulation(&load("silo1.ron", &settings), 1);
    assert_eq!(simulation.run(), End::Empty);
    let world = simulation.world_mut();
    assert_eq!((world.resource::<Ledger>().out(), world.resource::<DoorState>().open_time()), (60, Some(6.0)));
    let mut door = world.query_filtered::<(&Position, &Velocity), With<Door>>();
    // The last grain of the door rests a radius behind the flank at 15 cm, to one step of 0.5 mm.
    let left = door.iter(world).map(|(x, _)| x.0.x).fold(f64::INFINITY, f64::min);
    assert!((left - 0.18).abs() < 1e-3, "{left}");
    assert!(door.iter(world).all(|(x, v)| x.0.y == 0.0 && v.0 == Vector::ZERO));
    let flows = *world.resource::<EnergyFlows>();
    assert!(flows.wall_work != 0.0);
    let error = totals::of_world(world).energy() - flows.expected();
    // As in the whole runs: (w0 dt)^2/6 of the dissipation.
    assert!(error.abs() < 1.0e4 / 0.08 * 1e-6 / 6.0 * flows.dissipated, "{error} of {flows:?}");
}

#[test]
fn removed_door_takes_its_elastic_energy_out_of_the_balance() {
    let settings = [
        ("pictures", "None"),
        ("spawner.count", "100"),
        ("door", "(opens: At(9.0))"),
        ("rest", "None"),
        ("bed", "None"),
    ];
    let mut simulation = simulation(&load("silo1.ron", &settings), 1);
    let mut balance = |steps: u64| {
        simulation.run_steps(steps);
        let world = simulation.world_mut();
        let flows = *world.resource::<EnergyFlows>();
        (totals::of_world(world).energy() - flows.expected(), flows.removed)
    };
    let (before, nothing) = balance(8_999);
    let (after, removed) = balance(9_002);
    // The elastic energy of the door's contacts is counted as removed, so the balance changes by one half-kick only.
    // The force F of the last evaluation, with the door present, still acts for dt/2. It gives F^2 dt^2/(8 m) to the
    // grain, while the contact held F^2/(2 k): a share k dt^2/(4 m), 1.6 %. The neighbours that the grain is pressed
    // into contribute as much again.
    assert!(nothing == 0.0 && removed > 1e-3, "{removed} J");
    let share = 2.0 * 1.0e4 * 1.0e-6 / (4.0 * 0.16);
    assert!((after - before).abs() < share * removed, "{before} J, then {after} J, with {removed} J removed");
}

#[test]
fn grain_that_crosses_orifice_and_cull_line_in_one_step_counts_as_out() {
    for line in ["0.0", "-0.005"] {
        let cull = format!("(below: {line})");
        let settings = [("pictures", "None"), ("spawner.count", "30"), ("cull", cull.as_str())];
        let mut simulation = simulation(&load("silo1.ron", &settings), 1);
        let end = simulation.run();
        let ledger = simulation.world().resource::<Ledger>();
        assert_eq!((&end, ledger.out(), ledger.lost()), (&End::Empty, 30, 0), "{line}");
    }
}

#[test]
fn a_grain_below_the_cull_line_leaves_within_32_steps() {
    // It is below the line after 11 steps.
    let text = "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: Disc(100.0), step: Fixed(1.0e-3), \
         fill: [(low: (0.0, -0.04), high: (0.08, 0.04), spacing: 0.08, count: 1, radius: Fixed(0.04), velocity: (0.0, -1.0))], \
         cull: (below: -0.0105), until: 0.1, pictures: None)";
    let loaded = loading::from_text("below.ron", "below", root(), text.to_owned(), &[]).unwrap();
    let mut simulation = simulation(&loaded, 1);
    let mut culled_after = |steps: u64| {
        simulation.run_steps(steps);
        simulation.world().resource::<Ledger>().culled
    };
    assert_eq!((culled_after(30), culled_after(34)), (0, 1));
}

#[test]
fn grains_pressed_through_a_closed_door_count_as_lost() {
    let settings = [("pictures", "None"), ("spawner.count", "20"), ("door", "None"), ("rest", "None"), ("bed", "None")];
    let mut simulation = simulation(&load("silo1-literal.ron", &settings), 1);
    assert_eq!(simulation.run(), End::Empty);
    assert_eq!(simulation.world().resource::<Ledger>().lost(), 20);
}

#[test]
fn without_a_silo_no_grain_counts_as_lost() {
    let text = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: Disc(100.0), step: Fixed(1.0e-4), \
         walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Disc(centre: (0.3, 0.2), radius: 0.05)], until: 2.0, pictures: None, \
         spawner: (point: (0.25, 1.0), velocity: (0.0, 0.0), interval: 0.3, count: 4, radius: Fixed(0.04)))";
    let loaded = loading::from_text("open.ron", "open", root(), text.to_owned(), &[]).unwrap();
    let mut simulation = simulation(&loaded, 1);
    assert_eq!(simulation.run(), End::TimeReached);
    assert_eq!(simulation.world().resource::<Ledger>().inside(), 4);
}
