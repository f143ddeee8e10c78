//! ECS messages about events in a silo; any system may read them.
//!
//! A message lives for two steps, so a reader that runs every step misses none.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::particle::{GrainId, Species};
use crate::space::{Plane, Space};

/// A grain entered.
#[derive(Message, Clone, Copy, Debug)]
pub struct GrainReleased {
    /// The grain.
    pub id: GrainId,
}

/// A grain's path crossed the open orifice.
#[derive(Message, Clone, Copy, Debug)]
pub struct GrainOut<V: Space = Plane> {
    /// The grain.
    pub id: GrainId,
    /// Its position at the end of that step, m.
    pub position: V,
    /// Its mass, kg.
    pub mass: f64,
    /// Its species.
    pub species: Species,
}

/// A grain left the silo in any other way.
#[derive(Message, Clone, Debug)]
pub struct GrainLost<V: Space = Plane> {
    /// The grain.
    pub id: GrainId,
    /// Its position at the end of that step, m.
    pub position: V,
    /// Description: through which wall, or over which side.
    pub way: String,
    /// The nearest wall grain, if there is one.
    pub nearest: Option<GrainId>,
}

/// All grains have been released and have come to rest.
#[derive(Message, Clone, Copy, Debug)]
pub struct CameToRest;

/// The door began to open.
#[derive(Message, Clone, Copy, Debug)]
pub struct DoorOpened;

/// Registers the messages.
pub struct MessagesPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for MessagesPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_message::<GrainReleased>()
            .add_message::<GrainOut<V>>()
            .add_message::<GrainLost<V>>()
            .add_message::<CameToRest>()
            .add_message::<DoorOpened>();
    }
}
