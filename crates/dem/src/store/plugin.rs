//! The plugin that sets the store up, and the pass that clears forces in scenes without a contact pass.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::bodies::{Orientation, Shape};
use crate::gravity::Gravity;
use crate::instruction_set::InstructionSet;
use crate::particle::{Door, Fixed, Force, Grain, GrainId, Mass, Position, Radius, Slot, Species, Velocity};
use crate::persist::PersistApp as _;
use crate::space::Space;
use crate::step::Step;
use crate::store::adders_in_order::AddersInOrder;
use crate::store::mirror_set::MirrorSet;
use crate::store::{ParticleStore, component_sync, deferred_kick, population, renumbering, saved};

/// Initialises the force sums with the weight, in scenes without a contact pass.
pub fn clear_forces<V: Space>(gravity: Res<Gravity<V>>, mut store: ResMut<ParticleStore<V>>) {
    store.stale.add(MirrorSet::FORCE);
    let ParticleStore { loads, mass, tracks_energy, .. } = &mut *store;
    loads.force.reset(mass.len(), *tracks_energy);
    for (i, mass) in mass.iter().enumerate() {
        loads.force.set(i, gravity.0 * *mass);
    }
}

/// Adds the store, the component hooks that record entering and leaving particles, and component sync.
pub struct StorePlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for StorePlugin<V> {
    fn build(&self, app: &mut App) {
        // Chunked passes over the store need the instructions.
        app.init_resource::<ParticleStore<V>>().init_resource::<InstructionSet>();
        app.persist_component::<GrainId>()
            .persist_component::<Slot>()
            .persist_sound_component::<Position<V>>()
            .persist_sound_component::<Velocity<V>>()
            .persist_sound_component::<Force<V>>()
            .persist_sound_component::<Radius>()
            .persist_sound_component::<Mass>()
            .persist_component::<Shape>()
            .persist_sound_component::<Orientation<V>>()
            .persist_component::<Species>()
            .persist_component::<Grain>()
            .persist_component::<Fixed>()
            .persist_component::<Door>();
        saved::register::<V>(app);
        population::add::<V>(app.world_mut());
        renumbering::add::<V>(app);
        component_sync::add::<V>(app);
        deferred_kick::add(app);
        app.edit_schedule(Step, |schedule| {
            schedule.add_build_pass(AddersInOrder);
        });
    }
}
