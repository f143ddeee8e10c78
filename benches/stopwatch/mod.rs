//! A stopwatch for the systems of a step: measures the time of each system within whole steps of a running simulation.
//!
//! Behind every system of the schedule [`Step`] it inserts a small system that reads the clock, in the existing order
//! of execution. The cost of run conditions counts for their system. A reading costs about 50 ns, and a step has about
//! thirty.

#![allow(dead_code, reason = "each benchmark uses a part of it")]

use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SystemKey;
use siloflow::dem::step;
use siloflow::dem::threads::Threads;
use siloflow::dem::threads::trace::Passes;
use siloflow::prelude::*;

/// Parts of a step that are distinguished.
pub const PARTS: [(&str, Part); 10] = [
    ("grains enter, slots", Part::Phase(Phase::Spawn)),
    ("drift", Part::Phase(Phase::Drift)),
    ("neighbour list", Part::Phase(Phase::Neighbours)),
    ("contacts", Part::Stage(ForceStage::Contacts)),
    ("components of forces", Part::Sync(Phase::Forces)),
    ("kick", Part::Phase(Phase::Kick)),
    ("energy balance, finite values", Part::Phase(Phase::Control)),
    ("paths, culling, ledger, end, watchdog", Part::Phase(Phase::Cull)),
    ("outputs", Part::Phase(Phase::Observe)),
    ("forces added", Part::Stage(ForceStage::Added)),
];

/// A phase or one stage of the forces.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    /// A phase with all its systems.
    Phase(Phase),
    /// The copying of components before and after a phase.
    Sync(Phase),
    /// A stage of [`Phase::Forces`].
    Stage(ForceStage),
}

/// A system: its name without generic arguments, and the number of its part in [`PARTS`].
#[derive(Clone, Debug)]
pub struct Entry {
    pub name: String,
    pub part: Option<usize>,
}

/// Accumulated times of all systems.
#[derive(Resource)]
pub struct Stopwatch {
    /// Systems in their order of execution.
    pub systems: Vec<Entry>,
    /// Time of each system since the last call of [`reset`](Self::reset).
    pub spent: Vec<Duration>,
    /// Passes that threads share in each system since then, if the threads have a trace.
    pub passes: Vec<Passes>,
    last: Instant,
    last_passes: Passes,
}

impl Stopwatch {
    fn lap(&mut self, system: usize, passes: Passes) {
        let now = Instant::now();
        self.spent[system] += now - std::mem::replace(&mut self.last, now);
        let new = passes.since(std::mem::replace(&mut self.last_passes, passes));
        self.passes[system] = sum([self.passes[system], new]);
    }

    /// Sets all times to zero.
    pub fn reset(&mut self) {
        self.spent.fill(Duration::ZERO);
        self.passes.fill(Passes::default());
    }

    /// Returns the time in all systems.
    pub fn total(&self) -> Duration {
        self.spent.iter().sum()
    }

    /// Returns the time in a part, given by its number in [`PARTS`].
    pub fn part(&self, part: usize) -> Duration {
        self.systems
            .iter()
            .zip(&self.spent)
            .filter(|(entry, _)| entry.part == Some(part))
            .map(|(_, &spent)| spent)
            .sum()
    }

    /// Returns the passes in a part, given by its number in [`PARTS`].
    pub fn passes_of(&self, part: usize) -> Passes {
        sum(self.systems.iter().zip(&self.passes).filter(|(entry, _)| entry.part == Some(part)).map(|(_, &it)| it))
    }

    /// Returns the time in systems with this name.
    pub fn system(&self, name: &str) -> Duration {
        self.systems.iter().zip(&self.spent).filter(|(entry, _)| entry.name == name).map(|(_, &spent)| spent).sum()
    }
}

/// Returns the sum of passes.
pub fn sum(all: impl IntoIterator<Item = Passes>) -> Passes {
    all.into_iter().fold(Passes::default(), |a, b| Passes {
        count: a.count + b.count,
        wall: a.wall + b.wall,
        work: a.work + b.work,
        longest: a.longest + b.longest,
    })
}

fn start(mut watch: ResMut<Stopwatch>, threads: Res<Threads>) {
    watch.last_passes = threads.passes();
    watch.last = Instant::now();
}

/// Inserts a stopwatch into a simulation.
pub fn put_into(simulation: &mut Simulation) {
    simulation.world_mut().schedule_scope(Step, |world, schedule| {
        let part = |key: SystemKey| {
            PARTS.iter().position(|(_, part)| {
                let engine = |phase: Phase| [step::Part::Engine(phase).intern(), phase.intern()];
                let sync = |phase: Phase| [step::Part::Refresh(phase).intern(), step::Part::WriteBack(phase).intern()];
                let sets = match *part {
                    Part::Phase(Phase::Spawn) => {
                        let slots = [step::Part::Renumber.intern(), step::Part::Sort.intern()];
                        [engine(Phase::Spawn), sync(Phase::Spawn), slots].concat()
                    }
                    Part::Phase(phase) => [engine(phase), sync(phase)].concat(),
                    Part::Sync(phase) => sync(phase).to_vec(),
                    Part::Stage(stage) => vec![stage.intern()],
                };
                let holds = |set| schedule.graph().systems_in_set(set).is_ok_and(|members| members.contains(&key));
                sets.into_iter().any(holds)
            })
        };
        let systems = schedule.systems().expect("the schedule has been initialised");
        // The ECS inserts systems that apply commands. Their time counts for the next system.
        let named = systems.filter(|(_, system)| !system.name().to_string().contains("apply_deferred"));
        let (entries, sets): (Vec<_>, Vec<_>) = named
            .map(|(key, system)| {
                let name = system.name().to_string();
                let name = name.split('<').next().unwrap_or_default().trim_start_matches("siloflow::").to_owned();
                (Entry { name, part: part(key) }, system.default_system_sets()[0])
            })
            .unzip();
        schedule.add_systems(start.before(sets[0]));
        for (n, &set) in sets.iter().enumerate() {
            let lap = move |mut watch: ResMut<Stopwatch>, threads: Res<Threads>| watch.lap(n, threads.passes());
            let stop = lap.after(set);
            match sets.get(n + 1) {
                Some(&next) => schedule.add_systems(stop.before(next)),
                None => schedule.add_systems(stop),
            };
        }
        let spent = vec![Duration::ZERO; entries.len()];
        let passes = vec![Passes::default(); entries.len()];
        let last_passes = Passes::default();
        world.insert_resource(Stopwatch { systems: entries, spent, passes, last: Instant::now(), last_passes });
    });
}
