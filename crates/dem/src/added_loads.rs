//! Parameters of systems that add forces and torques to those of contacts: [`AddForce`] and [`AddTorque`].
//!
//! A sum does not depend on who adds first, except by its rounding. Systems with these parameters can only add, so siloflow itself puts
//! them in an order: that of their behaviours' names, then that of their registration. Two behaviours that push grains therefore share a
//! scene without knowing each other. (A system with `&mut Force` may also set a force, so siloflow cannot order it; see
//! [`ForceStage::Added`](crate::step::ForceStage::Added).)
//!
//! ```
//! use siloflow::prelude::*;
//!
//! /// Drag, F = -a v with a = 0.4 N s/m.
//! fn slow_down<V: Space>(mut grains: AddForce<V, &'static Velocity<V>>) {
//!     grains.each(|velocity| velocity.0 * -0.4);
//! }
//! # fn build(app: &mut App) {
//! in_space!(app, V => app.add_systems(Step, slow_down::<V>.in_set(ForceStage::Added)));
//! # }
//! ```
//!
//! The second type parameter is what the system reads of each grain, as in a [`Query`]; the third one is a filter. Fixed grains are visited
//! too, and do not move. A sum of zero changes nothing.

use std::ops::AddAssign;

use bevy_ecs::prelude::*;
use bevy_ecs::query::{QueryData, QueryFilter, ReadOnlyQueryData};
use bevy_ecs::system::SystemParam;

use crate::particle::{Force, Grain};
use crate::space::{Linear, Plane, Space};
use crate::spin::Torque;
use crate::store::AddsLoads;

/// System parameter: adds forces, N, to grains. `D` is what the system reads of a grain.
#[derive(SystemParam)]
pub struct AddForce<'w, 's, V: Space = Plane, D: ReadOnlyQueryData + 'static = (), F: QueryFilter + 'static = ()> {
    grains: Query<'w, 's, (D, &'static mut Force<V>), (With<Grain>, F)>,
    _adds: Res<'w, AddsLoads>,
}

/// Adds `load` to a sum, unless it is zero: a component that nobody changes is not copied back.
fn add_to<C: Component<Mutability = bevy_ecs::component::Mutable>, T: Linear + AddAssign>(
    mut sum: Mut<'_, C>,
    load: T,
    of: impl Fn(&mut C) -> &mut T,
) {
    if load != T::ZERO {
        *of(&mut sum) += load;
    }
}

impl<V: Space, D: ReadOnlyQueryData + 'static, F: QueryFilter + 'static> AddForce<'_, '_, V, D, F> {
    /// Adds the force (N) that `force` returns for each grain.
    pub fn each(&mut self, mut force: impl FnMut(<D as QueryData>::Item<'_, '_>) -> V) {
        for (data, sum) in &mut self.grains {
            add_to(sum, force(data), |sum: &mut Force<V>| &mut sum.0);
        }
    }

    /// Adds a force (N) to one grain. Returns whether there is such a grain.
    pub fn to(&mut self, grain: Entity, force: V) -> bool {
        let Ok((_, sum)) = self.grains.get_mut(grain) else { return false };
        add_to(sum, force, |sum: &mut Force<V>| &mut sum.0);
        true
    }
}

/// System parameter: adds torques, N m, to grains that spin. `D` is what the system reads of a grain.
#[derive(SystemParam)]
pub struct AddTorque<'w, 's, V: Space = Plane, D: ReadOnlyQueryData + 'static = (), F: QueryFilter + 'static = ()> {
    grains: Query<'w, 's, (D, &'static mut Torque<<V as Space>::Spin>), (With<Grain>, F)>,
    _adds: Res<'w, AddsLoads>,
}

impl<V: Space, D: ReadOnlyQueryData + 'static, F: QueryFilter + 'static> AddTorque<'_, '_, V, D, F> {
    /// Adds the torque (N m) about its centre that `torque` returns for each grain.
    pub fn each(&mut self, mut torque: impl FnMut(<D as QueryData>::Item<'_, '_>) -> V::Spin) {
        for (data, sum) in &mut self.grains {
            add_to(sum, torque(data), |sum: &mut Torque<V::Spin>| &mut sum.0);
        }
    }

    /// Adds a torque (N m) to one grain. Returns whether there is such a grain that spins.
    pub fn to(&mut self, grain: Entity, torque: V::Spin) -> bool {
        let Ok((_, sum)) = self.grains.get_mut(grain) else { return false };
        add_to(sum, torque, |sum: &mut Torque<V::Spin>| &mut sum.0);
        true
    }
}
