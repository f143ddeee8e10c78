//! Time integration: how positions and velocities follow from forces. One file a scheme, or a kind of them.

pub mod centred;
mod euler;
pub mod rotation;
mod verlet;
pub mod wrap;

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use serde::{Deserialize, Serialize};

use crate::space::Space;

/// The scene's `integrator`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Integrator {
    /// Velocity Verlet with centred contacts: second order with drag and friction too. Where contacts are elastic,
    /// it is `Verlet`.
    #[default]
    Centred,
    /// Velocity Verlet with the drag at the half-step velocity, as the assignment writes it. Second order; first
    /// with drag.
    Verlet,
    /// Symplectic Euler, first order, for teaching: errs where velocity Verlet does not, and is as stable.
    SymplecticEuler,
    /// Explicit Euler, first order and unstable for springs: for teaching, as the scheme that goes wrong.
    ExplicitEuler,
}

/// The integrator of a scene.
pub struct IntegratorPlugin<V: Space> {
    /// Which.
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
