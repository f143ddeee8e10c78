//! Weight: m g on every grain. Where it acts, the potential energy of a grain is -m g.x, zero at the origin.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::space::Vector;
use crate::step::{ForceStage, Step};

/// The acceleration of gravity, m/s^2; zero where the scene has none.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Gravity(pub Vector);

fn weigh(gravity: Res<Gravity>, mut columns: ResMut<Columns>) {
    let Columns { load, mass, .. } = &mut *columns;
    for (load, &mass) in load.iter_mut().zip(mass.iter()) {
        load.force += mass * gravity.0;
    }
}

/// Weight in a field that is not zero.
pub struct GravityPlugin;

impl Plugin for GravityPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, weigh.in_set(ForceStage::Gravity));
    }
}
