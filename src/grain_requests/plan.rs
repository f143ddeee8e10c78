//! The outcome of the requests of a step: the grains that go, change and come.

use bevy_ecs::prelude::*;

use crate::grain_requests::request::NewGrain;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;

/// A grain that goes.
pub(super) struct Leaving {
    pub(super) row: usize,
    pub(super) entity: Entity,
    pub(super) id: GrainId,
    pub(super) reason: String,
    /// Whether it was out or lost already.
    pub(super) is_gone: bool,
}

/// A grain that stays and changes.
pub(super) struct Change<V: Space> {
    pub(super) row: usize,
    pub(super) entity: Entity,
    pub(super) id: GrainId,
    pub(super) reason: String,
    /// Its new radius, m.
    pub(super) radius: f64,
    /// Its new mass, kg.
    pub(super) mass: f64,
    /// Its new motion, if it takes part in a merger.
    pub(super) moved: Option<Moved<V>>,
}

/// Place and motion of a grain.
pub(super) struct Moved<V: Space> {
    pub(super) position: V,
    pub(super) velocity: V,
    pub(super) spin: V::Spin,
}

/// A grain that comes.
pub(super) struct Coming<V: Space> {
    pub(super) grain: NewGrain<V>,
    /// Its mass, kg.
    pub(super) mass: f64,
    /// The grain of which it is a piece.
    pub(super) parent: Option<GrainId>,
    pub(super) reason: String,
}

/// The outcome of all requests of a step.
pub(super) struct Plan<V: Space> {
    pub(super) leaving: Vec<Leaving>,
    pub(super) changes: Vec<Change<V>>,
    pub(super) coming: Vec<Coming<V>>,
    /// The reasons of requests that are not carried out.
    pub(super) dropped: Vec<String>,
}
