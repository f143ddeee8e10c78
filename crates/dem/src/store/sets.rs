//! System sets of the passes over the store, for systems that run before or after them.

use bevy_ecs::prelude::*;

/// The set of [`Phase::Drift`](crate::step::Phase::Drift) after which spins are w(t+dt/2).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SpinsDrifted;

/// The set after which the store holds the velocity predictions of the scheme. It runs before the neighbour search.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct VelocitiesPredicted;

/// The set that applies the second kick; after it, velocities are v(t+dt).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Kicked;

/// The set of [`Renumber`](crate::store::Renumber) that applies a pending kick. After it, velocities belong to the step's end.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KicksApplied;
