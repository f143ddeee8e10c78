//! Saved state, in memory: every scene continues to its own bits, and no state is forgotten.

use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

use serde::{Deserialize, Serialize};
use siloflow::dem::persist;
use siloflow::lattice::gas::Gas;
use siloflow::lattice::sites::Sites;
use siloflow::output::summary::lattice;
use siloflow::prelude::*;
use siloflow::scene::loaded::AnyScene;

use crate::{hash, load, pins, root, simulation};

/// Runs a scene to its end, saved and restored with another number of threads once or twice on the way.
fn interrupted(row: &pins::Row) -> Option<u64> {
    let registry = Registry::default();
    let threads = |count: usize| NonZeroUsize::new(count).unwrap();
    match row.load().ok()? {
        AnyScene::Lattice(loaded) => {
            let mut run = Simulation::of_lattice(&loaded, &registry, threads(1)).ok()?;
            for (border, count) in [(loaded.scene.until / 3, 2), (loaded.scene.until / 2, 1)] {
                run.run_steps(border);
                run = Simulation::restored_lattice(&loaded, &registry, threads(count), &run.save().unwrap()).unwrap();
            }
            run.run();
            Some(lattice::state_hash(run.world().resource::<Sites>(), run.world().resource::<Gas>()))
        }
        AnyScene::Grains(loaded) => {
            let mut run = Simulation::new(&loaded, &registry, threads(1)).ok()?;
            let steps = (loaded.scene.until.get() / loaded.step()) as u64;
            for (border, count) in [(steps / 3 + 1, 2), (steps / 2 + 2, 1)] {
                if run.run_steps(border).is_some() {
                    break;
                }
                run = Simulation::restored(&loaded, &registry, threads(count), &run.save().unwrap()).unwrap();
            }
            run.run();
            Some(hash(&mut run))
        }
    }
}

#[test]
fn every_scene_continues_to_its_pinned_hash() {
    use rayon::prelude::*;
    let wrong: Vec<_> = pins::rows_of_this_target()
        .par_iter()
        .with_max_len(1)
        .filter_map(|row| {
            let found = format!("{:016x}", interrupted(row)?);
            (found != row.hash).then(|| format!("{row:?}: {found}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn all_written_state_of_every_scene_is_registered() {
    for row in pins::rows_of_this_target() {
        let registry = Registry::default();
        let one = NonZeroUsize::MIN;
        let run = match row.load().unwrap() {
            AnyScene::Lattice(loaded) => Simulation::of_lattice(&loaded, &registry, one),
            AnyScene::Grains(loaded) => Simulation::new(&loaded, &registry, one),
        };
        // The scene may refuse the scheme.
        let Ok(mut run) = run else { continue };
        run.run_steps(3);
        assert_eq!(persist::unregistered(run.world_mut()), BTreeMap::new(), "{row:?}");
    }
}

/// Saves the state of a shipped scene after some steps.
fn saved(scene: &str, settings: &[(&str, &str)], steps: u64) -> (AnyScene, Vec<persist::Section>) {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let scene = siloflow::scene::load::any(&crate::scene(scene), &settings).unwrap();
    let registry = Registry::default();
    let one = NonZeroUsize::MIN;
    let mut run = match &scene {
        AnyScene::Grains(loaded) => Simulation::new(loaded, &registry, one),
        AnyScene::Lattice(loaded) => Simulation::of_lattice(loaded, &registry, one),
    }
    .unwrap();
    run.run_steps(steps);
    let sections = run.save().unwrap();
    (scene, sections)
}

/// Restores a state and does three steps.
fn continued(scene: &AnyScene, sections: &[persist::Section]) -> Result<(), String> {
    let registry = Registry::default();
    let one = NonZeroUsize::MIN;
    let run = match scene {
        AnyScene::Grains(loaded) => Simulation::restored(loaded, &registry, one, sections),
        AnyScene::Lattice(loaded) => Simulation::restored_lattice(loaded, &registry, one, sections),
    };
    let mut run = run.map_err(|fault| fault.to_string())?;
    let done = run.world().resource::<Clock>().steps;
    run.run_steps(done + 3);
    Ok(())
}

#[test]
fn a_state_that_no_run_of_the_scene_has_is_refused_with_its_part() {
    let bed = saved("hard/pressed-door.ron", &[("fill[0].count", "40")], 5);
    let fed = saved("fed-hopper.ron", &[("feed[0].rate", "Mass(40.0)")], 40);
    let gas = saved("funnel-flow.ron", &[], 5);
    let not_finite = f64::NAN.to_le_bytes();
    // The part of the state, how many bytes at its end are replaced, by what, and words of the message.
    let cases: [(&(AnyScene, Vec<persist::Section>), &str, usize, &[u8], &str); 9] = [
        (&bed, "WallIndex", 1, &[99], "wall surface 99"),
        (&bed, "Position<", 8, &not_finite, "not finite"),
        (&bed, "Velocity<", 8, &f64::INFINITY.to_le_bytes(), "not finite"),
        (&bed, "particle::Radius", 8, &0.0_f64.to_le_bytes(), "not positive"),
        (&bed, "particle::GrainId", 1, &[7], "particle"),
        (&bed, "step::Clock", 1, &[0], ""),
        (&fed, "history::History", 8, &not_finite, "not finite"),
        (&fed, "pending::Pending", 1, &[3], "still to come"),
        (&gas, "gas::Gas", 1, &[0xff, 0xff, 0x7f], "no gas can have"),
    ];
    for ((scene, sections), part, replaced, bytes, word) in cases {
        continued(scene, sections).unwrap();
        let mut changed = sections.clone();
        let place = changed.iter().position(|(name, _)| name.contains(part)).expect(part);
        let state = &mut changed[place].1;
        state.truncate(state.len() - replaced);
        state.extend_from_slice(bytes);
        // A clock before step zero is one that a run can have, and any state may go on without a panic.
        let problem = continued(scene, &changed).err().unwrap_or_default();
        assert!(problem.contains(word) && problem.is_empty() == word.is_empty(), "{part}: {problem}");
        // State that is missing is no fresh start.
        changed.remove(place);
        let problem = continued(scene, &changed).unwrap_err();
        assert!(problem.contains("it lacks") && problem.contains(part), "{part}: {problem}");
    }
}

/// A behaviour with state of every kind.
#[derive(Deserialize)]
struct Ageing {
    saves: bool,
}

/// The age of a grain, s.
#[derive(Component, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Age(f64);

/// Numbers of steps, and of grains seen as new.
#[derive(Resource, Default, Debug, PartialEq, Clone, Serialize, Deserialize)]
struct Counts {
    steps: u64,
    new: u64,
}

/// For how long each contact has lasted, s.
#[derive(Resource, Default, Serialize, Deserialize)]
struct Contacts(PairMap<f64>);

fn begin(mut commands: Commands, mut counts: ResMut<Counts>, grains: Query<Entity, Added<Grain>>) {
    for grain in &grains {
        counts.new += 1;
        commands.entity(grain).insert(Age(0.0));
    }
}

fn age(clock: Res<Clock>, mut counts: ResMut<Counts>, mut ages: Query<(&mut Age, &mut Force, &Velocity)>) {
    counts.steps += 1;
    for (mut age, mut force, velocity) in &mut ages {
        age.0 += clock.dt;
        // A force that depends on the age, so that a wrong age changes the motion.
        force.0 -= 0.01 * age.0 * velocity.0;
    }
}

fn watch(contacts: ContactView, clock: Res<Clock>, mut durations: ResMut<Contacts>) {
    durations.0.visit(&contacts, |_, duration| *duration += clock.dt);
}

impl Behaviour for Ageing {
    fn build(self: Box<Self>, app: &mut App) {
        app.init_resource::<Counts>().init_resource::<Contacts>();
        if self.saves {
            app.persist::<Counts>().persist::<Contacts>().persist_component::<Age>();
        }
        app.add_systems(
            Step,
            (begin.in_set(Phase::Spawn), age.in_set(ForceStage::Added), watch.in_set(Phase::Observe)),
        );
    }
}

fn ageing(saves: bool) -> (Loaded, Registry) {
    let mut registry = Registry::default();
    registry.register::<Ageing>("ageing");
    let settings =
        [("spawner.count", "60"), ("until", "1.0"), ("behaviours", &*format!("{{\"ageing\": (saves: {saves})}}"))];
    (load("silo1.ron", &settings), registry)
}

#[test]
fn state_of_behaviours_is_saved_and_old_grains_are_not_new() {
    let (loaded, registry) = ageing(true);
    let state = |run: &mut Simulation| {
        let end = run.run();
        let hash = hash(run);
        let world = run.world_mut();
        let mut ages: Vec<_> = world.query::<(&GrainId, &Age)>().iter(world).map(|(id, age)| (*id, *age)).collect();
        ages.sort_by_key(|(id, _)| *id);
        let contacts = world.resource::<Contacts>().0.len();
        (end, hash, ages, world.resource::<Counts>().clone(), contacts)
    };
    let expected = state(&mut Simulation::new(&loaded, &registry, NonZeroUsize::MIN).unwrap());
    assert_eq!((expected.2.len(), expected.3.new), (20, 20));
    let mut run = Simulation::new(&loaded, &registry, NonZeroUsize::MIN).unwrap();
    run.run_steps(700);
    assert!(persist::unregistered(run.world_mut()).is_empty());
    let saved = run.save().unwrap();
    let mut restored = Simulation::restored(&loaded, &registry, NonZeroUsize::MIN, &saved).unwrap();
    assert_eq!(state(&mut restored), expected);
    // Saving has changed nothing.
    assert_eq!(state(&mut run), expected);
}

#[test]
fn forgotten_state_of_a_behaviour_is_found() {
    let (loaded, registry) = ageing(false);
    let mut run = Simulation::new(&loaded, &registry, NonZeroUsize::MIN).unwrap();
    run.run_steps(100);
    let found = persist::unregistered(run.world_mut());
    let names: Vec<_> = found.keys().map(|name| name.rsplit("::").next().unwrap()).collect();
    assert_eq!(names, ["Age", "Contacts", "Counts"], "{found:?}");
    assert!(
        found
            .values()
            .any(|state| state.writer.as_ref().is_some_and(|system| system.contains("age")) && !state.is_resource),
        "{found:?}"
    );
}

#[test]
fn state_of_another_scene_is_refused() {
    let frictionless = load("silo1.ron", &[]);
    let rough = load("couette.ron", &[]);
    let mut run = simulation(&rough, 1);
    run.run_steps(10);
    let saved = run.save().unwrap();
    let refused = Simulation::restored(&frictionless, &Registry::default(), NonZeroUsize::MIN, &saved);
    assert_eq!(refused.map(|_| ()).unwrap_err().code(), "checkpoint::state");
}

/// Places where state could hide from access lists, each with the reason why it may.
const HIDDEN: [(&str, &str); 12] = [
    ("budget.rs", "the time of checks, which end before a run begins"),
    ("contact/force_pass/exchange.rs", "the forces that the threads of one pass hand over"),
    ("survey/pair_forces.rs", "Local<'s, Vec<V>>: emptied before each use"),
    ("store/renumbering.rs", "Local<u64>: decides about the order of table rows only"),
    ("png/drawing.rs", "static: the fonts"),
    ("disk.rs", "static: the observer of operations on files"),
    ("collisions.rs", "static: the collision table"),
    ("threads.rs", "atomic counters of one job; whether a thread polls or waits"),
    ("threads/trace.rs", "the times of passes, which only a benchmark asks for"),
    ("ending/request.rs", "the flag of signals"),
    ("simulation/stepping.rs", "the flag of signals"),
    ("cli/", "signals and progress"),
];

#[test]
fn no_state_hides_from_access_lists() {
    let mut found = Vec::new();
    for of_crate in ["dem", "figures", "files", "lattice", "results", "text"] {
        let sources = root().join("crates").join(of_crate).join("src");
        search(&sources, &sources, &mut found);
    }
    search(&root().join("src"), &root().join("src"), &mut found);
    let unknown: Vec<_> =
        found.iter().filter(|path| !HIDDEN.iter().any(|(known, _)| path.starts_with(known))).collect();
    assert!(unknown.is_empty(), "a Local, static or cell in {unknown:?}: keep the state in a resource and register it");
}

/// Adds the sources that declare a `Local`, a `static` or a cell.
fn search(directory: &Path, sources: &Path, found: &mut Vec<String>) {
    for path in fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            search(&path, sources, found);
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.lines().take_while(|line| !line.starts_with("#[cfg(test)]"));
        let hides = |line: &str| {
            let code = line.split("//").next().unwrap_or_default().trim_start();
            let declares = code.starts_with("static ") || code.starts_with("pub static ");
            let names = ["Local<", "thread_local!", "OnceLock", "OnceCell", "RefCell", "Atomic"];
            declares || !code.starts_with("use ") && names.iter().any(|name| code.contains(name))
        };
        if code.into_iter().any(hides) {
            let relative = path.strip_prefix(sources).unwrap();
            found.push(relative.to_string_lossy().replace('\\', "/"));
        }
    }
}

#[test]
fn a_run_can_be_saved_after_every_step() {
    let loaded = load("silo1.ron", &[("spawner.count", "3"), ("until", "0.6")]);
    let mut straight = simulation(&loaded, 1);
    straight.run();
    let mut run = simulation(&loaded, 1);
    for steps in 1.. {
        if run.run_steps(steps).is_some() {
            break;
        }
        run = Simulation::restored(&loaded, &Registry::default(), NonZeroUsize::MIN, &run.save().unwrap()).unwrap();
    }
    assert_eq!(hash(&mut run), hash(&mut straight));
}
