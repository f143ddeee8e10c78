//! Gravity: the weight m g of every grain. The potential energy of a grain is -m g.x, zero at the origin.
//!
//! The weight is the first term of the force sum of a grain ([`crate::store::Loads::force`]), so it takes no separate
//! pass.

use bevy_ecs::prelude::*;

use crate::space::{Plane, Space};

/// The acceleration of gravity, m/s^2; zero where the scene has none.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct Gravity<V: Space = Plane>(pub V);
