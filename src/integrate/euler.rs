//! The two Euler schemes: both of first order, for teaching.
//!
//! * Explicit: x(t+dt) = x(t) + dt v(t), v(t+dt) = v(t) + dt a(t), with both on the right at time t. After a time T of free
//!   fall it is g T dt/2 too high. It feeds energy into every spring, by a factor 1 + (w0 dt)^2 a step, so no step is
//!   stable for contacts. The control of the free-fall test, and no more.
//! * Symplectic: v(t+dt) = v(t) + dt a(t), then x(t+dt) = x(t) + dt v(t+dt), a at time t. After a time T of free fall it is
//!   g T dt/2 too low. For forces that depend on positions alone it is symplectic, so that energy errs but does not drift,
//!   and stable for w0 dt < 2. It takes the same positions as velocity Verlet whose velocities are read half a step late.

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::columns::DENSE;
use crate::particle::{Fixed, Force, Mass, Position, Velocity};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Phase, Step};

fn euler_step<V: Space, const SYMPLECTIC: bool>(
    clock: Res<Clock>,
    mut grains: Query<(&mut Position<V>, &mut Velocity<V>, &Force<V>, &Mass), Without<Fixed>>,
) {
    let dt = clock.dt;
    for (mut x, mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        let columns = x.bypass_change_detection().iter_mut().zip(v.bypass_change_detection());
        for ((x, v), (force, mass)) in columns.zip(force.iter().zip(mass.iter())) {
            let before = v.0;
            v.0 += force.0 * (dt / mass.0);
            x.0 += (if SYMPLECTIC { v.0 } else { before }) * dt;
        }
    }
}

pub(super) fn add_explicit<V: Space>(app: &mut App) {
    app.add_systems(Step, euler_step::<V, false>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
}

pub(super) fn add_symplectic<V: Space>(app: &mut App) {
    app.add_systems(Step, euler_step::<V, true>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
}
