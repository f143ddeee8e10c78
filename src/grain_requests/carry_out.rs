//! Carries out the requests that wait.

use bevy_ecs::prelude::*;
use rustc_hash::FxHashMap;

use crate::grain_requests::Waiting;
use crate::grain_requests::booking::{Present, book_after, book_before};
use crate::grain_requests::contacts::find_neighbours;
use crate::grain_requests::plan::{Change, Coming, Moved, Plan};
use crate::grain_requests::request::{GrainMade, sort};
use crate::grain_requests::resolve::{Resolver, Rules, inertia_ratio};
use crate::grains::free_id::FreeId;
use crate::ledger::Ledger;
use siloflow_dem::messages::GrainReleased;
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::particle::{Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Velocity};
use siloflow_dem::space::Space;
use siloflow_dem::spin::{Inertia, Spin};
use siloflow_dem::step::Clock;
use siloflow_dem::store::{ParticleStore, Renumber, apply_pending_kick};

/// Run condition: a request waits.
pub(super) fn are_waiting<V: Space>(waiting: Res<Waiting<V>>) -> bool {
    !waiting.0.is_empty()
}

/// Carries out all requests. Afterwards the grains that came have rows.
pub(super) fn carry_out<V: Space>(world: &mut World) {
    apply_pending_kick(world);
    let mut requests = std::mem::take(&mut world.resource_mut::<Waiting<V>>().0);
    sort(&mut requests);
    let resolver =
        Resolver::new(world.resource::<ParticleStore<V>>(), world.resource::<Ledger>(), world.resource::<Rules>().mass);
    let plan = match resolver.resolve(requests) {
        Ok(plan) => plan,
        Err(problem) => {
            let step = world.resource::<Clock>().steps;
            let text = format!("step {step}: a behaviour asked for what cannot be: {problem}");
            world.resource_mut::<Outcome>().fail(Failure::Behaviour(text));
            return;
        }
    };
    book_before(world, &plan);
    let Plan { leaving, changes, coming, .. } = plan;
    for one in leaving {
        world.resource_mut::<Ledger>().remove(one.id, one.is_gone);
        world.despawn(one.entity);
    }
    let mut present: FxHashMap<GrainId, Present> = FxHashMap::default();
    let mut moves = Vec::new();
    for change in changes {
        present.insert(change.id, Present { reason: change.reason.clone(), is_new: false });
        resize(world, &change);
        moves.extend(change.moved.map(|moved| (change.entity, moved)));
    }
    for one in coming {
        let Some(id) = world.resource_mut::<FreeId>().take() else {
            let text = format!("a behaviour asked for more than {} grains", GrainId::MAX_GRAIN);
            world.resource_mut::<Outcome>().fail(Failure::Behaviour(text));
            return;
        };
        present.insert(id, Present { reason: one.reason.clone(), is_new: true });
        spawn(world, id, one);
    }
    world.run_schedule(Renumber);
    // A spin belongs to the new moments of inertia, which the renumbering has set.
    for (entity, moved) in moves {
        place(world, entity, &moved);
    }
    find_neighbours::<V>(world);
    book_after::<V>(world, &present);
}

/// Gives a grain another radius and mass.
fn resize<V: Space>(world: &mut World, change: &Change<V>) {
    let ratio = inertia_ratio(world.resource::<ParticleStore<V>>(), change.row, change.radius, change.mass);
    let mut entity = world.entity_mut(change.entity);
    entity.insert((Radius(change.radius), Mass(change.mass)));
    if let Some(Inertia(inertia)) = entity.get::<Inertia>().copied() {
        entity.insert(Inertia(inertia * ratio));
    }
}

/// Gives a grain another place and motion.
fn place<V: Space>(world: &mut World, entity: Entity, moved: &Moved<V>) {
    let spins = world.resource::<ParticleStore<V>>().has_spins();
    let mut entity = world.entity_mut(entity);
    entity.insert((Position(moved.position), Velocity(moved.velocity)));
    if spins {
        entity.insert(Spin(moved.spin));
    }
}

/// Spawns a grain.
fn spawn<V: Space>(world: &mut World, id: GrainId, coming: Coming<V>) {
    let Coming { grain, mass, parent, reason } = coming;
    let law = world.resource::<ParticleStore<V>>().inertia;
    let mut new = world.spawn(GrainBundle {
        particle: Particle {
            id,
            position: Position(grain.position),
            velocity: Velocity(grain.velocity),
            radius: Radius(grain.radius),
        },
        mass: Mass(mass),
        species: grain.species,
        grain: Grain,
    });
    match (grain.shape, law) {
        (Some(shape), Some(_)) => new.insert((shape, Spin(grain.spin))),
        (Some(shape), None) => new.insert(shape),
        (None, Some(law)) => new.insert(law.turning::<V>(mass, grain.radius, grain.spin)),
        (None, None) => &mut new,
    };
    world.write_message(GrainReleased { id });
    world.write_message(GrainMade { id, parent, reason });
}
