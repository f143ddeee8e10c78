//! Forces with which a caller pushes grains: a force for each grain, in every step until the caller takes them back. Their work counts as that of forces of
//! behaviours.
//!
//! [`PushPlugin`] adds this to a simulation ([`Simulation::with_plugins`]). The forces are not part of the saved state: a caller that continues a simulation gives
//! them again.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use rustc_hash::FxHashMap;

use crate::energy::{AddedWorkPlugin, EnergyFlows};
use crate::simulation::Simulation;
use siloflow_dem::added_loads::AddForce;
use siloflow_dem::particle::GrainId;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::step::{ForceStage, Step};
use siloflow_dem::store::register_predictable;

/// The force on each grain, N.
#[derive(Resource)]
struct Pushes<V: Space>(FxHashMap<GrainId, V>);

fn are_pushed<V: Space>(pushes: Res<Pushes<V>>) -> bool {
    !pushes.0.is_empty()
}

fn push<V: Space>(pushes: Res<Pushes<V>>, mut grains: AddForce<V, &'static GrainId>) {
    grains.each(|id| pushes.0.get(id).copied().unwrap_or(V::ZERO));
}

/// Lets a caller push grains. Steps without a push cost nothing.
pub struct PushPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for PushPlugin<V> {
    fn build(&self, app: &mut App) {
        register_predictable(app, are_pushed::<V>, are_pushed::<V>);
        app.insert_resource(Pushes::<V>(FxHashMap::default()))
            .derived::<Pushes<V>>()
            .add_systems(Step, push::<V>.run_if(are_pushed::<V>).in_set(ForceStage::Added));
        if app.world().contains_resource::<EnergyFlows>() && !app.is_plugin_added::<AddedWorkPlugin<V>>() {
            app.add_plugins(AddedWorkPlugin(PhantomData::<V>));
        }
    }
}

impl Simulation {
    /// Pushes grains with these forces, N, on top of earlier ones, from the next step on. A grain that is not there any more takes no force.
    ///
    /// # Errors
    /// If a force is not finite, or the simulation lacks [`PushPlugin`].
    pub fn push<V: Space>(&mut self, forces: impl IntoIterator<Item = (GrainId, V)>) -> Result<(), String> {
        let Some(mut pushes) = self.world.get_resource_mut::<Pushes<V>>() else {
            return Err("this simulation has no `PushPlugin`".to_owned());
        };
        let forces: Vec<_> = forces.into_iter().collect();
        if !forces.iter().all(|(_, force)| Linear::is_finite(*force)) {
            return Err("a force is infinite or NaN".to_owned());
        }
        for (grain, force) in forces.into_iter().filter(|(_, force)| *force != V::ZERO) {
            *pushes.0.entry(grain).or_insert(V::ZERO) += force;
        }
        Ok(())
    }

    /// Takes all forces of [`Simulation::push`] back.
    pub fn stop_pushing<V: Space>(&mut self) {
        if let Some(mut pushes) = self.world.get_resource_mut::<Pushes<V>>() {
            pushes.0.clear();
        }
    }
}
