//! The finite-value check: an infinite or undefined number stops the run and is named, with the grain and the step.
//!
//! Nobody needs a pass for it: a velocity or spin that is not finite makes the power of the drag forces so ([`crate::energy`]), or,
//! where no books are kept, the sum of all (of grains that components move, this takes a pass); a position the way that was gone
//! ([`Columns::travel`]); and a force that is not finite shows in the velocity of the same step. Only then, and in step
//! zero, are all of them looked through for the grain.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::contact::{AnyLaw, Bounce};
use crate::energy::{EnergyBooked, EnergyFlows};
use crate::outcome::{Failure, Outcome};
use crate::particle::Force;
use crate::space::{Linear, Space};
use crate::step::{Clock, Phase, Step};

/// Whether the sums of all velocities and of all spins are.
fn sums_are_finite<V: Space>(columns: &Columns<V>) -> bool {
    let of_velocities = || columns.body.iter().map(|body| body.velocity).sum();
    let of_spins = || columns.rotation.iter().map(|rotation| rotation.spin).sum();
    let (velocities, spins): (V, V::Spin) =
        (columns.kick_sum.unwrap_or_else(of_velocities), columns.spin_kick_sum.unwrap_or_else(of_spins));
    velocities.is_finite() && spins.is_finite()
}

fn check<V: Space>(
    clock: Res<Clock>,
    columns: Res<Columns<V>>,
    law: Option<Res<AnyLaw<V>>>,
    flows: Option<Res<EnergyFlows>>,
    forces: Query<&Force<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let motion_is_finite = || match &flows {
        Some(flows) => flows.dissipated.is_finite(),
        None => sums_are_finite(&columns),
    };
    if !clock.is_step_zero() && columns.travel.is_finite() && motion_is_finite() {
        return;
    }
    for i in 0..columns.len() {
        let quantity = match (columns.body[i].velocity.is_finite(), columns.body[i].position.is_finite()) {
            (_, false) => "position",
            (false, _) => "velocity",
            _ if !columns.spin(i).is_finite() => "spin",
            _ => continue,
        };
        let total = forces.get(columns.entity[i]).map_or(columns.loads.force.of(i), |force| force.0);
        let cause = if !columns.loads.force.of(i).is_finite() {
            let (mass, radius) = (1.0 / columns.body[i].inverse_mass, columns.body[i].radius);
            let bounce = Bounce { reduced_mass: mass, reduced_radius: radius, speed: 1.0 };
            let step = law.as_ref().map_or(f64::NAN, |law| clock.dt * law.0.frequency(&bounce));
            format!(
                "the force of its contacts is not finite either: the step is probably unstable, w0 dt = {step:.2} for \
                 this grain; lower `step` (`check` prints the limit)"
            )
        } else if !total.is_finite() {
            "a behaviour has added a force that is not finite".to_owned()
        } else {
            "its forces are finite, so a behaviour or an input file has set it".to_owned()
        };
        outcome.fail(Failure::NotFinite { step: clock.steps, grain: columns.id[i], quantity, cause });
        return;
    }
}

/// The finite-value check of every step.
pub struct FinitePlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for FinitePlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, check::<V>.in_set(Phase::Control).after(EnergyBooked));
    }
}
