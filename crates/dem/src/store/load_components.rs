//! The components [`Force`] and [`Torque`]: particles get them before the first system that uses them runs, and before a caller from
//! outside gets the world. Without such a use only the store holds forces and torques. That saves 24 B for each disc and 32 B for each
//! sphere (values and change ticks), and 16 or 32 B more with friction.

use bevy_ecs::prelude::*;
use bevy_ecs::system::{SystemParam, SystemState};

use crate::particle::{Force, GrainId, Slot};
use crate::space::Space;
use crate::spin::{Spin, Torque};
use crate::store::ParticleStore;
use crate::store::mirror::Mirror;
use crate::store::mirror_set::MirrorSet;

/// Adds forces and torques, if they are among `wanted`, to the particles that lack these components.
pub(super) fn add_loads<V: Space>(world: &mut World, state: &mut SystemState<AddLoads<V>>, wanted: MirrorSet) {
    if wanted.meets(MirrorSet::FORCE.or(MirrorSet::TORQUE)) {
        state.get_mut(world).expect("the store plugin inserts the store").add(wanted);
        state.apply(world);
    }
}

type Lacking<'w, 's, C, Where> = Query<'w, 's, (Entity, &'static Slot), (With<Where>, Without<C>)>;

/// System parameter that adds forces and torques to the particles that lack these components.
#[derive(SystemParam)]
pub(super) struct AddLoads<'w, 's, V: Space> {
    store: Res<'w, ParticleStore<V>>,
    force: Lacking<'w, 's, Force<V>, GrainId>,
    torque: Lacking<'w, 's, Torque<<V as Space>::Spin>, Spin<<V as Space>::Spin>>,
    commands: Commands<'w, 's>,
}

impl<V: Space> AddLoads<'_, '_, V> {
    /// Adds those among `wanted`.
    pub(super) fn add(mut self, wanted: MirrorSet) {
        add_component(&self.store, wanted, &self.force, &mut self.commands);
        add_component(&self.store, wanted, &self.torque, &mut self.commands);
    }
}

/// Adds a component with the value of the store. A particle without a slot gets it after it has one.
fn add_component<V: Space, C: Mirror<V>, Where: Component>(
    store: &ParticleStore<V>,
    wanted: MirrorSet,
    lacking: &Lacking<C, Where>,
    commands: &mut Commands,
) {
    if wanted.meets(C::KIND) && !lacking.is_empty() {
        let value = |(entity, slot): (Entity, &Slot)| Some((entity, C::from_store(store, slot.index())?));
        commands.insert_batch(lacking.iter().filter_map(value).collect::<Vec<_>>());
    }
}
