//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`], where 1 is written as x + dt v(t+dt/2), the same number; 4 and 5 are
//! [`Phase::Kick`]. Second order, symplectic and time-reversible while forces depend on positions alone. Drag is
//! evaluated with a velocity half a step old, which makes damped contacts first order; one such contact is stable
//! for dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::columns::{DENSE, GatheredVelocities};
use crate::particle::{Fixed, Force, Mass, Position, Velocity};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Phase, Step};

type Movable = Without<Fixed>;

fn drift<V: Space>(
    clock: Res<Clock>,
    mut grains: Query<(&mut Position<V>, &mut Velocity<V>, &Force<V>, &Mass), Movable>,
) {
    let dt = clock.dt;
    for (mut x, mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        let columns = x.bypass_change_detection().iter_mut().zip(v.bypass_change_detection());
        for ((x, v), (force, mass)) in columns.zip(force.iter().zip(mass.iter())) {
            v.0 += force.0 * (0.5 * dt / mass.0);
            x.0 += v.0 * dt;
        }
    }
}

fn kick<V: Space>(clock: Res<Clock>, mut grains: Query<(&mut Velocity<V>, &Force<V>, &Mass), Movable>) {
    let dt = clock.dt;
    for (mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        for (v, (force, mass)) in v.bypass_change_detection().iter_mut().zip(force.iter().zip(mass.iter())) {
            v.0 += force.0 * (0.5 * dt / mass.0);
        }
    }
}

pub(super) fn add<V: Space>(app: &mut App) {
    app.add_systems(
        Step,
        (
            drift::<V>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced),
            kick::<V>.in_set(Phase::Kick).before(GatheredVelocities),
        ),
    );
}
