//! The whole program against a naive simulator that shares no code with it: plain loops over all pairs and walls
//! ([`siloflow_oracle::simulator`]). It has its own vectors and its own formulas of the contact laws.
//!
//! Position, velocity, spin, force and torque of every grain of random dense beds ([`scene`]) are compared
//! ([`compare`]) at the start and after 1, 2, 10 and 40 steps, more than a contact duration. The cases cover:
//!
//! * every contact law, in the plane and in solid space, with one species and with three;
//! * walls of every kind, periodic sides, and grains that enter and are removed;
//! * a floor that forces move;
//! * grains of several spheres, bodies of revolution and others ([`shaped`]);
//! * each scheme, neighbour search and instruction set, one and two threads, with the energy balance and without.
//!
//! To show that the comparison can fail, each number of each law is changed slightly, and the scheme is exchanged. The
//! comparison must detect each change.

mod compare;
mod scene;
mod scene_text;
mod shaped;

use siloflow::dem::instruction_set::InstructionSet;
use siloflow_oracle::free_wall::FreeWall;
use siloflow_oracle::law::{Adhesion, Damping, Friction, Law, Normal, Rolling, RollingKind};
use siloflow_oracle::simulator::Scheme;

use self::compare::{SAMPLE_STEPS, Sample, differences, seen};
use self::scene::{Scene, Surroundings};

const SEARCHES: [&str; 5] =
    ["AllPairs", "Cells(size: 0.1)", "VerletList(skin: 0.004)", "CellsOfRange(rng: 2.2)", "VerletList(skin: 0.05)"];

/// Relative change of a number of a law that the comparison must detect.
const RELATIVE_CHANGE: f64 = 1.0e-8;

fn small(solid: bool) -> [usize; 3] {
    if solid { [4, 4, 5] } else { [8, 9, 1] }
}

/// Options of one run of siloflow.
#[derive(Clone, Copy, Debug)]
struct RunOptions {
    search: &'static str,
    threads: usize,
    energy_balance: bool,
    instructions: InstructionSet,
}

impl RunOptions {
    /// Returns combination `number` of the options. Consecutive numbers differ in most options.
    fn of(number: usize) -> Self {
        let all = InstructionSet::all();
        Self {
            search: SEARCHES[number % 5],
            threads: 1 + number / 2 % 2,
            energy_balance: (number / 4).is_multiple_of(2),
            instructions: all[number / 3 % all.len()],
        }
    }
}

/// Runs siloflow on a scene and returns its samples.
fn run(scene: &Scene, option: RunOptions) -> Vec<Sample> {
    let mut simulation = scene.simulation(option.search, option.threads, option.energy_balance);
    simulation.world_mut().insert_resource(option.instructions);
    seen(&mut simulation)
}

/// Asserts that siloflow and the naive simulator agree on a scene, and returns the samples of siloflow.
fn assert_agree(scene: &Scene, option: RunOptions) -> Vec<Sample> {
    let seen = run(scene, option);
    let found = differences(&scene.simulator(), &seen);
    assert!(found.iter().all(|share| *share < 1.0), "{}, {option:?}: {found:?}", scene.title());
    seen
}

/// Compares all small scenes with this law. Each scene runs with one combination of options, counted up from `first`.
fn assert_same(first: usize, law: Law) {
    // Discs of the plane cannot twist.
    let spaces: &[bool] = if law.twisting.is_some() { &[true] } else { &[false, true] };
    let mut options = (first..).map(RunOptions::of);
    for &solid in spaces {
        for around in Surroundings::ALL {
            for scheme in [Scheme::Verlet, Scheme::Centred] {
                let scene = Scene::new(law, solid, around, scheme, small(solid));
                let seen = assert_agree(&scene, options.next().unwrap());
                assert_changes_are_found(&scene, &seen);
            }
        }
    }
}

/// Compares all small scenes in which grains have shapes, with this law.
fn assert_same_with_shapes(first: usize, law: Law) {
    let mut options = (first..).map(RunOptions::of);
    for solid in [false, true] {
        for around in Surroundings::ALL {
            for scheme in [Scheme::Verlet, Scheme::Centred] {
                let mut scene = Scene::new(law, solid, around, scheme, small(solid)).with_shapes();
                let seen = assert_agree(&scene, options.next().unwrap());
                assert_changes_are_found(&scene, &seen);
                scene.clumps[0].inverse_inertias[2] *= 1.0 + RELATIVE_CHANGE;
                let found = differences(&scene.simulator(), &seen);
                assert!(
                    found[SAMPLE_STEPS.len() - 1] > 5.0,
                    "{}: a change of an inertia is not detected",
                    scene.title()
                );
            }
        }
    }
}

/// Compares beds with a wall that forces move, with this law. A change of each number of the wall must be detected.
fn assert_same_with_a_free_wall(first: usize, law: Law, around: Surroundings, free: fn(Scene) -> Scene) {
    let mut options = (first..).map(RunOptions::of);
    for (solid, scheme) in
        [(false, Scheme::Verlet), (false, Scheme::Centred), (true, Scheme::Verlet), (true, Scheme::Centred)]
    {
        let scene = free(Scene::new(law, solid, around, scheme, small(solid)));
        let seen = assert_agree(&scene, options.next().unwrap());
        let changes: [fn(&mut FreeWall) -> &mut f64; 6] = [
            |free| &mut free.inertia,
            |free| &mut free.mass,
            |free| &mut free.load,
            |free| &mut free.stiffness,
            |free| &mut free.damping,
            |free| &mut free.rate,
        ];
        for change in changes {
            let mut other = scene.clone();
            let free = other.walls.iter_mut().find_map(|wall| wall.free.as_mut()).unwrap();
            *change(free) *= 1.0 + 100.0 * RELATIVE_CHANGE;
            let found = differences(&other.simulator(), &seen);
            assert!(found[SAMPLE_STEPS.len() - 1] > 5.0, "{}: a change of the wall is not detected", scene.title());
        }
    }
}

/// Asserts that a small change of each number of the laws, and the other scheme, are detected at the last sample.
fn assert_changes_are_found(scene: &Scene, seen: &[Sample]) {
    let mut scene = scene.clone();
    let last = |scene: &Scene| differences(&scene.simulator(), seen)[SAMPLE_STEPS.len() - 1];
    for changed in 0..scene.numbers().len() {
        let mut other = scene.clone();
        let mut numbers = other.numbers();
        let (name, number) = &mut numbers[changed];
        let name = *name;
        // Normal springs carry most of the force, so a smaller change is detected.
        **number *= 1.0 + if name == "k" { 0.1 * RELATIVE_CHANGE } else { RELATIVE_CHANGE };
        assert!(last(&other) > 5.0, "{}: a change of {name} is not detected", scene.title());
    }
    scene.scheme = if scene.scheme == Scheme::Verlet { Scheme::Centred } else { Scheme::Verlet };
    assert!(last(&scene) > 1.0e6, "{}: a change of the scheme is not detected", scene.title());
}

fn linear(damping: Damping, pulls: bool) -> Law {
    let normal = Normal::Linear { k: 2.0e4, damping, pulls };
    Law { normal, adhesion: None, friction: None, rolling: None, twisting: None, at_point: false }
}

fn assignment() -> Law {
    Law { normal: Normal::Assignment { k: 2.0e4, b: 8.0 }, ..linear(Damping::B(0.0), true) }
}

fn with_friction(damping: Damping, friction: Friction, rolling: Option<Rolling>, at_point: bool) -> Law {
    Law { friction: Some(friction), rolling, at_point, ..linear(damping, at_point) }
}

fn hertz(restitution: f64, pulls: bool, mu: Option<f64>, rolling: Option<Rolling>, at_point: bool) -> Law {
    let friction = mu.map(|mu| Friction::Mindlin { mu });
    Law { normal: Normal::Hertz { restitution, pulls }, adhesion: None, friction, rolling, twisting: None, at_point }
}

fn spring(damping: Damping) -> Friction {
    Friction::Spring { k: 1.2e4, damping, mu: 0.3 }
}

fn dashpot(damping: Damping) -> Friction {
    Friction::Dashpot { damping, mu: 0.3 }
}

#[expect(clippy::unnecessary_wraps, reason = "a term of a law")]
fn rolling(damping: Damping) -> Option<Rolling> {
    Some(Rolling { k: 4.0e3, damping, mu: 0.1, kind: RollingKind::Spring })
}

#[test]
fn assignment_law_agrees() {
    assert_same(0, assignment());
}

#[test]
fn linear_springs_and_dashpots_agree() {
    assert_same(1, linear(Damping::B(8.0), false));
    assert_same(2, linear(Damping::PerMass(120.0), true));
    assert_same(3, linear(Damping::Restitution(0.6), true));
    assert_same(4, linear(Damping::Restitution(0.4), false));
}

#[test]
fn friction_by_dashpots_agrees() {
    assert_same(5, with_friction(Damping::B(8.0), dashpot(Damping::PerMass(150.0)), None, false));
    assert_same(6, with_friction(Damping::Restitution(0.6), dashpot(Damping::B(9.0)), None, true));
    assert_same(7, with_friction(Damping::PerMass(80.0), dashpot(Damping::OfNormal(0.8)), None, true));
}

#[test]
fn friction_by_springs_agrees() {
    assert_same(8, with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), None, false));
    assert_same(9, with_friction(Damping::PerMass(100.0), spring(Damping::PerMass(50.0)), None, true));
}

#[test]
fn rolling_resistance_agrees() {
    assert_same(10, with_friction(Damping::B(8.0), spring(Damping::B(3.0)), rolling(Damping::PerMass(60.0)), false));
    assert_same(
        11,
        with_friction(Damping::Restitution(0.7), spring(Damping::OfNormal(0.4)), rolling(Damping::B(2.0)), true),
    );
}

#[test]
fn hertz_and_mindlin_agree() {
    assert_same(12, hertz(0.6, false, None, None, false));
    assert_same(13, hertz(0.7, true, None, None, false));
    assert_same(14, hertz(0.6, true, Some(0.3), None, false));
    assert_same(15, hertz(0.5, false, Some(0.3), None, true));
    assert_same(16, hertz(0.7, false, Some(0.3), rolling(Damping::B(2.0)), false));
    assert_same(17, hertz(0.7, true, Some(0.3), rolling(Damping::PerMass(40.0)), true));
}

/// The law of Johnson, Kendall and Roberts on another law's friction.
fn jkr(work: f64, pulls: bool, law: Law) -> Law {
    Law { normal: Normal::Jkr { restitution: 0.6, pulls, work }, ..law }
}

#[test]
fn adhesion_beyond_touch_agrees() {
    let elastic = rolling(Damping::B(8.0)).map(|rolling| Rolling { kind: RollingKind::Elastic, ..rolling });
    assert_same(28, jkr(40.0, true, hertz(0.6, true, Some(0.3), None, false)));
    assert_same(29, jkr(60.0, false, hertz(0.6, false, Some(0.3), elastic, true)));
}

#[test]
fn kinds_of_rolling_resistance_agree() {
    let of = |kind: RollingKind, damping: Damping| rolling(damping).map(|rolling| Rolling { kind, ..rolling });
    let elastic = of(RollingKind::Elastic, Damping::B(2.0));
    let torque = of(RollingKind::Torque, Damping::B(0.0));
    assert_same(22, with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), elastic, false));
    assert_same(23, with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), torque, true));
    assert_same(24, hertz(0.6, false, Some(0.3), elastic, false));
    assert_same(25, hertz(0.7, true, Some(0.3), torque, true));
}

#[test]
fn twisting_resistance_agrees() {
    let twisting = |damping: Damping| rolling(damping).map(|term| Rolling { k: 3.0e3, mu: 0.05, ..term });
    let linear = with_friction(Damping::B(8.0), spring(Damping::B(3.0)), rolling(Damping::PerMass(60.0)), false);
    assert_same(30, Law { twisting: twisting(Damping::B(1.0)), ..linear });
    let hertz = Law { adhesion: Some(Adhesion::Dmt(40.0)), ..hertz(0.6, false, Some(0.3), None, true) };
    assert_same(31, Law { twisting: twisting(Damping::PerMass(30.0)), ..hertz });
}

#[test]
fn walls_that_forces_move_agree() {
    let rough =
        with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), true);
    let smooth = hertz(0.6, true, Some(0.3), None, false);
    assert_same_with_a_free_wall(37, rough, Surroundings::Walls, Scene::with_free_floor);
    assert_same_with_a_free_wall(38, smooth, Surroundings::Walls, Scene::with_free_floor);
    assert_same_with_a_free_wall(39, rough, Surroundings::Fittings, Scene::with_flap);
    assert_same_with_a_free_wall(40, smooth, Surroundings::Fittings, Scene::with_flap);
}

#[test]
fn grains_of_several_spheres_agree() {
    assert_same_with_shapes(
        32,
        with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), true),
    );
    assert_same_with_shapes(33, with_friction(Damping::PerMass(80.0), dashpot(Damping::OfNormal(0.8)), None, false));
    assert_same_with_shapes(34, hertz(0.6, true, Some(0.3), None, false));
    assert_same_with_shapes(35, jkr(40.0, true, hertz(0.6, true, Some(0.3), None, true)));
    assert_same_with_shapes(36, linear(Damping::Restitution(0.6), true));
}

#[test]
fn chosen_damping_of_mindlin_agrees() {
    let damped = |share: f64| Some(Friction::MindlinOfNormal { mu: 0.3, share });
    assert_same(26, Law { friction: damped(0.4), ..hertz(0.6, false, Some(0.3), None, false) });
    assert_same(27, Law { friction: damped(1.6), ..hertz(0.7, true, Some(0.3), rolling(Damping::B(2.0)), true) });
}

#[test]
fn adhesion_agrees() {
    let stuck = |law: Law, adhesion: Adhesion| Law { adhesion: Some(adhesion), ..law };
    let rough = |rolling| with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling, false);
    assert_same(18, stuck(rough(None), Adhesion::Force(4.0)));
    assert_same(19, stuck(rough(rolling(Damping::B(2.0))), Adhesion::Area(3.0e4)));
    assert_same(20, stuck(hertz(0.6, false, Some(0.3), None, true), Adhesion::Dmt(40.0)));
    assert_same(21, stuck(hertz(0.7, true, Some(0.3), rolling(Damping::PerMass(40.0)), false), Adhesion::Area(2.0e4)));
}

#[test]
fn undamped_centred_contacts_and_euler_schemes_agree() {
    for solid in [false, true] {
        for (scheme, law) in [
            (Scheme::Centred, linear(Damping::Restitution(1.0), true)),
            (Scheme::Centred, hertz(1.0, true, None, None, false)),
            (Scheme::SymplecticEuler, linear(Damping::Restitution(0.6), false)),
            (Scheme::ExplicitEuler, assignment()),
            (Scheme::SymplecticEuler, hertz(0.6, true, None, None, false)),
        ] {
            let scene = Scene::new(law, solid, Surroundings::Fittings, scheme, small(solid));
            assert_agree(&scene, RunOptions::of(3));
        }
    }
}

/// Asserts that one combination agrees with the naive simulator, and all others with that one to the last bit.
fn assert_all_agree(scene: &Scene, options: &[RunOptions]) {
    let seen = assert_agree(scene, options[0]);
    for option in &options[1..] {
        assert!(run(scene, *option) == seen, "{}: {option:?} differs from {:?}", scene.title(), options[0]);
    }
}

#[test]
fn every_search_instruction_set_and_thread_count_agrees() {
    let law = with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), true);
    let mut options = Vec::new();
    for search in SEARCHES {
        for instructions in InstructionSet::all() {
            options.extend([1, 2].map(|threads| RunOptions {
                search,
                threads,
                energy_balance: threads == 1,
                instructions,
            }));
        }
    }
    for scheme in [Scheme::Verlet, Scheme::Centred] {
        assert_all_agree(&Scene::new(law, true, Surroundings::Chute, scheme, small(true)), &options);
    }
}

/// The bed has more grains than one chunk, so several threads share them.
#[test]
fn many_grains_on_several_threads_agree() {
    let law = with_friction(Damping::Restitution(0.5), spring(Damping::OfNormal(0.5)), rolling(Damping::B(2.0)), false);
    let options = [2, 1, 3].map(|threads| RunOptions { threads, ..RunOptions::of(threads) });
    for (around, scheme) in [(Surroundings::Walls, Scheme::Centred), (Surroundings::Hole, Scheme::Verlet)] {
        assert_all_agree(&Scene::new(law, true, around, scheme, [16, 16, 9]), &options);
    }
}
