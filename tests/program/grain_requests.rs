//! Requests of behaviours that make, unmake and change grains, and parameters that only add forces.

use std::num::NonZeroUsize;
use std::path::Path;

use serde::{Deserialize, Serialize};
use siloflow::dem::space::Rotor as _;
use siloflow::energy::EnergyFlows;
use siloflow::grain_requests::{self, ReasonFigures};
use siloflow::measure::totals;
use siloflow::output::state_hash;
use siloflow::prelude::*;

/// A request of the behaviour `script` at the end of a step.
#[derive(Clone, Debug, Deserialize)]
enum Act {
    /// Grain 1 breaks into two pieces of half its radius at these places from its centre, m.
    Break(Vec<(f64, f64)>),
    /// Grains 2 and 3 become part of grain 1.
    Merge,
    /// Grain 1 gets a radius (m), its mass grows with the square.
    Resize(f64),
    /// This grain goes.
    Remove(u32),
    /// A grain comes at a place, m, with a radius, m.
    Create((f64, f64), f64),
    /// Grain 1 breaks into no pieces.
    Nothing,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Script {
    /// Step, act and reason.
    acts: Vec<(u64, Act, String)>,
    /// From this step on the radius of grain 1 grows by this factor in each step.
    #[serde(default)]
    grows: Option<(u64, f64)>,
}

fn id(number: u32) -> GrainId {
    GrainId::grain(number).unwrap()
}

impl Behaviour for Script {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        in_space!(app, V => {
            let script = self.clone();
            let act = move |clock: Res<Clock>, particles: Particles<V>, mut requests: GrainRequests<V>| {
                for (_, act, reason) in script.acts.iter().filter(|(step, ..)| *step == clock.steps) {
                    ask(act, reason, &particles, &mut requests);
                }
                if let Some((from, factor)) = script.grows.filter(|(from, _)| clock.steps >= *from) {
                    let row = particles.grains().find(|&row| particles.id(row) == id(1)).unwrap();
                    let _ = from;
                    requests.resize(id(1), particles.radius(row) * factor, particles.mass(row), "growth");
                }
            };
            app.add_systems(Step, act.in_set(Phase::Control))
        });
    }
}

fn ask<V: Space>(act: &Act, reason: &str, particles: &Particles<V>, requests: &mut GrainRequests<V>) {
    let place = |(x, y): (f64, f64)| V::narrow(Solid::new(x, y, 0.0));
    let first = || particles.grains().find(|&row| particles.id(row) == id(1)).unwrap();
    match act {
        Act::Break(places) => {
            let radius = 0.5 * particles.radius(first());
            requests.split(id(1), places.iter().map(|&at| Piece::new(place(at), radius)), reason);
        }
        Act::Merge => requests.merge(id(1), [id(3), id(2)], None, reason),
        Act::Resize(radius) => {
            let row = first();
            let ratio = radius / particles.radius(row);
            requests.resize(id(1), *radius, particles.mass(row) * ratio * ratio, reason);
        }
        Act::Remove(number) => requests.remove(id(*number), reason),
        Act::Create(at, radius) => requests.create(NewGrain::new(place(*at), *radius), reason),
        Act::Nothing => requests.split(id(1), [], reason),
    }
}

/// Pulls with F = -k x, N.
#[derive(Clone, Copy, Deserialize)]
struct Pull(f64);

impl Behaviour for Pull {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, app: &mut App) {
        in_space!(app, V => {
            let pull = move |mut grains: AddForce<V, &'static Position<V>>| grains.each(|x| x.0 * -self.0);
            app.add_systems(Step, pull.in_set(ForceStage::Added))
        });
    }
}

/// Notes the grains that were made, each with the one of which it is a piece.
#[derive(Deserialize)]
struct Listen();

#[derive(Resource, Default, Debug, PartialEq, Deserialize, Serialize)]
struct Made(Vec<(u32, Option<u32>)>);

impl Behaviour for Listen {
    fn build(self: Box<Self>, app: &mut App) {
        let note =
            |mut new: MessageReader<GrainMade>, present: Query<&GrainId, With<Grain>>, mut made: ResMut<Made>| {
                for GrainMade { id, parent, .. } in new.read() {
                    assert!(present.iter().any(|other| other == id));
                    made.0.push((id.number(), parent.map(GrainId::number)));
                }
            };
        app.init_resource::<Made>().persist::<Made>().add_systems(Step, note.in_set(Phase::Spawn));
    }
}

/// Pushes with the raw component.
#[derive(Deserialize)]
struct Raw();

impl Behaviour for Raw {
    fn build(self: Box<Self>, app: &mut App) {
        fn push(mut grains: Query<&mut Force, With<Grain>>) {
            grains.iter_mut().for_each(|mut force| force.0.x += 1.0);
        }
        app.add_systems(Step, push.in_set(ForceStage::Added));
    }
}

fn registry() -> Registry {
    let mut registry = Registry::default();
    registry.register::<Script>("script").register::<Script>("script_b").register::<Pull>("pull");
    registry.register::<Pull>("pull_b").register::<Raw>("raw").register::<Listen>("listen");
    registry
}

const LAW: &str =
    "contact: Linear(k: 1.0e4, damping: B(0.0), tangential: Spring(k: 1.0e4, damping: B(0.0), friction: 0.5))";

/// Three spinning discs (spheres) apart from each other, with these keys.
fn three(space: Dimension, keys: &str) -> Simulation {
    let [columns, zeros, spins, gravity] = match space {
        Dimension::Plane => ["id,radius,mass,x,y,vx,vy,wz", "", "", "(0.0, 0.0)"],
        Dimension::Solid => ["id,radius,mass,x,y,z,vx,vy,vz,wx,wy,wz", ",0.0", ",1.0,2.0", "(0.0, 0.0, 0.0)"],
    };
    let here = tempfile::tempdir().unwrap();
    let row = |[number, radius, mass, x, y, vx, vy, w]: [f64; 8]| {
        format!("{number},{radius},{mass},{x},{y}{zeros},{vx},{vy}{zeros}{spins},{w}\n")
    };
    let rows = [
        [1.0, 0.1, 1.0, 0.0, 0.0, 1.0, 0.0, 3.0],
        [2.0, 0.2, 3.0, 1.0, 0.5, -1.0, 2.0, -1.0],
        [3.0, 0.1, 2.0, -1.0, 0.5, 0.0, -1.0, 4.0],
    ];
    let text: String = rows.map(row).concat();
    std::fs::write(here.path().join("three.csv"), format!("{columns}\n{text}")).unwrap();
    let scene = format!(
        "(space: {space:?}, gravity: {gravity}, {LAW}, mass: Disc(100.0), step: Fixed(1.0e-3), until: 0.1, \
          grains: (file: \"three.csv\"), pictures: None, {keys})"
    );
    simulation(here.path(), scene)
}

fn simulation(here: &Path, scene: String) -> Simulation {
    let loaded =
        load::from_text("requests.ron", "requests", here, scene, &[]).unwrap_or_else(|fault| panic!("{fault}"));
    Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).unwrap_or_else(|fault| panic!("{fault}"))
}

/// Mass, momentum and angular momentum about the origin.
fn motion<V: Space>(run: &mut Simulation) -> (f64, V, V::Spin) {
    let world = run.world_mut();
    let mut grains =
        world.query_filtered::<(&Mass, &Position<V>, &Velocity<V>, &Spin<V::Spin>, &Inertia), With<Grain>>();
    let zero = (0.0, V::ZERO, V::Spin::default());
    grains.iter(world).fold(zero, |(mass, momentum, angular), (m, x, v, w, i)| {
        (mass + m.0, momentum + v.0 * m.0, angular + x.0.cross(v.0) * m.0 + w.0 * i.0)
    })
}

fn figures(run: &mut Simulation, reason: &str) -> ReasonFigures {
    grain_requests::figures(run.world()).remove(reason).unwrap_or_else(|| panic!("nothing was booked for `{reason}`"))
}

fn balance_error(run: &mut Simulation) -> f64 {
    let world = run.world_mut();
    totals::of_world(world).energy() - world.resource::<EnergyFlows>().expected()
}

#[test]
fn a_split_keeps_mass_and_momentum_and_the_pieces_fly_as_parts_of_the_grain() {
    fn check<V: Space>() {
        let acts = "behaviours: {\"script\": (acts: [(5, Break([(0.06, 0.0), (-0.05, 0.04)]), \"crack\")])}";
        let mut run = three(V::DIMENSION, acts);
        run.run_steps(5);
        let before = motion::<V>(&mut run);
        run.run_steps(6);
        let after = motion::<V>(&mut run);
        assert!((after.0 - before.0).abs() < 1e-14);
        assert!((after.1 - before.1).length() < 1e-14);
        let crack = figures(&mut run, "crack");
        assert_eq!((crack.made, crack.removed, crack.dropped), (2, 1, 0));
        let world = run.world_mut();
        let mut grains = world
            .query_filtered::<(&GrainId, &Radius, &Mass, &Position<V>, &Velocity<V>, &Spin<V::Spin>), With<Grain>>();
        let mut pieces: Vec<_> = grains.iter(world).filter(|grain| grain.0.number() > 3).collect();
        pieces.sort_unstable_by_key(|piece| *piece.0);
        assert_eq!(pieces.iter().map(|piece| piece.0.number()).collect::<Vec<_>>(), [4, 5]);
        let [a, b] = [pieces[0], pieces[1]];
        assert!((a.1.0, a.2.0) == (0.05, 0.5) && (b.1.0, b.2.0) == (0.05, 0.5));
        // Without gravity: x = x_0 + v t of the grain, and the pieces fly one step with v + w x r about their middle.
        let spin = a.5.0;
        let way = a.3.0 - b.3.0 - (a.4.0 - b.4.0) * 1e-3;
        assert!((way - V::narrow(Solid::new(0.11, -0.04, 0.0))).length() < 1e-14, "{way:?}");
        assert!((a.4.0 - b.4.0 - way.turned_by(spin)).length() < 1e-13);
        assert!(balance_error(&mut run).abs() < 1e-12);
        let ledger = run.world().resource::<Ledger>();
        assert_eq!((ledger.released, ledger.inside(), ledger.removed, ledger.lost()), (5, 4, 1, 0));
    }
    check::<Plane>();
    check::<Solid>();
}

#[test]
fn a_merger_keeps_mass_momentum_and_angular_momentum() {
    fn check<V: Space>() {
        let mut run = three(V::DIMENSION, "behaviours: {\"script\": (acts: [(5, Merge, \"sinter\")])}");
        run.run_steps(5);
        let energy = totals::of_world(run.world()).energy();
        let before = motion::<V>(&mut run);
        run.run_steps(6);
        let after = motion::<V>(&mut run);
        assert!((after.0 - before.0).abs() < 1e-14);
        assert!((after.1 - before.1).length() < 1e-14);
        assert!((after.2 - before.2).length_squared() < 1e-26, "{before:?} {after:?}");
        let world = run.world_mut();
        let (grain, radius, mass) =
            world.query_filtered::<(&GrainId, &Radius, &Mass), With<Grain>>().single(world).unwrap();
        let expected = match V::DIMENSION {
            Dimension::Plane => 0.06f64.sqrt(),
            Dimension::Solid => 0.01f64.cbrt(),
        };
        assert_eq!((grain.number(), mass.0), (1, 6.0));
        assert!((radius.0 - expected).abs() < 1e-15);
        // The energy that the merger takes is booked.
        assert!(balance_error(&mut run).abs() < 1e-12);
        let sinter = figures(&mut run, "sinter");
        assert_eq!((sinter.made, sinter.removed, sinter.resized), (0, 2, 1));
        let gained = totals::of_world(run.world()).energy() - energy;
        assert!((sinter.energy_j / gained - 1.0).abs() < 1e-12 && sinter.elastic_j == 0.0, "{sinter:?}, {gained} J");
    }
    check::<Plane>();
    check::<Solid>();
}

#[test]
fn growth_under_load_is_booked_to_the_order_of_the_scheme() {
    // A disc between two floors grows by a factor in each step and presses against both.
    let error = |dt: f64| {
        let here = tempfile::tempdir().unwrap();
        std::fs::write(here.path().join("one.csv"), "id,radius,mass,x,y,vx,vy,wz\n1,0.1,1.0,0.0,0.1,0.0,0.3,0.0\n")
            .unwrap();
        let factor = 1.0 + 0.2 * dt;
        let scene = format!(
            "(gravity: (0.0, -9.81), {LAW}, step: Fixed({dt:?}), until: 0.2, grains: (file: \"one.csv\"), pictures: None, integrator: Verlet, \
              walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), HalfPlane(point: (0.0, 0.201), normal: (0.0, -1.0))], \
              behaviours: {{\"script\": (acts: [], grows: (0, {factor:?}))}})"
        );
        let mut run = simulation(here.path(), scene);
        assert_eq!(run.run(), End::TimeReached);
        let growth = figures(&mut run, "growth");
        assert!(growth.elastic_j > 0.05 && growth.mass_kg == 0.0, "{growth:?}");
        balance_error(&mut run).abs()
    };
    let [coarse, fine] = [2e-4, 1e-4].map(error);
    // The elastic energy of each step's growth is booked exactly in its place; what is left is the oscillating error of Verlet, (w dt)^2/8 of the
    // energy with w^2 = 2 k/m, and so at most 2e4 dt^2/8 of some 1 J.
    assert!(coarse < 2e4 * 4e-8 / 8.0 && fine < 2e4 * 1e-8 / 8.0, "{coarse} {fine}");
}

#[test]
fn a_grain_that_breaks_under_load_leaves_an_error_of_first_order() {
    let error = |dt: f64| {
        let here = tempfile::tempdir().unwrap();
        std::fs::write(here.path().join("one.csv"), "id,radius,mass,x,y,vx,vy,wz\n1,0.1,1.0,0.0,0.1,0.5,-1.0,2.0\n")
            .unwrap();
        let step = (5e-3 / dt).round();
        let scene = format!(
            "(gravity: (0.0, -9.81), {LAW}, step: Fixed({dt:?}), until: 0.02, grains: (file: \"one.csv\"), pictures: None, \
              walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
              behaviours: {{\"script\": (acts: [({step}, Break([(0.04, -0.05), (-0.04, -0.05)]), \"crack\")])}})"
        );
        let mut run = simulation(here.path(), scene);
        assert_eq!(run.run(), End::TimeReached);
        let crack = figures(&mut run, "crack");
        // The floor and the other piece press the pieces.
        assert!(crack.elastic_j.abs() > 0.05, "{crack:?}");
        balance_error(&mut run).abs()
    };
    let [coarse, fine] = [2e-5, 1e-5].map(error);
    // The force of new overlaps begins a step late: F v dt, with forces below 200 N and speeds below 2 m/s.
    assert!(coarse < 200.0 * 2.0 * 2e-5 && (1.5..2.5).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn requests_of_two_behaviours_for_one_grain_do_not_depend_on_their_order() {
    let run = |first: &str, second: &str| {
        let script = |acts: &str| format!("(acts: [{acts}])");
        let keys = format!("behaviours: {{\"script\": {}, \"script_b\": {}}}", script(first), script(second));
        let mut run = three(Dimension::Plane, &keys);
        assert_eq!(run.run(), End::TimeReached);
        assert!(balance_error(&mut run).abs() < 1e-12);
        let ledger = run.world().resource::<Ledger>();
        let counts = (ledger.released, ledger.inside(), ledger.removed);
        (state_hash::of_world(run.world_mut()), counts, grain_requests::figures(run.world()))
    };
    let eat = "(5, Remove(1), \"eaten\")";
    let crack = "(5, Break([(0.06, 0.0), (-0.05, 0.04)]), \"crack\")";
    let sinter = "(5, Merge, \"sinter\")";
    let grow = "(5, Resize(0.11), \"growth\")";
    let two = "(5, Create((0.0, 2.0), 0.1), \"rain\"), (5, Create((0.0, 3.0), 0.1), \"rain\")";
    let owt = "(5, Create((0.0, 3.0), 0.1), \"rain\"), (5, Create((0.0, 2.0), 0.1), \"rain\")";
    for (first, second) in [(eat, crack), (sinter, crack), (crack, grow), (eat, sinter), (two, grow)] {
        assert_eq!(run(first, second), run(second, first), "{first} {second}");
    }
    assert_eq!(run(two, eat), run(owt, eat));
    let (_, counts, all) = run(crack, eat);
    assert_eq!(counts, (3, 2, 1));
    assert_eq!((all["crack"].dropped, all["crack"].made, all["eaten"].removed), (1, 0, 1));
    let (_, counts, all) = run(&format!("{two}, {grow}"), eat);
    assert_eq!((counts, all["rain"].made, all["growth"].dropped), ((5, 4, 1), 2, 1));
    // 100 kg/m^2 pi R^2 each.
    assert!((all["rain"].mass_kg - 2.0 * std::f64::consts::PI).abs() < 1e-14);
}

#[test]
fn requests_that_make_no_sense_stop_the_run() {
    for (act, expected) in [
        ("Nothing, \"crack\"", "`crack` has no pieces"),
        ("Resize(-0.1), \"growth\"", "a radius of -0.1, which is not above zero"),
        ("Create((0.0, 2.0), 0.0), \"rain\"", "a radius of 0"),
        ("Remove(1), \"Eaten!\"", "`Eaten!` is no reason"),
    ] {
        let mut run = three(Dimension::Plane, &format!("behaviours: {{\"script\": (acts: [(5, {act})])}}"));
        let End::Failed(Failure::Behaviour(text)) = run.run() else { panic!("{act} was carried out") };
        assert!(text.contains(expected) && text.contains("step 5"), "{text}");
    }
    // A grain that is not there any more is no error.
    let mut run = three(Dimension::Plane, "behaviours: {\"script\": (acts: [(5, Remove(9), \"eaten\")])}");
    assert_eq!(run.run(), End::TimeReached);
    assert_eq!(figures(&mut run, "eaten").dropped, 1);
}

#[test]
fn behaviours_hear_of_new_grains_and_add_forces_in_one_scene() {
    let acts = "\"script\": (acts: [(5, Break([(0.06, 0.0), (-0.05, 0.04)]), \"crack\"), (7, Create((0.0, 2.0), 0.1), \"rain\")])";
    let run = |keys: &str| {
        let mut run = three(Dimension::Plane, &format!("behaviours: {{{keys}, {acts}, \"listen\": ()}}"));
        assert_eq!(run.run(), End::TimeReached);
        assert_eq!(run.world().resource::<Made>().0, [(4, Some(1)), (5, Some(1)), (6, None)]);
        run
    };
    let mut both = run("\"pull\": (2.0), \"pull_b\": (3.0)");
    let mut one = run("\"pull\": (5.0)");
    let place = |run: &mut Simulation| {
        let world = run.world_mut();
        let mut grains: Vec<_> = world
            .query_filtered::<(&GrainId, &Position), With<Grain>>()
            .iter(world)
            .map(|(id, x)| (*id, x.0))
            .collect();
        grains.sort_unstable_by_key(|grain| grain.0);
        grains
    };
    // The same force, up to its rounding over 100 steps.
    for (a, b) in place(&mut both).into_iter().zip(place(&mut one)) {
        assert!(a.0 == b.0 && (a.1 - b.1).length() < 1e-14, "{a:?} {b:?}");
    }
}

#[test]
fn a_system_that_may_set_forces_is_refused_beside_others_and_the_parameter_is_named() {
    let scene = format!(
        "(gravity: (0.0, 0.0), {LAW}, step: Fixed(1.0e-3), until: 0.1, grains: (file: \"free-fall.csv\"), pictures: None, \
          behaviours: {{\"raw\": (), \"pull\": (1.0)}})"
    );
    let loaded = load::from_text("raw.ron", "raw", &crate::root().join("scenes"), scene, &[]).unwrap();
    let fault = Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).map(|_| ()).unwrap_err();
    assert_eq!(fault.code(), "behaviour::schedule");
    assert!(fault.remedy().is_some_and(|help| help.contains("`AddForce`")), "{fault:?}");
}

#[test]
fn shaped_grains_split_into_shaped_pieces_and_merge_with_their_angular_momentum() {
    #[derive(Deserialize)]
    struct Rods();
    impl Behaviour for Rods {
        fn lives_in(&self, _: Dimension) -> bool {
            true
        }
        fn build(self: Box<Self>, app: &mut App) {
            fn act(
                clock: Res<Clock>,
                rods: Query<(&GrainId, &Orientation<Solid>)>,
                mut requests: GrainRequests<Solid>,
            ) {
                if clock.steps == 3 {
                    let turn = rods.iter().find(|(grain, _)| **grain == id(1)).unwrap().1;
                    let piece = |side: f64| Piece {
                        shape: Some((Shape(0), *turn)),
                        ..Piece::new(turn.0.turn(Solid::new(side * 0.02, 0.0, 0.0)), 0.004)
                    };
                    requests.split(id(1), [piece(1.0), piece(-1.0)], "crack");
                    requests.merge(id(2), [id(3)], None, "sinter");
                }
            }
            app.add_systems(Step, act.in_set(Phase::Control));
        }
    }
    let mut registry = registry();
    registry.register::<Rods>("rods");
    let scene = "(space: Solid, gravity: (0.0, 0.0, 0.0), seed: 3, mass: Sphere(2000.0), step: Fixed(1.0e-4), until: 0.01, pictures: None,
          contact: Linear(k: 2.0e4, damping: B(0.0), tangential: Spring(k: 5.7e3, damping: B(0.0), friction: 0.5)),
          shapes: {\"rod\": Capsule(length: 0.03, diameter: 0.01, spheres: 4)},
          fill: [(low: (0.0, 0.0, 0.0), high: (0.6, 0.6, 0.6), place: Random, count: 3, shape: \"rod\", agitation: (1.0, 1.0, 1.0))],
          behaviours: {\"rods\": ()})";
    let loaded = load::from_text("rods.ron", "rods", Path::new(""), scene.to_owned(), &[])
        .unwrap_or_else(|fault| panic!("{fault}"));
    let mut run = Simulation::new(&loaded, &registry, NonZeroUsize::MIN).unwrap_or_else(|fault| panic!("{fault}"));
    let sums = |run: &mut Simulation| {
        let world = run.world_mut();
        let store = world.resource::<siloflow::dem::store::ParticleStore<Solid>>();
        let rows = store.integrated_rows().filter(|&row| store.id[row] != id(1) && store.id[row].number() < 4);
        let angular = rows.fold(Solid::ZERO, |sum, row| {
            let body = &store.body[row];
            sum + Space::cross(body.position, body.velocity) * store.mass[row] + store.angular_momentum(row)
        });
        let all = store.integrated_rows();
        let momentum = all.clone().fold(Solid::ZERO, |sum, row| sum + store.body[row].velocity * store.mass[row]);
        (angular, momentum, all.map(|row| store.mass[row]).sum::<f64>())
    };
    run.run_steps(3);
    let before = sums(&mut run);
    run.run_steps(4);
    let after = sums(&mut run);
    let scale = before.0.length();
    assert!((before.0 - after.0).length() < 1e-12 * scale, "{before:?} {after:?}");
    assert!((before.1 - after.1).length() < 1e-12 * before.1.length() && (before.2 - after.2).abs() < 1e-15);
    assert!(balance_error(&mut run).abs() < 1e-12 * before.2);
    let all = grain_requests::figures(run.world());
    assert_eq!((all["crack"].made, all["crack"].removed), (2, 1));
    assert_eq!((all["sinter"].resized, all["sinter"].removed), (1, 1));
    assert_eq!(run.world_mut().query_filtered::<&Shape, With<Grain>>().iter(run.world()).count(), 3);
    assert_eq!(run.run(), End::TimeReached);
}
