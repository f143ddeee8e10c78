//! The whole program against a naive simulator that shares no code with it: plain loops over all pairs and walls ([`simulator`]), with
//! the formulas of the contact laws written down once more ([`law`], [`plain`], [`centred`]) on vectors of their own.
//!
//! Compared are positions, velocities, spins, forces and torques of every grain of random dense beds ([`scene`]), of the start and after
//! 1, 2, 10 and 40 steps, more than a contact time ([`compare`]): for every contact law, in the plane and in solid space, between walls
//! of every kind and periodic sides, while grains enter and are removed, with one species and with three, under each scheme, neighbour search and
//! set of instructions, on one thread and on two, with books of energy and without. That the comparison can fail is shown by every
//! number of every law, changed by a little, and by the other scheme.

mod centred;
mod compare;
mod law;
mod plain;
mod scene;
mod scene_text;
mod simulator;
mod vector;

use siloflow::instructions::Instructions;

use self::compare::{LOOKS, Look, differences, seen};
use self::law::{Damping, Friction, Law, Normal, Rolling};
use self::scene::{Around, Scene};
use self::simulator::Scheme;

const SEARCHES: [&str; 5] =
    ["AllPairs", "Cells(size: 0.1)", "VerletList(skin: 0.004)", "CellsOfRange(rng: 2.2)", "VerletList(skin: 0.05)"];

/// By how much numbers of laws are changed to show that a difference is found.
const LITTLE: f64 = 1.0e-8;

fn small(solid: bool) -> [usize; 3] {
    if solid { [4, 4, 5] } else { [8, 9, 1] }
}

/// What one run of siloflow is made with.
#[derive(Clone, Copy, Debug)]
struct Way {
    search: &'static str,
    threads: usize,
    books: bool,
    instructions: Instructions,
}

impl Way {
    /// One of all ways; numbers that follow each other differ in much.
    fn of(number: usize) -> Self {
        let all = Instructions::all();
        Self {
            search: SEARCHES[number % 5],
            threads: 1 + number / 2 % 2,
            books: (number / 4).is_multiple_of(2),
            instructions: all[number / 3 % all.len()],
        }
    }
}

/// What siloflow makes of a scene in one way.
fn run(scene: &Scene, way: Way) -> Vec<Look> {
    let mut simulation = scene.simulation(way.search, way.threads, way.books);
    simulation.world_mut().insert_resource(way.instructions);
    seen(&mut simulation)
}

/// What siloflow makes of a scene, which is what the naive simulator makes of it.
fn assert_agree(scene: &Scene, way: Way) -> Vec<Look> {
    let seen = run(scene, way);
    let found = differences(&scene.simulator(), &seen);
    assert!(found.iter().all(|share| *share < 1.0), "{}, {way:?}: {found:?}", scene.title());
    seen
}

/// Compares all small scenes with this law, each in one way; `first` decides on that of the first one.
fn assert_same(first: usize, law: Law) {
    let mut ways = (first..).map(Way::of);
    for solid in [false, true] {
        for around in Around::ALL {
            for scheme in [Scheme::Verlet, Scheme::Centred] {
                let scene = Scene::new(law, solid, around, scheme, small(solid));
                let seen = assert_agree(&scene, ways.next().unwrap());
                assert_changes_are_found(&scene, &seen);
            }
        }
    }
}

/// Each number of the laws, changed by a little, and the other scheme make a difference after all steps.
fn assert_changes_are_found(scene: &Scene, seen: &[Look]) {
    let mut scene = scene.clone();
    let last = |scene: &Scene| differences(&scene.simulator(), seen)[LOOKS.len() - 1];
    for changed in 0..scene.numbers().len() {
        let mut other = scene.clone();
        let mut numbers = other.numbers();
        let (name, number) = &mut numbers[changed];
        let name = *name;
        // Normal springs carry more than anything else.
        **number *= 1.0 + if name == "k" { 0.1 * LITTLE } else { LITTLE };
        assert!(last(&other) > 5.0, "{}: {name} may change", scene.title());
    }
    scene.scheme = if scene.scheme == Scheme::Verlet { Scheme::Centred } else { Scheme::Verlet };
    assert!(last(&scene) > 1.0e6, "{}: so may the scheme", scene.title());
}

fn linear(damping: Damping, pulls: bool) -> Law {
    Law { normal: Normal::Linear { k: 2.0e4, damping, pulls }, friction: None, rolling: None, at_point: false }
}

fn assignment() -> Law {
    Law { normal: Normal::Assignment { k: 2.0e4, b: 8.0 }, ..linear(Damping::B(0.0), true) }
}

fn rubbing(damping: Damping, friction: Friction, rolling: Option<Rolling>, at_point: bool) -> Law {
    Law { friction: Some(friction), rolling, at_point, ..linear(damping, at_point) }
}

fn hertz(restitution: f64, pulls: bool, mu: Option<f64>, rolling: Option<Rolling>, at_point: bool) -> Law {
    let friction = mu.map(|mu| Friction::Mindlin { mu });
    Law { normal: Normal::Hertz { restitution, pulls }, friction, rolling, at_point }
}

fn spring(damping: Damping) -> Friction {
    Friction::Spring { k: 1.2e4, damping, mu: 0.3 }
}

fn dashpot(damping: Damping) -> Friction {
    Friction::Dashpot { damping, mu: 0.3 }
}

#[expect(clippy::unnecessary_wraps, reason = "a term of a law")]
fn rolling(damping: Damping) -> Option<Rolling> {
    Some(Rolling { k: 4.0e3, damping, mu: 0.1 })
}

#[test]
fn the_assignment_s_law() {
    assert_same(0, assignment());
}

#[test]
fn linear_springs_and_dashpots() {
    assert_same(1, linear(Damping::B(8.0), false));
    assert_same(2, linear(Damping::PerMass(120.0), true));
    assert_same(3, linear(Damping::Restitution(0.6), true));
    assert_same(4, linear(Damping::Restitution(0.4), false));
}

#[test]
fn friction_by_dashpots() {
    assert_same(5, rubbing(Damping::B(8.0), dashpot(Damping::PerMass(150.0)), None, false));
    assert_same(6, rubbing(Damping::Restitution(0.6), dashpot(Damping::B(9.0)), None, true));
    assert_same(7, rubbing(Damping::PerMass(80.0), dashpot(Damping::OfNormal(0.8)), None, true));
}

#[test]
fn friction_by_springs() {
    assert_same(8, rubbing(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), None, false));
    assert_same(9, rubbing(Damping::PerMass(100.0), spring(Damping::PerMass(50.0)), None, true));
}

#[test]
fn rolling_resistance() {
    assert_same(10, rubbing(Damping::B(8.0), spring(Damping::B(3.0)), rolling(Damping::PerMass(60.0)), false));
    assert_same(11, rubbing(Damping::Restitution(0.7), spring(Damping::OfNormal(0.4)), rolling(Damping::B(2.0)), true));
}

#[test]
fn hertz_and_mindlin() {
    assert_same(12, hertz(0.6, false, None, None, false));
    assert_same(13, hertz(0.7, true, None, None, false));
    assert_same(14, hertz(0.6, true, Some(0.3), None, false));
    assert_same(15, hertz(0.5, false, Some(0.3), None, true));
    assert_same(16, hertz(0.7, false, Some(0.3), rolling(Damping::B(2.0)), false));
    assert_same(17, hertz(0.7, true, Some(0.3), rolling(Damping::PerMass(40.0)), true));
}

#[test]
fn without_drag_the_centred_scheme_is_verlet_and_euler_is_euler() {
    for solid in [false, true] {
        for (scheme, law) in [
            (Scheme::Centred, linear(Damping::Restitution(1.0), true)),
            (Scheme::Centred, hertz(1.0, true, None, None, false)),
            (Scheme::SymplecticEuler, linear(Damping::Restitution(0.6), false)),
            (Scheme::ExplicitEuler, assignment()),
            (Scheme::SymplecticEuler, hertz(0.6, true, None, None, false)),
        ] {
            let scene = Scene::new(law, solid, Around::Fittings, scheme, small(solid));
            assert_agree(&scene, Way::of(3));
        }
    }
}

/// One way agrees with the naive simulator, and all others with it to the last bit.
fn assert_all_agree(scene: &Scene, ways: &[Way]) {
    let seen = assert_agree(scene, ways[0]);
    for way in &ways[1..] {
        assert!(run(scene, *way) == seen, "{}: {way:?} differs from {:?}", scene.title(), ways[0]);
    }
}

#[test]
fn every_search_and_set_of_instructions_on_one_thread_and_two() {
    let law = rubbing(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), true);
    let mut ways = Vec::new();
    for search in SEARCHES {
        for instructions in Instructions::all() {
            ways.extend([1, 2].map(|threads| Way { search, threads, books: threads == 1, instructions }));
        }
    }
    for scheme in [Scheme::Verlet, Scheme::Centred] {
        assert_all_agree(&Scene::new(law, true, Around::Chute, scheme, small(true)), &ways);
    }
}

/// More grains than one thread takes at a time, so that several share them.
#[test]
fn many_grains_on_several_threads() {
    let law = rubbing(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), false);
    let ways = [2, 1, 3].map(|threads| Way { threads, ..Way::of(threads) });
    for (around, scheme) in [(Around::Walls, Scheme::Centred), (Around::Hole, Scheme::Verlet)] {
        assert_all_agree(&Scene::new(law, true, around, scheme, [16, 16, 9]), &ways);
    }
}
