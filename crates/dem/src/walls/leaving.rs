//! Walls that leave: surfaces whose entities are despawned, such as a door that opens.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use serde::{Deserialize, Serialize};

use crate::persist::Problem;
use crate::space::Space;
use crate::step::{Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::moving::WallsPlaced;
use crate::walls::surfaces::Surfaces;

/// Marks the entity of a wall surface by its index in [`Surfaces`]. After the entity is despawned, the wall is absent from
/// the next step on.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[component(immutable, on_remove = record_leaving_wall)]
pub struct WallIndex(pub usize);

/// Walls whose entities have been despawned since the last step.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub struct LeavingWalls(pub Vec<usize>);

/// Refuses restored indices of walls that the scene does not have.
///
/// # Errors
/// It names the index.
pub fn check_restored<V: Space>(world: &mut World) -> Result<(), Problem> {
    let mut marked = world.query::<&WallIndex>();
    let count = world.get_resource::<Surfaces<V>>().map_or(0, |walls| walls.all.len());
    let leaving = world.get_resource::<LeavingWalls>().into_iter().flat_map(|leaving| &leaving.0).copied();
    let mut indices = marked.iter(world).map(|wall| wall.0).chain(leaving);
    match indices.find(|index| *index >= count) {
        Some(index) => Err(format!("it names wall surface {index}, and the scene has {count}")),
        None => Ok(()),
    }
}

/// Records a wall whose entity is despawned.
fn record_leaving_wall(mut world: DeferredWorld, context: HookContext) {
    let Some(&WallIndex(wall)) = world.get(context.entity) else { return };
    if let Some(mut leaving) = world.get_resource_mut::<LeavingWalls>() {
        leaving.0.push(wall);
    }
}

/// Run condition: the entity of a wall has been despawned.
#[must_use]
pub fn walls_leave(leaving: Res<LeavingWalls>) -> bool {
    !leaving.0.is_empty()
}

/// Removes walls whose entities were despawned. This happens one step later, so that the energy balance accounts for
/// the elastic energy of their contacts first.
fn remove_walls<V: Space>(mut leaving: ResMut<LeavingWalls>, mut walls: ResMut<Surfaces<V>>) {
    for wall in leaving.0.drain(..) {
        walls.all[wall].is_present = false;
    }
}

/// Removes walls whose entities are despawned.
pub struct LeavingWallsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LeavingWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        let remove = remove_walls::<V>.in_set(Part::Engine(Phase::Drift)).after(AfterDeferredKick).after(WallsPlaced);
        app.add_systems(Step, remove.run_if(walls_leave));
    }
}
