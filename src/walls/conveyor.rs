//! Conveyors: wall grains that move at a constant velocity, the rough walls of a shear cell or a rough belt.
//!
//! x <- x + v dt for every wall grain that the scene gives a velocity (`fill` with `fixed: true`). The work that it
//! takes to keep them going is booked as wall work. In a periodic scene they come round.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::particle::{Fixed, Position, Velocity};
use crate::space::Space;
use crate::step::{Clock, Phase, Step};

/// Marks a wall grain that keeps moving.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Conveyed;

type Belt = (With<Conveyed>, With<Fixed>);

fn convey<V: Space>(clock: Res<Clock>, mut belt: Query<(&mut Position<V>, &Velocity<V>), Belt>) {
    for (mut x, v) in &mut belt {
        x.0 += v.0 * clock.dt;
    }
}

/// Moves conveyors.
pub struct ConveyorPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for ConveyorPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, convey::<V>.in_set(Phase::Drift));
    }
}
