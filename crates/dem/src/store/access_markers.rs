//! Marks by which systems and observers declare how they use the store and its mirrored components, where their access lists say too
//! little ([`sync_plan`](super::sync_plan)).

use bevy_ecs::prelude::*;

/// Marker resource of systems that read positions, properties and forces in the store, but not velocities.
#[derive(Resource, Default)]
pub(crate) struct ReadsPlaces;

/// Marker resource of systems that read velocities or spins in the store.
#[derive(Resource, Default)]
pub(crate) struct ReadsMotion;

/// Marker resource of systems that add forces or torques and never set them ([`added_loads`](crate::added_loads)).
#[derive(Resource, Default)]
pub struct AddsLoads;

/// Systems with commands that add no observer and no component with hooks. A scene with only these systems needs no
/// check for observers and hooks.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PlainCommands;

/// Marks siloflow's own observers, which use no mirrored component.
#[derive(Component)]
pub(crate) struct OwnObserver;
