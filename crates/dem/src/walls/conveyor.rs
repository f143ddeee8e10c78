//! Conveyors: wall grains that move at constant velocity, for example the rough walls of a shear cell or a rough belt.
//!
//! x <- x + v dt for every wall grain with a velocity (`fill` with `fixed: true`). The work that keeps them moving
//! counts as wall work. In a periodic scene they are wrapped.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::particle::{Fixed, Position, Velocity};
use crate::persist::PersistApp as _;
use crate::space::Space;
use crate::step::{Clock, Phase, Step};

/// Marks a wall grain that moves at constant velocity.
#[derive(Component, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct Conveyed;

type Belt = (With<Conveyed>, With<Fixed>);

fn convey<V: Space>(clock: Res<Clock>, mut belt: Query<(&mut Position<V>, &Velocity<V>), Belt>) {
    for (mut x, v) in &mut belt {
        x.0 += v.0 * clock.dt;
    }
}

/// Moves the conveyors.
pub struct ConveyorPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for ConveyorPlugin<V> {
    fn build(&self, app: &mut App) {
        app.persist_component::<Conveyed>().add_systems(Step, convey::<V>.in_set(Phase::Drift));
    }
}
