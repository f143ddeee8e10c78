//! Grain snapshot: the present state of every grain of a world, in ascending order of ids.

use bevy_ecs::entity::EntityIndex;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;

use siloflow_dem::bodies::{Orientation, Shape};
use siloflow_dem::particle::{Grain, GrainId, Mass, Position, Radius, Species, Velocity};
use siloflow_dem::space::Space;
use siloflow_dem::spin::Spin;
use siloflow_dem::store::ParticleStore;

/// State of one grain, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GrainSnapshot<V: Space> {
    pub(crate) id: GrainId,
    pub(crate) radius: f64,
    pub(crate) mass: f64,
    pub(crate) position: V,
    pub(crate) velocity: V,
    pub(crate) species: Species,
    /// Spin; `None` if the grain cannot spin.
    pub(crate) spin: Option<V::Spin>,
    /// Shape, and orientation of its principal axes; `None` for a sphere (disc).
    pub(crate) shape: Option<(Shape, V::Rotor)>,
}

/// Returns whether grains of the world spin, also if it has no grain.
pub(crate) fn has_spins<V: Space>(world: &mut World) -> bool {
    world.get_resource::<ParticleStore<V>>().is_some_and(ParticleStore::has_spins)
        || world.query_filtered::<(), (With<Grain>, With<Spin<V::Spin>>)>().iter(world).next().is_some()
}

/// Calls `visit` with each grain, until a call fails.
///
/// # Errors
/// The first error of `visit`.
pub(crate) fn take<V: Space, E>(
    world: &mut World,
    visit: impl FnMut(GrainSnapshot<V>) -> Result<(), E>,
) -> Result<(), E> {
    // Indices take half the memory of entities: of a million discs this is the largest allocation when a run ends.
    let mut grains: Vec<(GrainId, EntityIndex)> = world
        .query_filtered::<(&GrainId, Entity), With<Grain>>()
        .iter(world)
        .map(|(id, grain)| (*id, grain.index()))
        .collect();
    grains.sort_unstable_by_key(|&(id, _)| id);
    let mut rows = world.query::<GrainRow<V>>();
    let snapshot = |row: GrainRowItem<'_, '_, V>| GrainSnapshot {
        id: *row.id,
        radius: row.radius.0,
        mass: row.mass.0,
        position: row.position.0,
        velocity: row.velocity.0,
        species: *row.species,
        spin: row.spin.map(|spin| spin.0),
        shape: row.shape.map(|(shape, rotor)| (*shape, rotor.0)),
    };
    let entity = |(_, index): (GrainId, EntityIndex)| world.entities().resolve_from_index(index);
    grains.into_iter().map(entity).filter_map(|grain| rows.get(world, grain).ok().map(snapshot)).try_for_each(visit)
}

/// The components of a grain.
#[derive(QueryData)]
struct GrainRow<V: Space> {
    id: &'static GrainId,
    radius: &'static Radius,
    mass: &'static Mass,
    position: &'static Position<V>,
    velocity: &'static Velocity<V>,
    species: &'static Species,
    spin: Option<&'static Spin<V::Spin>>,
    shape: Option<(&'static Shape, &'static Orientation<V>)>,
}
