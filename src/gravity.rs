//! Weight: m g on every grain. Where it acts, the potential energy of a grain is -m g.x, zero at the origin.
//!
//! It is what the sum of the forces on a grain begins with ([`crate::store::Loads::force`]), so that it takes no pass.

use bevy_ecs::prelude::*;

use crate::space::{Plane, Space};

/// The acceleration of gravity, m/s^2; zero where the scene has none.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Gravity<V: Space = Plane>(pub V);
