//! Rotation: spin w (rad/s), torque T (N m) and moment of inertia I (kg m^2) of grains, in scenes with friction.
//!
//! I = 2/5 m R^2 for a sphere, 1/2 m R^2 for a disc. A behaviour that changes a grain's mass or radius sets its [`Inertia`] as well. Wall
//! grains do not spin; a grain that a behaviour fixes keeps the spin that it has. How spins change: [`crate::integrate`].

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::{Dimension, Linear, Space};

/// Angular velocity, rad/s; in the plane a number, positive counter-clockwise.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Spin<W: Linear = f64>(pub W);

/// Torque about the centre, N m, as of the last evaluation.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Torque<W: Linear = f64>(pub W);

/// Moment of inertia about the centre, kg m^2.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(immutable)]
pub struct Inertia(pub f64);

/// The scene's `inertia`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum InertiaLaw {
    /// I = 2/5 m R^2.
    Sphere,
    /// I = 1/2 m R^2.
    Disc,
}

impl InertiaLaw {
    /// What a scene has that does not say: spheres in solid space, discs in the plane.
    #[must_use]
    pub fn usual(dimension: Dimension) -> Self {
        match dimension {
            Dimension::Plane => Self::Disc,
            Dimension::Solid => Self::Sphere,
        }
    }

    /// I/(m R^2).
    #[must_use]
    pub fn factor(self) -> f64 {
        match self {
            Self::Sphere => 0.4,
            Self::Disc => 0.5,
        }
    }

    /// What a grain of this mass (kg), radius (m) and spin (rad/s) needs to turn.
    pub(crate) fn turning<V: Space>(self, mass: f64, radius: f64, spin: V::Spin) -> TurningBundle<V> {
        (Spin(spin), Torque(V::Spin::ZERO), Inertia(self.factor() * mass * radius * radius))
    }
}

pub(crate) type TurningBundle<V> = (Spin<<V as Space>::Spin>, Torque<<V as Space>::Spin>, Inertia);
