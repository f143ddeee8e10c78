//! Components of rotation, in scenes with friction: spin w (rad/s), torque T (N m) and moment of inertia I (kg m^2) of
//! grains.
//!
//! I = 2/5 m R^2 for a sphere, 1/2 m R^2 for a disc. A behaviour that changes a grain's mass or radius must set its
//! [`Inertia`] as well. Wall grains do not spin. A grain that a behaviour fixes keeps its spin. [`crate::integrate`]
//! describes how spins change.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::{Dimension, Linear, Space};

/// Angular velocity, rad/s. In the plane it is a number, positive counter-clockwise.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Spin<W: Linear = f64>(pub W);

/// Torque about the centre, N m, at the last evaluation. Like [`Force`](crate::particle::Force), grains have it where a system
/// uses it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Torque<W: Linear = f64>(pub W);

/// Moment of inertia about the centre, kg m^2; for a shaped grain in solid space the mean of its principal moments.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[component(immutable)]
pub struct Inertia(pub f64);

/// The scene's `inertia`: the rule for moments of inertia.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum InertiaLaw {
    /// I = 2/5 m R^2.
    Sphere,
    /// I = 1/2 m R^2.
    Disc,
}

impl InertiaLaw {
    /// The default of a scene: discs in the plane, spheres in solid space.
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

    /// Returns the components that a grain of this mass (kg), radius (m) and spin (rad/s) needs to rotate.
    pub fn turning<V: Space>(self, mass: f64, radius: f64, spin: V::Spin) -> TurningBundle<V> {
        (Spin(spin), Inertia(self.factor() * mass * radius * radius))
    }
}

pub(crate) type TurningBundle<V> = (Spin<<V as Space>::Spin>, Inertia);
