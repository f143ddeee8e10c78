//! The finite-value check: an infinite or undefined number stops the run and is named, with the grain and the step.
//!
//! One pass over positions, velocities and spins at the end of a step; a force that is not finite shows in the velocity
//! of the same step.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{Body, Columns};
use crate::contact::{AnyLaw, Bounce};
use crate::outcome::{Failure, Outcome};
use crate::particle::Force;
use crate::space::{Linear, Space};
use crate::step::{Clock, Phase, Step};

fn check<V: Space>(
    clock: Res<Clock>,
    columns: Res<Columns<V>>,
    law: Option<Res<AnyLaw<V>>>,
    forces: Query<&Force<V>>,
    mut outcome: ResMut<Outcome>,
) {
    // Zero times a finite number is zero; anything else makes the sum NaN. No branch in the loop.
    let mut sum = 0.0;
    for Body { position: x, velocity: v, .. } in &columns.body {
        sum += (*x + *v).dot(V::ZERO);
    }
    for spin in &columns.spin {
        sum += spin.dot(V::Spin::ZERO);
    }
    if sum == 0.0 {
        return;
    }
    for i in 0..columns.len() {
        let quantity = match (columns.body[i].velocity.is_finite(), columns.body[i].position.is_finite()) {
            (_, false) => "position",
            (false, _) => "velocity",
            _ if columns.spin.get(i).is_some_and(|spin| !spin.is_finite()) => "spin",
            _ => continue,
        };
        let total = forces.get(columns.entity[i]).map_or(columns.load[i].force, |force| force.0);
        let cause = if !columns.load[i].force.is_finite() {
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
        app.add_systems(Step, check::<V>.in_set(Phase::Control));
    }
}
