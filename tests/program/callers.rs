//! Calls between two steps of a simulation: other numbers for grains, pushes, a state in a file, another thread.

use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::output::state_hash;
use siloflow::prelude::*;
use siloflow::simulation::assign::Assigned;
use siloflow::simulation::push::PushPlugin;

/// Nine discs that lie on each other and on a floor, with friction.
const HEAP: &str = "(seed: 2, gravity: (0.0, -9.81), mass: Disc(100.0), step: Fixed(1.0e-4), until: 0.3, pictures: None,
    contact: Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 1.0e5, damping: OfNormal(1.0), friction: 0.5)),
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), HalfPlane(point: (-0.13, 0.0), normal: (1.0, 0.0)),
            HalfPlane(point: (0.13, 0.0), normal: (-1.0, 0.0))],
    fill: [(low: (-0.12, 0.0), high: (0.12, 0.24), spacing: 0.08, jitter: 0.002, radius: Fixed(0.038))])";

fn loaded() -> Loaded {
    load::from_text("heap.ron", "heap", Path::new(""), HEAP.to_owned(), &[]).unwrap_or_else(|fault| panic!("{fault}"))
}

fn heap() -> Simulation {
    let push = |app: &mut App| {
        app.add_plugins(PushPlugin::<Plane>(PhantomData));
    };
    Simulation::with_plugins(&loaded(), &Registry::default(), NonZeroUsize::MIN, push).unwrap()
}

fn balance_error(run: &mut Simulation) -> f64 {
    let world = run.world_mut();
    totals::of_world(world).energy() - world.resource::<EnergyFlows>().expected()
}

/// Places, velocities and spins in the order of ids.
fn numbers(run: &mut Simulation) -> Vec<(Plane, Plane, f64)> {
    let world = run.world_mut();
    let mut grains = world.query_filtered::<(&GrainId, &Position, &Velocity, &Spin), With<Grain>>();
    let mut all: Vec<_> = grains.iter(world).map(|(id, x, v, w)| (*id, (x.0, v.0, w.0))).collect();
    all.sort_unstable_by_key(|grain| grain.0);
    all.into_iter().map(|grain| grain.1).collect()
}

#[test]
fn assigned_numbers_are_the_state_and_their_energy_is_booked() {
    let mut run = heap();
    run.run_steps(2500);
    let before = numbers(&mut run);
    let error = balance_error(&mut run);
    let scale = totals::of_world(run.world()).energy();
    // Everything is lifted out of its contacts with the floor, kicked and spun.
    let places: Vec<_> = before.iter().map(|grain| grain.0 + Plane::new(0.001, 0.02)).collect();
    run.assign(Assigned::Positions(&places)).unwrap();
    let velocities: Vec<_> = before.iter().map(|grain| grain.1 + Plane::new(0.0, 0.5)).collect();
    run.assign(Assigned::Velocities(&velocities)).unwrap();
    let spins: Vec<_> = before.iter().map(|grain| grain.2 + 3.0).collect();
    run.assign::<Plane>(Assigned::Spins(&spins)).unwrap();
    let after = numbers(&mut run);
    for (after, ((x, v), w)) in after.iter().zip(places.iter().zip(&velocities).zip(&spins)) {
        assert_eq!(*after, (*x, *v, *w));
    }
    assert!((balance_error(&mut run) - error).abs() < 1e-13 * scale);
    assert_eq!(run.run(), End::TimeReached);
    // The contacts in the pile have gone on, and the floor was met again.
    assert!((balance_error(&mut run) - error).abs() < 5e-3 * run.world().resource::<EnergyFlows>().dissipated);
    let refused = [
        run.assign(Assigned::Positions(&places[1..])),
        run.assign(Assigned::Velocities(&[Plane::new(f64::NAN, 0.0); 9])),
    ];
    assert!(refused.iter().all(Result::is_err), "{refused:?}");
}

#[test]
fn grains_may_be_put_through_walls_and_are_not_lost_by_that() {
    let mut run = heap();
    run.run_steps(100);
    let places: Vec<_> = numbers(&mut run).iter().map(|grain| grain.0 + Plane::new(10.0, 0.0)).collect();
    run.assign(Assigned::Positions(&places)).unwrap();
    run.run_steps(200);
    assert_eq!(run.world().resource::<Ledger>().lost(), 0);
}

#[test]
fn a_push_accelerates_and_its_work_is_counted() {
    let mut run = heap();
    run.run_steps(10);
    let before = numbers(&mut run);
    let ids = run.grain_ids::<Plane>();
    let mass = 100.0 * std::f64::consts::PI * 0.038 * 0.038;
    // Weightless, and one grain is pushed aside.
    let weight = Plane::new(0.0, 9.81 * mass);
    run.push(ids.iter().map(|&id| (id, weight))).unwrap();
    run.push([(ids[8], Plane::new(mass, 0.0))]).unwrap();
    run.run_steps(20);
    run.stop_pushing::<Plane>();
    let after = numbers(&mut run);
    let work = run.world().resource::<EnergyFlows>().added_work;
    // In free fall until then: a grain keeps its velocity, and the last one gains 1 m/s^2 for 1 ms. Half a kick of each end is by the weight alone.
    let fall = 9.81 * 0.5e-4;
    for (index, (before, after)) in before.iter().zip(&after).enumerate() {
        let gained = after.1 - before.1;
        let pushed = if index == 8 { 1e-3 } else { 0.0 };
        assert!(
            (gained.x - pushed).abs() < 0.6e-4 * pushed.max(1e-9) * 1e3 && gained.y.abs() <= fall + 1e-15,
            "{index}: {gained:?}"
        );
    }
    // Force times way.
    let expected: f64 = before.iter().zip(&after).map(|(before, after)| weight.y * (after.0.y - before.0.y)).sum();
    assert!((work / expected - 1.0).abs() < 0.1, "{work} {expected}");
    assert!(balance_error(&mut run).abs() < 1e-6 * totals::of_world(run.world()).energy());
    run.run_steps(21);
    assert!(run.world().resource::<EnergyFlows>().added_work - work < 0.1 * work.abs());
    assert!(run.push([(ids[0], Plane::new(f64::INFINITY, 0.0))]).is_err());
    let mut other = Simulation::new(&loaded(), &Registry::default(), NonZeroUsize::MIN).unwrap();
    assert!(other.push([(ids[0], weight)]).is_err());
}

#[test]
fn a_saved_file_and_a_run_are_continued_to_the_same_bits() {
    let here = tempfile::tempdir().unwrap();
    let mut whole = heap();
    whole.run();
    let expected = state_hash::of_world(whole.world_mut());
    let mut first = heap();
    first.run_steps(1234);
    let file = here.path().join("state");
    first.save_to(&file, "heap").unwrap();
    let push = |app: &mut App| {
        app.add_plugins(PushPlugin::<Plane>(PhantomData));
    };
    let go_on = |state: &Path| Simulation::continued(&loaded(), &Registry::default(), NonZeroUsize::MIN, state, push);
    let mut second = go_on(&file).unwrap();
    assert_eq!(second.world().resource::<Clock>().steps, 1234);
    second.run();
    assert_eq!(state_hash::of_world(second.world_mut()), expected);
    // A run directory, with files of outputs.
    let scene = here.path().join("heap.ron");
    std::fs::write(&scene, HEAP).unwrap();
    let out = here.path().join("run");
    let arguments = ["siloflow", "run", "--quiet", "--out"].map(std::ffi::OsString::from);
    let arguments = arguments.into_iter().chain([out.clone().into_os_string(), scene.into_os_string()]);
    assert_eq!(siloflow::cli::run_with(&Registry::default(), arguments), std::process::ExitCode::SUCCESS);
    let mut third = go_on(&out).unwrap();
    assert_eq!(state_hash::of_world(third.world_mut()), expected);
    assert!(second.save_to(&here.path().join("missing").join("state"), "heap").is_err());
    second.save_to(&file, "heap").unwrap();
    assert_eq!(go_on(&file).unwrap().world().resource::<Clock>().steps, 3000);
    std::fs::write(&file, "nonsense").unwrap();
    for wrong in [file, here.path().join("missing"), here.path().to_owned()] {
        assert!(go_on(&wrong).map(|_| ()).unwrap_err().code().starts_with("checkpoint::"), "{}", wrong.display());
    }
}

#[test]
fn a_simulation_passes_to_another_thread() {
    let mut run = heap();
    let there = std::thread::spawn(move || {
        run.run();
        state_hash::of_world(run.world_mut())
    });
    let mut here = heap();
    here.run();
    assert_eq!(there.join().unwrap(), state_hash::of_world(here.world_mut()));
}
