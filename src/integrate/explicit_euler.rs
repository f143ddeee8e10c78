//! Explicit Euler: x(t+dt) = x(t) + dt v(t), v(t+dt) = v(t) + dt a(t), with both on the right at time t.
//!
//! First order: after a time T of free fall it is g T dt/2 too high. It feeds energy into every spring,
//! by a factor 1 + (w0 dt)^2 a step, so no step is stable for contacts. The control of the free-fall test, and no more.

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::particle::{Fixed, Force, Mass, Position, Velocity};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Phase, Step};

fn euler_step<V: Space>(
    clock: Res<Clock>,
    mut grains: Query<(&mut Position<V>, &mut Velocity<V>, &Force<V>, &Mass), Without<Fixed>>,
) {
    let dt = clock.dt;
    for (mut x, mut v, force, mass) in &mut grains {
        let v = &mut v.bypass_change_detection().0;
        x.bypass_change_detection().0 += *v * dt;
        *v += force.0 * (dt / mass.0);
    }
}

pub(super) fn add<V: Space>(app: &mut App) {
    app.add_systems(Step, euler_step::<V>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
}
