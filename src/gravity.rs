//! Weight: m g on every grain. Where it acts, the potential energy of a grain is -m g.x, zero at the origin.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::space::{Plane, Space};
use crate::step::{ForceStage, Step};

/// The acceleration of gravity, m/s^2; zero where the scene has none.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Gravity<V: Space = Plane>(pub V);

fn weigh<V: Space>(gravity: Res<Gravity<V>>, mut columns: ResMut<Columns<V>>) {
    let Columns { load, mass, .. } = &mut *columns;
    for (load, &mass) in load.iter_mut().zip(mass.iter()) {
        load.force += gravity.0 * mass;
    }
}

/// Weight in a field that is not zero.
pub struct GravityPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for GravityPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, weigh::<V>.in_set(ForceStage::Gravity));
    }
}
