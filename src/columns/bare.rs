//! Bare grains: rows of the columns, and no entities.
//!
//! An entity costs memory: its components, 8 B of change ticks for each, and what the ECS knows of it, together more than what
//! the columns hold of it. Where nobody looks at components in a run, neither a behaviour nor a program's system, grains are
//! bare. They become entities once somebody asks for them ([`Lead`](super::Lead)), and stay entities. What is fixed always is one.
//!
//! [`Gate`] lets grains in and out, bare or not. Bare ones come and go when slots are dealt out, as entities do.

use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::columns::{Columns, PopulationChanged, Slot};
use crate::particle::{Force, Grain, GrainBundle, Mass, Particle, Position, Radius, Velocity};
use crate::rows;
use crate::space::Space;
use crate::spin::{InertiaLaw, TurningBundle};

/// A bare grain that has no slot yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Newcomer<V: Space> {
    pub(crate) grain: GrainBundle<V>,
    /// Spin, rad/s.
    pub(crate) spin: V::Spin,
}

impl<V: Space> Newcomer<V> {
    /// What it needs to turn, by this law.
    pub(crate) fn turning(&self, law: InertiaLaw) -> TurningBundle<V> {
        law.turning::<V>(self.grain.mass.0, self.grain.particle.radius.0, self.spin)
    }
}

/// Bare grains that come and go when slots are dealt out next.
#[derive(Resource)]
pub(crate) struct Turnover<V: Space> {
    pub(crate) entering: Vec<Newcomer<V>>,
    /// Their entries, in ascending order.
    leaving: Vec<u32>,
}

impl<V: Space> Default for Turnover<V> {
    fn default() -> Self {
        Self { entering: Vec::new(), leaving: Vec::new() }
    }
}

impl<V: Space> Turnover<V> {
    /// Whether entry `i` is of a bare grain that leaves.
    pub(crate) fn is_leaving(&self, i: usize) -> bool {
        self.leaving.binary_search_by(|&leaving| (leaving as usize).cmp(&i)).is_ok()
    }
}

impl<V: Space> Columns<V> {
    /// The entries of bare grains that stay.
    pub(crate) fn bare(&self, turnover: &Turnover<V>) -> impl Iterator<Item = usize> + Clone {
        let end = if self.is_bare { self.movable_end } else { 0 };
        (0..end).filter(|&i| !turnover.is_leaving(i))
    }

    /// Whether entry `i` is of a bare grain, or of an entity that there is.
    pub(crate) fn is_somebody(&self, i: usize, exists: impl Fn(Entity) -> bool) -> bool {
        let entity = self.entity[i];
        entity == Entity::PLACEHOLDER || exists(entity)
    }

    /// Entry `i` as the components of an entity.
    fn bundle(&self, i: usize) -> GrainBundle<V> {
        let body = &self.body[i];
        GrainBundle {
            particle: Particle {
                id: self.id[i],
                position: Position(body.position),
                velocity: Velocity(body.velocity),
                force: Force(self.loads.force.of(i)),
                radius: Radius(body.radius),
            },
            mass: Mass(self.mass[i]),
            species: self.species[i],
            grain: Grain,
        }
    }
}

/// Grains that are released enter in this set of [`Phase::Spawn`](crate::step::Phase::Spawn).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Entering;

/// Through which grains enter and leave.
#[derive(SystemParam)]
pub(crate) struct Gate<'w, 's, V: Space> {
    commands: Commands<'w, 's>,
    pub(crate) columns: Res<'w, Columns<V>>,
    pub(crate) turnover: ResMut<'w, Turnover<V>>,
    population: ResMut<'w, PopulationChanged>,
}

impl<V: Space> Gate<'_, '_, V> {
    /// Lets a grain in that does not spin.
    pub(crate) fn admit(&mut self, grain: GrainBundle<V>) {
        if self.columns.is_bare {
            self.turnover.entering.push(Newcomer { grain, spin: V::Spin::default() });
            self.population.note();
        } else {
            self.commands.spawn(grain);
        }
    }

    /// Takes the grain of entry `i` out of the world; the entity that it was, if it was one. Entries are called in ascending order.
    pub(crate) fn dismiss(&mut self, i: usize) -> Option<Entity> {
        let entity = self.columns.entity[i];
        if entity == Entity::PLACEHOLDER {
            self.turnover.leaving.extend(u32::try_from(i));
            self.population.note();
            return None;
        }
        self.commands.entity(entity).despawn();
        Some(entity)
    }
}

/// Makes entities of all bare grains and newcomers. Slots stay what they are; [`follow`](super::follow) gives torques.
pub(crate) fn embody<V: Space>(world: &mut World) {
    let mut turnover = std::mem::take(&mut *world.resource_mut::<Turnover<V>>());
    rows::sort_newcomers(&mut turnover.entering);
    let mut columns = world.resource_mut::<Columns<V>>();
    let entries: Vec<_> = columns.bare(&turnover).collect();
    let resident = |&i: &usize| (Newcomer { grain: columns.bundle(i), spin: columns.spin(i) }, Slot::of(i));
    let residents: Vec<_> = entries.iter().map(resident).collect();
    columns.is_bare = false;
    let inertia = columns.inertia;
    let population = std::mem::take(&mut *world.resource_mut::<PopulationChanged>());
    let entities = spawn(world, inertia, residents.into_iter());
    spawn(world, inertia, turnover.entering.into_iter().map(|new| (new, Slot::default())));
    // New as they are, nothing has changed: slots must not be dealt out anew because somebody looks.
    for (mut radius, mut mass) in world.query_filtered::<(&mut Radius, &mut Mass), With<Grain>>().iter_mut(world) {
        radius.set_last_changed(Tick::new(0));
        mass.set_last_changed(Tick::new(0));
    }
    // It is the same population as before, and the same grains are leaving.
    world.insert_resource(population);
    world.resource_mut::<Turnover<V>>().leaving = turnover.leaving;
    let mut columns = world.resource_mut::<Columns<V>>();
    for (i, entity) in entries.into_iter().zip(entities) {
        columns.entity[i] = entity;
    }
}

/// All at once: tables are made for as many.
fn spawn<V: Space>(
    world: &mut World,
    inertia: Option<InertiaLaw>,
    grains: impl Iterator<Item = (Newcomer<V>, Slot)>,
) -> Vec<Entity> {
    match inertia {
        None => world.spawn_batch(grains.map(|(new, slot)| (new.grain, slot))).collect(),
        Some(law) => world.spawn_batch(grains.map(|(new, slot)| (new.turning(law), new.grain, slot))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;
    use std::path::Path;

    use super::*;
    use crate::assembly::Assembly;
    use crate::behaviour::Registry;
    use crate::columns::{SecondKick, looks_when};
    use crate::energy::EnergyFlows;
    use crate::grains::file;
    use crate::ledger::Ledger;
    use crate::output::state_hash;
    use crate::scene::load::{self, Loaded};
    use crate::simulation::Simulation;
    use crate::space::{Dimension, Plane, Solid};
    use crate::step::Clock;

    fn scene(name: &str, settings: &[(&str, &str)]) -> Loaded {
        let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        load::load(&Path::new("scenes").join(name), &settings).unwrap()
    }

    /// Whether grains are bare, and whether some are leaving.
    fn are_bare(world: &World) -> (bool, bool) {
        fn of<V: Space>(world: &World) -> (bool, bool) {
            (world.resource::<Columns<V>>().is_bare, !world.resource::<Turnover<V>>().leaving.is_empty())
        }
        match Dimension::of_world(world) {
            Dimension::Plane => of::<Plane>(world),
            Dimension::Solid => of::<Solid>(world),
        }
    }

    /// State, its file, the flows of energy and the ledger, as they are.
    fn look(run: &mut Simulation) -> (u64, String, [u64; 5], [u32; 4]) {
        let world = run.columns_world_mut();
        let state = match Dimension::of_world(world) {
            Dimension::Plane => file::write::<Plane>(world),
            Dimension::Solid => file::write::<Solid>(world),
        };
        let EnergyFlows { released, wall_work, lifted, added_work: _, dissipated, removed } = *world.resource();
        let flows = [released, wall_work, lifted, dissipated, removed].map(f64::to_bits);
        let ledger = world.resource::<Ledger>();
        let counts = [ledger.released, ledger.inside(), ledger.out(), ledger.culled];
        (state_hash::of_world(world), state, flows, counts)
    }

    /// A spawner, a discharge and grains that are removed; friction between moving walls, and periodic sides; gravity along those, in
    /// solid space. And the step in which entities are asked for.
    const SCENES: [(&str, &[(&str, &str)], u64); 3] = [
        ("silo1.ron", &[("spawner.count", "20"), ("door.opens", "At(2.5)"), ("until", "4.5")], 1500),
        ("couette.ron", &[("integrator", "Centred"), ("until", "0.02")], 70),
        ("chute3d.ron", &[("until", "0.008")], 300),
    ];

    #[test]
    fn who_looks_and_who_is_an_entity_changes_no_bit_of_state_and_books() {
        for (name, settings, step) in SCENES {
            let loaded = scene(name, &[settings, &[("pictures", "None")]].concat());
            let registry = Registry::default();
            let bare = || Simulation::with(&loaded, &registry, NonZeroUsize::MIN, |_| {}).unwrap();
            let mut never = bare();
            let mut always = Simulation::new(&loaded, &registry, NonZeroUsize::MIN).unwrap();
            assert_eq!([&never, &always].map(|run| are_bare(run.world()).0), [true, false], "{name}");
            let (start, mut first_leaves, mut late) = (look(&mut always), None, 0);
            never.advance_to_end(|world| {
                late += u32::from(world.resource::<SecondKick>().is_owed);
                first_leaves = first_leaves.or(are_bare(world).1.then_some(world.resource::<Clock>().steps));
            });
            always.run();
            let end = look(&mut never);
            assert_eq!(end, look(&mut always), "{name}: entities from the start");
            let looked_at =
                |assembly: &mut Assembly<'_>| assembly.add_with("the program", |app| looks_when(app, || true));
            let mut looked_at = Simulation::with(&loaded, &registry, NonZeroUsize::MIN, looked_at).unwrap();
            looked_at.run();
            assert_eq!(end, look(&mut looked_at), "{name}: velocities looked at in every step");
            assert!(late > 0, "{name}: no kick was put off");
            assert_ne!(end, start, "{name}: nothing happened");
            for step in [Some(step), first_leaves].into_iter().flatten() {
                let mut midway = bare();
                assert!(midway.run_steps(step).is_none(), "{name}: it has ended");
                assert!(!are_bare(midway.world()).0, "{name}");
                midway.run();
                assert_eq!(end, look(&mut midway), "{name}: entities from step {step} on");
            }
            if name == "silo1.ron" {
                let [released, _, out, culled] = end.3;
                assert!(released == 20 && out > 0 && culled > 0 && culled < 20, "{:?}", end.3);
                assert!(first_leaves.is_some());
            }
            assert!(are_bare(never.world()).0, "{name}");
            // Whoever asks is given all of them.
            let grains = never.world_mut().query_filtered::<(), With<Grain>>().iter(never.world()).count();
            assert_eq!(grains, end.1.lines().count() - 1, "{name}");
        }
    }
}
