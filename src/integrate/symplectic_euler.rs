//! Symplectic Euler: v(t+dt) = v(t) + dt a(t), then x(t+dt) = x(t) + dt v(t+dt), a at time t.
//!
//! First order: after a time T of free fall it is g T dt/2 too low. For forces that depend on positions alone it is
//! symplectic, so that energy errs but does not drift, and stable for w0 dt < 2. It takes the same positions as velocity
//! Verlet whose velocities are read half a step late; for teaching, next to explicit Euler.

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
        *v += force.0 * (dt / mass.0);
        x.bypass_change_detection().0 += *v * dt;
    }
}

pub(super) fn add<V: Space>(app: &mut App) {
    app.add_systems(Step, euler_step::<V>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
}
