//! Time integration: computes positions and velocities from forces. Each file holds one scheme, or one family of them.

mod euler;
mod recorded_velocity;
pub mod rigid;
pub mod rotation;
mod scatter;
mod turning;
mod verlet;
pub mod wrap;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use serde::{Deserialize, Serialize};

use crate::space::Space;

/// The scene key `integrator`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Integrator {
    /// Velocity Verlet with centred contacts: second order, also with drag and friction. For elastic contacts it equals
    /// `Verlet`.
    #[default]
    Centred,
    /// Velocity Verlet with the drag at the half-step velocity, as the assignment writes it. Second order without drag,
    /// first order with it.
    Verlet,
    /// Symplectic Euler, for teaching: first order, but as stable as velocity Verlet.
    SymplecticEuler,
    /// Explicit Euler, for teaching: first order and unstable for springs.
    ExplicitEuler,
}

/// Adds the integrator of a scene.
pub struct IntegratorPlugin<V: Space> {
    /// The scheme.
    pub kind: Integrator,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for IntegratorPlugin<V> {
    fn build(&self, app: &mut App) {
        match self.kind {
            Integrator::Verlet | Integrator::Centred => verlet::add::<V>(app),
            Integrator::SymplecticEuler => euler::add_symplectic::<V>(app),
            Integrator::ExplicitEuler => euler::add_explicit::<V>(app),
        }
    }
}
