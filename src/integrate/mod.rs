//! Time integration: how positions and velocities follow from forces. One file a scheme.

mod explicit_euler;
mod verlet;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use serde::{Deserialize, Serialize};

use crate::space::Space;

/// The scene's `integrator`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Integrator {
    /// Velocity Verlet with the drag at the half-step velocity, as the assignment writes it. Second order; first
    /// with drag.
    #[default]
    Verlet,
    /// Explicit Euler, first order and unstable for springs: for teaching, as the scheme that goes wrong.
    ExplicitEuler,
}

/// The integrator of a scene.
pub struct IntegratorPlugin<V: Space>(pub Integrator, pub PhantomData<V>);

impl<V: Space> Plugin for IntegratorPlugin<V> {
    fn build(&self, app: &mut App) {
        match self.0 {
            Integrator::Verlet => verlet::add::<V>(app),
            Integrator::ExplicitEuler => explicit_euler::add::<V>(app),
        }
    }
}
