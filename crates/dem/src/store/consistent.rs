//! Whether the restored particles fit the restored store.
//!
//! Steps index rows by slots and particles by entities without further checks. So after a checkpoint is read, every present row has an
//! entity with its id, slot, and the components that steps need; every particle has a row, or enters with the next renumbering; and radii
//! and masses can be divided by.

use std::collections::HashSet;

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;

use crate::particle::{GrainId, Mass, Position, Radius, Slot, Velocity};
use crate::persist::Problem;
use crate::space::Space;
use crate::spin::Inertia;
use crate::store::population::Population;
use crate::store::{Body, ParticleStore};

/// A particle with the components that steps need.
#[derive(QueryData)]
struct RestoredParticle<V: Space> {
    entity: Entity,
    id: &'static GrainId,
    has_position: Has<Position<V>>,
    has_velocity: Has<Velocity<V>>,
    radius: Option<&'static Radius>,
    slot: Option<&'static Slot>,
    mass: Option<&'static Mass>,
    inertia: Option<&'static Inertia>,
}

/// Checks a world in which all state is restored.
pub(super) fn check<V: Space>(world: &mut World) -> Result<(), Problem> {
    problem::<V>(world).map_or(Ok(()), |problem| Err(format!("the store of particles: {problem}")))
}

fn problem<V: Space>(world: &mut World) -> Option<&'static str> {
    let mut particles = world.query::<RestoredParticle<V>>();
    let store = world.get_resource::<ParticleStore<V>>()?;
    let population = world.get_resource::<Population>()?;
    if let Some(problem) = problem_of_rows(store) {
        return Some(problem);
    }
    let newcomers: HashSet<Entity> = population.touched.iter().copied().collect();
    let is_positive = |number: f64| number > 0.0 && number.is_finite();
    let mut ids = HashSet::new();
    let mut rows = 0_usize;
    for particle in particles.iter(world) {
        let RestoredParticleItem { entity, id, has_position, has_velocity, radius, slot, mass, inertia } = particle;
        let (Some(radius), Some(slot), true, true) = (radius, slot, has_position, has_velocity) else {
            return Some("a particle lacks a component");
        };
        let can_divide = is_positive(radius.0)
            && mass.is_none_or(|mass| is_positive(mass.0))
            && inertia.is_none_or(|inertia| is_positive(inertia.0));
        if !can_divide {
            return Some("a radius, mass or moment of inertia is not positive");
        }
        if !ids.insert(*id) {
            return Some("two particles have one id");
        }
        match store.row_of(entity, *slot) {
            Some(row) if store.id[row] == *id => rows += 1,
            None if newcomers.contains(&entity) => {}
            _ => return Some("a particle has no row"),
        }
    }
    let spheres = (0..store.len()).filter(|&i| !store.is_whole(i) && store.is_present(i)).count();
    (rows + spheres + store.vacated.len() != store.len()).then_some("a row has no particle")
}

/// Returns a fault of the rows by themselves, in words.
fn problem_of_rows<V: Space>(store: &ParticleStore<V>) -> Option<&'static str> {
    let left: HashSet<usize> = store.vacated.iter().copied().collect();
    let are_left = store.vacated.iter().all(|&row| store.entity.get(row) == Some(&Entity::PLACEHOLDER));
    if left.len() != store.vacated.len() || !are_left {
        return Some("the rows of particles that have left differ");
    }
    let is_body = |(body, mass): (&Body<V>, &f64)| body.radius > 0.0 && body.inverse_mass >= 0.0 && *mass >= 0.0;
    if !store.body.iter().zip(&store.mass).all(is_body) {
        return Some("a radius or a mass is not positive");
    }
    let are_free = store.body[..store.free_end].iter().all(|body| body.inverse_mass > 0.0);
    let are_fixed = store.body[store.free_end..].iter().all(|body| body.inverse_mass == 0.0);
    (!are_free || !are_fixed).then_some("a fixed particle is among the movable ones, or a movable one among the fixed")
}
